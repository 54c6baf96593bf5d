"""slices.json and the G-code that it lists: kept by content, written beside and renamed."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from handgen import atomic
from handgen.builder.store import digest_file

INDEX = "slices.json"
FOLDER = "slices"


class Slices:
    """What was sliced into one output folder; threads may share it."""

    def __init__(self, folder: Path):
        self.folder, self._lock = folder, threading.Lock()
        self.rows = {row["gcode"]: row for row in read(folder)}

    def kept(self, gcode: str, key: str) -> dict[str, Any] | None:
        """The row of a G-code file that is what `key` names, unchanged."""
        row = self.rows.get(gcode)
        if row is None or row["key"] != key or digest_file(self.folder / gcode) != row["sha256"]:
            return None
        return row

    def writing(self, gcode: str) -> AbstractContextManager[Path]:
        """A path beside the file's own, which takes its place unless an error is raised."""
        return atomic.writing(self.folder / gcode)

    def write(self, rows: Iterable[dict[str, Any]]) -> None:
        """Enter rows; the index is exchanged as a whole."""
        with self._lock:
            self.rows |= {row["gcode"]: row for row in rows}
            text = json.dumps([self.rows[name] for name in sorted(self.rows)], indent=1, allow_nan=False)
            atomic.write(self.folder / INDEX, text + "\n")


def read(folder: Path) -> list[dict[str, Any]]:
    """The rows of a folder's slices.json; none where it is missing or damaged."""
    try:
        rows = json.loads((folder / INDEX).read_bytes())
        return [row for row in rows if {"part", "slicer", "gcode", "key", "sha256"} <= row.keys()]
    except (OSError, ValueError, TypeError, AttributeError):
        return []
