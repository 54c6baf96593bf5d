"""The elements of one material, and its law as the kernels take it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from handgen.materials.law import Law
from handgen.simulation import element, principal

POLYNOMIALS = {"neo_hookean": ("c10",), "mooney_rivlin": ("c10", "c01"), "yeoh": ("c10", "c20", "c30")}
"""Laws that the kernel's polynomial holds, with their constants in order."""


def kernel_law(law: Law) -> tuple[int, np.ndarray]:
    """(form, constants) of `law` as `principal.respond` takes them.

    Raises:
        ValueError: the kernel does not know this law.
    """
    if law.name == "ogden":
        return principal.OGDEN, np.array([v for pair in zip(*law.constants, strict=True) for v in pair])
    if law.name not in POLYNOMIALS:
        raise ValueError(f"the solid model knows {', '.join([*POLYNOMIALS, 'ogden'])}, not {law.name}")
    values = dict(zip(POLYNOMIALS[law.name], law.constants, strict=True))
    return principal.POLYNOMIAL, np.array([values.get(name, 0.0) for name in ("c10", "c20", "c30", "c01")])


@dataclass
class Block:
    """The elements of one material, with what Newton extrapolates at their points, and from what."""

    cells: np.ndarray
    dn: np.ndarray
    weight: np.ndarray
    form: int
    constants: np.ndarray
    bulk: float
    mean: bool
    framed: np.ndarray
    dofs: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), int))
    place: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 0), np.int32))

    def __post_init__(self):
        self.stress = np.zeros((*self.weight.shape, 3, 3))
        self.kept = np.zeros((*self.weight.shape, *element.KEPT))
        self.swell = np.zeros((len(self.cells), 3 * self.cells.shape[1] + 1))
        self.pressure = np.zeros(self.weight.shape)

    def softened(self, lost: float) -> np.ndarray:
        """The constants with a share of the law's stresses `lost`; of a row of powers only the mu."""
        if self.form == principal.OGDEN:
            return self.constants * np.where(np.arange(len(self.constants)) % 2, 1.0, 1.0 - lost)
        return (1.0 - lost) * self.constants
