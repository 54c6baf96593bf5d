"""What of a hand is assumed: defaults that no source gives, and what the file itself marks so."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from handgen.parameters.explain import skeleton
from handgen.parameters.fault import Fault, Path, nearest, text
from handgen.parameters.model import Hand

SECTION = "assumed"


def collect(hand: Hand) -> list[dict]:
    """`[{path, value, reason}]`, one entry a value, in the order of the hand's definition.

    A pattern of the `assumed` section speaks for all values below the paths it matches; where
    several speak for one value, the longest pattern does, and of equal ones that with fewer `*`.
    """
    reasons = {path: (len(path), 0, why) for path, why in _defaults(hand, ())}
    values = dict(_leaves(_plain(hand), ()))
    for pattern, why in hand.assumed.items():
        keys = _keys(pattern)
        rank = (len(keys), -keys.count("*"))
        for path in values:
            if _covers(keys, path) and rank >= reasons.get(path, (0, 0, ""))[:2]:
                reasons[path] = (*rank, why)
    return [{"path": text(path), "value": value, "reason": reasons[path][2]}
            for path, value in values.items() if path in reasons]


def unmatched(data: dict, patterns: dict[str, str]) -> Iterator[Fault]:
    """Patterns that match nothing in `data` (a resolved hand, or raw data where that has errors)."""
    for pattern in patterns:
        keys, here = _keys(pattern), [data]
        for i, key in enumerate(keys):
            below = [child for node in here for child in _step(node, key)]
            if not below:
                names = sorted({str(k) for node in here for k, _ in _children(node)})
                mend = nearest(key, names)
                yield Fault((SECTION, pattern), f"matches nothing: there is no {key!r}"
                            + (f" in {text(tuple(keys[:i]))}" if i else ""),
                            allowed="one of " + ", ".join([*names, "*"]) if names else None,
                            suggestion=".".join([*keys[:i], mend, *keys[i + 1:]]) if mend else None)
                break
            here = below


def impossible(data: dict) -> list[Fault]:
    """Of raw `data` with errors: patterns that could match in no hand at all."""
    patterns = data.get(SECTION)
    if not isinstance(patterns, dict):
        return []
    absent = {fault.path for fault in unmatched(data, patterns)}
    return [fault for fault in unmatched(skeleton(Hand), patterns) if fault.path in absent]


def resolved(hand: Hand) -> dict:
    """The hand as plain data, defaults included, in the files' own names."""
    return hand.model_dump(mode="json", by_alias=True)


def leaves(hand: Hand) -> dict[str, Any]:
    """Key path -> value of every parameter, defaults included, in the order of the definition."""
    return {text(path): value for path, value in _leaves(_plain(hand), ())}


def _plain(hand: Hand) -> dict:
    return {key: value for key, value in resolved(hand).items() if key not in (SECTION, "schema")}


def _defaults(model: BaseModel, at: Path) -> Iterator[tuple[Path, str]]:
    """(path, reason) of every field that was left at a default marked `assumed`."""
    for name, info in type(model).model_fields.items():
        path, value = (*at, info.alias or name), getattr(model, name)
        reason = (info.json_schema_extra or {}).get("assumed")
        if reason and name not in model.model_fields_set:
            yield path, reason
        for below, child in [(path, value)] if not isinstance(value, list) else (
                [((*path, i), entry) for i, entry in enumerate(value)]):
            if isinstance(child, BaseModel):
                yield from _defaults(child, below)


def _leaves(node: Any, at: Path) -> Iterator[tuple[Path, Any]]:
    """Every value below `node`: a number, a text, or a list of such (a point, a taper)."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield from _leaves(value, (*at, key))
    elif isinstance(node, list) and any(isinstance(entry, dict) for entry in node):
        for i, value in enumerate(node):
            yield from _leaves(value, (*at, i))
    elif node is not None and node != []:
        yield at, node


def _keys(pattern: str) -> list[str]:
    """`fingers.*.joints[*].position` -> its keys; `[3]` and `.3` are the same."""
    return pattern.replace("[", ".").replace("]", "").split(".")


def _covers(keys: list[str], path: Path) -> bool:
    return len(keys) <= len(path) and all(
        k in ("*", str(p)) for k, p in zip(keys, path, strict=False))


def _children(node: Any) -> Iterator[tuple[str | int, Any]]:
    """What stands below a node; an absent optional value counts as not there."""
    pairs = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    return ((key, value) for key, value in pairs if value is not None)


def _step(node: Any, key: str) -> list[Any]:
    return [value for name, value in _children(node) if key in ("*", str(name))]
