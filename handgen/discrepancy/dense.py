"""A few simulated values of an effect's parameters -> as many as an integral over them asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

FINE = {1: 121, 2: 33, 3: 13}
"""Values an axis, by the number of parameters."""
COARSE = {1: 25, 2: 13, 3: 7}
"""The same where two effects are taken together."""


@dataclass(frozen=True)
class Dense:
    """Predictions at many values of the parameters, and what weight the prior gives to each."""

    values: np.ndarray
    """(m, d)."""
    predictions: np.ndarray
    """(m, n), NaN where the simulation found no balance."""
    log_weights: np.ndarray
    """(m,), their exponentials add up to 1."""
    last: np.ndarray
    """(m,) whether the simulation found no balance at the next value, so that more cannot be judged."""

    def on(self, points: np.ndarray) -> Dense:
        """Only the values that have a prediction at all of `points`: what was not read forbids nothing."""
        there = np.isfinite(self.predictions[:, points]).all(axis=1)
        if there.all():
            return self
        weights = self.log_weights[there]
        if len(weights):
            weights = weights - np.logaddexp.reduce(weights)
        return Dense(self.values[there], self.predictions[there], weights,
                     (self.last | _next_to(~there, self.values))[there])


def dense(axes: Sequence[np.ndarray], densities: Sequence[np.ndarray], predictions: np.ndarray,
          counts: dict[int, int] = FINE) -> Dense:
    """Monotone cubic interpolation (PCHIP) axis by axis; NaN where there is no prediction, see `Dense.on`."""
    d = len(axes)
    count = counts[d]
    lines, weights = [], []
    found = predictions
    for i, (axis, density) in enumerate(zip(axes, densities, strict=True)):
        line = np.linspace(axis[0], axis[-1], count) if len(axis) > 1 else np.asarray(axis, float)
        found = np.moveaxis(_along(axis, np.moveaxis(found, i, 0), line), 0, i)
        ends = np.ones(len(line))
        if len(line) > 1:
            ends[[0, -1]] = 0.5
        lines.append(line)
        table = density if np.ndim(density) == 2 else (axis, density)
        weights.append(np.interp(line, *table) * ends)
    values = np.stack([grid.ravel() for grid in np.meshgrid(*lines, indexing="ij")], axis=1)
    weight = weights[0]
    for more in weights[1:]:
        weight = np.multiply.outer(weight, more)
    weight, found = weight.ravel(), found.reshape(-1, predictions.shape[-1])
    usable = np.isfinite(found).any(axis=1) & (weight > 0)
    last = _next_to(np.isnan(found).all(axis=1) & (weight > 0), values)[usable]
    values, found, weight = values[usable], found[usable], weight[usable]
    return Dense(values, found, np.log(weight / weight.sum()) if len(weight) else weight, last)


def _next_to(marked: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(m,) which of the `values` (m, d) of a grid are `marked` or stand next to one that is."""
    from scipy.ndimage import binary_dilation

    at = tuple(np.unique(column, return_inverse=True)[1] for column in values.T)
    grid = np.zeros([one.max() + 1 for one in at], bool)
    grid[at] = marked
    return binary_dilation(grid)[at]


def _along(axis: np.ndarray, rows: np.ndarray, line: np.ndarray) -> np.ndarray:
    """`rows` (len(axis), ...) at the values of `line`; NaN outside what has a prediction."""
    if len(axis) == 1:
        return rows
    from scipy.interpolate import PchipInterpolator

    flat = rows.reshape(len(axis), -1)
    there = np.isfinite(flat)
    found = np.full((len(line), flat.shape[1]), np.nan)
    for pattern in np.unique(there, axis=1).T:
        columns = np.flatnonzero((there == pattern[:, None]).all(axis=0))
        known = axis[pattern]
        if len(known) >= 2:
            found[:, columns] = PchipInterpolator(known, flat[np.ix_(pattern, columns)],
                                                  extrapolate=False)(line)
    return found.reshape(len(line), *rows.shape[1:])
