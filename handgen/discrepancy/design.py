"""At which values of its parameters an effect is simulated, and what its prior says between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handgen.effects import Effect

SHARES = {1: (0.001, 0.02, 0.2, 0.5, 0.8, 0.98, 0.999), 2: (0.05, 0.5, 0.95), 3: (0.1, 0.9)}
"""Quantiles of a prior that are simulated, by the number of parameters: what lies beyond the outermost is
called something unknown."""
FIRST = {2: (0.05, 0.35, 0.7, 0.97, 0.999)}
"""Of the first of several parameters, which is the effect's size."""
TABLE = 201


def axes(effect: Effect) -> tuple[np.ndarray, ...]:
    """Ascending values of each parameter. Of a single one the null is among them, where its range has it."""
    found = []
    for i, parameter in enumerate(effect.parameters):
        if parameter.switch:
            found.append(np.array(parameter.grid(1), float))
            continue
        count = len(effect.parameters)
        shares = FIRST.get(count, SHARES[count]) if i == 0 else SHARES[count]
        values = {parameter.quantile(share) for share in shares}
        if count == 1 and parameter.low <= parameter.null <= parameter.high:
            values.add(parameter.null)
        found.append(np.array(sorted(values), float))
    return tuple(found)


def densities(effect: Effect, grid: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Tables (2, TABLE) of value and prior density over each axis."""
    found = []
    for parameter, axis in zip(effect.parameters, grid, strict=True):
        if len(axis) == 1:
            found.append(np.ones(1))
            continue
        line = np.linspace(axis[0], axis[-1], TABLE)
        found.append(np.array([line, [parameter.density(value) for value in line]]))
    return tuple(found)
