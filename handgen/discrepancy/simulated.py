"""The library of a model, from the full simulation: baseline, nuisances, every effect, an ensemble.

Every bend goes through the cache by the content of its case: what an effect does not touch is not solved
again, neither in this diagnosis nor in the next.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from handgen.bending.comparison import asked, direct, observed
from handgen.bending.model import BendModel
from handgen.bending.model import Effect as Switch
from handgen.bending.request import Request
from handgen.discrepancy import design, nuisance, tolerance
from handgen.discrepancy.library import Interplay, Library, Response, Series, Sizes, same_state, size_name
from handgen.discrepancy.worker import Bends
from handgen.effects import Parameter, catalogue
from handgen.errors import EngineError, InputError
from handgen.measurements.load import Measured
from handgen.measurements.model import Test
from handgen.simulation.case import Case, Curve

MESH = 0.012
"""Deviation of a coarse mesh, as a share of a test's largest prediction: `--refine 1` moves the adult index
finger by 0.6 mm and the free actuator by 1.3 %. Smooth over the load."""
SMOOTH = 0.5
"""Loads over which it changes, as a share of the largest."""
SHRINK = 0.1
"""Share of the ensemble's correlations that is not believed: it has few members."""
FEW = 8
"""Fingers within tolerance, where a test is only to be chosen."""
LOCAL = 16
"""The same, with an effect on."""
SEEN = 1e-6
"""Shares of a reading below which an effect does nothing."""


@dataclass(frozen=True)
class Row:
    """One prediction of all tests: a request a test, or why there is none."""

    requests: tuple[Request | None, ...]


@dataclass
class Simulation:
    """All about one model and the tests that it is held against."""

    measured: Measured
    tests: Sequence[Test]
    model: BendModel
    bends: Bends
    seed: int = 0
    """Of the ensemble within tolerance."""
    on: Mapping[str, Sizes] = field(default_factory=dict)
    """Effects that are on beside the model's own, at these sizes, which are open."""

    def row(self, model: BendModel | None = None, change=lambda case: case) -> Row:
        """Requests for every test by `model`, with each case changed; None where a hand forbids it."""
        found = []
        for test in self.tests:
            try:
                one = asked(self.measured, test, model or self.with_effects({}))
                found.append(replace(one, case=change(one.case)))
            except (InputError, ValueError):
                found.append(None)
        return Row(tuple(found))

    def predict(self, rows: Sequence[Row], what: str) -> np.ndarray:
        """(rows, n), NaN where there is no balance."""
        wanted = [request for row in rows for test, request in zip(self.tests, row.requests, strict=True)
                  if request is not None and not test.direct]
        curves = iter(self.bends.curves(wanted, what))
        lines = []
        for row in rows:
            line: list[float] = []
            for test, request in zip(self.tests, row.requests, strict=True):
                if request is not None and test.direct:
                    line += _numbers(direct(test, request))
                else:
                    line += read(test, next(curves) if request is not None else None)
            lines.append(line)
        return np.array(lines, float)

    def with_effects(self, effects: Mapping[str, Sizes]) -> BendModel:
        """The model with these effects on beside its own, and beside those that are on."""
        more = [Switch(id=name, parameters=dict(values)) for name, values in {**self.on, **effects}.items()]
        return self.model.model_copy(update={"effects": [*self.model.effects, *more]})

    def including(self, name: str, parameters: Sizes) -> Simulation:
        """The same of a model that has an effect of its own more."""
        own = Switch(id=name, parameters=dict(parameters))
        return replace(self, model=self.model.model_copy(update={"effects": [*self.model.effects, own]}))

    def localised(self, library: Library, values: Mapping[str, Sizes]) -> Library:
        """`library` with what is open simulated anew with some effects on, each at its `values`.

        A finger that hangs by its own weight asks for its stiffness where a weightless one does not.
        """
        left_open = nuisance.nuisances(list(self.tests))
        found = dict(library.responses)
        for name, parameters in values.items():
            other = self.including(name, parameters)
            middle = other.predict([other.row()], f"{name} at its most probable size")[0]
            slopes, spread = jacobian(other, middle, left_open), structural(other, middle, LOCAL)
            there = np.isfinite(slopes).all(axis=1)
            found[name] = replace(
                found[name], jacobian=np.where(there[:, None], slopes, library.jacobian),
                structural=where_known(there, spread, library.structural))
        return replace(library, responses=found)

    def together(self, library: Library,
                 pairs: Mapping[tuple[str, str], tuple[Sizes, Sizes]]) -> Library:
        """`library` with what two effects do together, of each of `pairs` at these sizes of both."""
        wanted = [effects for (a, b), (first, second) in pairs.items()
                  for effects in ({a: first, b: second}, {a: first}, {b: second})]
        rows = [self.row(self.with_effects(effects)) for effects in wanted]
        predictions = self.predict(rows, f"{len(pairs)} pairs")
        found = dict(library.interplays)
        moved = (predictions - library.baseline).reshape(len(pairs), 3, -1)
        for two, (both, *alone) in zip(pairs, moved, strict=True):
            found[two] = Interplay(np.array(alone), both - sum(alone))
        return replace(library, interplays=found)


