"""Worker processes: each imports the CAD kernels once and then makes part after part.

Plain subprocesses with a pipe, instead of `multiprocessing.Pool`: a killed worker is noticed at
once and its part is known by name, a script that calls `build` needs no `__main__` guard, and the
workers never import the caller's modules.
"""

from __future__ import annotations

import os
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from typing import Any

from handgen.build.libraries import explain
from handgen.errors import EngineError, GeometryError

Job = tuple[str, Callable[..., Any], tuple]
"""(name for people, importable function, its arguments)."""

START = ("import sys; sys.path[:] = {path!r}; "
         "from handgen.build.pool import serve; serve({descriptor})")
MEMORY_PER_WORKER = 0.75e9
"""Bytes: a worker with its kernels loaded and a hand in the making."""

PR_SET_PDEATHSIG = 1


class Workers:
    """Up to `count` worker processes that hold `lock`; use as a context manager."""

    def __init__(self, count: int, lock: int):
        self.count, self.lock = count, lock
        self.processes: dict[Connection, subprocess.Popen] = {}

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_) -> None:
        for pipe, process in self.processes.items():
            process.kill()
            process.wait()
            pipe.close()

    def run(self, groups: list[list[Job]]) -> Iterator[tuple[str, Any]]:
        """(name, result) of every job as it is done; a group's jobs run in order in one worker.

        Raises:
            GeometryError: as the job raised it.
            EngineError: a job failed otherwise, or its worker died; names the part.
        """
        queue = [list(group) for group in groups if group]
        self._start(min(self.count, len(queue)))
        idle, busy = list(self.processes), {}
        while queue or busy:
            while idle and queue:
                busy[idle[0]] = queue.pop(0)
                self._send(idle.pop(0), busy)
            for pipe in wait(list(busy)):
                (name, _, _), *rest = busy[pipe]
                yield name, self._receive(pipe, name)
                if rest:
                    busy[pipe] = rest
                    self._send(pipe, busy)
                else:
                    del busy[pipe]
                    idle.append(pipe)

    def _start(self, count: int) -> None:
        for _ in range(count - len(self.processes)):
            ours, theirs = Pipe()
            code = START.format(path=sys.path, descriptor=theirs.fileno())
            process = subprocess.Popen(
                [sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(), self.lock))
            theirs.close()
            self.processes[ours] = process

    def _send(self, pipe: Connection, busy: dict) -> None:
        name, function, arguments = busy[pipe][0]
        try:
            pipe.send((name, function, arguments))
        except OSError:
            raise self._died(pipe, name) from None

    def _receive(self, pipe: Connection, name: str) -> Any:
        try:
            kind, value = pipe.recv()
        except (EOFError, OSError):
            raise self._died(pipe, name) from None
        if kind == "geometry":
            raise GeometryError(*value)
        if kind == "engine":
            raise EngineError(f"{name}: {value}")
        return value

    def _died(self, pipe: Connection, name: str) -> EngineError:
        code = self.processes[pipe].wait()
        how = f"was killed by signal {-code}" if code < 0 else f"ended with code {code}"
        return EngineError(f"{name}: the process that made it {how} (out of memory?)")


def default_count() -> int:
    """One worker per processor that this process may use, as far as memory allows."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(processors, int(_available_memory() / MEMORY_PER_WORKER)))


def _available_memory() -> float:
    """Bytes that can be had without swapping; where the system does not say, 2 GB."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, StopIteration):
        return 2e9


def serve(descriptor: int) -> None:
    """A worker's life: take a job, do it, answer; ends with the pipe or with its parent."""
    _die_with_parent()
    pipe = Connection(descriptor)
    while True:
        try:
            _, function, arguments = pipe.recv()
        except EOFError:
            return
        pipe.send(_answer(function, arguments))


def _answer(function: Callable, arguments: tuple) -> tuple[str, Any]:
    try:
        return "done", function(*arguments)
    except GeometryError as error:
        return "geometry", (error.part, error.path, error.message)
    except EngineError as error:
        return "engine", str(error)
    except ImportError as error:
        return "engine", explain(error)
    except MemoryError:
        return "engine", "out of memory"
    except Exception:
        return "engine", "unexpected failure\n" + traceback.format_exc()


def _die_with_parent() -> None:
    """A killed build takes its workers with it (Linux; elsewhere they end with their job)."""
    if sys.platform == "linux":
        import ctypes
        import signal

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
