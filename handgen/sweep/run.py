"""A sweep, run: what is missing is computed, every row is kept at once, the table is written at the end."""

from __future__ import annotations

import itertools
import os
import re
import time
import uuid
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from handgen.sweep import draw, table
from handgen.sweep.best import feasible, missed, ranked, save_kept
from handgen.sweep.cluster import Cluster, Job, cluster
from handgen.sweep.load import Prepared, prepare
from handgen.sweep.plan import base_breaks, output
from handgen.sweep.results import FINISHED
from handgen.sweep.store import Store, default
from handgen.sweep.variant import Task, confirming, task
from handgen.sweep.work import retried

RESULTS, CONFIRMED = "results.parquet", "confirmed.parquet"
TOLD = 5
"""Best variants that a run tells of, whatever it keeps."""
REASONS, NUMBERS = 100, re.compile(r"-?\d+(\.\d+)?(e[-+]?\d+)?")
"""Different ones that a run counts, and what they may differ in and still be one."""
EVERY = 2.0
"""Seconds between two lines of progress."""
Progress = Callable[[str], None]


def run(file: str | os.PathLike, *, out: str | os.PathLike | None = None, workers: int | None = None,
        scheduler: str | None = None, store: str | os.PathLike | None = None,
        progress: Progress | None = None) -> dict[str, Any]:
    """Run the sweep `file`; what an earlier run or another sweep computed is not computed again.

    Writes `results.parquet` (and `confirmed.parquet`, `best/`) to `out`, outputs/<name>.

    Raises:
        InputError: everything wrong with the file, its base and its model; or no scheduler answers.
        EngineError: the scheduler was lost, or its workers run another handgen.
    """
    prepared, say, begun = prepare(file), progress or (lambda line: None), time.perf_counter()
    folder, runner = output(prepared, out), Runner(prepared, Store(store or default()), progress)
    if broken := base_breaks(prepared):
        say(f"note: the base file breaks {', '.join(broken)}")
    folder.mkdir(parents=True, exist_ok=True)
    with runner.using(workers, scheduler):
        if prepared.sweep.method == "optimise":
            from handgen.sweep.optimise import optimise

            variants = optimise(prepared, runner, folder)
        else:
            variants = None
            runner.compute(task(prepared, values) for values in draw.points(prepared.sweep))
        rows, tally = Rows(prepared, runner.store, variants), Tally(prepared)
        table.write(folder / RESULTS, prepared, rows.kinds, tally.seen(rows))
        best = tally.best
        confirmed = _confirm(prepared, runner, best, folder) if prepared.sweep.confirm else []
        # What was screened and not confirmed is not kept.
        held = ranked(prepared.sweep, confirmed)
        chosen = held if prepared.sweep.confirm else best
        kept = save_kept(prepared, chosen[:prepared.kept], folder, say)
    counts = tally.statuses
    return {
        "schema": "handgen.sweep-run/1", "name": prepared.sweep.name, "out": str(folder),
        "results": str(folder / RESULTS), "variants": sum(counts.values()), "computed": runner.computed,
        "reused": sum(counts.values()) - runner.computed_screening, "statuses": dict(counts),
        "feasible": tally.feasible, "reasons": tally.told_reasons(), "rules_broken": dict(tally.broken),
        "bounds_missed": dict(tally.missed),
        "axes": list(prepared.sweep.vary), "objectives": prepared.sweep.objectives,
        "constraints": list(prepared.sweep.constraints), "best": best[:max(TOLD, prepared.kept)],
        "confirmed": confirmed, "held": len(held) if prepared.sweep.confirm else None, "kept": kept,
        "wall_s": round(time.perf_counter() - begun, 3),
    }


class Runner:
    """Computes tasks that the store does not have, on one cluster that starts when it is first needed."""

    def __init__(self, prepared: Prepared, store: Store, progress: Progress | None):
        self.prepared, self.store, self.say = prepared, store, progress or (lambda line: None)
        self.limit = prepared.sweep.time_limit
        self.run = uuid.uuid4().hex
        self.computed = self.computed_screening = 0
        self._asked: tuple[int | None, str | None] = (None, None)
        self._cluster: Cluster | None = None
        self._open: Any = None

    def using(self, workers: int | None, scheduler: str | None) -> Runner:
        self._asked = workers, scheduler
        return self

    def __enter__(self) -> Runner:
        return self

    def __exit__(self, *error) -> None:
        if self._open is not None:
            self._open.__exit__(*error)

    @property
    def cluster(self) -> Cluster:
        if self._cluster is None:
            self._open = cluster(*self._asked)
            self._cluster = self._open.__enter__()
            if not self._cluster.workers:
                self.say(f"no worker there yet; start some: dask worker {self._asked[1]} --nthreads 1")
        return self._cluster

    def known(self, key: str) -> dict[str, Any] | None:
        """The row that the store has already, unless it ran out of a shorter time."""
        row = self.store.read(key)
        return None if row is None or retried(row, self.limit) else row

    def compute(self, tasks: Iterator[Task], said: str = "", total: int | None = None) -> None:
        """See that the store has the row of every task, `total` at most (all of the sweep's)."""
        missing = Missing(self, tasks, draw.count(self.prepared.sweep) if total is None else total)
        first = next(missing, None)
        if first is None:
            return
        clock = _Clock(lambda line: self.say(said + line), lambda: self.cluster.workers)
        for key, row in self.cluster.rows(_after(first, missing), missing.left, str(self.store.folder),
                                          self.run, self.limit):
            self.keep(key, row)
            missing.asked.discard(key)
            clock.tick(missing.total)
        self.computed_screening = self.computed
        clock.last(missing.total)

    def keep(self, key: str, row: dict[str, Any]) -> None:
        """A worker that shares this disk has kept its row already."""
        self.computed += 1
        if self.store.read(key) is None:
            self.store.write(key, row)


