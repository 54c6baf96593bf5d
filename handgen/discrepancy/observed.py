"""Repeats -> means and how far they can be trusted; what does not fit its neighbours weighs less and is flagged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

FREEDOMS = 4.0
"""Of Student's t for a reading: one far off weighs (FREEDOMS + 1) / (FREEDOMS + z^2)."""
OUTLYING = 4.5
"""Deviations from which a reading, or a whole repeat, is flagged."""
EXPECTED = 0.01
"""Scatter of a reading as a share of a test's range, expected before any repeat is seen."""
PRIOR_FREEDOMS = 3.0
"""Readings that this expectation is worth."""


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

    A reading is load + repeat + error: the variance of errors is pooled over all loads, that of repeats
    comes from their shifts. Both lean on EXPECTED where there are few repeats.
    """
    x = np.asarray(test.repeats, float)
    there = np.isfinite(x)
    columns = there.any(axis=0)
    if not columns.any():
        raise ValueError(f"{test.id}: no reading at all")
    span = float(np.nanmax(x) - np.nanmin(x)) or abs(float(np.nanmax(x))) or 1.0
    expected = max(EXPECTED * span, test.resolution / np.sqrt(12), 1e-9)
    level, shift = _polished(x, there)
    residual = np.where(there, x - level - shift[:, None], 0.0)
    freedoms = max(int(there.sum()) - int(columns.sum()) - int(there.any(axis=1).sum()) + 1, 0)
    sigma = _scale(residual[there], freedoms, expected)
    inner = sigma / np.sqrt(np.maximum(there.sum(axis=1), 1))
    between = _between(shift[there.any(axis=1)], inner[there.any(axis=1)])
    z = residual / sigma
    z_row = _row_deviations(shift, there.any(axis=1), np.hypot(np.hypot(between, inner), sigma / 2))
    weight = np.where(there, _student(z) * _student(z_row)[:, None], 0.0)
    total = weight.sum(axis=0)
    means = np.full(x.shape[1], np.nan)
    means[columns] = np.where(there, weight * x, 0.0).sum(axis=0)[columns] / total[columns]
    share = np.divide(weight, total, out=np.zeros_like(weight), where=total > 0)
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
    for _ in range(10):
        step = np.zeros_like(level)
        step[columns] = np.nanmedian(left[:, columns], axis=0)
        level, left = level + step, left - step
        if rows.sum() > 1:
            step = np.zeros_like(shift)
            step[rows] = np.nanmedian(left[rows], axis=1)
            step[rows] -= np.median((shift + step)[rows])
            shift, left = shift + step, left - step[:, None]
    return level, shift


def _scale(residuals: np.ndarray, freedoms: int, expected: float) -> float:
    """Scatter of a reading: squares cut at what Student's t still believes, beside the expected ones."""
    if freedoms == 0:
        return expected
    sigma = max(1.4826 * float(np.median(np.abs(residuals))) * np.sqrt(len(residuals) / freedoms),
                expected / 3)
    for _ in range(20):
        squares = float((_student(residuals / sigma) * residuals**2).sum())
        sigma = np.sqrt((squares + PRIOR_FREEDOMS * expected**2) / (freedoms + PRIOR_FREEDOMS))
    return float(sigma)


def _between(shifts: np.ndarray, inner: np.ndarray) -> float:
    """Standard deviation of the repeats' shifts beyond what errors explain, by the median."""
    if len(shifts) < 2:
        return 0.0
    spread = 1.4826 * float(np.median(np.abs(shifts - np.median(shifts)))) * np.sqrt(
        len(shifts) / (len(shifts) - 1))
    return float(np.sqrt(max(spread**2 - float(np.mean(inner**2)), 0.0)))


def _row_deviations(shift: np.ndarray, rows: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Deviations of each repeat from the middle one; with two nobody knows which is off."""
    if rows.sum() < 3:
        return np.zeros_like(shift)
    return np.where(rows, (shift - np.median(shift[rows])) / sigma, 0.0)
