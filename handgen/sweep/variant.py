"""One variant: what a sweep's axes make of its base, and the hash of everything that determines its row."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from handgen.bending import solvers
from handgen.sweep import draw, keypath, load
from handgen.sweep.load import BEND, FORCE, HAND, MODEL, Prepared
from handgen.sweep.model import Bending, Confirm, Force

FORMAT = 1
"""Of rows; another one is another hash."""
SILENT = {HAND: load.SILENT,
          MODEL: ("schema", "name", "description", "sources", "assumed", "fitted")}
"""Keys that no result depends on."""
SOURCES = ("bending", "checks", "geometry", "materials", "mechanics", "parameters", "simulation",
           "sweep/evaluate.py", "sweep/mass.py")
"""What rows depend on, in the package."""


@dataclass(frozen=True)
class Task:
    """All that a worker must know of a variant; plain data."""

    hand: dict
    hand_file: str
    model: dict
    model_file: str
    bend: dict
    force: dict | None
    solver: str
    rules: str

    @property
    def key(self) -> str:
        """sha256 of what determines the row, sources of handgen included."""
        content = {
            "format": FORMAT, "version": version(), "hand": _told(self.hand, SILENT[HAND]),
            "model": _told(self.model, SILENT[MODEL]), "bend": self.bend, "force": self.force,
            "solver": [self.solver, _solver_version(self.solver)], "rules": self.rules}
        text = json.dumps(draw.plain(content), sort_keys=True, separators=(",", ":"), allow_nan=True)
        return hashlib.sha256(text.encode()).hexdigest()


def task(prepared: Prepared, values: Mapping[str, Any]) -> Task:
    """The variant of `prepared` with `values` (axis -> value)."""
    sweep = prepared.sweep
    data = {HAND: prepared.base, MODEL: prepared.model, BEND: sweep.bend.model_dump(),
            FORCE: sweep.force.model_dump() if sweep.force else None}
    made: dict[tuple, Any] = {}
    for axis, value in values.items():
        for target in prepared.targets[axis]:
            place = target.scope, target.path
            made[place] = target.value(value, made.get(place, target.base))
            data[target.scope] = keypath.put(data[target.scope], target.path, made[place])
    return Task(data[HAND], str(prepared.base_file), data[MODEL], prepared.model_file, data[BEND],
                data[FORCE], sweep.solver, sweep.rules)


def confirming(one: Task, by: Confirm) -> Task:
    """The same variant by another solver and more rules."""
    return replace(one, bend={**one.bend, "refine": by.refine}, solver=by.solver, rules=by.rules)


def bending(one: Task) -> Bending:
    """The bend of a task, validated.

    Raises:
        ValidationError: an axis gave it a value that it cannot have.
    """
    return Bending.model_validate(one.bend)


def force(one: Task) -> Force | None:
    """The force of a task, validated.

    Raises:
        ValidationError: an axis gave it a value that it cannot have.
    """
    return None if one.force is None else Force.model_validate(one.force)


@cache
def version() -> str:
    """Hash of the sources that rows depend on."""
    root, total = Path(__file__).parents[1], hashlib.sha256()
    for name in SOURCES:
        path = root / name
        files = [path] if path.is_file() else sorted(p for p in path.rglob("*")
                                                     if p.suffix in (".py", ".yaml", ".json"))
        for file in files:
            total.update(str(file.relative_to(root)).encode() + b"\0" + file.read_bytes())
    return total.hexdigest()


@cache
def _solver_version(name: str) -> str:
    return "" if name in solvers.OWN else solvers.solver(name).version


def _told(data: Mapping[str, Any], silent: tuple[str, ...]) -> dict:
    return {key: value for key, value in data.items() if key not in silent}
