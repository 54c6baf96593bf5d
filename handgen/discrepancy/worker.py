"""Many bends on a few processes, each kept once it is solved: an interruption loses those in work alone."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from handgen.bending import cache, solvers
from handgen.bending.request import Request
from handgen.bending.run import solve
from handgen.errors import EngineError
from handgen.simulation.case import Curve

Progress = Callable[[str], None]
LONGEST = ("assembly", "exoskeleton", "actuator")
"""Parts, those whose bends take longest first."""
NOTICES = 20
"""Lines of progress that a row of bends is told in, about."""


@dataclass
class Bends:
    """Answers to requests, from the cache or by `workers` processes."""

    workers: int = 2
    progress: Progress = lambda line: None
    solved: int = 0
    """Bends that no earlier run had kept."""
    known: dict[str, Curve | None] = field(default_factory=dict)

    def curves(self, requests: Sequence[Request], what: str) -> list[Curve | None]:
        """Of each request its curve; None where the solver failed altogether."""
        keys = [cache.key(one.case, solvers.solver(one.solver)) for one in requests]
        waiting: dict[str, Request] = {}
        for key, one in zip(keys, requests, strict=True):
            if key not in self.known and key not in waiting:
                if (curve := cache.read(key)) is not None:
                    self.known[key] = curve
                else:
                    waiting[key] = one
        if waiting:
            self._solve(waiting, what)
        return [read(one, self.known[key]) for key, one in zip(keys, requests, strict=True)]

    def _solve(self, waiting: dict[str, Request], what: str) -> None:
        total = len(waiting)
        every = max(total // NOTICES, 1)
        self.progress(f"{what}: {total} bends to solve")
        for done, (key, curve) in enumerate(self._answers(waiting), start=1):
            self.known[key] = curve
            self.solved += 1
            if done % every == 0 or done == total:
                self.progress(f"{what}: {done} of {total}")

    def _answers(self, waiting: dict[str, Request]):
        """(key, curve) as they are solved; longest first, so that no process idles at the end."""
        from concurrent.futures import ProcessPoolExecutor, as_completed
        from multiprocessing import get_context

        order = sorted(waiting, key=lambda key: LONGEST.index(waiting[key].part))
        if self.workers == 1 or len(order) == 1:
            for key in order:
                yield key, answer(waiting[key])
            return
        count = min(self.workers, len(order))
        pool = ProcessPoolExecutor(count, get_context("spawn"), _begin, (os.getpid(),))
        try:
            jobs = {pool.submit(answer, waiting[key]): key for key in order}
            for job in as_completed(jobs):
                yield jobs.pop(job), job.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def answer(asked: Request) -> Curve | None:
    """The curve of `asked` before what changes readings; kept by the cache, where the parent finds it too."""
    from dataclasses import replace

    try:
        curve = solve(replace(asked, effects=())).curve
    except EngineError:
        return None
    return replace(curve, grids={}, states=tuple(replace(s, positions={}, stretch={}) for s in curve.states))


def read(asked: Request, curve: Curve | None) -> Curve | None:
    """`curve` as it is read with the effects of `asked`."""
    from handgen.bending.applied import read as applied

    if curve is None:
        return None
    return applied(curve, asked.case, asked.effects, asked.gauge)


def _begin(parent: int) -> None:
    """One thread a process; a parent that is gone, however it went, takes its workers along."""
    import signal
    import threading
    import time

    from handgen.simulation.solid import THREADS

    os.environ[THREADS] = "1"
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
