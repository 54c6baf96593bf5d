"""Which test to do next: the one in which the explanations that are left foresee different readings.

Box and Hill (Technometrics 9 (1967) 57-71) weigh the divergence of every two predictions by how probable both
are; here the divergence is bounded (one less Bhattacharyya's coefficient), so that one far-fetched
explanation cannot choose the test.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from handgen.discrepancy.problem import Problem
from handgen.discrepancy.score import Grid, Scores
from handgen.discrepancy.untold import telling

TOLD = 0.7
"""Bhattacharyya's coefficient below which a test helps to tell two explanations apart: of two as probable as
each other, at most half of it is taken for the wrong one."""
WORTH = 0.01
"""Gain below which no test is worth doing."""
LIKELY = 0.02
"""Probability below which an explanation is not asked about."""


@dataclass(frozen=True)
class Proposal:
    """A test that is worth doing."""

    test: str
    gain: float
    """Probability that two explanations, drawn as they are believed, are two and are told apart."""
    separates: tuple[str, ...]
    """Explanations that it tells from the most probable one, and that one."""


def next_test(scores: Scores, candidates: Sequence[str], sigmas: Mapping[str, float],
              untold: Sequence[str] = (), or_both: Sequence[str] = ()) -> Proposal | None:
    """The best of `candidates`, tests of the library that were not done yet; None if none tells anything.

    `sigmas`: of a mean reading, by quantity, in its unit. `untold`: effects that are to be parted first, or
    else the explanations `or_both`, however probable each of them is.
    """
    if untold:
        means = set().union(*(telling(*two) for two in combinations(untold, 2)))
        able = {test.id for test in scores.problem.library.tests if {test.path, test.quantity} & means}
        scores, candidates = _even(scores, untold), [name for name in candidates if name in able]
    elif or_both:
        scores = _even(scores, or_both)
    found = [proposal(scores, name, sigmas) for name in candidates]
    best = max(found, key=lambda one: one.gain, default=None)
    return best if best is not None and best.gain >= WORTH else None


def _even(scores: Scores, ids: Sequence[str]) -> Scores:
    """Each of `ids` alone is as probable as the others, and nothing else is: what was believed of them before
    counts for nothing."""
    kept = [replace(h, probability=1 / len(ids)) for h in scores.hypotheses if h.id in ids]
    return replace(scores, hypotheses=tuple(kept))


def proposal(scores: Scores, test: str, sigmas: Mapping[str, float]) -> Proposal:
    """What `test` would tell."""
    problem, library = scores.problem, scores.problem.library
    points = library.points(test)
    asked = [h for h in scores.hypotheses if h.probability >= LIKELY and not h.outside]
    there = np.isfinite(np.array([library.baseline, *(h.centre for h in asked)])).all(axis=0)
    points = points[there[points]]
    series = next(one for one in library.tests if one.id == test)
    noise = sigmas[series.quantity] ** 2 * np.eye(len(points))
    if len(points) == 0 or len(asked) < 2:
        return Proposal(test, 0.0, ())
    foreseen = {h.id: foresee(problem, h.ids, h.centre, points) for h in asked}
    gain, first = 0.0, {}
    for a, b in combinations(asked, 2):
        alike = coefficient(foreseen[a.id], foreseen[b.id], noise)
        gain += 2 * a.probability * b.probability * (1 - alike)
        if a is asked[0]:
            first[b.id] = alike
    told = [name for name, alike in first.items() if alike < TOLD] or [min(first, key=first.get)]
    return Proposal(test, gain, (asked[0].id, *told))


def foresee(
    problem: Problem, ids: Sequence[str], centre: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(mean, covariance) of a test's means by an explanation, given all that was read; no reading error."""
    whiten = problem.whitener(ids)
    gain = whiten(problem.model(points, problem.scored, ids=ids))
    left = problem.model(points, points, ids=ids) - gain @ gain.T
    added = [name for name in ids if name not in problem.library.on]
    if len(added) == 1:
        grid = Grid.of(problem, [whiten], added[0], [1.0])
        log = grid.log_densities[0] + grid.log_weights
        share = np.exp(log - log.max())
        share /= share.sum()
        predictions = grid.predictions[:, points] + grid.white[0] @ gain.T
    else:
        share = np.ones(1)
        predictions = (centre[points] + gain @ whiten(problem.data - centre[problem.scored]))[None, :]
    predictions, share = (
        predictions[np.isfinite(predictions).all(axis=1)],
        share[np.isfinite(predictions).all(axis=1)],
    )
    mean = share @ predictions
    apart = predictions - mean
    return mean, left + (apart * share[:, None]).T @ apart


def coefficient(
    a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray], noise: np.ndarray
) -> float:
    """Bhattacharyya's coefficient of two Gaussians read with `noise`: 1 for the same, 0 for far apart."""
    first, second = a[1] + noise, b[1] + noise
    middle = (first + second) / 2
    apart = a[0] - b[0]
    logs = [np.linalg.slogdet(matrix)[1] for matrix in (middle, first, second)]
    distance = apart @ np.linalg.solve(middle, apart) / 8 + (logs[0] - (logs[1] + logs[2]) / 2) / 2
    return float(np.exp(-max(distance, 0.0)))
