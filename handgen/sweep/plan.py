"""What a sweep would do: how many variants, how many of them are known, how long, how much disk."""

from __future__ import annotations

import os
import statistics
import time
from pathlib import Path
from typing import Any

from handgen import checks
from handgen.checks import definition
from handgen.parameters.load import loaded
from handgen.sweep import draw
from handgen.sweep.cluster import cores
from handgen.sweep.evaluate import evaluate
from handgen.sweep.load import Prepared, prepare
from handgen.sweep.store import Store, default
from handgen.sweep.variant import task
from handgen.sweep.work import retried

PROBES = 3
"""Variants that are really evaluated to know how long one takes."""
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
    known, spent = 0, []
    if sweep.method != "optimise":
        unknown = []
        for values in draw.points(sweep):
            one = task(prepared, values)
            row = home.read(one.key)
            if row is not None and not retried(row, sweep.time_limit):
                known += 1
                spent += [row["wall_s"]] if row["status"] in ("done", "incomplete") and row["wall_s"] else []
            elif len(unknown) < PROBES:
                unknown.append(one)
    else:
        unknown = [task(prepared, {name: draw.value(axis, 0.5) for name, axis in sweep.vary.items()})]
    missing = draw.count(sweep) - known
    if probe and missing and not spent:
        spent = _probed(unknown, home)
    each = statistics.median(spent) if spent else None
    return {
        "schema": "handgen.sweep-plan/1", "name": sweep.name, "method": sweep.method, "solver": sweep.solver,
        "variants": draw.count(sweep), "known": known, "missing": missing, "workers": processes,
        "seconds_each": each, "seconds": None if each is None else each * missing / processes,
        "store_MB": missing * ROW_BYTES / 1e6, "memory_MB": WORKER_MB * (processes + 1),
        "axes": {name: {"sets": len(prepared.targets[name]),
                        "values": len(draw.levels(axis)) if sweep.method == "grid" else None}
                 for name, axis in sweep.vary.items()},
        "confirms": sweep.confirm.best if sweep.confirm else 0, "keeps": prepared.kept,
        "base_breaks": base_breaks(prepared), "store": str(home.folder),
    }


def base_breaks(prepared: Prepared) -> list[str]:
    """Rules on the definition that the base file breaks."""
    hand = loaded(prepared.base, prepared.base_file).hand
    report = definition.judge(hand, checks.own_limits(hand, str(prepared.base_file)))
    return sorted({f["rule"] for f in report["findings"] if f["severity"] == "error"})


def _probed(tasks: list, home: Store) -> list[float]:
    """Seconds that variants take, engines warm; their rows are kept."""
    spent = []
    for i, one in enumerate(tasks):
        begun = time.perf_counter()
        row = evaluate(one)
        seconds = time.perf_counter() - begun
        home.write(one.key, row)
        if i or len(tasks) == 1:
            spent.append(seconds)
    return spent or [seconds]


def output(prepared: Prepared, out: str | os.PathLike | None) -> Path:
    """The sweep's folder."""
    return Path(out) if out is not None else Path("outputs") / prepared.sweep.name


