"""Pictures of an actuator's own parts: the eight of its tooling, and its mould cut open for each pour."""

from __future__ import annotations

import base64
import tempfile
from pathlib import Path

from handgen.export import preview
from handgen.geometry import cores, csg, mould
from handgen.geometry.actuator import SILICONE, thread_path
from handgen.geometry.casting import Setup
from handgen.geometry.part import Part
from handgen.geometry.tooling import COLOURS
from handgen.parameters.model import Hand
from handgen.worksheet.silicone import between

LYING = preview.Camera((0.25, 1.0, -0.55), (0.0, 0.0, 1.0))
FRONT = preview.Camera((0.0, 0.25, -1.0), (-1.0, 0.0, 0.0))
"""On the open half, the tip down, as the mould is poured."""
SECOND = (0.75, 0.80, 0.90)
"""Colour of the second pour, where the first lies beside it."""
THREAD = (0.75, 0.20, 0.15)


def tools(parts: list[Part], numbers: dict[str, str]) -> str:
    """The tooling of one actuator, as it is printed, with its `numbers` by role: a data URI.

    Raises:
        EngineError: this machine cannot draw off screen.
    """
    cells = []
    for part in parts:
        vertices, faces = part.triangles
        if part.up[2] < 0:
            vertices = vertices * (1.0, -1.0, -1.0)
        cells.append(preview.Cell(_label(part.role, numbers[part.role]), ((vertices, faces, part.colour),)))
    return _drawn(cells, LYING, 2)


def filled(hand: Hand, name: str) -> str:
    """The mould of one actuator at its two pours, its front half taken off: a data URI.

    Raises:
        EngineError: this machine cannot draw off screen.
    """
    setup = Setup(hand, name)
    large, small = cores.large_core(setup), cores.small_core(setup)
    level = setup.top * setup.casting.cup_fill / 100
    first = csg.Difference(between(setup, level, setup.length), (large,))
    trimmed = csg.Difference(between(setup, 0.0, setup.length), (large,))
    second = csg.Difference(between(setup, level, setup.length), (small, trimmed))
    shells = [(mould.half(setup, pins=True), COLOURS["mould_a"]), (mould.base(setup), COLOURS["mould_base"]),
              (mould.suspender(setup), COLOURS["suspender"])]
    around = [_half(shape, colour) for shape, colour in shells]
    cells = [
        preview.Cell("outer layer", (*around, _half(first, SILICONE), _whole(large, COLOURS["core_large"]),
                                     _thread(hand, name))),
        preview.Cell("inner layer", (*around, _half(trimmed, SILICONE), _half(second, SECOND),
                                     _whole(small, COLOURS["core_small"]))),
    ]
    return _drawn(cells, FRONT, 2)


def _label(role: str, number: str) -> str:
    """What is embossed and what it is; long names of actuators say both."""
    words = role.replace("_", " ")
    return number if number.split()[-1] == words.split()[-1] else f"{number} {words}"


def _half(shape: csg.Shape, colour: preview.Colour) -> preview.Solid:
    """What lies behind the mould's split, z <= 0."""
    from handgen.geometry.mesh_kernel import evaluate

    mesh = evaluate(shape).trim_by_plane((0.0, 0.0, -1.0), 0.0).to_mesh()
    return mesh.vert_properties[:, :3], mesh.tri_verts.astype(int), colour


def _whole(shape: csg.Shape, colour: preview.Colour) -> preview.Solid:
    from handgen.geometry.mesh_kernel import evaluate, triangles

    return (*triangles(evaluate(shape)), colour)


def _thread(hand: Hand, name: str) -> preview.Solid:
    """The thread on its core, drawn three times as thick so that it is seen."""
    import pyvista

    line = pyvista.lines_from_points(thread_path(hand, name)[:, :3])
    tube = line.tube(radius=1.5 * hand.thread_of(name).diameter, n_sides=8).triangulate()
    return tube.points, tube.faces.reshape(-1, 4)[:, 1:], THREAD


def _drawn(cells: list[preview.Cell], camera: preview.Camera, columns: int) -> str:
    with tempfile.TemporaryDirectory(prefix="handgen-") as folder:
        path = Path(folder) / "picture.png"
        preview.draw(path, cells, camera, columns)
        return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()
