"""A law: a strain-energy function with its constants, seen through squared principal stretches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import NamedTuple

import numpy as np

from handgen.materials import energies
from handgen.materials.energies import ogden

PAIRS = ((1, 2), (2, 0), (0, 1))
"""The pair of directions k opposite to direction k."""


class Response(NamedTuple):
    """W and its derivatives with respect to the squared principal stretches x, all in MPa."""

    value: np.ndarray
    """W, shape (...)."""
    first: np.ndarray
    """W_a = dW/dx_a, shape (..., 3)."""
    second: np.ndarray
    """W_ab, shape (..., 3, 3)."""
    quotient: np.ndarray
    """(W_a - W_b)/(x_a - x_b) of PAIRS, shape (..., 3); the limit where the two coincide."""


@dataclass(frozen=True)
class Law:
    """A strain-energy function of incompressible or isochoric deformation with its constants.

    Plain data (hashable, picklable): `name` is a file of `energies`, `constants` are in the order of
    its CONSTANTS, in MPa; Ogden's are ((mu...), (alpha...)) of the convention "mu/alpha".
    """

    name: str
    constants: tuple

    @property
    def energy(self) -> ModuleType:
        return energies.energy(self.name)

    @property
    def shear_modulus(self) -> float:
        """G at small strain, MPa; Young's modulus is 3 G."""
        return self.energy.shear_modulus(*self.constants)

    def response(self, x: np.ndarray) -> Response:
        """W and its derivatives at squared isochoric principal stretches `x`, shape (..., 3)."""
        x = np.asarray(x)
        form = _from_invariants if self.energy.FORM == "invariants" else _from_separable
        return form(self.energy, self.constants, x)


def law(name: str, constants: Mapping[str, float]) -> Law:
    """The law `name` ("neo_hookean", "mooney_rivlin", "yeoh") with constants by name, MPa.

    Raises:
        ValueError: no such law of scalar constants, or constants that are not exactly its own.
    """
    if name not in energies.names():
        raise ValueError(f"there is no law {name!r}; there are {', '.join(energies.names())}")
    wanted = energies.energy(name).CONSTANTS
    if set(constants) != set(wanted):
        raise ValueError(f"{name} takes {', '.join(wanted)}, not {', '.join(sorted(constants)) or 'nothing'}")
    return Law(name, tuple(float(constants[key]) for key in wanted))


def ogden_law(mu: Sequence[float], alpha: Sequence[float], convention: ogden.Convention) -> Law:
    """An Ogden law from `mu` (MPa) and `alpha` of the convention "mu/alpha" or "2mu/alpha^2".

    Raises:
        ValueError: as many mu as alpha are needed, at least one, and no alpha of zero.
    """
    if len(mu) != len(alpha) or not len(mu):
        raise ValueError(f"Ogden takes as many mu as alpha; here are {len(mu)} mu and {len(alpha)} alpha")
    if 0 in alpha:
        raise ValueError("an Ogden law with alpha = 0 has no energy")
    own = ogden.converted(mu, alpha, convention, "mu/alpha")
    return Law("ogden", (tuple(map(float, own)), tuple(map(float, alpha))))


def invariants(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """I1 and I2 of squared principal stretches `x`, shape (..., 3)."""
    a, b, c = x[..., 0], x[..., 1], x[..., 2]
    return a + b + c, a * b + b * c + c * a


def _from_invariants(energy: ModuleType, constants: tuple, x: np.ndarray) -> Response:
    """Chain rule through dI1/dx_a = 1 and dI2/dx_a = I1 - x_a = b_a."""
    i1, i2 = invariants(x)
    w1, w2 = energy.first(i1, i2, *constants)
    w11, w12, w22 = (w[..., None, None] for w in energy.second(i1, i2, *constants))
    b = i1[..., None] - x
    column, row = b[..., :, None], b[..., None, :]
    second = w11 + w12 * (column + row) + w22 * column * row + w2[..., None, None] * (1 - np.eye(3))
    quotient = -w2[..., None] * np.ones(3)
    return Response(energy.value(i1, i2, *constants), w1[..., None] + w2[..., None] * b, second, quotient)


def _from_separable(energy: ModuleType, constants: tuple, x: np.ndarray) -> Response:
    """W_ab = 0 for a != b."""
    quotient = np.stack([energy.quotient(x[..., a], x[..., b], *constants) for a, b in PAIRS], -1)
    second = energy.second(x, *constants)[..., None] * np.eye(3)
    return Response(energy.value(x, *constants).sum(-1), energy.first(x, *constants), second, quotient)
