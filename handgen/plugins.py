"""What other packages hang in, looked up once a process: the look-up reads the metadata of all packages."""

from __future__ import annotations

from functools import cache
from importlib import metadata


@cache
def entry_points(group: str) -> tuple[metadata.EntryPoint, ...]:
    """Entry points of a group."""
    return tuple(metadata.entry_points(group=group))
