"""`handgen report`: survey, bend, write one self-contained HTML file."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handgen import atomic
from handgen.builder.survey import survey
from handgen.errors import InputError, Problem
from handgen.parameters.fault import nearest
from handgen.parameters.load import load
from handgen.report import bends
from handgen.report.page import page

FILE = "report.html"
NONE = "none"
SCHEMA = "handgen.report/1"
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Report:
    """A page, and what is to be said of it."""

    name: str
    content: bytes
    passed: bool
    findings: int
    bent: dict[str, str]
    """Finger -> how far it was bent."""
    missing: dict[str, str]
    """Finger -> why it was not."""


def report(params: str | os.PathLike, out: str | os.PathLike | None = None,
           fingers: Iterable[str] | None = None, *, progress: Progress | None = None,
           workers: int | None = None) -> dict[str, Any]:
    """Write `report.html` for the hand of `params` into `out` (`outputs/<name>`); see `compose`.

    Returns {"schema", "name", "page", "bytes", "passed", "findings", "bent", "missing"}.
    """
    found = compose(params, out, fingers, progress=progress, workers=workers)
    target = home(found.name, out) / FILE
    atomic.write(target, found.content)
    return {"schema": SCHEMA, "name": found.name, "page": str(target), "bytes": len(found.content),
            "passed": found.passed, "findings": found.findings, "bent": found.bent, "missing": found.missing}


def compose(params: str | os.PathLike, out: str | os.PathLike | None = None,
            fingers: Iterable[str] | None = None, *, progress: Progress | None = None,
            workers: int | None = None, known: bool = False, serial: int | None = None) -> Report:
    """The page of the hand of `params`, to lie in `out`; nothing is written.

    `fingers`: those to bend (all; ["none"]: no bends). Meshes come from the build in `out` where it still
    holds; meshes, reports and bends from the cache where it has them. `known` bends only what was solved
    before; `serial` numbers a page for `handgen view`.

    Raises:
        InputError: bad parameters, an unknown finger, or a folder that is not handgen's.
        GeometryError: a part cannot be made.
        EngineError: a kernel, a worker or the solver gave up.
    """
    loaded, say = load(params), progress or (lambda line: None)
    wanted = _wanted(fingers, loaded.hand.fingers.present())
    folder = home(loaded.hand.name, out)
    with survey(loaded, folder, say, workers) as surveyed:
        bent, missing = bends.bend(surveyed, wanted, known, say)
        content = page(surveyed, bent, missing, folder, serial).encode()
        return Report(loaded.hand.name, content, surveyed.report["passed"], len(surveyed.report["findings"]),
                      {name: found.reached for name, found in bent.items()}, missing)


def home(name: str, out: str | os.PathLike | None) -> Path:
    """The folder of the hand `name`."""
    return Path(out) if out is not None else Path("outputs") / name


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