def read(test: Test, curve: Curve | None) -> list[float]:
    """What `test` reads off `curve` at each of its loads; NaN where there is nothing."""
    if curve is None:
        return [np.nan] * len(test.load.values)
    return _numbers(observed(test, curve))


def _numbers(values: Sequence[float | None]) -> list[float]:
    return [np.nan if value is None else value for value in values]


def series(test: Test) -> Series:
    return Series(test.id, test.part, test.observable.quantity, tuple(test.load.values), test.observable.unit,
                  test.load.quantity, test.orientation, test.path, test.obstacle)


def library(simulation: Simulation, only: Sequence[str] | None = None,
            members: int = tolerance.MEMBERS) -> Library:
    """Everything that the scoring needs; of `only` some effects, with so many fingers within tolerance.

    Raises:
        InputError: hand and model do not fit together.
        EngineError: the model finds no balance at any load of any test.
    """
    for test in simulation.tests:
        asked(simulation.measured, test, simulation.model)
    baseline = simulation.predict([simulation.row()], "the model as it is")[0]
    if not np.isfinite(baseline).any():
        raise EngineError(f"the model {simulation.model.name} finds no balance at any load of any test")
    left_open = nuisance.nuisances(list(simulation.tests))
    sizes = _sizes(simulation)
    sigmas = [one.sigma for one in left_open] + [one.deviation for _, one in sizes]
    return Library(
        tuple(series(test) for test in simulation.tests), baseline,
        (*(one.name for one in left_open), *(size_name(name, one.name) for name, one in sizes)),
        np.diag(np.square(sigmas)), jacobian(simulation, baseline, left_open),
        responses(simulation, baseline, only), structural(simulation, baseline, members),
        on={name: dict(values) for name, values in simulation.on.items()})


def _sizes(simulation: Simulation) -> list[tuple[str, Parameter]]:
    """Parameters of the effects that are on."""
    return [(name, one) for name in simulation.on for one in catalogue()[name].parameters if not one.switch]


def jacobian(simulation: Simulation, baseline: np.ndarray,
             left_open: Sequence[nuisance.Nuisance]) -> np.ndarray:
    """(n, k), by central differences: of what is `left_open`, then of the sizes of effects that are on."""
    owner = np.repeat(np.arange(len(simulation.tests)), [len(t.load.values) for t in simulation.tests])
    moved = [one for one in left_open if one.kind != "zero"]
    rows = [simulation.row(None, shifted(left_open, {one.name: sign * nuisance.STEP * one.sigma}))
            for one in moved for sign in (1, -1)]
    rows += [simulation.row(simulation.with_effects({name: {
                **simulation.on[name], one.name: simulation.on[name][one.name] + sign * _step(one)}}))
             for name, one in _sizes(simulation) for sign in (1, -1)]
    predictions = iter(simulation.predict(rows, "stiffness and gauge"))
    columns = []
    for one in left_open:
        mine = np.array([one.moves(test) for test in simulation.tests])[owner]
        if one.kind == "zero":
            columns.append(mine.astype(float))
            continue
        up, down = next(predictions), next(predictions)
        columns.append(np.where(mine, _slope(up, down, baseline, nuisance.STEP * one.sigma), 0.0))
    for _, one in _sizes(simulation):
        up, down = next(predictions), next(predictions)
        columns.append(_slope(up, down, baseline, _step(one)))
    return np.stack(columns, axis=1)


