"""Where a model and its readings part: beyond what the repeats allow, at which loads, in which shape.

Residuals are simulated less measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handgen.discrepancy.library import Library, Series
from handgen.discrepancy.observed import Observed, Readings, Summary

SHAPES = ("offset", "slope", "curvature")
"""Parts of a residual over the load: orthogonal polynomials of degree 0, 1, 2."""
PLAIN = {"offset": "{0} too {1} on the whole", "slope": "up to {0} {2} towards the last load",
         "curvature": "up to {0} {2} at both ends than between"}
STANDS_OUT = 3.0
"""Deviations from which a part of a residual is spoken of."""
BENDING = 6
"""Loads from which a residual's curvature is told from something that happens at the last one."""
CHANCE = 0.01
"""Probability below which a misfit is more than the repeats allow."""


SAME = ("part", "quantity", "orientation", "obstacle")
"""Of a test that was read on the way up and on the way down."""


@dataclass(frozen=True)
class Point:
    """One reading's mean against the model."""

    test: str
    load: float
    residual: float
    sigmas: float
    """Deviations of the mean, by the repeats alone."""


@dataclass(frozen=True)
class Located:
    """What is wrong with one test."""

    test: str
    unit: str
    points: tuple[Point, ...]
    misfit: float
    """F: mean square of the residuals over the mean square error of a mean, from the repeats."""
    chance: float
    """Probability of so large an F if nothing but the repeats' scatter were at work."""
    shapes: tuple[tuple[str, float, float], ...]
    """(name, size in the unit of the reading, deviations) of offset, slope, curvature."""
    last: tuple[float, float] | None
    """(size, deviations) by which the residual of the last load leaves the course of the others."""
    drift: tuple[float, float] | None
    """(per repeat, deviations) by which readings drift from repeat to repeat."""
    outlying: tuple[tuple[int, float | None, float], ...]
    """(repeat from 1, load or None for the whole repeat, deviations)."""
    assumed: float | None = None
    """Scatter of a reading where no second repeat shows it."""

    @property
    def beyond(self) -> bool:
        """More than the repeats allow."""
        return self.chance < CHANCE

    @property
    def words(self) -> list[str]:
        """What stands out, for people."""
        found = [PLAIN[name].format(f"{abs(size):.2g} {self.unit}", "large" if size > 0 else "small",
                                    "more" if size > 0 else "less")
                 for name, size, sigmas in self.shapes if abs(sigmas) >= STANDS_OUT]
        if self.last is not None and abs(self.last[1]) >= STANDS_OUT:
            found.append(f"at {self.points[-1].load:g} {self.last[0]:+.2g} {self.unit} off the course of the "
                         "other loads")
        return found


def locate(library: Library, observed: Observed, predictions: np.ndarray | None = None) -> list[Located]:
    """Of each test; `predictions` at all points of the library, its baseline if left out."""
    predicted = library.baseline if predictions is None else predictions
    known = {test.id: test for test in library.tests}
    return [_located(known[test.id], test, predicted[library.points(test.id)]) for test in observed.tests]


def _located(series: Series, test: Readings, predicted: np.ndarray) -> Located:
    summary = test.summary
    there = np.isfinite(summary.means) & np.isfinite(predicted)
    loads = np.asarray(series.loads)[there]
    residual = (predicted - summary.means)[there]
    covariance = summary.covariance[np.ix_(there, there)]
    sigma = np.sqrt(np.diag(covariance))
    points = tuple(Point(series.id, float(load), float(r), float(r / s))
                   for load, r, s in zip(loads, residual, sigma, strict=True))
    count = max(len(residual), 1)
    misfit = float(residual @ np.linalg.solve(covariance, residual) / count)
    return Located(series.id, series.unit, points, misfit, _chance(misfit, count, summary.freedoms),
                   tuple(_shapes(loads, residual, covariance)), _last(loads, residual, covariance),
                   _drift(test, summary),
                   tuple((i + 1, None if j is None else series.loads[j], z) for i, j, z in summary.outlying),
                   None if summary.freedoms else summary.sigma)


