"""Repeats -> means and how far to trust them; a reading that does not fit weighs less and is flagged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

FREEDOMS = 4.0
"""Of Student's t for a reading: one far off weighs (FREEDOMS + 1) / (FREEDOMS + z^2)."""
OUTLYING = 4.0
"""Deviations from which a reading, or a whole repeat, is flagged."""
EXPECTED = 0.02
"""Scatter of a reading as a share of a test's range, expected before any repeat is seen: 3.5, 2.3 and 1.3 %
in Tables 5.4, 5.6 and 5.8."""
ALONE = 1.5
"""By which it is widened where no repeat confirms it."""
PRIOR_FREEDOMS = 2.0
"""Readings that this expectation is worth."""
BETWEEN = 0.5
"""Scatter of whole repeats against each other that is expected, as a share of a reading's."""
CONSISTENT = 1.25
"""By which the weights of normal errors make their squares too small."""
ROUNDS = 10


@dataclass(frozen=True)
class Readings:
    """One test as measured."""

    id: str
    repeats: np.ndarray
    """(repeats, loads), NaN where nothing was read."""
    resolution: float = 0.0
    fitted: tuple[bool, ...] | None = None
    """Of each load, whether its readings may be fitted; None: all."""

    @cached_property
    def summary(self) -> Summary:
        return summarise(self)


@dataclass(frozen=True)
class Summary:
    """Means of a test's loads and their covariance."""

    means: np.ndarray
    """(loads,) NaN where nothing was read."""
    covariance: np.ndarray
    """(loads, loads) of the means, from the repeats' scatter and the resolution."""
    sigma: float
    """Of one reading."""
    shift: float
    """Of a whole repeat against the others."""
    freedoms: int
    outlying: tuple[tuple[int, int | None, float], ...]
    """(repeat, load or None for the whole repeat, deviations)."""


@dataclass(frozen=True)
class Observed:
    """Tests as measured."""

    tests: tuple[Readings, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        return tuple(test.id for test in self.tests)

    def only(self, ids: Sequence[str]) -> Observed:
        return Observed(tuple(test for test in self.tests if test.id in ids))


def summarise(test: Readings) -> Summary:
    """Means weighted by how well each reading fits its load and its repeat.

    A reading is load + repeat + error: errors have one variance over all loads, repeats another one. Both
    lean on what is expected where there are few repeats.
    """
    x = np.asarray(test.repeats, float)
    there = np.isfinite(x)
    columns, rows = there.any(axis=0), there.any(axis=1)
    if not columns.any():
        raise ValueError(f"{test.id}: no reading at all")
    span = float(np.nanmax(x) - np.nanmin(x)) or abs(float(np.nanmax(x))) or 1.0
    expected = max(EXPECTED * span, test.resolution / np.sqrt(12), 1e-9)
    freedoms = max(int(there.sum()) - int(columns.sum()) - int(rows.sum()) + 1, 0)
    level, shift = _polished(x, there)
    sigma, weight = ALONE * expected, there.astype(float)
    if freedoms:
        sigma = _start(x, there, level, shift, expected)
    for _ in range(ROUNDS if freedoms else 0):
        z = np.where(there, (x - level - shift[:, None]) / sigma, 0.0)
        weight = np.where(there, _student(z), 0.0)
        level, shift = _fitted(x, weight, level)
        squares = float((weight * np.where(there, x - level - shift[:, None], 0.0) ** 2).sum())
        sigma = np.sqrt((CONSISTENT * squares + PRIOR_FREEDOMS * expected**2) / (freedoms + PRIOR_FREEDOMS))
    z = np.where(there, (x - level - shift[:, None]) / sigma, 0.0)
    inner = sigma / np.sqrt(np.maximum(there.sum(axis=1), 1))
    z_row, between = _rows(shift, rows, inner, BETWEEN * sigma)
    weight *= _student(z_row)[:, None]
    total = weight.sum(axis=0)
    share = np.divide(weight, total, out=np.zeros_like(weight), where=total > 0)
    means = np.where(columns, (share * np.where(there, x, 0.0)).sum(axis=0), np.nan)
    covariance = between**2 * share.T @ share + sigma**2 * np.diag((share**2).sum(axis=0))
    covariance += test.resolution**2 / 12 * np.eye(len(means))
    outlying = [(int(i), int(j), float(z[i, j])) for i, j in np.argwhere(np.abs(z) > OUTLYING)]
    outlying += [(int(i), None, float(z_row[i])) for i in np.flatnonzero(np.abs(z_row) > OUTLYING)]
    return Summary(means, covariance, float(sigma), float(between), freedoms, tuple(outlying))


def _student(z: np.ndarray) -> np.ndarray:
    return (FREEDOMS + 1) / (FREEDOMS + z**2)


def _polished(x: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tukey's median polish: (level of each load, shift of each repeat)."""
    left = np.where(there, x, np.nan)
    level, shift = np.zeros(x.shape[1]), np.zeros(x.shape[0])
    columns, rows = there.any(axis=0), there.any(axis=1)
    for _ in range(ROUNDS):
        step = np.zeros_like(level)
        step[columns] = np.nanmedian(left[:, columns], axis=0)
        level, left = level + step, left - step
        if rows.sum() > 1:
            step = np.zeros_like(shift)
            step[rows] = np.nanmedian(left[rows], axis=1)
            step[rows] -= np.median((shift + step)[rows])
            shift, left = shift + step, left - step[:, None]
    return level, shift


def _start(x: np.ndarray, there: np.ndarray, level: np.ndarray, shift: np.ndarray, expected: float) -> float:
    """Scatter of a reading by the median, which one reading far off does not move."""
    left = np.abs(np.where(there, x - level - shift[:, None], np.nan))
    return max(1.4826 * float(np.nanmedian(left)), expected / 2)


def _fitted(x: np.ndarray, weight: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weighted means of loads and repeats in turn; the middle repeat's shift is 0."""
    filled = np.where(weight > 0, x, 0.0)
    rows = weight.sum(axis=1) > 0
    shift = np.zeros(len(x))
    for _ in range(3):
        shift[rows] = ((weight * (filled - level)).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-12))[rows]
        shift[rows] -= np.median(shift[rows])
        level = (weight * (filled - shift[:, None])).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-12)
    return level, shift


def _rows(
    shift: np.ndarray, rows: np.ndarray, inner: np.ndarray, expected: float
) -> tuple[np.ndarray, float]:
    """(deviations of each repeat from the others, scatter of the repeats beyond what errors explain).

    With two repeats nobody knows which one is off.
    """
    z, count = np.zeros_like(shift), int(rows.sum())
    if count < 2:
        return z, 0.0
    for i in np.flatnonzero(rows) if count > 2 else ():
        others = rows & (np.arange(len(rows)) != i)
        mine = shift[others]
        squares = float(((mine - mine.mean()) ** 2).sum())
        spread = (squares + 2 * expected**2) / (count - 2 + 2)
        z[i] = (shift[i] - mine.mean()) / np.sqrt((spread + inner[i] ** 2) * (1 + 1 / (count - 1)))
    weight = np.where(rows, _student(z), 0.0)
    centre = float(weight @ shift / weight.sum())
    squares = float(weight @ (shift - centre) ** 2)
    left = (squares + expected**2) / count - float((inner[rows] ** 2).mean())
    return z, float(np.sqrt(max(left, 0.0)))
