"""How the fingers of two designs bend: the same, as solved before, or not known without solving."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from handgen.bending import Request, cache, request, solve, solvers
from handgen.errors import InputError
from handgen.parameters.load import Loaded

TOLD = ("pressure_kPa", "converged", "bend_angle_deg", "tip_drop_mm", "elongation_mm", "max_stretch")
UNSOLVED = "not solved yet"


def bends(a: Loaded, b: Loaded, solving: bool, progress: Callable[[str], None]) -> list[dict[str, Any]]:
    """A row a finger, 0 to 100 kPa, palm down: {"finger", "change", "a", "b", "why"}.

    `change`: "same" (the solver would be asked the very same), "changed", "gone", "new". "a" and "b":
    {"points", "reached", "reached_unit"}, or null with the reason under "why". `solving` solves what is not
    known.

    Raises:
        EngineError: the solver cannot be loaded or failed.
    """
    asked = [_asked(loaded) for loaded in (a, b)]
    return [_row(finger, [side.get(finger) for side in asked], solving, progress)
            for finger in {**asked[0], **asked[1]}]


def _asked(loaded: Loaded) -> dict[str, Request | str]:
    """Finger -> what a solver is asked, or why it cannot be."""
    found: dict[str, Request | str] = {}
    for name in loaded.hand.fingers.present():
        try:
            found[name] = request(loaded, finger=name)
        except InputError as error:
            found[name] = "; ".join(f"{p.path}: {p.message}" if p.path else p.message for p in error.problems)
    return found


def _row(finger: str, asked: list[Request | str | None], solving: bool, progress: Callable[[str], None]
         ) -> dict[str, Any]:
    keys = [_key(each) for each in asked]
    change = "gone" if asked[1] is None else "new" if asked[0] is None else (
        "same" if keys[0] == keys[1] else "changed")
    sides, why = [], {}
    for side, each, key in zip("ab", asked, keys, strict=True):
        found = None
        if isinstance(each, str):
            why[side] = each
        elif each is not None and not solving and cache.read(key) is None:
            why[side] = UNSOLVED
        elif each is not None:
            progress(f"bending {finger} of {each.hand}")
            found = _told(solve(each).document)
        sides.append(found)
    return {"finger": finger, "change": change, "a": sides[0], "b": sides[1], "why": why}


def _key(asked: Request | str | None) -> str | None:
    if isinstance(asked, Request):
        return cache.key(asked.case, solvers.solver(asked.solver))
    return asked


def _told(document: Mapping[str, Any]) -> dict[str, Any]:
    return {"points": [{key: point[key] for key in TOLD} for point in document["points"]],
            "reached": document["reached"], "reached_unit": document["reached_unit"],
            "model": document["model"]}
