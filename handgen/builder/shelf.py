"""Meshes and reports of designs that were never built, by the key of all that determines them.

Files in the cache folder, written beside and renamed. What is missing or damaged is made again; a cache that
cannot be written costs time only. The folder may be deleted at any time.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from handgen.bending import cache

LARGEST = 500_000_000
"""Bytes; beyond, what was not used for longest goes."""


class Shelf:
    """The files of one kind; `ending` with its dot."""

    def __init__(self, name: str, ending: str):
        self.folder, self.ending = cache.folder() / name, ending

    def get(self, key: str) -> bytes | None:
        path = self._path(key)
        try:
            content = path.read_bytes()
            os.utime(path)
        except OSError:
            return None
        return content

    def put(self, key: str, content: bytes) -> None:
        with contextlib.suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            cache.make_room(self.folder, LARGEST)
            handle, name = tempfile.mkstemp(prefix=f"{key}.", suffix=".writing", dir=self.folder)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(content)
                os.replace(name, self._path(key))
            finally:
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(name)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{self.ending}"
