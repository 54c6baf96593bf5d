"""One thing wrong in a parameter file, before it is known which file of a chain says it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import NamedTuple

Path = tuple[str | int, ...]
"""Key path: mapping keys and list indices from the top of the file."""


class Fault(NamedTuple):
    """What is wrong at a key path; `line` only where the reader of the file knows it already."""

    path: Path
    message: str
    value: object = None
    allowed: str | None = None
    suggestion: str | None = None
    line: int | None = None


def text(path: Path) -> str:
    """`fingers.index.joints[1].slot_length`."""
    parts = (f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)
    return "".join(parts).removeprefix(".")


def nearest(word: object, valid: Iterable[str]) -> str | None:
    """The valid name that looks most like `word`; None if nothing comes close."""
    found = difflib.get_close_matches(str(word)[:64], list(valid), n=1, cutoff=0.5)
    return found[0] if found else None
