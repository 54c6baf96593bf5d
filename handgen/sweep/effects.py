"""What each axis does to a result: main effects from the table, Sobol indices by a polynomial (SALib)."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from handgen.sweep import draw
from handgen.sweep.model import Axis

BINS = 8
"""Groups of equal size along an axis that takes more values."""
FOLDS = 5
LEAST_R2 = 0.8
"""Share of the variance that the polynomial must foretell, or there are no indices."""
ROWS_PER_TERM = 3
HIGHEST = 3
"""Degree of the polynomial at most."""
BASE_SAMPLES = 1024
FEW = 6
"""Axes up to which the polynomial has mixed terms."""


def main_effects(shares: np.ndarray, values: list[np.ndarray], results: np.ndarray) -> list[dict[str, Any]]:
    """Per axis: the mean result of each group of its values, and the range of those means.

    `shares` (n, d): where each row lies on each axis; `values`: per axis the values themselves (n,), of any
    kind; `results` (n,), NaN where a row has none.
    """
    there, found = np.isfinite(results), []
    for at in range(shares.shape[1]):
        own = shares[there, at]
        levels = np.unique(own)
        if len(levels) <= BINS:
            group = np.searchsorted(levels, own)
        else:
            edges = np.unique(np.quantile(own, np.linspace(0, 1, BINS + 1)[1:-1]))
            group = np.searchsorted(edges, own, side="right")
        points = []
        for one in np.unique(group):
            mine = group == one
            axis_values = values[at][there][mine]
            numbers = _numbers(axis_values)
            where = float(np.mean(axis_values.astype(float))) if numbers else str(axis_values[0])
            points.append({"value": where, "mean": float(results[there][mine].mean()),
                           "rows": int(mine.sum())})
        means = [p["mean"] for p in points]
        found.append({"points": points, "range": max(means) - min(means) if means else 0.0})
    return found


def sobol_indices(axes: dict[str, Axis], shares: np.ndarray, results: np.ndarray,
                  seed: int) -> dict[str, Any]:
    """First-order and total Sobol indices with their 95 % intervals.

    The axes are independent and their shares even by construction. The result is replaced by a polynomial
    of the shares, as high as the rows allow; its share of the variance in rows it has not seen (`r2`) is
    given, and below LEAST_R2 there are no indices.
    """
    from SALib.analyze import sobol
    from SALib.sample import sobol as saltelli

    there = np.isfinite(results)
    u, y = shares[there], results[there]
    if len(y) < 2 or float(np.ptp(y)) == 0.0:
        return {"reason": "the result does not vary", "rows": len(y)}
    terms = _terms(u, len(y))
    if terms is None:
        return {"reason": "too few rows", "rows": len(y)}
    r2 = _foretold(u, y, terms)
    if r2 < LEAST_R2:
        return {"reason": f"a polynomial foretells only {max(0.0, r2):.0%} of the variance", "rows": len(y),
                "r2": r2}
    weights = _fit(u, y, terms)
    problem = {"num_vars": len(axes), "names": list(axes), "bounds": [[0.0, 1.0]] * len(axes)}
    sample = saltelli.sample(problem, BASE_SAMPLES, calc_second_order=False, seed=seed)
    stepped = np.column_stack([_stepped(axis, sample[:, i]) for i, axis in enumerate(axes.values())])
    with np.errstate(all="ignore"):
        found = sobol.analyze(problem, _basis(stepped, terms) @ weights, calc_second_order=False, seed=seed)
    return {"rows": len(y), "r2": r2, "axes": {
        name: {key: float(found[key][i]) for key in ("S1", "S1_conf", "ST", "ST_conf")}
        for i, name in enumerate(axes)}}


def _stepped(axis: Axis, share: np.ndarray) -> np.ndarray:
    """Shares of an axis that takes only some values: the middle of each one's part."""
    count = len(axis.choices) if axis.choices is not None else None
    if count is None and (axis.step or axis.steps) and axis.distribution is None:
        levels = draw.levels(axis)
        at = np.array([draw.share(axis, level) for level in levels])
        return at[np.minimum((share * len(at)).astype(int), len(at) - 1)]
    return share if count is None else (np.minimum((share * count).astype(int), count - 1) + 0.5) / count


def _terms(u: np.ndarray, rows: int) -> list[tuple[int, ...]] | None:
    """Exponents of the polynomial's terms; None: not even a straight one has rows enough."""
    d = u.shape[1]
    levels = [len(np.unique(u[:, i])) for i in range(d)]
    for degree in range(HIGHEST, 0, -1):
        if d <= FEW:
            terms = [t for t in itertools.product(range(degree + 1), repeat=d) if sum(t) <= degree]
        else:
            terms = [(0,) * d] + [tuple(k if i == j else 0 for j in range(d))
                                  for i in range(d) for k in range(1, degree + 1)]
        terms = [t for t in terms if all(k < levels[i] for i, k in enumerate(t))]
        if rows >= ROWS_PER_TERM * len(terms):
            return terms
    return None


def _basis(u: np.ndarray, terms: list[tuple[int, ...]]) -> np.ndarray:
    """Products of Legendre polynomials on [0, 1]."""
    from scipy.special import eval_legendre

    single = [[eval_legendre(k, 2 * u[:, i] - 1) for k in range(HIGHEST + 1)] for i in range(u.shape[1])]
    return np.column_stack([np.prod([single[i][k] for i, k in enumerate(term)], axis=0) for term in terms])


def _fit(u: np.ndarray, y: np.ndarray, terms: list[tuple[int, ...]]) -> np.ndarray:
    return np.linalg.lstsq(_basis(u, terms), y, rcond=None)[0]


def _foretold(u: np.ndarray, y: np.ndarray, terms: list[tuple[int, ...]]) -> float:
    """R2 of rows that the fit has not seen, in FOLDS parts."""
    left, fold = np.empty(len(y)), np.arange(len(y)) % FOLDS
    for one in range(FOLDS):
        seen = fold != one
        left[~seen] = y[~seen] - _basis(u[~seen], terms) @ _fit(u[seen], y[seen], terms)
    return float(1.0 - (left**2).sum() / ((y - y.mean()) ** 2).sum())


def _numbers(values: np.ndarray) -> bool:
    try:
        values.astype(float)
    except (TypeError, ValueError):
        return False
    return True
