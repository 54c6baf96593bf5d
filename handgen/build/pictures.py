"""What a finished build shows: the assembled hand for viewers, and pictures of its parts."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handgen.build.plan import Planned, salt
from handgen.build.pool import Job, Workers
from handgen.errors import EngineError
from handgen.export import preview
from handgen.geometry import csg
from handgen.geometry.measure import read_stl
from handgen.geometry.part import Part
from handgen.parameters.model import Hand

HAND = "exoskeleton/hand"
DORSUM = preview.Camera((0.0, 0.0, -1.0), (1.0, 0.0, 0.0))
PALM = preview.Camera((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
SIDE = preview.Camera((-0.35, -1.0, -0.2), (0.0, 0.0, 1.0))
LYING = preview.Camera((0.25, 1.0, -0.55), (0.0, 0.0, 1.0))
CUT = preview.Camera((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class View:
    """One file that shows parts: `key` names its content, `make(stage, view)` writes it."""

    file: str
    parts: tuple[Part, ...]
    key: str
    camera: preview.Camera
    columns: int
    make: Callable[[Path, View], Drawn]

    @property
    def shows(self) -> tuple[str, ...]:
        return tuple(part.name for part in self.parts)


@dataclass(frozen=True)
class Drawn:
    """The file's sha256, or why there is none."""

    sha256: str | None
    warning: str | None = None


def views(hand: Hand, present: Iterable[Planned]) -> list[View]:
    """The views that the parts of this build allow."""
    planned = {p.part.name: p for p in present}

    def view(file, names, camera, columns, make=sheet):
        key = csg.digest((salt(), file, *(planned[name].key for name in names)))
        return View(file, tuple(planned[name].part for name in names), key, camera, columns, make)

    def named(prefix, apart=()):
        return [name for name in planned if name.startswith(prefix) and name not in apart]

    wanted = [(f"previews/hand_{side}.png", named(HAND), camera, 1, sheet)
              for side, camera in (("palm", PALM), ("dorsum", DORSUM), ("side", SIDE))]
    wanted += [("previews/fingers.png", named("exoskeleton/", (HAND,)), LYING, 1, sheet),
               ("previews/actuators.png", named("actuators/"), CUT, 1, cut_open)]
    sets = dict.fromkeys(name.split("/")[1] for name in named("tooling/"))
    wanted += [(f"previews/tooling_{s}.png", named(f"tooling/{s}/"), LYING, 2, sheet) for s in sets]
    return [view(*w) for w in wanted if w[1]]


def draw(pool: Workers, work: list[Job]) -> Iterator[tuple[str, Drawn]]:
    """(file, outcome) of every job; a machine that cannot draw costs the pictures only."""
    left = {file for file, _, _ in work}
    try:
        for file, drawn in pool.run([[job] for job in work]):
            left.discard(file)
            yield file, drawn
    except EngineError as error:
        for file in sorted(left):
            yield file, Drawn(None, f"previews left out: {error}; on Debian: apt install {preview.PACKAGES}")


def sheet(stage: Path, view: View) -> Drawn:
    """The parts as they are printed, one cell each."""
    cells = [preview.Cell(_label(part), (_solid(stage, part),)) for part in view.parts]
    return _draw(stage, view, cells)


def cut_open(stage: Path, view: View) -> Drawn:
    """The parts' bodies, each cut open along the plane y = 0."""
    from handgen.geometry.mesh_kernel import evaluate

    cells = []
    for part in view.parts:
        solids = []
        for body in part.bodies:
            half = evaluate(body.shape).trim_by_plane((0.0, 1.0, 0.0), 0.0).to_mesh()
            solids.append((half.vert_properties[:, :3], half.tri_verts.astype(int), body.colour))
        cells.append(preview.Cell(_label(part), tuple(solids)))
    return _draw(stage, view, cells)


def _draw(stage: Path, view: View, cells: list[preview.Cell]) -> Drawn:
    path = stage / view.file
    try:
        preview.draw(path, cells, view.camera, view.columns)
    except EngineError as error:
        return Drawn(None, f"previews left out: {error}")
    return Drawn(hashlib.sha256(path.read_bytes()).hexdigest())


def _label(part: Part) -> str:
    return part.name.rsplit("/", 1)[-1].replace("_", " ")


def _solid(stage: Path, part: Part) -> preview.Solid:
    """The STL's triangles, welded; a half that opens downwards is turned to show its inside."""
    corners = read_stl((stage / f"{part.name}.stl").read_bytes())
    vertices, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    if part.up[2] < 0:
        vertices = vertices * (1.0, -1.0, -1.0)
    return vertices, faces.reshape(-1, 3), part.colour
