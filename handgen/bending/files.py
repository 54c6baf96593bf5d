"""A bend's folder: JSON, CSV, plot, shapes, picture; written beside and renamed."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from handgen.bending import curl, figure, states
from handgen.bending.request import Request
from handgen.bending.result import SCHEMA, Bend
from handgen.errors import EngineError, InputError, Problem
from handgen.export import preview

FOLDER = "bend"
JSON, CSV, PLOT, SHAPE, PICTURE = "bend.json", "curve.csv", "curve.png", "finger.stl", "curl.png"
PICTURED = 6
"""Most fingers in the picture."""
LEFT_OUT = ("the picture of the curling finger is left out: this machine cannot draw off screen; "
            f"on Debian: apt install {preview.PACKAGES}")


def target(asked: Request, out: str | os.PathLike | None = None) -> Path:
    """The folder that a bend is written to: `<out>/bend/<finger>_<part>`, `out` by default `outputs/<hand>`.

    Raises:
        InputError: it holds something that handgen did not write, or cannot be written.
    """
    home = Path(out) if out is not None else Path("outputs") / asked.hand
    folder = home / FOLDER / f"{asked.finger}_{asked.part}"
    if folder.exists() and not _own(folder):
        raise InputError([Problem("--out", "", str(folder),
                                  f"holds files and no {JSON} of handgen: not touched",
                                  "a new or empty folder, or one that `handgen bend` wrote")])
    there = next(place for place in (folder.parent, *folder.parent.absolute().parents) if place.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        raise InputError([Problem("--out", "", str(there), "is no folder that can be written to")])
    return folder


def write(found: Bend, out: str | os.PathLike | None = None,
          progress: Callable[[str], None] | None = None) -> Path:
    """Write bend.json, curve.csv, curve.png, states/*.vtu with states.pvd, finger.stl and curl.png.

    The folder is exchanged as a whole. What needs a shape is written where the solver gives one; a machine
    that cannot draw costs the picture only, and `progress` is told.

    Raises:
        InputError: see `target`.
    """
    folder = target(found.request, out)
    stage = folder.with_name(f".{folder.name}.writing-{os.getpid()}")
    folder.parent.mkdir(parents=True, exist_ok=True)
    _tidy(folder)
    try:
        stage.mkdir()
        _fill(stage, found, progress or (lambda line: None))
        _exchange(stage, folder)
    finally:
        shutil.rmtree(stage, ignore_errors=True)
    return folder


def _fill(stage: Path, found: Bend, say: Callable[[str], None]) -> None:
    document = found.document
    shown = states.shaped(found.curve)
    (stage / JSON).write_text(json.dumps(document, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    (stage / CSV).write_text(_table(document["points"]), encoding="utf-8")
    if any(point["converged"] for point in document["points"]):
        figure.draw(stage / PLOT, document)
    if not shown:
        return
    bare = found.request.part == "exoskeleton"
    loads = [state.tip_load if bare else 1e3 * state.pressure for state in shown]
    unit = "N" if bare else "kPa"
    states.write_states(found.curve, stage, _file_names(loads, unit))
    states.write_stl(found.curve, stage / SHAPE)
    chosen, case = _spread(len(shown)), found.request.case
    plane = None if case.obstacle is None else -float(case.finger.outer(0.0)) - case.obstacle
    try:
        curl.draw(stage / PICTURE, found.curve, [shown[i] for i in chosen],
                  [f"{loads[i]:.4g} {unit}" for i in chosen], plane)
    except EngineError as error:
        say(f"warning: {LEFT_OUT} ({error})")


def _table(points: Sequence[dict[str, Any]]) -> str:
    """CSV of the points; null is an empty field."""
    text = io.StringIO()
    rows = csv.DictWriter(text, list(points[0]), lineterminator="\n")
    rows.writeheader()
    for point in points:
        rows.writerow(point | {"converged": int(point["converged"]), "flags": "; ".join(point["flags"])})
    return text.getvalue()


def _file_names(loads: Sequence[float], unit: str) -> list[str]:
    """020kPa, 000_07N: so that they sort by load."""
    places = max(len(f"{load:.6g}".partition(".")[2]) for load in loads)
    width = 3 + (places + 1 if places else 0)
    return [f"{load:0{width}.{places}f}{unit}".replace(".", "_") for load in loads]


def _spread(count: int) -> list[int]:
    """At most PICTURED of `count` places, evenly, the first and last among them."""
    most = min(count, PICTURED)
    return sorted({round(i * (count - 1) / max(most - 1, 1)) for i in range(most)})


def _own(folder: Path) -> bool:
    if folder.is_dir() and not any(folder.iterdir()):
        return True
    try:
        return json.loads((folder / JSON).read_bytes())["schema"] == SCHEMA
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _tidy(folder: Path) -> None:
    """Bring back what a run killed between two renames laid aside; clear what killed runs were writing."""
    aside = _aside(folder)
    if aside.exists() and not folder.exists():
        aside.rename(folder)
    shutil.rmtree(aside, ignore_errors=True)
    for stale in folder.parent.glob(f".{folder.name}.writing-*"):
        if not _alive(stale.name.rsplit("-", 1)[-1]):
            shutil.rmtree(stale, ignore_errors=True)


def _alive(process: str) -> bool:
    try:
        os.kill(int(process), 0)
    except ProcessLookupError:
        return False
    except (PermissionError, ValueError):
        return True
    return int(process) != os.getpid()


def _exchange(stage: Path, folder: Path) -> None:
    """Put `stage` in the place of `folder`: a kill on the way leaves the old one aside, for `_tidy`."""
    aside = _aside(folder)
    with contextlib.suppress(FileNotFoundError):
        folder.rename(aside)
    stage.rename(folder)
    shutil.rmtree(aside, ignore_errors=True)


def _aside(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.previous")
