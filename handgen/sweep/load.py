"""A sweep file -> all that a run needs, or everything that is wrong with it at once."""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from handgen.bending import loads, solvers
from handgen.bending.model import BendModel, default_name, load_model, path_of
from handgen.errors import InputError, Problem
from handgen.materials import library
from handgen.parameters import assumptions, document, explain
from handgen.parameters.fault import Fault, Path, nearest, text
from handgen.parameters.load import load as load_hand
from handgen.parameters.load import merged
from handgen.parameters.model import Hand
from handgen.parameters.single import validated
from handgen.sweep import draw, keypath, results
from handgen.sweep.model import MOST, SCHEMA, Axis, Bending, Force, Sweep

HAND, MODEL, BEND, FORCE = "hand", "model", "bend", "force"
PREFIXES = {"model.": MODEL, "bend.": BEND, "force.": FORCE}
"""What a key path begins with that does not lead into the parameter file."""


@dataclass(frozen=True)
class Target:
    """One place that an axis sets: `adds` * value more than there is, `scales` by it, or the value itself."""

    scope: str
    path: Path
    adds: float | None = None
    scales: bool = False
    base: float = 0.0

    def value(self, given: Any, there: float) -> Any:
        """What `given` makes of `there`: the base's number, or what another axis made of it."""
        if self.adds is not None:
            return round(there + self.adds * given, 9)
        return round(there * given, 9) if self.scales else given


@dataclass(frozen=True)
class Prepared:
    """A sweep that can run."""

    sweep: Sweep
    file: FilePath
    base: dict
    """Merged data of the base file."""
    base_file: FilePath
    model: dict
    """Data of the model, sets that an axis leads into spelled out."""
    model_file: str
    targets: dict[str, tuple[Target, ...]]
    """Axis -> what it sets."""

    @property
    def count(self) -> int:
        return draw.count(self.sweep)

    @property
    def pressures(self) -> tuple[float, ...]:
        return pressures(self.sweep.bend)

    @property
    def kept(self) -> int:
        return keep(self.sweep)


def prepare(file: str | os.PathLike) -> Prepared:
    """Read the sweep file and what it names.

    Raises:
        InputError: everything wrong with it, with its base and with its model.
    """
    here, problems = document.read(os.fspath(file)), []
    raw = copy.deepcopy(here.data)
    try:
        sweep = validated(here, Sweep, SCHEMA, _axes, _related)
    except InputError as error:
        # What is right must not hide what else is wrong.
        problems, sweep = error.problems, _salvaged(raw)
        if sweep is None:
            raise
        told = {problem.path for problem in problems}
        problems += [p for p in map(here.problem, _related(sweep)) if p.path not in told]
    folder = FilePath(file).parent
    base_file = folder / sweep.base
    base, hand = {}, None
    try:
        base = merged(base_file)
        hand = load_hand(base_file).hand
    except InputError as error:
        problems += error.problems
    model_data, model, model_file = {}, None, ""
    try:
        wanted = sweep.model or default_name()
        beside = folder / wanted
        model_file = path_of(beside if beside.is_file() else wanted)
        model = load_model(model_file)[0]
        model_data = document.read(model_file).data
    except InputError as error:
        problems += [Problem(os.fspath(file), "model", p.value, p.message, p.allowed, p.suggestion)
                     if p.path == "--model" else p for p in error.problems]
    targets: dict[str, tuple[Target, ...]] = {}
    faults = [*_loadable(sweep), *_named(sweep)]
    if hand is not None and model is not None:
        model_data = _spelled(model_data, sweep)
        places = _places(hand, model, model_data)
        faults += [*_set_by_axes(sweep, places, targets), *_fingered(sweep, hand)]
    problems += [here.problem(fault) for fault in faults]
    if problems:
        raise InputError(problems)
    return Prepared(sweep, FilePath(file), base, base_file, model_data, model_file, targets)


def _salvaged(raw: object) -> Sweep | None:
    """The sweep without what is wrong in it; None where nothing is left to look at."""
    if not isinstance(raw, dict) or raw.get("schema") != SCHEMA or not isinstance(raw.get("vary"), dict):
        return None
    raw.setdefault("name", "unnamed")
    for fault in _axes(raw):
        raw["vary"].pop(fault.path[1], None)
    for _ in range(2):
        try:
            return Sweep.model_validate(raw)
        except ValidationError as error:
            for detail in error.errors():
                section, *rest = detail["loc"]
                inside = rest and isinstance(raw.get(section), dict)
                (raw[section] if inside else raw).pop(rest[0] if inside else section, None)
    return None


def pressures(bend: Bending) -> tuple[float, ...]:
    """kPa, rising."""
    if bend.pressure is not None:
        return (bend.pressure,)
    return loads.pressures(bend.pressures, bend.part, loads.Faults())


def keep(sweep: Sweep) -> int:
    """How many of the best are written."""
    if sweep.keep is None:
        return 0
    return sweep.keep if isinstance(sweep.keep, int) else int(sweep.keep.split()[1])


