"""Least squares on one measured test: what its readings determine, and how far each assumption carries it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from handgen.bending.comparison import Gap, gap
from handgen.errors import EngineError
from handgen.measurements.model import Test
from handgen.measurements.statistics import means, pooled_deviation

Simulate = Callable[..., list[float | None]]
"""(unknowns by name, assumptions by name) -> what the test reads at each of its loads."""
STEP = 0.01
"""Of the finite differences, as a share of a value: what it moves is a thousand times the solver's noise."""
EVALUATIONS = 30
"""Of the residuals at most, those for differences not counted."""
CLOSE = 1e-4
"""Relative change of values or squares at which a fit has arrived."""


@dataclass(frozen=True)
class Unknown:
    """A number to be found, where the search starts, what it may be, and how many decimals are kept."""

    name: str
    unit: str
    start: float
    low: float
    high: float
    places: int


@dataclass(frozen=True)
class Fit:
    """Values found, rounded as they are kept, and what they give."""

    values: Mapping[str, float]
    deviations: Mapping[str, float]
    """Standard deviations from the scatter of the repeats alone."""
    simulated: Sequence[float | None]
    gap: Gap
    """Over the loads that were fitted."""


@dataclass(frozen=True)
class Assumption:
    """Something else that could be so, and the fit that it leads to."""

    what: str
    fit: Fit


def fit(test: Test, unknowns: Sequence[Unknown], simulate: Simulate, begin: Mapping[str, float] | None = None,
        **assumptions) -> Fit:
    """The unknowns for which `simulate` comes closest to the means of `test`, where they may be fitted.

    The search starts from `begin`, or from where the unknowns say.

    Raises:
        EngineError: the solver gave up on the way, or the search did not arrive.
    """
    from scipy.optimize import least_squares

    names = [unknown.name for unknown in unknowns]
    wanted = [mean if may else None for mean, may in zip(means(test), test.fitted, strict=True)]

    def residuals(values: np.ndarray) -> np.ndarray:
        found = simulate(dict(zip(names, map(float, values), strict=True)), **assumptions)
        pairs = [(f, w) for f, w in zip(found, wanted, strict=True) if w is not None]
        if any(f is None for f, _ in pairs):
            raise EngineError(f"{test.id}: no balance with {dict(zip(names, values, strict=True))}")
        return np.array([f - w for f, w in pairs])

    start = [begin[u.name] if begin else u.start for u in unknowns]
    solved = least_squares(residuals, start, bounds=([u.low for u in unknowns], [u.high for u in unknowns]),
                           x_scale=start, diff_step=STEP, xtol=CLOSE, ftol=CLOSE, max_nfev=EVALUATIONS)
    if not solved.success:
        raise EngineError(f"{test.id}: the fit of {', '.join(names)} did not arrive")
    if limits := [name for name, at in zip(names, solved.active_mask, strict=True) if at]:
        raise EngineError(f"{test.id}: the fit runs to the limit of {', '.join(limits)}")
    values = {u.name: round(float(v), u.places) for u, v in zip(unknowns, solved.x, strict=True)}
    one_mean = (pooled_deviation(test, test.fitted) or 0.0) / np.sqrt(len(test.repeats))
    deviations = one_mean * np.sqrt(np.diag(np.linalg.inv(solved.jac.T @ solved.jac)))
    simulated = simulate(values, **assumptions)
    return Fit(values, dict(zip(names, map(float, deviations), strict=True)), simulated,
               gap(test, simulated, fitted=True))


def spread(name: str, fitted: Fit, others: Sequence[Assumption]) -> tuple[float, float]:
    """(least, largest) value of `name` that the assumptions and two deviations of the repeats allow."""
    value, sigma = fitted.values[name], fitted.deviations[name]
    found = [value - 2 * sigma, value + 2 * sigma, *(other.fit.values[name] for other in others)]
    return min(found), max(found)
