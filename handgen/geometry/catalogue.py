"""Every part of a hand by name, in the order of the contract; trees only, so it is cheap."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path

from handgen.errors import InputError, Problem
from handgen.geometry.actuator import actuator, refuse_forbidden
from handgen.geometry.finger import exoskeleton
from handgen.geometry.hand import hand_part
from handgen.geometry.part import Part
from handgen.geometry.tooling import tooling
from handgen.parameters.load import load
from handgen.parameters.model import Hand


def parts(path: str | Path) -> dict[str, Part]:
    """The parts of the parameter file at `path`, by name.

    Raises:
        InputError: the file is not a valid hand, or its layers leave no core and may not be thinned.
    """
    hand = load(path).hand
    refuse_forbidden(hand, str(path))
    return catalogue(hand)


def catalogue(hand: Hand) -> dict[str, Part]:
    """All parts of `hand` by name: exoskeleton, actuators, tooling."""
    actuators = hand.actuators.present()
    listed = [
        *([hand_part(hand)] if hand.palm else []),
        *(exoskeleton(hand, name) for name in hand.fingers.present()),
        *(actuator(hand, name) for name in actuators),
        *(part for name in actuators for part in tooling(hand, name)),
    ]
    return {part.name: part for part in listed}


def select(names: Iterable[str], wanted: Iterable[str] | None) -> list[str]:
    """Those of `names` that `wanted` asks for, in the order of `names`; None asks for all.

    A pattern may be a part's whole name (`exoskeleton/hand`), a folder (`tooling/index`), or any
    single word of a name: `index` is everything of the index finger, `mould_a` the first half of
    every mould. `*`, `?` and `[...]` stand for any text, also across folders.

    Raises:
        InputError: a pattern asks for nothing.
    """
    names = list(names)
    if wanted is None:
        return names
    found, problems = set(), []
    for pattern in wanted:
        hits = {name for name in names if _asks_for(pattern.strip("/"), name)}
        found |= hits
        if not hits:
            problems.append(_unknown(pattern, names))
    if problems:
        raise InputError(problems)
    return [name for name in names if name in found]


def _asks_for(pattern: str, name: str) -> bool:
    return (fnmatchcase(name, pattern) or name.startswith(pattern + "/")
            or any(fnmatchcase(word, pattern) for word in name.split("/")))


def _unknown(pattern: str, names: list[str]) -> Problem:
    words = {word for name in names for word in name.split("/")}
    nearest = difflib.get_close_matches(pattern, [*names, *sorted(words)], n=1, cutoff=0.5)
    return Problem("--part", "", pattern, "no part has this name", ", ".join(names),
                   nearest[0] if nearest else None)