def _axes(data: dict) -> list[Fault]:
    """Lists and `low:high:step` as axes."""
    vary, faults = data.get("vary"), []
    if not isinstance(vary, dict):
        return faults
    data["vary"] = {}
    for name, given in vary.items():
        if isinstance(given, list):
            given = {"choices": given}
        elif isinstance(given, str):
            parts = [_number(part) for part in given.split(":")]
            whole = len(parts) in (2, 3) and None not in parts
            given = dict(zip(("low", "high", "step"), parts, strict=False)) if whole else None
        if not isinstance(given, dict):
            faults.append(Fault(("vary", name), "is neither a list nor a range", vary[name],
                                "low:high:step, a list, or keys such as low, high, steps"))
            given = {"choices": [None]}
        data["vary"][name] = given
    return faults


def _number(word: str) -> float | None:
    try:
        number = float(word)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _related(sweep: Sweep) -> list[Fault]:
    """What is wrong between keys that are right by themselves."""
    faults = [fault for name, axis in sweep.vary.items() for fault in _axis(axis, ("vary", name))]
    if not faults:
        faults += _methodical(sweep)
    for name, bound in sweep.constraints.items():
        if bound.min is None and bound.max is None:
            faults.append(Fault(("constraints", name), "bounds nothing", None, "min, max or both"))
        elif bound.min is not None and bound.max is not None and bound.min > bound.max:
            faults.append(Fault(("constraints", name), f"can never be met: min {bound.min:g} is above max",
                                bound.max, f"max of at least {bound.min:g}"))
    if isinstance(sweep.keep, str) and not (
            sweep.keep.startswith("best ") and sweep.keep[5:].isdecimal() and int(sweep.keep[5:])):
        faults.append(Fault(("keep",), "should say how many", sweep.keep, "best N"))
    if (sweep.keep or sweep.confirm) and not sweep.objectives:
        faults.append(Fault(("objectives",), "missing: without one nothing is best"))
    return faults


def _axis(axis: Axis, at: Path) -> Iterator[Fault]:
    ranged = axis.low is not None and axis.high is not None
    if axis.choices is not None:
        more = [k for k in axis.model_fields_set if k not in ("choices", "adds", "scales")]
        if more:
            yield Fault((*at, more[0]), "says nothing beside a list of choices")
        kinds = {document.json.dumps(choice) for choice in axis.choices}
        if len(kinds) < len(axis.choices):
            yield Fault(at, "has the same choice twice", axis.choices)
    elif axis.distribution == "normal":
        if axis.mean is None or axis.sigma is None:
            yield Fault(at, "a normal distribution needs mean and sigma")
    elif not ranged:
        yield Fault(at, "is no range", None, "low and high, a list of choices, or a distribution")
    if axis.low is not None and axis.high is not None and not axis.low < axis.high:
        yield Fault((*at, "high"), f"the range is empty: it begins at {axis.low:g}", axis.high,
                    f"above {axis.low:g}")
    elif axis.distribution == "loguniform" and ranged and axis.low <= 0:
        yield Fault((*at, "low"), "has no logarithm", axis.low, "above 0")
    elif axis.distribution == "triangular" and ranged and not (
            axis.mode is not None and axis.low <= axis.mode <= axis.high):
        yield Fault((*at, "mode"), "a triangular distribution needs its mode within the range", axis.mode,
                    f"{axis.low:g} to {axis.high:g}")
    elif axis.step is not None and ranged and axis.steps is None:
        if axis.step > axis.high - axis.low:
            yield Fault((*at, "step"), "is longer than the range", axis.step,
                        f"{axis.high - axis.low:g} at most")
        elif (axis.high - axis.low) / axis.step > 10_000:
            yield Fault((*at, "step"), "makes too many values", axis.step, "10000 values at most")
    if axis.adds and axis.scales:
        yield Fault((*at, "scales"), "an axis either adds or scales")


def _methodical(sweep: Sweep) -> Iterator[Fault]:
    """What the method asks of axes, budget and objectives."""
    if sweep.method == "grid":
        for name, axis in sweep.vary.items():
            if axis.choices is None and axis.step is None and axis.steps is None:
                yield Fault(("vary", name), "a grid needs to know how many values", None,
                            "step, steps, or a list; or `method: sobol`")
                return
        asked = math.prod(len(draw.levels(axis)) for axis in sweep.vary.values())
        if asked > (sweep.budget or MOST):
            yield Fault(("budget",), f"the grid has {asked} variants", sweep.budget or MOST,
                        f"at least {asked}, or fewer values" if asked <= MOST else "fewer values")
        return
    if sweep.budget is None:
        yield Fault(("budget",), f"`method: {sweep.method}` needs to know how many variants")
    if sweep.method == "optimise":
        if not sweep.objectives:
            yield Fault(("objectives",), "missing: what is best?", None, "result: maximise or minimise")
        for name, axis in sweep.vary.items():
            if axis.distribution not in (None, "uniform", "loguniform"):
                yield Fault(("vary", name, "distribution"), "an optimisation draws from ranges and lists",
                            axis.distribution, "low and high")


