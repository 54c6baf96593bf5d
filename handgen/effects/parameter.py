"""A number of an effect: unit, physical range, what is believed of it before any test."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Literal

NOTHING = 1e-6
"""Share of a parameter's range within which a value counts as its null."""


@dataclass(frozen=True)
class Prior:
    """What is believed of a parameter that its effect is there, cut off at the parameter's range.

    normal: (mean, deviation); lognormal: (median, deviation of the natural logarithm); point: (value,), for a
    switch that is either on or off.
    """

    kind: Literal["normal", "lognormal", "point"]
    numbers: tuple[float, ...]

    def cumulative(self, value: float) -> float:
        """Share of the prior, not cut off, below `value`."""
        if self.kind == "point":
            return float(value >= self.numbers[0])
        if self.kind == "lognormal":
            return 0.0 if value <= 0.0 else self._normal.cdf(math.log(value))
        return self._normal.cdf(value)

    def inverse(self, share: float) -> float:
        """The value below which `share` of the prior, not cut off, lies."""
        if self.kind == "point":
            return self.numbers[0]
        found = self._normal.inv_cdf(share)
        return math.exp(found) if self.kind == "lognormal" else found

    def density(self, value: float) -> float:
        """Of the prior, not cut off; of a point it is 1 there."""
        if self.kind == "point":
            return float(value == self.numbers[0])
        if self.kind == "lognormal":
            return 0.0 if value <= 0.0 else self._normal.pdf(math.log(value)) / value
        return self._normal.pdf(value)

    @property
    def _normal(self) -> NormalDist:
        middle, deviation = self.numbers
        return NormalDist(math.log(middle) if self.kind == "lognormal" else middle, deviation)


@dataclass(frozen=True)
class Parameter:
    """One number of an effect."""

    name: str
    unit: str
    low: float
    high: float
    null: float
    """The value at which the effect is absent."""
    prior: Prior
    meaning: str

    @property
    def usual(self) -> float | None:
        """Median of the prior: what is taken where a model file leaves the parameter out; None where that is
        as good as nothing, as of an error of either sign."""
        middle = self.quantile(0.5)
        return None if abs(middle - self.null) < NOTHING * (self.high - self.low) else middle

    @property
    def switch(self) -> bool:
        """Whether only two values make sense: `null`, and that of the prior's point."""
        return self.prior.kind == "point"

    def quantile(self, share: float) -> float:
        """The value below which `share` of the prior within the range lies."""
        if self.switch:
            return self.prior.numbers[0]
        below, above = self.prior.cumulative(self.low), self.prior.cumulative(self.high)
        found = self.prior.inverse(min(max(below + share * (above - below), 1e-12), 1.0 - 1e-12))
        return min(max(found, self.low), self.high)

    @property
    def deviation(self) -> float:
        """Half of what the middle 68 % of the prior within the range span."""
        return max((self.quantile(0.84) - self.quantile(0.16)) / 2, NOTHING)

    def density(self, value: float) -> float:
        """Of the prior within the range."""
        if not self.low <= value <= self.high:
            return 0.0
        if self.switch:
            return self.prior.density(value)
        inside = self.prior.cumulative(self.high) - self.prior.cumulative(self.low)
        return self.prior.density(value) / inside

    def grid(self, count: int) -> Sequence[float]:
        """`count` values, spread as the prior is: the middles of shares of equal weight; of a switch one."""
        if self.switch:
            return [self.prior.numbers[0]]
        return [self.quantile((i + 0.5) / count) for i in range(count)]

    def allowed(self, value: float) -> bool:
        if self.switch:
            return value in (self.null, self.prior.numbers[0])
        return self.low <= value <= self.high

    @property
    def range(self) -> str:
        """In words, with the unit."""
        if self.switch:
            return f"{self.null:g} or {self.prior.numbers[0]:g}"
        return f"{self.low:g} to {self.high:g}" + (f" {self.unit}" if self.unit != "1" else "")
