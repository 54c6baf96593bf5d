"""One strain-energy function a file: pure numpy functions, vectorised over points; a new law is a new file.

Every function takes the isochoric (volume-free) deformation and constants in MPa, and gives MJ/m3 =
MPa. They are plain arithmetic on arrays or scalars, so that numba compiles the same functions for a
finite-element kernel: no law is written twice. A file has one of two forms, each where it is cheapest:

- `FORM = "invariants"`: W(I1, I2) of the isochoric right Cauchy-Green tensor C. Five scalars (W1, W2,
  W11, W12, W22) give stress and tangent as plain products of C; no eigenvalues are needed.
- `FORM = "separable"`: W = w(x1) + w(x2) + w(x3) of the *squared* principal stretches, the eigenvalues of
  C. Besides w' and w'' it gives the quotient (w'(x) - w'(y))/(x - y), which the shear terms of the
  tangent need, in a form that stays exact at coincident stretches: no perturbation, no special case.

`handgen.materials.law` brings both to one interface, `handgen.materials.tensors` makes stress and
tangent of either.
"""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType


def names() -> tuple[str, ...]:
    """The laws there are: the files of this folder."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def energy(name: str) -> ModuleType:
    """The file of the law `name`, one of `names()`."""
    return importlib.import_module(f"{__name__}.{name}")
