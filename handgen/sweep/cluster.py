"""Variants shared out to Dask workers, a local cluster's or a scheduler's that somebody started."""

from __future__ import annotations

import contextlib
import itertools
import logging
import math
import os
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from handgen.errors import EngineError, InputError, Problem
from handgen.sweep.variant import Task, version
from handgen.sweep.work import packed, work

AHEAD = 2
"""Batches in hand for every thread: enough that none waits, few enough that memory stays flat."""
BATCH_S, BATCH = 0.5, 32
"""Variants go out together for about so many seconds of work, so many at most: a message costs 10 ms."""
LOG = 10
"""Messages that Dask remembers for its developers; its usual thousand would hold as many variants."""
DEATHS = 8
"""Of workers on one variant before Dask gives it up; the attempts' log does so before."""
PATIENCE = 10.0
"""Seconds that a scheduler may take to answer."""
DEAF = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
"""What a local worker does first: Ctrl-C is its parent's, which ends it."""
DIED = {"status": "killed", "reason": "its worker died again and again", "wall_s": None}
Job = tuple[str, Task]


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Cluster:
    """Workers; `rows` has them work."""

    def __init__(self, client: Any):
        self.client = client

    @property
    def workers(self) -> int:
        """How many there are now."""
        return len(self.client.ncores())

    @property
    def threads(self) -> int:
        """How many variants can be worked on at once, when there is anybody: one a process."""
        return max(1, self.workers)

    def rows(self, jobs: Iterable[Job], left: Callable[[], int], folder: str, run: str, limit: float
             ) -> Iterator[tuple[str, dict[str, Any]]]:
        """(key, row) of every job as it is finished, in no order; `left` says how many are still to come.

        Raises:
            EngineError: the scheduler is lost, or its workers run another handgen.
        """
        from distributed import as_completed

        waiting, asked, size, numbers = iter(jobs), {}, 1, itertools.count()
        done = as_completed(loop=self.client.loop, with_results=False)
        made_by = version()

        def submit(batch: list[Job]) -> None:
            future = self.client.submit(work, packed(batch), folder, run, limit, made_by,
                                        key=f"variants-{run}-{next(numbers)}", pure=False)
            asked[future] = batch
            done.add(future)

        def more() -> None:
            most = AHEAD * self.threads
            while len(asked) < most and (
                    batch := list(itertools.islice(waiting, max(1, min(size, math.ceil(left() / most)))))):
                submit(batch)

        more()
        while asked:
            future = next(done)
            batch = asked.pop(future)
            found = _rows(future)
            if found is None and len(batch) > 1:
                # One of them kills its workers; the others shall not answer for it.
                for job in batch:
                    submit([job])
            else:
                size = _size(found or []) or size
                yield from zip((key for key, _ in batch), found or [DIED], strict=True)
            future.release()
            more()


def _size(rows: list[dict[str, Any]]) -> int:
    """How many variants like `rows` make a batch; 0: they do not say."""
    spent = [row["wall_s"] for row in rows if row.get("wall_s")]
    return max(1, min(BATCH, int(BATCH_S * len(spent) / sum(spent)))) if spent else 0


def _rows(future: Any) -> list[dict[str, Any]] | None:
    """What a future came to; None if its workers died."""
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        return None
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
                "distributed.scheduler.worker-saturation": 1.0,
                "distributed.admin.low-level-log-length": LOG}
    for name in ("distributed", "tornado", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with dask.config.set(settings), contextlib.ExitStack() as stack:
        if scheduler is None:
            address = stack.enter_context(LocalCluster(
                n_workers=workers or cores(), threads_per_worker=1, processes=True, preload=[DEAF],
                silence_logs=logging.CRITICAL, dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": False}))
        else:
            address = scheduler
        try:
            client = stack.enter_context(Client(address, timeout=PATIENCE, set_as_default=False))
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError([Problem(
                "command line", "--scheduler", scheduler, f"no scheduler answers: {error}",
                "the address of a running one, such as tcp://127.0.0.1:8786")]) from error
        yield Cluster(client)
