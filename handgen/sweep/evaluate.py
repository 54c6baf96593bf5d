"""A variant -> its row: validated, judged, bent, weighed. What is wrong with it becomes its status."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
from pydantic import ValidationError

from handgen import checks
from handgen.bending.model import BendModel, model_of
from handgen.bending.request import request
from handgen.bending.run import solve
from handgen.checks import definition
from handgen.checks.limits import Limits
from handgen.errors import EngineError, GeometryError, InputError
from handgen.geometry.profile import FingerProfile
from handgen.parameters.load import Loaded, loaded
from handgen.parameters.model import Hand
from handgen.sweep import mass, results
from handgen.sweep.model import Bending, Force
from handgen.sweep.variant import Task, bending, force

LONGEST = 400
"""Characters of a reason."""
_models: dict[str, BendModel] = {}


class _EndedError(Exception):
    """The row is known: its status and reason."""


def evaluate(task: Task) -> dict[str, Any]:
    """The row of `task`, without what names it; never raises for what a variant is like."""
    begun, row = time.perf_counter(), {"status": "done", "reason": ""}
    try:
        _fill(row, task)
    except _EndedError as ended:
        row["status"], row["reason"] = ended.args
    except EngineError as error:
        row["status"], row["reason"] = "failed", _short(str(error))
    except Exception as error:
        # Other packages' solvers and rules may raise anything: one variant is no reason to end a sweep.
        row["status"], row["reason"] = "failed", _short(f"{type(error).__name__}: {error}")
    row["wall_s"] = round(time.perf_counter() - begun, 4)
    return row


def _fill(row: dict[str, Any], task: Task) -> None:
    """Results into `row`.

    Raises:
        _EndedError: there can be no more of them.
        EngineError: solver or rule gave up.
    """
    try:
        bend, pushed = bending(task), force(task)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise _EndedError("invalid", _short(f"bend.{where}: {first['msg']}")) from error
    try:
        loading, model = loaded(task.hand, task.hand_file), _model(task)
        limits = checks.own_limits(loading.hand, task.hand_file)
    except InputError as error:
        raise _EndedError("invalid", _told(error)) from error
    hand = loading.hand
    try:
        _judge(row, task, hand, limits)
        _weigh(row, hand, bend, limits)
        _bend(row, task, loading, model, bend)
        if pushed is not None and row["status"] == "done":
            _push(row, task, loading, model, bend, pushed)
    except InputError as error:
        raise _EndedError("refused", _told(error)) from error
    except GeometryError as error:
        raise _EndedError("refused", _short(f"{error.path}: {error.part}: {error.message}")) from error


def _model(task: Task) -> BendModel:
    """The task's model; the last ones are kept, as most sweeps have one."""
    from handgen.bending.cache import canonical

    key = repr(canonical(task.model))
    if key not in _models:
        if len(_models) > 8:
            _models.clear()
        _models[key] = model_of(_copied(task.model), task.model_file)
    return _models[key]


def _copied(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _copied(value) for key, value in data.items()}
    return [_copied(entry) for entry in data] if isinstance(data, list) else data


def _judge(row: dict[str, Any], task: Task, hand: Hand, limits: Limits) -> None:
    if task.rules == "none":
        return
    if task.rules == "all":
        from handgen.geometry.catalogue import catalogue

        report = checks.judge(hand, catalogue(hand), task.hand_file)
    else:
        report = definition.judge(hand, limits)
    broken = sorted({f["rule"] for f in report["findings"] if f["severity"] == "error"})
    unmet = sorted({rule["rule"] for rule in report["rules"] if rule["status"] == "fail"})
    row["rules_passed"], row["rules_broken"] = float(report["passed"]), ", ".join(broken)
    row["rules_unmet"] = float(len(unmet))
    row["rules_warned"] = ", ".join(rule for rule in unmet if rule not in broken)


def _weigh(row: dict[str, Any], hand: Hand, bend: Bending, limits: Limits) -> None:
    """Masses, walls, strain and time to print of the finger, as far as it has these."""
    name = bend.finger
    silicone, chamber = mass.actuator(hand, name)
    row["silicone_g"], row["chamber_ml"] = 1e-3 * hand.casting.silicone.density * silicone, 1e-3 * chamber
    finger = hand.fingers.present().get(name)
    if finger is None:
        return
    process = hand.printing.hand if hand.palm else hand.printing.finger
    volume, profile = mass.exoskeleton(hand, name), FingerProfile(finger)
    row["exoskeleton_g"] = 1e-3 * process.density * volume
    row["finger_g"] = row["exoskeleton_g"] + row["silicone_g"]
    row["print_h"] = volume / process.rate / 3600
    x = np.linspace(0.0, finger.inner_length, definition.STATIONS)
    row["least_wall_mm"] = float((profile.outer(x) - profile.bore(x)).min())
    row["hinge_strain"] = max(
        definition.strip_strain(profile, joint, hand.exoskeleton.joint_fillet, math.radians(max(
            0.0, limits.get("hinge.strain", "full_curl", joint.name).value - joint.rest_angle)))[0]
        for joint in finger.joints)


def _bend(row: dict[str, Any], task: Task, loading: Loaded, model: BendModel, bend: Bending) -> None:
    pressures = [bend.pressure] if bend.pressure is not None else bend.pressures
    asked = request(loading, model=model, finger=bend.finger, part=bend.part, pressures=pressures,
                    orientation=bend.orientation, solver=task.solver, refine=bend.refine)
    found = solve(asked, keep=False)
    points, flags = found.document["points"], []
    for point in points:
        for name in results.BEND:
            row[results.at(name, point["pressure_kPa"])] = point[name]
        flags += [flag for flag in (*point["flags"], point["note"]) if flag and flag not in flags]
    row |= {name: points[-1][name] for name in results.BEND}
    row["bend_angle_error_deg"] = points[-1].get("bend_angle_error_deg")
    row["flags"] = _short("; ".join(flags))
    row["solver"] = task.solver
    row["unknowns"], row["factorisations"] = found.curve.unknowns, found.curve.factorisations
    if not found.complete:
        row["status"], row["reason"] = "incomplete", _short(found.reached)


def _push(row: dict[str, Any], task: Task, loading: Loaded, model: BendModel, bend: Bending,
          pushed: Force) -> None:
    """The fingertip's force; a finger that does not come to rest on the plane is flagged, and has none."""
    asked = request(loading, model=model, finger=bend.finger, orientation=bend.orientation,
                    solver=task.solver, refine=bend.refine, obstacle=pushed.obstacle,
                    pressures=[pushed.pressure / 2, pushed.pressure])
    last = solve(asked, keep=False).curve.states[-1]
    row["fingertip_force_N"] = last.tip_force if last.converged else None
    if not last.converged:
        row["flags"] = _short("; ".join(filter(None, [row["flags"], f"no force: {last.note}"])))


def _told(error: InputError) -> str:
    return _short("; ".join(f"{p.path}: {p.message}" for p in error.problems))


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else text[:LONGEST - 3] + "..."
