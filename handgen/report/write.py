"""`handgen report`: survey, bend, write one self-contained HTML file."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from handgen.builder.survey import survey
from handgen.errors import InputError, Problem
from handgen.parameters.fault import nearest
from handgen.parameters.load import load
from handgen.report import bends
from handgen.report.page import page

FILE = "report.html"
NONE = "none"
SCHEMA = "handgen.report/1"


def report(params: str | os.PathLike, out: str | os.PathLike | None = None, fingers: Iterable[str] | None = None, *,
           progress: Callable[[str], None] | None = None, workers: int | None = None, known: bool = False,
           live: bool = False) -> dict[str, Any]:
    """Write `report.html` for the hand of `params` into `out` (`outputs/<name>`).

    `fingers`: those to bend (all; ["none"]: no bends). Meshes come from the build in `out` where it still holds,
    meshes, reports and bends from the cache where it has them. `known` bends only what was solved before; `live`
    writes a page for `handgen view`.

    Returns {"schema", "name", "page", "bytes", "passed", "findings", "bent", "missing"}.

    Raises:
        InputError: bad parameters, an unknown finger, or a folder that is not handgen's.
        GeometryError: a part cannot be made.
        EngineError: a kernel, a worker or the solver gave up.
    """
    loaded, say = load(params), progress or (lambda line: None)
    wanted = _wanted(fingers, loaded.hand.fingers.present())
    folder = Path(out) if out is not None else Path("outputs") / loaded.hand.name
    with survey(loaded, folder, say, workers) as surveyed:
        bent, missing = bends.bend(surveyed, wanted, known, say)
        content = page(surveyed, bent, missing, folder, live).encode()
        findings = len(surveyed.report["findings"])
        passed = surveyed.report["passed"]
    target = folder / FILE
    write(target, content)
    return {"schema": SCHEMA, "name": loaded.hand.name, "page": str(target), "bytes": len(content),
            "passed": passed, "findings": findings, "bent": {n: b.reached for n, b in bent.items()}, "missing": missing}


def write(target: Path, content: bytes) -> None:
    """Beside, then renamed: a reader sees the old page or the new one."""
    target.parent.mkdir(parents=True, exist_ok=True)
    stage = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        stage.write_bytes(content)
        os.replace(stage, target)
    finally:
        stage.unlink(missing_ok=True)


def _wanted(fingers: Iterable[str] | None, there: list[str]) -> list[str]:
    """The fingers to bend, in the hand's order."""
    if fingers is None:
        return list(there)
    asked = list(fingers)
    if asked == [NONE]:
        return []
    problems = [Problem("command line", "--fingers", name, "there is none of this name",
                        "one of " + ", ".join([*there, NONE]), nearest(name, there))
                for name in asked if name not in there]
    if problems:
        raise InputError(problems)
    return [name for name in there if name in asked]
