"""Variants shared out to Dask workers, a local cluster's or a scheduler's that somebody started."""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from handgen.errors import EngineError, InputError, Problem
from handgen.sweep.variant import Task, version
from handgen.sweep.work import work

AHEAD = 4
"""Variants in hand for every thread: enough that none waits, few enough that memory stays flat."""
DEATHS = 8
"""Of workers on one variant before Dask gives it up; the attempts' log does so before."""
PATIENCE = 10.0
"""Seconds that a scheduler may take to answer."""
Job = tuple[str, Task]


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Cluster:
    """Workers; `rows` has them work."""

    def __init__(self, client: Any):
        self.client = client

    @property
    def threads(self) -> int:
        """How many variants can be worked on at once: one a process."""
        return max(1, len(self.client.ncores()))

    def rows(self, jobs: Iterable[Job], folder: str, run: str, limit: float,
             tick: Callable[[], None] = lambda: None) -> Iterator[tuple[str, dict[str, Any]]]:
        """(key, row) of every job as it is finished, in no order.

        Raises:
            EngineError: the scheduler is lost, or its workers run another handgen.
        """
        from distributed import as_completed

        waiting, asked = iter(jobs), {}
        done = as_completed(loop=self.client.loop)
        made_by = version()

        def more() -> None:
            while len(asked) < AHEAD * self.threads and (job := next(waiting, None)) is not None:
                key, task = job
                future = self.client.submit(work, key, task, folder, run, limit, made_by,
                                            key=f"variant-{run}-{key}", pure=False)
                asked[future] = key
                done.add(future)

        more()
        while asked:
            future = next(done)
            key = asked.pop(future)
            yield key, _row(future)
            future.release()
            tick()
            more()


def _row(future: Any) -> dict[str, Any]:
    """What a future came to."""
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker as error:
        return {"status": "killed", "reason": f"its worker died again and again: {error}"[:400],
                "wall_s": None}
    except EngineError:
        raise
    except Exception as error:
        raise EngineError(f"the scheduler gave up: {type(error).__name__}: {error}") from error


@contextlib.contextmanager
def cluster(workers: int | None, scheduler: str | None) -> Iterator[Cluster]:
    """A cluster: `workers` processes of a thread each on this machine, or those of `scheduler`.

    Raises:
        InputError: there is no scheduler at that address.
    """
    import dask
    from distributed import Client, LocalCluster

    settings = {"distributed.scheduler.allowed-failures": DEATHS,
                "distributed.comm.timeouts.connect": PATIENCE,
                "distributed.scheduler.worker-saturation": 1.0}
    for name in ("distributed", "tornado", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with dask.config.set(settings), contextlib.ExitStack() as stack:
        if scheduler is None:
            address = stack.enter_context(LocalCluster(
                n_workers=workers or cores(), threads_per_worker=1, processes=True, dashboard_address=None,
                silence_logs=logging.CRITICAL))
        else:
            address = scheduler
        try:
            client = stack.enter_context(Client(address, timeout=PATIENCE, set_as_default=False))
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError([Problem(
                "command line", "--scheduler", scheduler, f"no scheduler answers: {error}",
                "the address of a running one, such as tcp://127.0.0.1:8786")]) from error
        yield Cluster(client)
