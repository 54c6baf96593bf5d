"""Worker processes: each imports the CAD kernels once and then makes part after part.

Plain subprocesses with a pipe, instead of `multiprocessing.Pool`: a killed worker is noticed at
once and its part is known by name, a script that calls `build` needs no `__main__` guard, and the
workers never import the caller's modules.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import subprocess
import sys
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from importlib import import_module
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from typing import Any

from handgen.builder.libraries import explain
from handgen.errors import EngineError, GeometryError

Job = tuple[str, Callable[..., Any], tuple]
"""(name for people, importable function, its arguments)."""

START = ("import sys; sys.path[:] = {path!r}; "
         "from handgen.builder.pool import serve; serve({descriptor}, {kernels}, {parent})")
MEMORY_PER_WORKER = 0.75e9
"""Bytes: a worker with its kernels loaded and a hand in the making."""

PR_SET_PDEATHSIG = 1


class Workers:
    """Up to `count` worker processes that hold `lock` and load `kernels` first; a context manager."""

    def __init__(self, count: int, lock: int, kernels: tuple[str, ...] = ("cadquery", "manifold3d")):
        self.count, self.lock, self.kernels = count, lock, kernels
        self.queue: deque[list[Job]] = deque()
        self.processes: dict[Connection, subprocess.Popen] = {}
        self.busy: dict[Connection, list[Job]] = {}

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_) -> None:
        for pipe in list(self.processes):
            self._end(pipe)

    def warm(self, count: int) -> None:
        """Start workers for `count` jobs to come; they load the kernels while the jobs are planned."""
        for _ in range(min(self.count, count) - len(self.processes)):
            self._start()

    def add(self, group: list[Job]) -> None:
        """Queue jobs that one worker shall do in order."""
        self.queue.append(group)

    def results(self) -> Iterator[tuple[str, Any]]:
        """(name, result) of every job as it is done; jobs may be added meanwhile.

        A job that fails gives its error as result: a GeometryError as it was raised, or an
        EngineError that names the part, also when its worker died.
        """
        while self.queue or self.busy:
            self._hand_out()
            for pipe in wait(list(self.busy)):
                (name, _, _), *rest = self.busy.pop(pipe)
                result = self._receive(pipe, name)
                if rest and pipe in self.processes:
                    self._send(pipe, rest)
                elif rest:
                    self.queue.appendleft(rest)
                yield name, result

    def _hand_out(self) -> None:
        """Give every idle worker its next group; start workers as they are needed."""
        while self.queue:
            idle = [pipe for pipe in self.processes if pipe not in self.busy]
            if not idle and len(self.processes) >= self.count:
                return
            self._send(idle[0] if idle else self._start(), self.queue.popleft())

    def _start(self) -> Connection:
        ours, theirs = Pipe()
        code = START.format(path=sys.path, descriptor=theirs.fileno(), kernels=self.kernels,
                            parent=os.getpid())
        # In a group of its own: an interrupt at the terminal is the caller's, who then ends its workers.
        self.processes[ours] = subprocess.Popen(
            [sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            pass_fds=(theirs.fileno(), self.lock), process_group=0)
        theirs.close()
        return ours

    def _send(self, pipe: Connection, group: list[Job]) -> None:
        self.busy[pipe] = group
        # A worker that is dead already is noticed when its answer is read.
        with contextlib.suppress(OSError):
            pipe.send(group[0])

    def _receive(self, pipe: Connection, name: str) -> Any:
        try:
            kind, value = pipe.recv()
        except (EOFError, OSError):
            code = self.processes[pipe].wait()
            self._end(pipe)
            how = f"was killed by signal {-code}" if code < 0 else f"ended with code {code}"
            return EngineError(f"{name}: the process that made it {how} (out of memory?)")
        if kind == "geometry":
            return GeometryError(*value)
        return EngineError(f"{name}: {value}") if kind == "engine" else value

    def _end(self, pipe: Connection) -> None:
        process = self.processes.pop(pipe)
        process.kill()
        process.wait()
        pipe.close()


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


def serve(descriptor: int, kernels: tuple[str, ...], parent: int) -> None:
    """A worker's life: load `kernels`, take a job, do it, answer; ends with the pipe or with its parent."""
    _die_with(parent)
    # A kernel that cannot be loaded is reported by the first job that needs it.
    with contextlib.suppress(ImportError):
        for kernel in kernels:
            import_module(kernel)
    pipe = Connection(descriptor)
    while True:
        try:
            _, function, arguments = pipe.recv()
            pipe.send(_answer(function, arguments))
        except (EOFError, BrokenPipeError):
            return
        _give_back()


def _give_back() -> None:
    """Freed memory to the system, on glibc: the rules on walls alone leave 300 MB to the allocator, and the
    next job's kernel would come on top."""
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)


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


def _die_with(parent: int) -> None:
    """A killed build takes its workers with it (Linux; elsewhere they end with their job)."""
    if sys.platform == "linux":
        import signal

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it went before the signal was asked for
            sys.exit()