def _spelled(data: dict, sweep: Sweep) -> dict:
    """The model's data, library sets that a key path leads into written out."""
    data = {**data, "materials": dict(data["materials"])}
    for name, axis in sweep.vary.items():
        for path in (axis.adds or axis.scales or [name]):
            keys = keypath.keys(path)
            if keys[:2] == ["model", "materials"] and len(keys) > 3:
                given = data["materials"].get(keys[2])
                if isinstance(given, str):
                    one = library.parameter_set(given).model_dump(mode="json", exclude_defaults=True)
                    del one["material"]
                    data["materials"][keys[2]] = one
    return data


def _places(hand: Hand, model: BendModel, model_data: dict) -> dict[str, Any]:
    """Scope -> what key paths may name there."""
    known = model.model_dump(mode="json", by_alias=True)
    resolved = assumptions.resolved(hand)
    for key in ("schema", "name", "description", "assumed"):
        resolved.pop(key, None)
    return {HAND: resolved, MODEL: {**known, "materials": model_data["materials"]},
            BEND: {k: True for k in Bending.model_fields if k not in ("pressures", "part")},
            FORCE: {k: True for k in Force.model_fields}}


def _set_by_axes(sweep: Sweep, places: dict[str, Any], targets: dict) -> Iterator[Fault]:
    """Fills `targets`; what is wrong with the key paths."""
    taken: dict[tuple[str, Path], str] = {}
    for name, axis in sweep.vary.items():
        at: Path = ("vary", name)
        found: list[Target] = []
        named = ([(path, factor, False) for path, factor in axis.adds.items()] if axis.adds else
                 [(path, None, True) for path in axis.scales] if axis.scales else [(name, None, False)])
        for given, adds, scales in named:
            prefix = next((p for p in PREFIXES if given.startswith(p)), "")
            scope, rest = PREFIXES.get(prefix, HAND), given.removeprefix(prefix)
            paths, lost, valid = _matched(scope, rest, places)
            if not paths:
                near = nearest(lost, valid)
                yield Fault(at, f"there is no {lost!r} in {given}", given,
                            "one of " + ", ".join(valid) if valid else "a key path",
                            given.replace(lost, near, 1) if near else None)
            for path in paths:
                other = sweep.vary.get(taken.get((scope, path), ""))
                if other is not None and not (adds is not None and other.adds):
                    yield Fault(at, f"{text(path)} is set by {taken[scope, path]!r} too", given)
                taken[scope, path] = name
                base = keypath.get(places[scope], path)
                moved = adds is not None or scales
                if moved and (isinstance(base, bool) or not isinstance(base, int | float)):
                    yield Fault(at, f"{prefix}{text(path)} is no number that could be "
                                f"{'scaled' if scales else 'added to'}", given)
                    continue
                found.append(Target(scope, path, adds, scales, base if moved else 0.0))
            if scope == FORCE and sweep.force is None:
                yield Fault(at, "there is no `force` in this sweep", given)
        targets[name] = tuple(found)


def _matched(scope: str, rest: str, places: dict[str, Any]) -> tuple[list[Path], str | None, list[str]]:
    """As `keypath.matches`; an optional key that the base leaves out may be named too."""
    paths, lost, valid = keypath.matches(places[scope], rest)
    if not paths and scope == HAND:
        optional, _, _ = keypath.matches(explain.skeleton(Hand), rest)
        if optional and not any(isinstance(key, int) for path in optional for key in path):
            return optional, None, []
    return paths, lost, valid


def _fingered(sweep: Sweep, hand: Hand) -> Iterator[Fault]:
    """The finger must be one of the hand's."""
    bend = sweep.bend
    there = hand.actuators.present() if bend.part == "actuator" else hand.fingers.present()
    if bend.finger not in there:
        yield Fault(("bend", "finger"), "there is none of this name", bend.finger,
                    "one of " + ", ".join(there), nearest(bend.finger, there))


def _loadable(sweep: Sweep) -> Iterator[Fault]:
    """Solvers, pressures and orientation, as `handgen bend` checks them."""
    bend = sweep.bend
    known = solvers.names(bend.part)
    for path, solver in ((("solver",), sweep.solver),
                         *([(("confirm", "solver"), sweep.confirm.solver)] if sweep.confirm else [])):
        if solver not in known:
            yield Fault(path, "there is none of this name", solver, "one of " + ", ".join(known),
                        nearest(solver, known))
    wrong = loads.Faults()
    loads.orientation(bend.orientation, bend.part, wrong)
    loads.pressures(bend.pressures, bend.part, wrong)
    where = {"--orientation": ("bend", "orientation"), "--pressures": ("bend", "pressures")}
    yield from (Fault(where[p.path], p.message, p.value, p.allowed, p.suggestion) for p in wrong)


def _named(sweep: Sweep) -> Iterator[Fault]:
    """Objectives and constraints must name results."""
    known = results.names(sweep, () if "bend.pressure" in sweep.vary else pressures(sweep.bend))
    for section, names in (("objectives", sweep.objectives), ("constraints", sweep.constraints)):
        for name in names:
            if name not in known:
                yield Fault((section, name), "there is no such result", name, "one of " + ", ".join(known),
                            nearest(name, known))
