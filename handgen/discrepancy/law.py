"""What an effect's own law gets wrong: the same effect by another law moves every reading a little otherwise.

The library simulates one law of each effect. Nature's may differ: another strain energy, a capstan for a
constant friction, pores of another shape. As far as it only makes the effect larger or smaller, its size
takes that up; what is left is a size that wanders over the load, by a share of itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from handgen.discrepancy.library import Library, same_state

SHARE = 0.2
"""By which an effect's size wanders, one standard deviation. A neo-Hookean law and Ogden's with an exponent
of 1.42 that agree at a stretch of 2 differ by -13 % at 1.25 and +19 % at 3; of porosity 0.2 to 0.4,
Mackenzie's law and the square leave stiffnesses that differ by 4 to 19 %."""
SMOOTH = 0.5
"""Loads over which it wanders, as a share of a test's largest."""


class Values(Protocol):
    """Predictions (m, n) at many values (m, d) of an effect's parameters."""

    values: np.ndarray
    predictions: np.ndarray


def errors(library: Library, dense: Mapping[str, Values], best: Mapping[str, int]) -> dict[str, np.ndarray]:
    """(n, n) covariance of what each effect's law gets wrong at its most probable size.

    `best`: index of that size among the values of `dense`.
    """
    same, loads = same_state(library.tests)
    alike = same * np.exp(-((loads[:, None] - loads[None, :]) / SMOOTH) ** 2 / 2)
    found = {}
    for name, at in best.items():
        by = SHARE * by_size(library, dense[name], at)
        found[name] = alike * np.outer(by, by)
    return found


def by_size(library: Library, dense: Values, at: int) -> np.ndarray:
    """(n,) what a doubled size would move, to first order; 0 where nothing is predicted."""
    shift = dense.predictions - library.baseline
    moved = shift[at]
    if dense.values.shape[1] == 1 and len(dense.values) > 2:
        size = dense.values[:, 0]
        null = size[int(np.nansum(shift**2, axis=1).argmin())]
        moved = np.gradient(dense.predictions, size, axis=0)[at] * (size[at] - null)
    return np.where(np.isfinite(moved), moved, 0.0)
