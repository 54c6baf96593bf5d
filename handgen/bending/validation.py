"""Every test of a measurements file bent with one model file after another, and how far each one is off."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from handgen import __version__
from handgen.bending.comparison import Gap, asked, gap, loads, observed, readings, times
from handgen.bending.model import FOLDER, BendModel, load_model
from handgen.bending.request import Request, request
from handgen.bending.result import Bend
from handgen.bending.run import solve
from handgen.errors import InputError, Problem
from handgen.measurements.load import Measured, load_measurements
from handgen.measurements.model import Test
from handgen.measurements.statistics import means, pooled_deviation
from handgen.simulation.case import Curve

SCHEMA = "handgen.validation/1"
MEASUREMENTS = FOLDER.parent / "measurements" / "coimbra_index.yaml"
MODELS = ("literature", "thesis", "calibrated")
POINTS = {"pressure": 12, "tip_load": 28}
"""Parts that a curve from no load to the largest is drawn in, beside the loads that were measured."""
BALLOON = 30.0
"""kPa of Figure 5.7: the actuator with and without its thread."""
VARIANTS = ("bonded", "weightless")
"""What an assembly must not be: stuck to its bore, or without own weight; shown beside what it is."""
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Answer:
    """A test as one model sees it."""

    test: Test
    model: BendModel
    bend: Bend
    variant: str = ""

    @property
    def curve(self) -> Curve:
        return self.bend.curve

    @property
    def fitted(self) -> bool:
        """Whether numbers of the model were fitted on this test."""
        return self.test.id in self.model.fitted


@dataclass(frozen=True)
class Validation:
    """All answers, and the actuator with and without its thread."""

    measured: Measured
    models: tuple[BendModel, ...]
    answers: tuple[Answer, ...]
    variants: tuple[Answer, ...]
    balloons: tuple[dict[str, Any], ...]

    @property
    def complete(self) -> bool:
        """Every point of every test converged, in every model."""
        return all(answer.bend.complete for answer in self.answers)

    @property
    def document(self) -> dict[str, Any]:
        """`handgen.validation/1`: kPa, N, mm, deg."""
        m = self.measured.measurements
        return {
            "schema": SCHEMA,
            "name": m.name,
            "hand": self.measured.hand.hand.name,
            "finger": m.finger,
            "models": [model.name for model in self.models],
            "tests": [_test(test, [a for a in self.answers if a.test is test],
                            [a for a in self.variants if a.test is test]) for test in m.tests],
            "balloon": list(self.balloons),
            "complete": self.complete,
            "handgen_version": __version__,
        }


def validate(measurements: str | os.PathLike = MEASUREMENTS, models: Sequence[str] = MODELS, *,
             keep: bool = True, progress: Progress | None = None) -> Validation:
    """Bend every test of the file `measurements` with each of `models` (names of params/models, or files).

    `keep=False` neither reads nor writes the cache.

    Raises:
        InputError: everything wrong with the measurements, the hand and the models; nothing was solved.
        EngineError: a solver cannot be loaded or failed.
    """
    say = progress or (lambda line: None)
    measured = load_measurements(measurements)
    chosen = _models(models)
    answers, variants = [], []
    for test, name, wanted in _requests(measured, models):
        say(f"{test.id}, {name}")
        answers.append(Answer(test, chosen[name], solve(wanted, keep=keep)))
        if test.part == "assembly" and test.obstacle is None:
            variants += [Answer(test, chosen[name], solve(_variant(wanted, what), keep=keep), what)
                         for what in VARIANTS]
    balloons = []
    for name in models if any(test.part == "actuator" for test in measured.measurements.tests) else ():
        say(f"actuator with and without thread, {name}")
        balloons.append(_balloon(measured, name, keep))
    return Validation(measured, tuple(chosen.values()), tuple(answers), tuple(variants), tuple(balloons))


def _models(names: Sequence[str]) -> dict[str, BendModel]:
    """The models by what they were called.

    Raises:
        InputError: those that are none, and names that two of them share.
    """
    problems, found = [], {}
    for name in names:
        try:
            found[name] = load_model(name)[0]
        except InputError as error:
            problems += error.problems
    titles = [model.name for model in found.values()]
    problems += [Problem("command line", "--models", title, "is the name of two models", "each name once")
                 for title in sorted({title for title in titles if titles.count(title) > 1})]
    if problems:
        raise InputError(problems)
    return found


def _requests(measured: Measured, models: Sequence[str]) -> list[tuple[Test, str, Request]]:
    """(test, model, what to solve), test by test.

    Raises:
        InputError: everything wrong with hand and models.
    """
    problems: list[Problem] = []
    found = []
    for test in (one for one in measured.measurements.tests if not one.direct):
        between = np.linspace(0.0, max(test.load.values), POINTS[test.load.quantity] + 1).round(4).tolist()
        for model in models:
            try:
                found.append((test, model, asked(measured, test, model, between)))
            except InputError as error:
                problems += [problem for problem in error.problems if problem not in problems]
    if problems:
        raise InputError(problems)
    return found


def _variant(wanted: Request, what: str) -> Request:
    case = wanted.case
    if what == "bonded":
        return replace(wanted, case=replace(case, contact=replace(case.contact, bonded=True)))
    return replace(wanted, case=replace(case, gravity=(0.0, 0.0, 0.0)))


def _balloon(measured: Measured, model: str, keep: bool) -> dict[str, Any]:
    """The free actuator of Figure 5.7, wound and not: how much longer and thicker at BALLOON."""
    pressures = np.linspace(0.0, BALLOON, 7).tolist()
    wound = request(measured.hand, finger=measured.measurements.finger, part="actuator", model=model,
                    orientation="weightless", pressures=pressures)
    bare = replace(wound, case=replace(wound.case, winding=None))
    found = {"model": load_model(model)[0].name, "pressure_kPa": BALLOON}
    for what, one in (("wound", wound), ("bare", bare)):
        bend = solve(one, keep=keep)
        state = next((s for s in reversed(bend.curve.states) if s.converged), None)
        found[what] = {
            "reached_kPa": float(f"{1e3 * bend.curve.reached:.12g}"),
            "elongation_mm": None if state is None else state.elongation,
            "widening_mm": None if state is None else _widening(bend.curve, state.positions["actuator"]),
            "stopped": bend.curve.stopped,
        }
    return found


def _widening(curve: Curve, positions: np.ndarray) -> float:
    """Largest growth of the distance from the axis, mm."""
    drawn = curve.grids["actuator"].nodes
    return float((np.hypot(*positions[:, 1:].T) - np.hypot(*drawn[:, 1:].T)).max())


# The document


def _test(test: Test, answers: Sequence[Answer], variants: Sequence[Answer]) -> dict[str, Any]:
    return {
        "id": test.id,
        "title": test.title or test.id,
        "part": test.part,
        "orientation": test.orientation,
        "obstacle_mm": test.obstacle,
        "load": test.load.quantity,
        "load_unit": test.load.unit,
        "observable": test.observable.quantity,
        "unit": test.observable.unit,
        "path": test.path,
        "loads": test.load.values,
        "times": times(test) if test.path == "hold" else None,
        "repeats": test.repeats,
        "means": means(test),
        "deviation": pooled_deviation(test),
        "may_be_fitted": list(test.fitted),
        "models": {answer.model.name: _answer(answer) for answer in answers},
        "variants": {what: {v.model.name: _values(v) for v in variants if v.variant == what}
                     for what in VARIANTS} if variants else {},
        "others": [other.model_dump() for other in test.simulated],
    }


def _answer(answer: Answer) -> dict[str, Any]:
    test, curve = answer.test, answer.curve
    simulated = readings(test, curve)
    return {
        **_values(answer),
        "fitted": answer.fitted,
        "residuals": [s - m if s is not None and m is not None else None
                      for s, m in zip(simulated, means(test), strict=True)],
        "gap": _gap(gap(test, simulated)),
        "gap_where_fitting_is_allowed": _gap(gap(test, simulated, fitted=True)),
        "gap_where_it_is_not": _gap(gap(test, simulated, fitted=False)),
        "reached": answer.bend.reached,
        "complete": answer.bend.complete,
        "folds_kPa": [1e3 * fold for fold in curve.folds],
        "curve": {"loads": loads(test, curve), "values": observed(test, curve)},
    }


def _values(answer: Answer) -> dict[str, Any]:
    return {"simulated": readings(answer.test, answer.curve)}


def _gap(found: Gap | None) -> dict[str, Any] | None:
    return None if found is None else asdict(found)
