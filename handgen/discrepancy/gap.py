"""Three gaps side by side: the model as it was, re-tuned only, and patched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handgen.discrepancy.problem import Problem
from handgen.discrepancy.refit import Fitted
from handgen.measurements.statistics import rms

STATES = ("before", "retuned", "patched")


@dataclass(frozen=True)
class TestGap:
    """RMS of prediction less mean reading over one test's loads, in its unit."""

    test: str
    unit: str
    fitted: dict[str, float | None]
    """Over loads that were fitted."""
    held_out: dict[str, float | None]
    """The same loads, each predicted by a fit without it; of a held-out test all loads."""
    never_fitted: bool
    """No load of this test was fitted."""
    __test__ = False


def gaps(problem: Problem, before: np.ndarray, retuned: Fitted, patched: Fitted) -> list[TestGap]:
    """Of every test with a reading. Predictions are at all points of the problem's library."""
    predicted = {"before": before, "retuned": retuned.predicted, "patched": patched.predicted}
    left_out = {"before": before, "retuned": retuned.left_out, "patched": patched.left_out}
    found = []
    for i, test in enumerate(problem.library.tests):
        mine = problem.library.owner[problem.points] == i
        if not mine.any():
            continue
        scored = mine & problem.used
        never = not scored.any()
        rows = mine if never else scored
        found.append(TestGap(
            test.id, test.unit,
            dict.fromkeys(STATES) if never else {s: _rms(problem, predicted[s], rows) for s in STATES},
            {s: _rms(problem, left_out[s], rows) for s in STATES}, never))
    return found


def pooled(problem: Problem, values: dict[str, np.ndarray], unit: str) -> dict[str, float | None]:
    """RMS over all scored points that are read in `unit`."""
    mine = np.array([problem.library.tests[i].unit == unit for i in problem.library.owner[problem.points]])
    return {state: _rms(problem, value, mine & problem.used) for state, value in values.items()}


def unit_of(problem: Problem) -> str:
    """The unit that most scored points are read in."""
    units = [problem.library.tests[i].unit for i in problem.library.owner[problem.scored]]
    return max(dict.fromkeys(units), key=units.count)


def _rms(problem: Problem, predicted: np.ndarray, rows: np.ndarray) -> float | None:
    residual = (predicted[problem.points] - problem.means)[rows]
    residual = residual[np.isfinite(residual)]
    return rms(residual.tolist()) if len(residual) else None
