"""A measured test and a model -> the bend that answers it, and how far the two are apart."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from handgen.bending.model import BendModel
from handgen.bending.request import Request, request
from handgen.effects.course import READING
from handgen.errors import InputError, Problem
from handgen.measurements.load import Measured
from handgen.measurements.model import Test
from handgen.measurements.statistics import means, rms
from handgen.simulation.case import Curve

FROM_STATE = {"tip_drop": 1.0, "elongation": 1.0, "tip_force": 1.0, "bend_angle": 180.0 / math.pi}
"""Observables are values of a state of this name, in these units of it."""


IN_FILE = {"--pressures": "load.values", "--tip-loads": "load.values", "--obstacle": "obstacle",
           "--orientation": "orientation"}
"""Options of `handgen bend`, and the keys of a test that they come from."""


@dataclass(frozen=True)
class Gap:
    """Simulated less measured means, over some of a test's loads."""

    count: int
    rms: float
    largest: float
    """The residual of the largest size, with its sign."""
    rms_relative: float | None
    """RMS of residuals over the means; None where a mean is 0."""


def asked(measured: Measured, test: Test, model: str | os.PathLike | BendModel,
          more: Sequence[float] = ()) -> Request:
    """What `handgen bend` would be asked to answer `test`, and at `more` loads between its own.

    Unloading begins where the test does: at its largest load, to which the finger was loaded before. On a
    path other than loading there is nothing between the readings: `more` is left out.

    Raises:
        InputError: hand and model do not fit, or the loads not the path.
    """
    values = sorted({*test.load.values, *more}) if test.path == "loading" else test.load.values
    row = {"tip_loads": values} if test.load.quantity == "tip_load" else {"pressures": values}
    try:
        return request(measured.hand, finger=measured.measurements.finger, part=test.part, model=model,
                       orientation=test.orientation, obstacle=test.obstacle, path=test.path,
                       times=_between(test, values), repeats=len(test.repeats), **row)
    except InputError as error:
        raise InputError(_in_file(error.problems, measured, test)) from None


def times(test: Test) -> list[float]:
    """s since the first load of every reading, READING apart where the test gives none."""
    return test.times or [READING * (i + 1) for i in range(len(test.load.values))]


def _between(test: Test, values: Sequence[float]) -> list[float]:
    """s of the readings at `values`; between a test's own they pass evenly from load to load."""
    return times(test) if test.path != "loading" else np.interp(
        values, test.load.values, times(test)).tolist()


def _in_file(problems: Sequence[Problem], measured: Measured, test: Test) -> list[Problem]:
    """Problems of a command line that nobody typed, where the file says it; points between are left out."""
    found = []
    for problem in problems:
        if (key := IN_FILE.get(problem.path)) is None:
            found.append(problem)
        elif key != "load.values" or problem.value in test.load.values:
            found.append(replace(problem, file=str(measured.file), path=f"tests.{test.id}.{key}"))
    return found


def observed(test: Test, curve: Curve) -> list[float | None]:
    """What is read off each state of `curve`; None where one did not converge."""
    name = test.observable.quantity
    return [FROM_STATE[name] * getattr(state, name) if state.converged else None for state in curve.states]


def direct(test: Test, wanted: Request) -> list[float | None]:
    """What `test` reads at each of its loads where that takes no bend, with the effects of `wanted`."""
    values: list[float | None] = [0.0] * len(test.load.values)
    if test.observable.quantity == "chamber_pressure":
        values = [1e3 * pressure for pressure in wanted.case.pressures]
    for effect, parameters in wanted.effects:
        values = list(effect.on_reading(test.observable.quantity, test.load.values, values, parameters))
    return values


def loads(test: Test, curve: Curve) -> list[float]:
    """The loads of the states of `curve`, in the unit of `test`."""
    if test.load.quantity == "tip_load":
        return [state.tip_load for state in curve.states]
    return [1e3 * state.pressure for state in curve.states]


def readings(test: Test, curve: Curve) -> list[float | None]:
    """What is read off `curve` at the loads of `test`, in its order."""
    there = [round(load, 9) for load in loads(test, curve)]
    wanted, values = [round(load, 9) for load in test.load.values], observed(test, curve)
    if there == wanted:
        return values
    found = dict(zip(there, values, strict=True))
    return [found[load] for load in wanted]


def gap(test: Test, simulated: Sequence[float | None], fitted: bool | None = None) -> Gap | None:
    """How far `simulated` is off, over loads that may be `fitted` (True), that may not (False), or all.

    None where nothing is left to compare.
    """
    pairs = [(s - m, m) for s, m, f in zip(simulated, means(test), test.fitted, strict=True)
             if s is not None and m is not None and fitted in (None, f)]
    if not pairs:
        return None
    residuals = [residual for residual, _ in pairs]
    relative = rms([r / m for r, m in pairs]) if all(m for _, m in pairs) else None
    return Gap(len(pairs), rms(residuals), max(residuals, key=abs), relative)
