"""What repeats say: the mean of each load, its scatter, and the scatter of one reading pooled over loads."""

from __future__ import annotations

import math
from collections.abc import Sequence

from handgen.measurements.model import Test


def columns(test: Test) -> list[list[float]]:
    """The readings there are of each load."""
    return [[reading for reading in column if reading is not None]
            for column in zip(*test.repeats, strict=True)]


def means(test: Test) -> list[float | None]:
    """Of each load; None where nothing was read."""
    return [sum(column) / len(column) if column else None for column in columns(test)]


def pooled_deviation(test: Test, which: Sequence[bool] | None = None) -> float | None:
    """Standard deviation of one reading among its repeats, over all loads, or over those of `which`.

    sqrt(sum (x - mean)^2 / sum (n - 1)), in the observable's unit; None without repeats.
    """
    squares, freedoms = 0.0, 0
    for column, wanted in zip(columns(test), which or [True] * len(test.load.values), strict=True):
        if column and wanted:
            mean = sum(column) / len(column)
            squares += sum((reading - mean) ** 2 for reading in column)
            freedoms += len(column) - 1
    return math.sqrt(squares / freedoms) if freedoms else None


def rms(residuals: Sequence[float]) -> float:
    """Root of the mean square."""
    return math.sqrt(sum(r * r for r in residuals) / len(residuals))
