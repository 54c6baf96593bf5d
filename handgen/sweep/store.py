"""Rows on disk, each in a file of its own, named by the hash of what determines it; shared by all sweeps.

A row is written beside and renamed: it is there as a whole or not at all, whoever is killed when. Beside it
stands, while it is worked on, a log of attempts: what a process that dies leaves behind.
"""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any, BinaryIO

from handgen.bending import cache

WRITING, ABANDONED = ".writing", 2.0
"""Ending of a row that is being written, and seconds after which nobody is at it any more."""
TIMEOUT = b"Timeout ("
"""How the interpreter's watchdog begins what it writes (`faulthandler`)."""
MOST_DEATHS = 4
"""Attempts of one run that may die on a variant before it is given up."""


def default() -> Path:
    """In the folder of kept results (`HANDGEN_CACHE`, or the user's cache folder)."""
    return cache.folder() / "sweep"


class Store:
    """The rows in `folder`."""

    def __init__(self, folder: str | os.PathLike):
        self.folder = Path(folder)

    def path(self, key: str) -> Path:
        return self.folder / key[:2] / f"{key}.json"

    def read(self, key: str) -> dict[str, Any] | None:
        """The row of `key`; None where there is none that is whole."""
        try:
            row = json.loads(self.path(key).read_bytes())
        except (OSError, ValueError):
            return None
        return row if isinstance(row, dict) and "status" in row else None

    def write(self, key: str, row: dict[str, Any]) -> None:
        """Keep `row`, durable at once."""
        path = self.path(key)
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f"{key[:12]}.", suffix=WRITING, dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(json.dumps(row, allow_nan=True).encode())
                file.flush()
                os.fsync(file.fileno())
            os.replace(name, path)
        finally:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(name)

    # Attempts

    def _log(self, key: str) -> Path:
        return self.path(key).with_suffix(".attempts")

    def begin(self, key: str, run: str) -> tuple[BinaryIO, tuple[str, str] | None]:
        """(the open log, which the watchdog may write to; how the variant ends, if earlier attempts say so).

        Attempts of other runs than `run` say nothing: they were killed with their parent.
        """
        path = self._log(key)
        path.parent.mkdir(parents=True, exist_ok=True)
        self._sweep_up(key)
        before = path.read_bytes() if path.exists() else b""
        mine, ended = before.count(run.encode()), None
        if mine and TIMEOUT in before:
            ended = "timeout", _where(before)
        elif mine >= MOST_DEATHS:
            ended = "killed", f"its worker died {mine} times"
        log = path.open("ab" if mine else "wb")  # the caller closes it
        log.write(f"{run}\n".encode())
        log.flush()
        return log, ended

    def _sweep_up(self, key: str) -> None:
        """Take away what a process that was killed had not written to its end."""
        for beside in self.path(key).parent.glob(f"{key[:12]}.*{WRITING}"):
            with contextlib.suppress(FileNotFoundError):
                if time.time() - beside.stat().st_mtime > ABANDONED:
                    beside.unlink()

    def end(self, key: str, log: BinaryIO) -> None:
        log.close()
        with contextlib.suppress(FileNotFoundError):
            self._log(key).unlink()


def _where(log: bytes) -> str:
    """The innermost place of handgen, or of anything, that the watchdog found busy."""
    lines = [line.strip() for line in log.decode(errors="replace").splitlines()
             if line.strip().startswith("File ")]
    inside = [line for line in lines if "handgen" in line and "sweep" not in line] or lines
    if not inside:
        return ""
    file, _, rest = inside[0].removeprefix('File "').partition('"')
    return f"busy in {Path(file).name}{rest}"