def _step(parameter: Parameter) -> float:
    """Of the finite differences, within the parameter's range on both sides of its median."""
    middle = parameter.quantile(0.5)
    return min(nuisance.STEP * parameter.deviation, parameter.high - middle, middle - parameter.low)


def _slope(up: np.ndarray, down: np.ndarray, middle: np.ndarray, step: float) -> np.ndarray:
    """One-sided where the other side has no balance."""
    both = (up - down) / (2 * step)
    one = np.where(np.isfinite(up), (up - middle) / step, (middle - down) / step)
    return np.where(np.isfinite(both), both, one)


def shifted(left_open: Sequence[nuisance.Nuisance], values: dict[str, float]):
    """Case -> the case with nuisances at `values`."""
    def change(case: Case) -> Case:
        for one in left_open:
            case = one.applied(case, values.get(one.name, 0.0))
        return case
    return change


def responses(simulation: Simulation, baseline: np.ndarray,
              only: Sequence[str] | None = None) -> dict[str, Response]:
    """Of every effect that does anything to these tests, and is not on already."""
    there = {one.id for one in simulation.model.effects} | set(simulation.on)
    known = {name: effect for name, effect in catalogue().items()
             if name not in there and (only is None or name in only)}
    plans = {name: design.axes(effect) for name, effect in known.items()}
    nodes = [(name, dict(zip([p.name for p in known[name].parameters], map(float, values), strict=True)))
             for name, axes in plans.items() for values in itertools.product(*axes)]
    rows = [simulation.row(simulation.with_effects({name: values})) for name, values in nodes]
    predictions = simulation.predict(rows, f"{len(plans)} effects")
    found, at = {}, 0
    for name, axes in plans.items():
        shape = tuple(len(axis) for axis in axes)
        count = int(np.prod(shape))
        mine = predictions[at:at + count].reshape(*shape, -1)
        at += count
        moved = np.abs(mine - baseline) > SEEN * np.nanmax(np.abs(baseline))
        if moved.any():
            found[name] = Response(name, tuple(p.name for p in known[name].parameters), axes,
                                   design.densities(known[name], axes), mine)
    return found


def where_known(there: np.ndarray, new: np.ndarray, old: np.ndarray) -> np.ndarray:
    """(n, n) covariance: `new` between points that are `there`, `old` between the others, none across.

    Two covariances that are mixed otherwise need not be one.
    """
    both, neither = there[:, None] & there[None, :], ~there[:, None] & ~there[None, :]
    return np.where(both, new, np.where(neither, old, 0.0))


def structural(simulation: Simulation, baseline: np.ndarray, members: int) -> np.ndarray:
    """(n, n): the ensemble within tolerance, and the mesh."""
    def changes() -> Iterator[Row]:
        for by in tolerance.members(members, simulation.seed):
            yield simulation.row(change=lambda case, by=by: tolerance.deviating(case, by))

    ensemble = simulation.predict(list(changes()), "fingers within tolerance")
    spread = np.where(np.isfinite(ensemble), ensemble - baseline, 0.0)
    there = np.maximum(np.isfinite(ensemble).sum(axis=0), 1)
    spread -= spread.sum(axis=0) / there
    spread = np.where(np.isfinite(ensemble), spread, 0.0)
    covariance = spread.T @ spread / max(len(ensemble) - 1, 1)
    diagonal = np.diag(np.diag(covariance))
    return (1 - SHRINK) * covariance + SHRINK * diagonal + mesh(simulation.tests, baseline)


def mesh(tests: Sequence[Test], baseline: np.ndarray) -> np.ndarray:
    """Covariance of a coarse mesh: smooth over the load, and the same on the way back."""
    same, loads = same_state([series(test) for test in tests])
    meshed = np.repeat([not test.direct for test in tests], [len(test.load.values) for test in tests])
    there = np.where(np.isfinite(baseline) & meshed, np.abs(baseline), 0.0)
    size = MESH * (same * there).max(axis=1)
    apart = (loads[:, None] - loads[None, :]) / SMOOTH
    return np.outer(size, size) * (0.95 * same * np.exp(-apart**2 / 2) + 0.05 * np.eye(len(baseline)))
