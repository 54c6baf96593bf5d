"""A picture of every finding: the part as it was judged, with the place marked."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from handgen.builder import jobs
from handgen.builder.pictures import LEFT_OUT, View
from handgen.builder.plan import Planned, salt
from handgen.builder.pool import Workers
from handgen.errors import EngineError
from handgen.export import spots
from handgen.geometry import csg
from handgen.geometry.part import Part

FOLDER = "previews"
"""Of a check's pictures, beside its report."""
SHOWN = ("error", "warning")
"""Severities that get a picture, the worst first."""
MOST = 40
"""Pictures of one report: a design that is wrong in more places is wrong all over."""

Found = Mapping[str, Any]
"""A finding as the report lists it."""


def views(report: Mapping[str, Any], planned: Iterable[Planned], folder: str = FOLDER) -> list[View]:
    """Views of the findings above `info` in parts of this build, errors first, at most MOST.

    A file's name begins with the finding's number in the report, from 1.
    """
    parts = {p.part.name: p for p in planned}
    numbered = [(number, found) for severity in SHOWN for number, found in enumerate(report["findings"], 1)
                if found["severity"] == severity and found["part"] in parts]
    return [_view(number, found, _alike(found, report), parts[found["part"]], folder)
            for number, found in numbered[:MOST]]


def draw(report: Mapping[str, Any], planned: Iterable[Planned], stage: Path, pool: Workers
         ) -> tuple[dict[str, bytes], str | None]:
    """(file -> picture, a warning where this machine cannot draw); the parts' STLs lie in `stage`.

    Raises:
        EngineError: a worker died.
    """
    for view in views(report, planned):
        pool.add([(view.file, view.make, (stage, view.file))])
    drawn, warning = {}, None
    for file, result in pool.results():
        if isinstance(result, EngineError):
            warning = f"{LEFT_OUT} ({result})"
        elif isinstance(result, Exception):
            raise result
        else:
            drawn[file] = (stage / file).read_bytes()
    return drawn, warning


def _alike(found: Found, report: Mapping[str, Any]) -> list[Found]:
    """`found`, then what the same rule found elsewhere in the same part."""
    return [found, *(f for f in report["findings"] if f is not found and f["severity"] in SHOWN
                     and (f["rule"], f["part"]) == (found["rule"], found["part"]))]


def _view(number: int, found: Found, alike: list[Found], made: Planned, folder: str) -> View:
    file = f"{folder}/{number:02d}_{found['rule']}_{made.part.name.replace('/', '_')}.png"
    places = tuple(tuple(f["where"]) for f in alike if f["where"])
    if found["where"] is None:
        places = ()
    caption = spots.Caption(found["severity"], f"{found['severity']}  {found['rule']}  {made.part.name}",
                            (found["message"], f"mend: {found['fix']}"))
    label = "" if found["measured"] is None else spots.figure(found["measured"], found["unit"])
    key = csg.digest((salt(), file, made.key, str(places), str(caption), label))
    return View(file, (made.part.name,), key, partial(_drawn, made.part, places, label, caption))


def _drawn(part: Part, places: tuple, label: str, caption: spots.Caption, stage: Path, file: str) -> str:
    vertices, faces = jobs.welded(stage / f"{part.name}.stl")
    spots.draw(stage / file, (vertices, faces, part.colour), places, label, caption)
    return hashlib.sha256((stage / file).read_bytes()).hexdigest()
