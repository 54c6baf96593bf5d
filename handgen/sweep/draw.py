"""Axes -> points: grids, and Sobol sequences through each axis's distribution."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator
from typing import Any

from handgen.sweep.model import Axis, Sweep

BLOCK = 1024
"""Points of a Sobol sequence drawn at once."""
DIGITS = 9
"""Significant digits of a drawn number: what a file would say, and the same on every machine."""


def count(sweep: Sweep) -> int:
    """How many variants the sweep has (an optimisation: at most)."""
    if sweep.method == "grid":
        return math.prod(len(levels(axis)) for axis in sweep.vary.values())
    return sweep.budget or 0


def points(sweep: Sweep) -> Iterator[dict[str, Any]]:
    """Axis -> value, variant by variant: a grid's last axis fastest.

    Raises:
        ValueError: an optimisation has no points beforehand.
    """
    axes = sweep.vary
    if sweep.method == "grid":
        for values in itertools.product(*(levels(axis) for axis in axes.values())):
            yield dict(zip(axes, values, strict=True))
    elif sweep.method == "sobol":
        from scipy.stats import qmc

        engine, left = qmc.Sobol(len(axes), scramble=True, rng=sweep.seed), count(sweep)
        while left:
            block = min(left, BLOCK)
            with warnings.catch_warnings():
                # A budget that is no power of two is the user's choice.
                warnings.simplefilter("ignore", UserWarning)
                drawn = engine.random(block)
            for row in drawn:
                yield {name: value(axis, float(u)) for (name, axis), u in zip(axes.items(), row, strict=True)}
            left -= block
    else:
        raise ValueError(f"`method: {sweep.method}` draws as it goes")


def levels(axis: Axis) -> list[Any]:
    """The axis's values on a grid."""
    return [_level(axis, i) for i in range(_size(axis))]


def _size(axis: Axis) -> int:
    """How many levels."""
    if axis.choices is not None:
        return len(axis.choices)
    return axis.steps or math.floor((axis.high - axis.low) / axis.step * (1 + 1e-12)) + 1


def _level(axis: Axis, i: int) -> Any:
    if axis.choices is not None:
        return axis.choices[i]
    if axis.steps is None:
        return tidy(axis.low + i * axis.step)
    if axis.distribution is not None:
        return _between(axis, (i + 0.5) / axis.steps)
    return tidy(axis.low + i * (axis.high - axis.low) / max(axis.steps - 1, 1))


def stepped(axis: Axis) -> bool:
    """Whether the axis has no values but its levels."""
    return axis.choices is not None or axis.step is not None or axis.steps is not None


def value(axis: Axis, u: float) -> Any:
    """The axis's value at the share `u` (0 to 1) of its distribution."""
    if stepped(axis):
        size = _size(axis)
        return _level(axis, min(int(u * size), size - 1))
    return _between(axis, u)


def _between(axis: Axis, u: float) -> float:
    match axis.distribution:
        case "normal":
            return tidy(_normal(axis, u))
        case "loguniform":
            return tidy(axis.low * (axis.high / axis.low) ** u)
        case "triangular":
            at = (axis.mode - axis.low) / (axis.high - axis.low)
            width = axis.high - axis.low
            return tidy(axis.low + width * math.sqrt(u * at) if u < at
                        else axis.high - width * math.sqrt((1 - u) * (1 - at)))
    return tidy(axis.low + u * (axis.high - axis.low))


def share(axis: Axis, given: Any) -> float:
    """Where `given` lies on the axis, 0 to 1; of choices the middle of its part. The inverse of `value`."""
    if axis.choices is not None:
        return (axis.choices.index(given) + 0.5) / len(axis.choices)
    match axis.distribution:
        case "normal":
            from scipy.stats import norm

            low, high = cut(axis)
            return float((norm.cdf((given - axis.mean) / axis.sigma) - low) / (high - low))
        case "loguniform":
            return math.log(given / axis.low) / math.log(axis.high / axis.low)
        case "triangular":
            width, at = axis.high - axis.low, axis.mode - axis.low
            return ((given - axis.low) ** 2 / (width * at) if given < axis.mode
                    else 1 - (axis.high - given) ** 2 / (width * (width - at)))
    return (given - axis.low) / (axis.high - axis.low)


def tidy(number: float) -> float:
    """`number` with as many digits as are kept."""
    return float(f"{number:.{DIGITS}g}")


def plain(data: Any) -> Any:
    """`data` with whole numbers as any others: 8 and 8.0 are one value."""
    if isinstance(data, dict):
        return {key: plain(child) for key, child in data.items()}
    if isinstance(data, list | tuple):
        return [plain(child) for child in data]
    return float(data) if isinstance(data, int) and not isinstance(data, bool) else data


def cut(axis: Axis) -> tuple[float, float]:
    """Shares of the whole bell below the axis's two ends."""
    from scipy.stats import norm

    low = 0.0 if axis.low is None else norm.cdf((axis.low - axis.mean) / axis.sigma)
    high = 1.0 if axis.high is None else norm.cdf((axis.high - axis.mean) / axis.sigma)
    return float(low), float(high)


def _normal(axis: Axis, u: float) -> float:
    from scipy.stats import norm

    low, high = cut(axis)
    return axis.mean + axis.sigma * float(norm.ppf(min(max(low + u * (high - low), 1e-9), 1 - 1e-9)))
