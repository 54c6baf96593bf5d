"""An explanation of the data: before its probability is known, and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from handgen.discrepancy.library import OUTSIDE
from handgen.discrepancy.problem import Problem

INTERVAL, WIDE = (0.025, 0.975), (0.005, 0.995)
REFUTED = 0.001
"""Chance of its misfit below which an explanation is given up, whatever was believed of it before."""


@dataclass(frozen=True)
class Estimate:
    """A parameter as the data leave it: the value that explains them best, a 95 % and a 99 % interval."""

    name: str
    value: float
    low: float
    high: float
    wide: tuple[float, float]


@dataclass(frozen=True)
class Hypothesis:
    """One explanation. `ids`: its effects, those that are on in its library first."""

    id: str
    ids: tuple[str, ...]
    log_evidence: float
    probability: float
    parameters: Mapping[str, tuple[Estimate, ...]]
    """Of each effect."""
    nuisances: np.ndarray
    """(k,) as the data leave them, in their own units."""
    nuisance_covariance: np.ndarray
    centre: np.ndarray
    """(n,) predictions before nuisances."""
    predicted: np.ndarray
    """(n,) at all points of the library, nuisances included, structural error not."""
    chi2: float
    """Of the scored residuals, against everything that the hypothesis leaves open."""
    freedoms: int
    p_value: float
    cut: tuple[str, ...] = ()
    """Effects of which the most probable size is the last that the simulation found a balance for."""

    @property
    def refuted(self) -> bool:
        """Whether it does not fit even at its most probable size."""
        return self.p_value < REFUTED

    @property
    def outside(self) -> bool:
        """Whether something is in it that no effect explains."""
        return self.id.split("+")[-1] == OUTSIDE

    def more_than(self, effects: Sequence[str]) -> bool:
        """Whether it holds all of `effects`, and something beside them."""
        return set(effects) <= set(self.ids) and (self.outside or len(self.ids) > len(effects))


@dataclass(frozen=True)
class Draft:
    """A hypothesis before its probability is known. `ids`: its effects beside those that are on."""

    id: str
    ids: tuple[str, ...]
    log_evidence: float
    parameters: Mapping[str, tuple[Estimate, ...]]
    centre: np.ndarray
    """(n,) predictions before nuisances."""
    count: int
    """Parameters of its effects."""
    problem: Problem
    cut: tuple[str, ...] = ()

    outside = Hypothesis.outside


def estimates(names: Sequence[str], values: np.ndarray, log_posterior: np.ndarray) -> tuple[Estimate, ...]:
    """Best value and interval of each parameter; `values` (m, d), `log_posterior` (m,) up to a constant."""
    share = np.exp(log_posterior - log_posterior.max())
    share /= share.sum()
    best = values[int(log_posterior.argmax())]
    found = []
    for i, name in enumerate(names):
        line, mass = values[:, i], share
        if len(names) > 1:
            line, where = np.unique(line, return_inverse=True)
            mass = np.bincount(where, share)
        # Half of a value's weight lies below it
        below = np.cumsum(mass) - mass / 2
        (low, high), wide = (_holding(float(best[i]), np.interp(shares, below, line))
                             for shares in (INTERVAL, WIDE))
        found.append(Estimate(name, float(best[i]), low, high, wide))
    return tuple(found)


def _holding(value: float, ends: np.ndarray) -> tuple[float, float]:
    return float(min(ends[0], value)), float(max(ends[1], value))