class Missing:
    """Jobs that the store has no row for, each once; counts as it goes."""

    def __init__(self, runner: Runner, tasks: Iterator[Task], total: int):
        self.runner, self.tasks, self.total, self.taken = runner, tasks, total, 0
        self.asked: set[str] = set()
        """What is on its way to the store."""

    def left(self) -> int:
        """How many may still come."""
        return self.total - self.taken

    def __iter__(self) -> Missing:
        return self

    def __next__(self) -> Job:
        for one in self.tasks:
            key = one.key
            if key in self.asked or self.runner.known(key) is not None:
                self.total -= 1
                continue
            self.asked.add(key)
            self.taken += 1
            return key, one
        raise StopIteration


def _after(first: Job, rest: Iterator[Job]) -> Iterator[Job]:
    yield first
    yield from rest


class _Clock:
    """Progress with the time that is left."""

    def __init__(self, say: Progress, workers: Callable[[], int]):
        self.say, self.workers = say, workers
        self.begun = self.told = time.perf_counter()
        self.first, self.done = self.begun, 0

    def tick(self, total: int) -> None:
        self.done += 1
        now = time.perf_counter()
        if self.done == 1:
            self.first = now  # before it, workers started
        if now - self.told >= EVERY:
            self.told = now
            left = (now - self.first) / (self.done - 1) * (total - self.done) if self.done > 1 else None
            self.say(f"{self.done} of {total} variants, {self.workers()} workers"
                     + ("" if left is None else f", {duration(left)} left"))

    def last(self, total: int) -> None:
        self.say(f"{self.done} variants computed in {duration(time.perf_counter() - self.begun)}")


def duration(seconds: float) -> str:
    """`3 s`, `12 min`, `5.4 h`."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


class Rows:
    """The sweep's rows in its order, read from the store every time they are asked for."""

    def __init__(self, prepared: Prepared, store: Store, variants: list[dict] | None = None, by=None,
                 numbers: list[int] | None = None):
        self.prepared, self.store, self.variants, self.numbers = prepared, store, variants, numbers
        self.by = by or (lambda one: one)
        varied = "bend.pressure" in prepared.sweep.vary
        self.kinds = table.columns(prepared, () if varied else prepared.pressures)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        points = self.variants if self.variants is not None else draw.points(self.prepared.sweep)
        for number, values in zip(self.numbers or itertools.count(), points, strict=False):
            key = self.by(task(self.prepared, values)).key
            row = self.store.read(key) or {"status": "failed", "reason": "the store has lost it"}
            yield {"variant": number, "hash": key, **values, **row}


class Tally:
    """What a run says of its rows, counted as they go by: no more than the best of them stay in memory."""

    def __init__(self, prepared: Prepared):
        self.sweep, self.statuses, self.feasible = prepared.sweep, Counter(), 0
        self.broken, self.missed, self._reasons = Counter(), Counter(), Counter()
        self._examples: dict[tuple[str, str], str] = {}
        self._best: list[dict[str, Any]] = []
        self.most = max(TOLD, prepared.kept, prepared.sweep.confirm.best if prepared.sweep.confirm else 0)

    def seen(self, rows: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        """`rows`, counted."""
        for row in rows:
            self.statuses[row["status"]] += 1
            if feasible(self.sweep, row):
                self.feasible += 1
                self._best.append(row)
                if len(self._best) > 2 * self.most:
                    self._best = self.best
            else:
                self._blame(row)
            yield row

    def _blame(self, row: dict[str, Any]) -> None:
        """Count why `row` is none of the feasible ones."""
        if row["status"] != "done":
            why = row["status"], NUMBERS.sub("#", row["reason"])
            if why in self._reasons or len(self._reasons) < REASONS:
                self._reasons[why] += 1
                self._examples.setdefault(why, row["reason"])
        self.broken.update(filter(None, row.get("rules_broken", "").split(", ")))
        self.missed.update(missed(self.sweep, row))

    def told_reasons(self) -> list[dict[str, Any]]:
        """The reasons that most rows have, alike but for their numbers; one of each as it stands."""
        return [{"status": why[0], "reason": self._examples[why], "rows": rows}
                for why, rows in self._reasons.most_common(TOLD)]

    @property
    def best(self) -> list[dict[str, Any]]:
        """The best so far, the best first."""
        return ranked(self.sweep, self._best)[:self.most]


def _confirm(prepared: Prepared, runner: Runner, best: list[dict], folder: Path) -> list[dict[str, Any]]:
    """The best variants once more, by the solver that confirms."""
    by = prepared.sweep.confirm
    wanted = [{axis: row[axis] for axis in prepared.sweep.vary} for row in best[:by.best]]
    if not wanted:
        return []
    runner.say(f"confirming {len(wanted)} by {by.solver}")
    screening = runner.computed_screening
    runner.compute(iter([confirming(task(prepared, values), by) for values in wanted]), total=len(wanted))
    runner.computed_screening = screening
    rows = Rows(prepared, runner.store, wanted, lambda one: confirming(one, by),
                [row["variant"] for row in best[:by.best]])
    table.write(folder / CONFIRMED, prepared, rows.kinds, rows)
    for row in rows:
        if row["status"] not in FINISHED:
            runner.say(f"note: variant {row['variant']} was not confirmed: {row['status']}, {row['reason']}")
    return [row for row in rows if row["status"] in FINISHED]
