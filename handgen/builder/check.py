"""The check: mesh every part, run every rule, show where it hurts. Nothing printable is written."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from handgen import checks
from handgen.builder import jobs, spotted
from handgen.builder.plan import Planned, groups
from handgen.builder.pool import Workers, default_count
from handgen.builder.store import CHECK_FOLDER, CHECKS, Store
from handgen.builder.verdict import Verdict, publish
from handgen.geometry.catalogue import catalogue
from handgen.parameters.load import load


def check(
    params: str | os.PathLike,
    out: str | os.PathLike | None = None,
    progress: Callable[[str], None] | None = None,
    workers: int | None = None,
) -> dict[str, Any]:
    """Judge the hand of the parameter file `params`; report and pictures go to `out`/checks.

    `out` is the folder of the build (`outputs/<name>`), which stays as it is.

    Returns {"name", "out", "checks", "passed"}: `checks` the contract's handgen.checks/1.

    Raises:
        InputError: bad parameters, or a folder that is not handgen's.
        GeometryError: a part cannot be made.
        EngineError: a kernel, a worker or another package's rule gave up.
    """
    loaded = load(params)
    checks.own_limits(loaded.hand, str(loaded.file))
    base = Path(out) if out is not None else Path("outputs") / loaded.hand.name
    Store(base)
    folder = base / CHECK_FOLDER
    Store(folder, CHECKS)
    say = progress or (lambda line: None)
    planned = [Planned(part, "", {}) for part in catalogue(loaded.hand).values()]
    with tempfile.TemporaryDirectory(prefix="handgen-") as place, tempfile.TemporaryFile() as lock:
        stage = Path(place)
        verdict = Verdict(loaded, [p.part.name for p in planned], stage)
        with Workers(workers or default_count(), lock.fileno(), ("manifold3d",)) as pool:
            pool.warm(len(planned))
            for group in groups(planned):
                pool.add([(p.part.name, jobs.mesh, (p.part, stage, p.extra)) for p in group])
            for _, result in pool.results():
                if isinstance(result, Exception):
                    raise result
            say(f"{len(planned)} parts meshed")
            verdict.start(pool)
            for name, result in pool.results():
                verdict.take(name, result)
                say(f"{name}: done")
            report = verdict.report
            drawn, warning = spotted.draw(report, planned, stage, pool)
    if warning:
        say(f"warning: {warning}")
    publish(report, drawn, folder)
    return {"name": loaded.hand.name, "out": str(folder), "checks": report, "passed": report["passed"]}
