"""A sweep file -> all that a run needs, or everything that is wrong with it at once."""

from __future__ import annotations

import copy
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
from handgen.sweep import draw, faults, keypath, results
from handgen.sweep.model import SCHEMA, Bending, Force, Sweep

HAND, MODEL, BEND, FORCE = "hand", "model", "bend", "force"
PREFIXES = {"model.": MODEL, "bend.": BEND, "force.": FORCE}
"""What a key path begins with that does not lead into the parameter file."""
SILENT = ("schema", "name", "description", "assumed")
"""Keys of a parameter file that no result depends on."""
STAND_INS = {"name": "unnamed", "base": "missing", "vary": {"bend.refine": {"choices": [0]}}}
"""For keys that a sweep must have, so that a file without them can be looked at."""


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
        sweep = validated(here, Sweep, SCHEMA, faults.spelled_out, faults.related)
    except InputError as error:
        # What is right must not hide what else is wrong.
        problems, sweep = error.problems, _salvaged(raw)
        if sweep is None:
            raise
    told = [problem.path for problem in problems]
    further = [here.problem(fault) for fault in faults.related(sweep)] if problems else []
    base, base_file, hand, wrong = _based(here, sweep)
    further += wrong
    model_data, model_file, model, wrong = _modelled(here, sweep)
    further += wrong
    targets: dict[str, tuple[Target, ...]] = {}
    found = [*_loadable(sweep), *_named(sweep)]
    if hand is not None and model is not None:
        model_data = _spelled(model_data, sweep)
        places = _places(hand, model, model_data)
        found += [*_set_by_axes(sweep, places, targets), *_fingered(sweep, hand)]
    further += map(here.problem, found)
    # A key that is wrong is told once, and what was taken in its place not at all.
    problems += [p for p in further if p.file != here.file or not any(
        path == p.path or path.startswith(f"{p.path}.") for path in told)]
    if problems:
        raise InputError(problems)
    return Prepared(sweep, FilePath(file), base, base_file, model_data, model_file, targets)


def _based(here: document.Document, sweep: Sweep) -> tuple[dict, FilePath, Hand | None, list[Problem]]:
    """(data of the base file, the file, its hand, what is wrong with it)."""
    file = FilePath(here.file).parent / sweep.base
    try:
        return merged(file), file, load_hand(file).hand, []
    except InputError as error:
        if file.is_file():
            return {}, file, None, error.problems
        one = error.problems[0]
        near = one.suggestion and os.fspath(FilePath(sweep.base).parent / one.suggestion)
        return {}, file, None, [here.problem(Fault(("base",), one.message, sweep.base,
                                                   "a parameter file, relative to this one", near))]


def _modelled(here: document.Document, sweep: Sweep) -> tuple[dict, str, BendModel | None, list[Problem]]:
    """(data of the model file, the file, the model, what is wrong with it)."""
    wanted = sweep.model or default_name()
    beside = FilePath(here.file).parent / wanted
    try:
        file = path_of(beside if beside.is_file() else wanted)
        return document.read(file).data, file, load_model(file)[0], []
    except InputError as error:
        return {}, "", None, [
            here.problem(Fault(("model",), p.message, p.value, p.allowed, p.suggestion))
            if p.path == "--model" else p for p in error.problems]


def _salvaged(raw: object) -> Sweep | None:
    """The sweep without what is wrong in it; None where nothing is left to look at."""
    if not isinstance(raw, dict) or raw.get("schema") != SCHEMA:
        return None
    for fault in faults.spelled_out(raw):
        raw["vary"].pop(fault.path[1], None)
    for _ in range(4):
        for key, value in STAND_INS.items():
            if not raw.get(key):
                raw[key] = copy.deepcopy(value)
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
    for key in SILENT:
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
                for there, by in _overlaps(taken, scope, path):
                    if there != path or adds is None or not sweep.vary[by].adds:
                        yield Fault(at, f"{text(path)} is set by {by!r} too", given)
                taken[scope, path] = name
                base = keypath.get(places[scope], path)
                moved = adds is not None or scales
                if moved and (isinstance(base, bool) or not isinstance(base, int | float)):
                    yield Fault(at, f"{prefix}{text(path)} is no number that could be "
                                f"{'scaled' if scales else 'added to'}", given)
                    continue
                found.append(Target(scope, path, adds, scales, base if moved else 0.0))
            if scope == FORCE and sweep.force is None:
                yield Fault(at, "there is no `force` in this sweep", given,
                            "a section `force` with pressure and obstacle")
        targets[name] = tuple(found)


def _overlaps(taken: dict[tuple[str, Path], str], scope: str, path: Path) -> list[tuple[Path, str]]:
    """(path, its axis) of what is taken and is `path`, a part of it, or holds it."""
    return [(there, by) for (place, there), by in taken.items()
            if place == scope and there[:len(path)] == path[:len(there)]]


def _matched(scope: str, rest: str, places: dict[str, Any]) -> tuple[list[Path], str | None, list[str]]:
    """As `keypath.matches`; an optional key that the base leaves out may be named too."""
    paths, lost, valid = keypath.matches(places[scope], rest)
    if not paths and scope == HAND and keypath.keys(rest)[0] not in SILENT:
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
    if any(loads.orientation(bend.orientation, bend.part, wrong)) and sweep.solver == solvers.REVOLUTION:
        yield Fault(("bend", "orientation"), loads.OFF_AXIS, bend.orientation, loads.WEIGHTLESS)
    loads.pressures(bend.pressures, bend.part, wrong)
    where = {"--orientation": ("bend", "orientation"), "--pressures": ("bend", "pressures")}
    yield from (Fault(where[p.path], p.message, p.value, p.allowed, p.suggestion) for p in wrong)


def _named(sweep: Sweep) -> Iterator[Fault]:
    """Objectives and constraints must name results."""
    known = results.names(sweep, () if "bend.pressure" in sweep.vary else pressures(sweep.bend))
    for section, names in (("objectives", sweep.objectives), ("constraints", sweep.constraints)):
        for name in names:
            if name == results.FORCED and sweep.force is None:
                yield Fault((section, name), "there is no `force` in this sweep", name,
                            "a section `force` with pressure and obstacle")
            elif name not in known:
                yield Fault((section, name), "there is no such result", name, "one of " + ", ".join(known),
                            nearest(name, known))
