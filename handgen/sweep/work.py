"""What runs on a worker: one variant after another, watched over, its row durable before the next begins."""

from __future__ import annotations

import contextlib
import faulthandler
import os
import pickle
import sys
import threading
import zlib
from collections.abc import Sequence
from typing import Any

from handgen.errors import EngineError
from handgen.simulation.solid import THREADS
from handgen.sweep.evaluate import evaluate
from handgen.sweep.store import Store
from handgen.sweep.variant import Task, version

_alone = threading.Lock()
"""A process bends one variant at a time, however many threads its worker was given."""


def packed(jobs: Sequence[tuple[str, Task]]) -> bytes:
    """`jobs` for the way to a worker: what variants share is in it once."""
    return zlib.compress(pickle.dumps(list(jobs)), 1)


def work(jobs: bytes, folder: str, run: str, limit: float, made_by: str) -> list[dict[str, Any]]:
    """The rows of `packed` jobs, from the store in `folder` or computed within `limit` seconds each.

    Raises:
        EngineError: this worker's handgen is another one than the parent's (`made_by`).
    """
    if made_by != version():
        raise EngineError("this worker runs another version of handgen than the sweep's parent")
    return [_row(key, task, folder, run, limit) for key, task in pickle.loads(zlib.decompress(jobs))]


def _row(key: str, task: Task, folder: str, run: str, limit: float) -> dict[str, Any]:
    """The row of `task`.

    A process that hangs, even in compiled code, is ended by the interpreter's watchdog; the scheduler starts
    the variant again elsewhere, which finds in the attempts' log what happened.
    """
    with _alone:
        store = Store(folder)
        if (row := store.read(key)) is not None and not retried(row, limit):
            return row
        os.environ[THREADS] = "1"
        log, ended = _begun(store, key, run)
        try:
            if ended is not None:
                status, reason = ended
                late = status == "timeout"
                row = {"status": status, "reason": f"after {limit:g} s, {reason}" if late else reason,
                       "limit_s": limit, "wall_s": limit if late else None}
            else:
                faulthandler.dump_traceback_later(limit, exit=True, file=log or sys.stderr)
                try:
                    row = evaluate(task)
                finally:
                    faulthandler.cancel_dump_traceback_later()
            with contextlib.suppress(OSError):  # a worker without the parent's disk: the parent keeps the row
                store.write(key, row)
        finally:
            if log is not None:
                store.end(key, log)
    return row


def _begun(store: Store, key: str, run: str):
    """As `Store.begin`; (None, None) on a worker that cannot write there."""
    try:
        return store.begin(key, run)
    except OSError:
        return None, None


def retried(row: dict[str, Any], limit: float) -> bool:
    """Whether a stored row is tried again: it ran out of time, and has more now."""
    return row["status"] == "timeout" and row.get("limit_s", 0.0) < limit
