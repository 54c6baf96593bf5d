"""Which parameters differ, by key path, and what had to be adapted."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from typing import Any

from handgen.geometry.actuator import adaptations
from handgen.parameters.assumptions import leaves
from handgen.parameters.model import Hand

WORDS = ("name", "description")
"""Parameters that change nothing but what a design is called."""


def parameters(a: Hand, b: Hand) -> list[dict[str, Any]]:
    """[{"path", "a", "b"}], null where one of them has no such value; in the order of the definition."""
    before, after = leaves(a), leaves(b)
    return [{"path": path, "a": before.get(path), "b": after.get(path)}
            for path in {**before, **after}
            if path not in WORDS and before.get(path) != after.get(path)]


def adapted(a: Hand, b: Hand) -> dict[str, list[dict[str, Any]]]:
    """Adaptations that only one of the two needs, or needs otherwise."""
    return apart(map(asdict, adaptations(a)), map(asdict, adaptations(b)), lambda each: str(each["reason"]))


def apart(a: Iterable[Mapping[str, Any]], b: Iterable[Mapping[str, Any]],
          same: Callable[[Mapping[str, Any]], Any]) -> dict[str, list]:
    """{"gone": of `a` what has no counterpart in `b`, "new": of `b` ...}; each counts once."""
    new, gone = list(b), []
    for each in a:
        twin = next((other for other in new if same(other) == same(each)), None)
        if twin is None:
            gone.append(each)
        else:
            new.remove(twin)
    return {"gone": gone, "new": new}
