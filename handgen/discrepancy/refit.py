"""A model's open numbers, fitted by the full simulation with their priors; then load after load left out.

The linearised scoring finds where to begin; what is reported is simulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from handgen.bending.model import BendModel
from handgen.discrepancy import nuisance, simulated
from handgen.discrepancy.hypothesis import Hypothesis
from handgen.discrepancy.problem import Problem
from handgen.discrepancy.simulated import Row, Simulation
from handgen.effects import Parameter, catalogue

ROUNDS = 3
STEP = 0.05
"""Of an effect's parameter for finite differences, as a share of its prior's middle 68 %."""
SETTLED = 0.1
"""Deviations that no number still moves by when the fit has arrived."""


@dataclass(frozen=True)
class Number:
    """One number to fit: a nuisance, or a parameter of an effect."""

    effect: str | None
    name: str
    mean: float
    sigma: float
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True)
class Fitted:
    """A model with its numbers fitted, and what it predicts."""

    numbers: tuple[Number, ...]
    values: np.ndarray
    covariance: np.ndarray
    predicted: np.ndarray
    """(n,) of the full simulation, at all points of the library."""
    left_out: np.ndarray
    """(n,) where each load was predicted by a fit that had not seen it; NaN where that has no meaning."""

    def effects(self) -> dict[str, dict[str, float]]:
        """Parameters of each effect."""
        found: dict[str, dict[str, float]] = {}
        for number, value in zip(self.numbers, self.values, strict=True):
            if number.effect is not None:
                found.setdefault(number.effect, {})[number.name] = float(value)
        return found

    def nuisances(self) -> dict[str, float]:
        return {
            number.name: float(value)
            for number, value in zip(self.numbers, self.values, strict=True)
            if number.effect is None
        }

    def sigma(self, effect: str | None, name: str) -> float:
        at = next(i for i, n in enumerate(self.numbers) if (n.effect, n.name) == (effect, name))
        return float(np.sqrt(self.covariance[at, at]))


@dataclass
class Refit:
    """Fits one explanation of a problem."""

    simulation: Simulation
    problem: Problem
    left_open: Sequence[nuisance.Nuisance]
    ids: tuple[str, ...] = ()
    what: str = "re-tuning"

    def __post_init__(self) -> None:
        numbers = [Number(None, one.name, 0.0, one.sigma) for one in self.left_open]
        known = catalogue()
        for name in self.ids:
            for parameter in known[name].parameters:
                if parameter.switch:
                    continue
                numbers.append(
                    Number(name, parameter.name, *_normal(parameter), parameter.low, parameter.high)
                )
        self.numbers = tuple(numbers)

    def run(self, begin: Hypothesis) -> Fitted:
        """The fit, from where the scoring left `begin`."""
        values = self._begin(begin)
        predicted, slopes = self._predicted(values), None
        for _ in range(ROUNDS):
            slopes = self._slopes(values, predicted)
            target = self._step(values, predicted, slopes, self.problem.used)
            moved = np.abs(target - values) / np.array([n.sigma for n in self.numbers])
            better = self._predicted(target)
            if self._loss(target, better) > self._loss(values, predicted):
                target = (values + target) / 2
                better = self._predicted(target)
                if self._loss(target, better) > self._loss(values, predicted):
                    break
            values, predicted = target, better
            if moved.max() < SETTLED:
                break
        left_out = self._left_out(values, predicted, slopes)
        return Fitted(self.numbers, values, self._covariance(slopes), predicted, left_out)

    def model(self, values: np.ndarray) -> BendModel:
        """The model with its effects at `values`."""
        effects: dict[str, dict[str, float]] = {name: {} for name in self.ids}
        for number, value in zip(self.numbers, values, strict=True):
            if number.effect is not None:
                effects[number.effect][number.name] = float(value)
        return self.simulation.with_effects(effects)

    # One round

    def _begin(self, begin: Hypothesis) -> np.ndarray:
        found = []
        for number in self.numbers:
            if number.effect is None:
                found.append(float(begin.nuisances[self._column(number.name)]))
            else:
                one = next(e for e in begin.parameters[number.effect] if e.name == number.name)
                found.append(min(max(one.value, number.low), number.high))
        return np.array(found)

    def _column(self, name: str) -> int:
        return [one.name for one in self.left_open].index(name)

    def _row(self, values: np.ndarray) -> Row:
        open_values = {
            n.name: float(v) for n, v in zip(self.numbers, values, strict=True) if n.effect is None
        }
        return self.simulation.row(self.model(values), simulated.shifted(self.left_open, open_values))

    def _zeros(self, values: np.ndarray) -> np.ndarray:
        """(n,) what the zeros of the readings add."""
        zeros = np.array(
            [
                value if number.effect is None and number.name.startswith("zero") else 0.0
                for number, value in zip(self.numbers, values, strict=True)
            ]
        )
        return self._left_open_slopes @ zeros[: len(self.left_open)]

    def _predicted(self, values: np.ndarray) -> np.ndarray:
        return self.simulation.predict([self._row(values)], self.what)[0] + self._zeros(values)

    def _slopes(self, values: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """(n, numbers)."""
        moves, steps = [], []
        for i, number in enumerate(self.numbers):
            if number.name.startswith("zero") and number.effect is None:
                continue
            step = (nuisance.STEP if number.effect is None else STEP) * number.sigma
            if values[i] + step > number.high:
                step = -step
            moves.append(values + step * np.eye(len(values))[i])
            steps.append((i, step))
        rows = self.simulation.predict([self._row(move) for move in moves], self.what)
        slopes = np.zeros((len(predicted), len(values)))
        slopes[:, : len(self.left_open)] = self._left_open_slopes
        for (i, step), move, row in zip(steps, moves, rows, strict=True):
            found = (row + self._zeros(move) - predicted) / step
            slopes[:, i] = np.where(np.isfinite(found), found, slopes[:, i])
        return slopes

    @property
    def _left_open_slopes(self) -> np.ndarray:
        """(n, nuisances) of the library, less those of the sizes of effects that are on."""
        return self.problem.library.jacobian[:, : len(self.left_open)]

    def _weights(self, used: np.ndarray) -> np.ndarray:
        """(s, s) inverse covariance of readings and structural error, of the points that are `used`."""
        at = self.problem.points[used]
        structural = self.problem.structural(self.ids)[np.ix_(at, at)]
        return np.linalg.inv(structural + self.problem.errors[np.ix_(used, used)])

    def _priors(self) -> tuple[np.ndarray, np.ndarray]:
        return (np.array([n.mean for n in self.numbers]), np.diag([1 / n.sigma**2 for n in self.numbers]))

    def _step(
        self, values: np.ndarray, predicted: np.ndarray, slopes: np.ndarray, used: np.ndarray
    ) -> np.ndarray:
        """The values that the linearised problem asks for, within bounds."""
        at = self.problem.points[used]
        there = np.isfinite(predicted[at])
        used = np.flatnonzero(used)[there]
        at = self.problem.points[used]
        weights = self._weights(np.isin(np.arange(len(self.problem.points)), used))
        mean, precision = self._priors()
        matrix, residual = slopes[at], self.problem.means[used] - predicted[at]
        normal = matrix.T @ weights @ matrix + precision
        right = matrix.T @ weights @ residual + precision @ (mean - values)
        found = values + np.linalg.solve(normal, right)
        return np.clip(found, [n.low for n in self.numbers], [n.high for n in self.numbers])

    def _loss(self, values: np.ndarray, predicted: np.ndarray) -> float:
        residual = self.problem.data - predicted[self.problem.scored]
        if not np.isfinite(residual).all():
            return np.inf
        mean, precision = self._priors()
        return float(
            residual @ self._weights(self.problem.used) @ residual
            + (values - mean) @ precision @ (values - mean)
        )

    def _covariance(self, slopes: np.ndarray) -> np.ndarray:
        matrix = slopes[self.problem.scored]
        return np.linalg.inv(matrix.T @ self._weights(self.problem.used) @ matrix + self._priors()[1])

    def _left_out(self, values: np.ndarray, predicted: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Every scored load predicted by a fit without it; of one that is never fitted, `predicted`."""
        found = np.where(np.isin(np.arange(len(predicted)), self.problem.points), predicted, np.nan)
        folds = np.flatnonzero(self.problem.used)
        rows, moves = [], []
        owner = self.problem.library.owner
        for fold in folds:
            used = self.problem.used.copy()
            used[fold] = False
            move = self._step(values, predicted, slopes, used)
            row = self._row(move)
            mine = owner[self.problem.points[fold]]
            rows.append(
                replace(
                    row,
                    requests=tuple(request if i == mine else None for i, request in enumerate(row.requests)),
                )
            )
            moves.append(move)
        predictions = self.simulation.predict(rows, f"{self.what}, load after load left out")
        for fold, move, row in zip(folds, moves, predictions, strict=True):
            point = self.problem.points[fold]
            found[point] = row[point] + self._zeros(move)[point]
        return found


def _normal(parameter: Parameter) -> tuple[float, float]:
    """Mean and deviation of a parameter's prior, by its middle 68 %."""
    return (parameter.quantile(0.16) + parameter.quantile(0.84)) / 2, parameter.deviation