def _chance(misfit: float, count: int, freedoms: int) -> float:
    """Of so large a mean square of `count` residuals. Without a second repeat the scatter is not found from
    readings but assumed, and wide."""
    from scipy.stats import chi2, f

    found = f.sf(misfit, count, freedoms) if freedoms else chi2.sf(misfit * count, count)
    return float(found)


def _shapes(loads: np.ndarray, residual: np.ndarray, covariance: np.ndarray):
    """Size (largest over the loads) and deviations of each part of the residual."""
    count = min(len(SHAPES), len(loads))
    if count == 0:
        return
    scaled = (loads - loads.min()) / (np.ptp(loads) or 1.0)
    basis = np.linalg.qr(np.vander(scaled, count, increasing=True))[0]
    for name, vector in zip(SHAPES, basis.T, strict=False):
        vector = vector * (1 if vector[-1] >= 0 else -1)
        amount, sigma = float(vector @ residual), float(np.sqrt(vector @ covariance @ vector))
        yield name, amount * float(np.abs(vector).max()), amount / sigma


def _last(loads: np.ndarray, residual: np.ndarray, covariance: np.ndarray) -> tuple[float, float] | None:
    """By how much the last residual leaves the line, from BENDING loads on the parabola, through the others;
    None below four loads."""
    if len(loads) < 4:
        return None
    count = 3 if len(loads) >= BENDING else 2
    scaled = loads / (np.abs(loads).max() or 1.0)
    weights = np.vander(scaled[-1:], count)[0] @ np.linalg.pinv(np.vander(scaled[:-1], count))
    contrast = np.append(-weights, 1.0)
    size, sigma = float(contrast @ residual), float(np.sqrt(contrast @ covariance @ contrast))
    return size, size / sigma


def _drift(test: Readings, summary: Summary) -> tuple[float, float] | None:
    """Slope of the repeats' means over their number; None below three repeats."""
    rows = np.asarray(test.repeats, float) - summary.means
    kept = np.isfinite(rows).any(axis=1)
    if kept.sum() < 3:
        return None
    order = np.flatnonzero(kept).astype(float)
    shifts = np.array([np.nanmean(row) for row in rows[kept]])
    counts = np.isfinite(rows[kept]).sum(axis=1)
    order -= order.mean()
    slope = float(order @ shifts / (order @ order))
    sigma = float(np.sqrt((order**2 @ (summary.sigma**2 / counts + summary.shift**2)) / (order @ order)**2))
    return slope, slope / sigma


def compared(observed: Observed, library: Library) -> list[tuple[str, str, float, float]]:
    """(loading test, unloading test, mean difference, deviations) where one quantity was read both ways."""
    known = {test.id: test for test in library.tests}
    found = []
    for up in observed.tests:
        for down in observed.tests:
            a, b = known[up.id], known[down.id]
            alike = all(getattr(a, name) == getattr(b, name) for name in SAME)
            if alike and a.path == "loading" and b.path == "unloading":
                found += _both_ways(a, b, up.summary, down.summary)
    return found


def _both_ways(a: Series, b: Series, up: Summary, down: Summary) -> Sequence[tuple[str, str, float, float]]:
    shared = [load for load in a.loads if load in b.loads]
    i, j = [a.loads.index(load) for load in shared], [b.loads.index(load) for load in shared]
    difference = down.means[j] - up.means[i]
    there = np.isfinite(difference)
    if not there.any():
        return []
    i, j = np.array(i)[there], np.array(j)[there]
    covariance = up.covariance[np.ix_(i, i)] + down.covariance[np.ix_(j, j)]
    size = float(difference[there].mean())
    return [(a.id, b.id, size, size / float(np.sqrt(covariance.sum()) / there.sum()))]
