"""What a sweep would do: how many variants, how many of them are known, how long, how much disk."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from handgen import checks
from handgen.checks import definition
from handgen.parameters.load import loaded
from handgen.sweep import draw
from handgen.sweep.cluster import cores
from handgen.sweep.evaluate import evaluate
from handgen.sweep.load import Prepared, prepare
from handgen.sweep.results import FINISHED
from handgen.sweep.store import Store, default
from handgen.sweep.variant import Task, task
from handgen.sweep.work import retried

PROBES = 3
"""Variants that are really evaluated to know how long one takes."""
MIDDLE = (0.5, 0.4, 0.6)
"""Where they lie on the axes of a search."""
START_S = 3.0
"""For workers to start, about."""
ROW_BYTES = 4096
"""A stored row: a block of the file system."""
WORKER_MB = 250.0
"""Memory of a worker process with its engines loaded, about."""


def plan(file: str | os.PathLike, *, workers: int | None = None, store: str | os.PathLike | None = None,
         probe: bool = True) -> dict[str, Any]:
    """What `handgen sweep` would do with `file`; a few variants are evaluated for their time, and kept.

    Raises:
        InputError: everything wrong with the file, its base and its model.
    """
    prepared, home = prepare(file), Store(store or default())
    sweep, processes = prepared.sweep, workers or cores()
    known, rows, unknown = 0, [], []
    for one in _first(prepared):
        row = home.read(one.key)
        if row is not None and not retried(row, sweep.time_limit):
            known += sweep.method != "optimise"
            rows.append(row)
        elif len(unknown) < PROBES:
            unknown.append(one)
    missing = draw.count(sweep) - known
    spent, tried = [row["wall_s"] for row in rows if row["status"] in FINISHED and row["wall_s"]], []
    if probe and missing and not spent:
        tried = _probed(unknown, home)
        spent = [seconds for seconds, row in tried if row["status"] in FINISHED]
    each = statistics.median(spent) if spent else None
    return {
        "schema": "handgen.sweep-plan/1", "name": sweep.name, "method": sweep.method, "solver": sweep.solver,
        "variants": draw.count(sweep), "known": known, "missing": missing, "workers": processes,
        "seconds_each": each,
        "seconds": None if each is None else (START_S if missing else 0.0) + each * missing / processes,
        "store_MB": missing * ROW_BYTES / 1e6, "memory_MB": WORKER_MB * (processes + 1),
        "axes": {name: {"sets": len(prepared.targets[name]),
                        "values": len(draw.levels(axis)) if sweep.method == "grid" else None}
                 for name, axis in sweep.vary.items()},
        "confirms": sweep.confirm.best if sweep.confirm else 0, "keeps": prepared.kept,
        "base_breaks": base_breaks(prepared), "store": str(home.folder),
        "tried": [{k: row.get(k, "") for k in ("status", "reason", "rules_broken")} for _, row in tried],
    }


def _first(prepared: Prepared) -> Iterator[Task]:
    """The sweep's variants; of a search, which has none beforehand, some in the middle of its axes."""
    sweep = prepared.sweep
    points = draw.points(sweep) if sweep.method != "optimise" else (
        {name: draw.value(axis, u) for name, axis in sweep.vary.items()} for u in MIDDLE)
    return (task(prepared, values) for values in points)


def base_breaks(prepared: Prepared) -> list[str]:
    """Rules on the definition that the base file breaks."""
    hand = loaded(prepared.base, prepared.base_file).hand
    report = definition.judge(hand, checks.own_limits(hand, str(prepared.base_file)))
    return sorted({f["rule"] for f in report["findings"] if f["severity"] == "error"})


def _probed(tasks: list[Task], home: Store) -> list[tuple[float, dict[str, Any]]]:
    """(seconds that a variant takes, its row), engines warm; rows are kept."""
    found = []
    for one in tasks:
        found.append(_timed(one))
        home.write(one.key, found[-1][1])
    bent = [i for i, (_, row) in enumerate(found) if row["status"] in FINISHED]
    if len(bent) == 1:
        found[bent[0]] = _timed(tasks[bent[0]])
    elif bent:
        # The first one has loaded the engines.
        del found[bent[0]]
    return found


def _timed(one: Task) -> tuple[float, dict[str, Any]]:
    begun = time.perf_counter()
    row = evaluate(one)
    return time.perf_counter() - begun, row


def output(prepared: Prepared, out: str | os.PathLike | None) -> Path:
    """The sweep's folder."""
    return Path(out) if out is not None else Path("outputs") / prepared.sweep.name
