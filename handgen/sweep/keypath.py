"""Key paths into plain data: `fingers.index.joints.*.slot_length`, `joints[0]` and `joints.0` alike."""

from __future__ import annotations

from typing import Any

from handgen.parameters.fault import Path


def keys(text: str) -> list[str]:
    """The path's keys, as written."""
    return text.replace("[", ".").replace("]", "").split(".")


def matches(skeleton: Any, text: str) -> tuple[list[Path], str | None, list[str]]:
    """(paths that `text` names in `skeleton`, the first key that leads nowhere, what could stand there)."""
    here: list[tuple[Path, Any]] = [((), skeleton)]
    for key in keys(text):
        below = [((*path, name), child) for path, node in here for name, child in _children(node)
                 if key in ("*", str(name))]
        if not below:
            return [], key, sorted({str(name) for _, node in here for name, _ in _children(node)})
        here = below
    return [path for path, _ in here], None, []


def _children(node: Any) -> list[tuple[str | int, Any]]:
    if isinstance(node, dict):
        return list(node.items())
    return list(enumerate(node)) if isinstance(node, list) else []


def get(data: Any, path: Path) -> Any:
    """The value at `path`; None where the data does not say it."""
    for key in path:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def put(data: Any, path: Path, value: Any) -> Any:
    """`data` with `value` at `path`; what is not changed is shared. Missing mappings are made."""
    if not path:
        return value
    key, *rest = path
    if isinstance(data, list):
        return [put(entry, tuple(rest), value) if i == key else entry for i, entry in enumerate(data)]
    return {**data, key: put(data.get(key, {}), tuple(rest), value)}
