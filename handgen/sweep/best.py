"""Which variants are best, and their files."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from handgen import atomic
from handgen.errors import HandgenError
from handgen.sweep.load import Prepared
from handgen.sweep.model import Sweep
from handgen.sweep.variant import task


def feasible(sweep: Sweep, row: dict[str, Any]) -> bool:
    """Whether a row has all that is asked of it, breaks no rule and meets every bound."""
    if row["status"] != "done" or row.get("rules_passed") == 0.0:
        return False
    if any(row.get(name) is None for name in sweep.objectives):
        return False
    return excess(sweep, row) <= 0.0


def excess(sweep: Sweep, row: dict[str, Any]) -> float:
    """By how much bounds are missed, each as a share of itself, summed; infinite without a result."""
    total = 0.0
    for name, bound in sweep.constraints.items():
        value = row.get(name)
        if value is None:
            return math.inf
        if bound.max is not None:
            total += max(0.0, value - bound.max) / (abs(bound.max) or 1.0)
        if bound.min is not None:
            total += max(0.0, bound.min - value) / (abs(bound.min) or 1.0)
    return total


def missed(sweep: Sweep, row: dict[str, Any]) -> list[str]:
    """Constraints that a row has a value for and does not meet."""
    return [name for name, bound in sweep.constraints.items() if (value := row.get(name)) is not None and (
        (bound.max is not None and value > bound.max) or (bound.min is not None and value < bound.min))]


def ranked(sweep: Sweep, rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Feasible rows, the best first: by the first objective, then the next; [] without objectives."""
    if not sweep.objectives:
        return []
    found = (row for row in rows if feasible(sweep, row))
    return sorted(found, key=lambda row: (*_costs(sweep, row), row["variant"]))


def _costs(sweep: Sweep, row: dict[str, Any]) -> list[float]:
    return [-row[name] if way == "maximise" else row[name] for name, way in sweep.objectives.items()]


def save_kept(prepared: Prepared, best: list[dict[str, Any]], folder: Path,
              say: Callable[[str], None]) -> list[str]:
    """Parameter files and the finger's parts of the `best` rows, in `folder`/best; returns the files."""
    import yaml

    from handgen.builder import build

    files = []
    for rank, row in enumerate(best, start=1):
        name = f"{prepared.sweep.name}_{rank}"
        values = {axis: row[axis] for axis in prepared.sweep.vary}
        hand = task(prepared, values).hand
        place = folder / "best" / f"{name}.yaml"
        told = "; ".join(f"{axis} {value}" for axis, value in values.items())
        text = yaml.safe_dump({**hand, "name": name, "description": f"{prepared.sweep.name}: {told}"[:400]},
                              sort_keys=False, allow_unicode=True)
        atomic.write(place, text)
        files.append(str(place))
        finger = prepared.sweep.bend.finger
        try:
            build(place, out=place.with_suffix(""), parts=[f"exoskeleton/{finger}", f"actuators/{finger}"],
                  progress=None, workers=1)
        except HandgenError as error:
            say(f"warning: {name} was not built: {error}")
    return files
