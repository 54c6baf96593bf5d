"""What a finished build shows: the assembled hand for viewers, and pictures of its parts."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from handgen.builder import jobs
from handgen.builder.plan import Planned, salt
from handgen.export import glb, preview
from handgen.geometry import csg
from handgen.geometry.assembly import assembly
from handgen.geometry.part import Part
from handgen.parameters.model import Hand

HAND = "exoskeleton/hand"
ASSEMBLY = "assembly/hand.glb"
LEFT_OUT = ("previews are left out: this machine cannot draw off screen; "
            f"on Debian: apt install {preview.PACKAGES}")
DORSUM = preview.Camera((0.0, 0.0, -1.0), (1.0, 0.0, 0.0))
PALM = preview.Camera((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
SIDE = preview.Camera((0.15, -1.0, -0.25), (0.0, 0.0, 1.0))
LYING = preview.Camera((0.25, 1.0, -0.55), (0.0, 0.0, 1.0))
CUT = preview.Camera((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class View:
    """One file that shows parts: `key` names its content, `make(stage, file)` writes it.

    `make` returns the file's sha256, and raises an EngineError where it cannot draw.
    """

    file: str
    shows: tuple[str, ...]
    key: str
    make: Callable[[Path, str], str]


def views(hand: Hand, parameters: str, present: Iterable[Planned]) -> list[View]:
    """The views that the parts of this build allow; `parameters` is the hash of the hand's."""
    planned = {p.part.name: p for p in present}
    shown = [_pictured(planned, *wanted) for wanted in _pictures(list(planned)) if wanted[1]]
    if hand.palm:
        names = tuple(dict.fromkeys(seated.name for seated in assembly(hand)))
        if planned.keys() >= set(names):
            key = csg.digest((salt(), parameters, *(planned[name].key for name in names)))
            shown.append(View(ASSEMBLY, names, key, partial(assembled, hand)))
    return shown


def _pictures(names: list[str]) -> Iterator[tuple]:
    """(file, names of its parts, camera, columns, function that draws it)."""
    for side, camera in (("palm", PALM), ("dorsum", DORSUM), ("side", SIDE)):
        yield f"previews/hand_{side}.png", [n for n in names if n == HAND], camera, 1, sheet
    fingers = [n for n in names if n.startswith("exoskeleton/") and n != HAND]
    yield "previews/fingers.png", fingers, LYING, 1, sheet
    yield "previews/actuators.png", [n for n in names if n.startswith("actuators/")], CUT, 1, cut_open
    for which in dict.fromkeys(n.split("/")[1] for n in names if n.startswith("tooling/")):
        tools = [n for n in names if n.startswith(f"tooling/{which}/")]
        yield f"previews/tooling_{which}.png", tools, LYING, 2, sheet


def _pictured(planned, file, names, camera, columns, make) -> View:
    key = csg.digest((salt(), file, *(planned[name].key for name in names)))
    parts = tuple(planned[name].part for name in names)
    return View(file, tuple(names), key, partial(make, parts, camera, columns))


def assembled(hand: Hand, stage: Path, file: str) -> str:
    """Everything in its place, in the frame of the hand."""
    nodes = []
    for seated in assembly(hand):
        if seated.axis or seated.pressed_by:
            mesh = seated.mesh
            vertices, faces = mesh.vertices, mesh.faces
        else:
            vertices, faces = _welded(stage, seated.part)
            vertices, faces = seated.carry(vertices), faces[:, ::-1] if seated.mirrored else faces
        nodes.append((seated.name, vertices, faces, seated.part.colour))
    content = glb.to_bytes(hand.name, nodes)
    path = stage / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return hashlib.sha256(content).hexdigest()


def sheet(parts: tuple[Part, ...], camera: preview.Camera, columns: int, stage: Path, file: str) -> str:
    """The parts as they are printed, one cell each; a half that opens downwards shows its inside."""
    cells = []
    for part in parts:
        vertices, faces = _welded(stage, part)
        if part.up[2] < 0:
            vertices = vertices * (1.0, -1.0, -1.0)
        label = "" if part.name == HAND else _label(part)
        cells.append(preview.Cell(label, ((vertices, faces, part.colour),)))
    return _draw(stage / file, cells, camera, columns)


def cut_open(parts: tuple[Part, ...], camera: preview.Camera, columns: int, stage: Path, file: str) -> str:
    """The parts' bodies, each cut open along the plane y = 0."""
    from handgen.geometry.mesh_kernel import evaluate

    cells = []
    for part in parts:
        solids = []
        for body in part.bodies:
            half = evaluate(body.shape).trim_by_plane((0.0, 1.0, 0.0), 0.0).to_mesh()
            solids.append((half.vert_properties[:, :3], half.tri_verts.astype(int), body.colour))
        cells.append(preview.Cell(_label(part), tuple(solids)))
    return _draw(stage / file, cells, camera, columns)


def _draw(path: Path, cells: list[preview.Cell], camera: preview.Camera, columns: int) -> str:
    preview.draw(path, cells, camera, columns)
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _label(part: Part) -> str:
    return part.name.rsplit("/", 1)[-1].replace("_", " ")


def _welded(stage: Path, part: Part) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and faces (m, 3) of the part's STL."""
    return _read(stage / f"{part.name}.stl")


# Remembered, because one worker draws the hand from three sides.
_read = functools.lru_cache(maxsize=4)(jobs.welded)
