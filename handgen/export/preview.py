"""PNG previews, rendered off screen with PyVista: neutral light, ambient occlusion, plain labels.

A picture is a sheet of cells; a cell is a label and coloured meshes. Cells are laid out in the
plane of the picture, all to the same scale, so that parts can be compared by eye.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handgen.errors import EngineError

Colour = tuple[float, float, float]
"""sRGB, 0..1."""
Solid = tuple[np.ndarray, np.ndarray, Colour]
"""Vertices (n, 3) in mm, faces (m, 3), colour."""

WIDTH = 1000
"""Of every picture, pixels."""
TALLEST = 1300
"""Height that the parts of a picture may take, pixels; captions come on top."""
MARGIN, GAP, LINE = 32, 28, 36
"""Around the sheet, between cells, and the height of a label, pixels."""
INK: Colour = (0.15, 0.15, 0.18)
"""Of what is written."""
SHARP = 22.0
"""Edges that turn by more than this, deg, stay edges in the shading."""
PACKAGES = "libegl1 libgl1-mesa-dri"
"""Debian packages that draw without a display or a graphics card."""


@dataclass(frozen=True)
class Cell:
    label: str
    solids: tuple[Solid, ...]


@dataclass(frozen=True)
class Camera:
    """Parallel projection: the direction that the viewer looks in, and what points up."""

    look: tuple[float, float, float]
    up: tuple[float, float, float]

    def axes(self) -> np.ndarray:
        """Rows: right, up and towards the viewer, as unit vectors."""
        towards = -np.array(self.look, float)
        towards /= np.linalg.norm(towards)
        right = np.cross(self.up, towards)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(towards, right), towards])


def draw(path: Path, cells: Sequence[Cell], camera: Camera, columns: int) -> None:
    """Render `cells` in rows of at most `columns` to the PNG at `path`.

    Raises:
        EngineError: this machine cannot draw off screen.
    """
    axes = camera.axes()
    scale, height, places = layout([_extent(cell, axes) for cell in cells], columns)
    plotter = canvas(height)
    for cell, (centre, below) in zip(cells, places, strict=True):
        low, high = _extent(cell, axes)
        shift = ((centre - np.array([WIDTH, height]) / 2) / scale - (low + high) / 2) @ axes[:2]
        for vertices, faces, colour in cell.solids:
            add(plotter, np.asarray(vertices, float) + shift, faces, colour)
        if cell.label:
            caption(plotter, cell.label, below)
    light(plotter, axes, height / scale)
    save(plotter, path)


def canvas(height: int):
    """A white sheet off screen, WIDTH wide.

    Raises:
        EngineError: this machine cannot draw off screen.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    # VTK reports every display that it does not find; what matters is checked here.
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    plotter = pyvista.Plotter(off_screen=True, window_size=(WIDTH, height), lighting="none")
    _check_window(plotter)
    return plotter


def add(plotter, vertices: np.ndarray, faces: np.ndarray, colour: Colour) -> None:
    """Triangles `faces` (m, 3) of `vertices` (n, 3), mm; curves look smooth, edges sharp."""
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    plotter.add_mesh(mesh.compute_normals(split_vertices=True, feature_angle=SHARP,
                                          auto_orient_normals=False, consistent_normals=False),
                     color=colour, smooth_shading=False, specular=0.15, specular_power=12,
                     interpolation="gouraud")


def save(plotter, path: Path) -> None:
    """The picture as PNG at `path`; the plotter is done with."""
    path.parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(str(path))
    plotter.close()


def _extent(cell: Cell, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner of a cell in the plane of the picture, mm."""
    points = np.vstack([vertices for vertices, _, _ in cell.solids]) @ axes[:2].T
    return points.min(axis=0), points.max(axis=0)


def layout(extents, columns: int):
    """(pixels per mm, height of the picture, per cell its centre and its caption's place).

    `extents`: lower left and upper right corner of every cell in the plane of the picture, mm.
    """
    sizes = [high - low for low, high in extents]
    rows = [range(i, min(i + columns, len(sizes))) for i in range(0, len(sizes), columns)]
    scale = min((WIDTH - 2 * MARGIN - GAP * (len(row) - 1)) / sum(sizes[i][0] for i in row) for row in rows)
    scale = min(scale, (TALLEST - 2 * MARGIN) / sum(max(sizes[i][1] for i in row) for row in rows))
    tall = [max(sizes[i][1] for i in row) * scale for row in rows]
    height = round(2 * MARGIN + sum(tall) + LINE * len(rows) + GAP * (len(rows) - 1))
    places, top = [], height - MARGIN
    for row, high in zip(rows, tall, strict=True):
        spare = WIDTH - 2 * MARGIN - sum(sizes[i][0] * scale for i in row)
        left, space = MARGIN + spare / (2 * len(row)), spare / len(row)
        for i in row:
            wide = sizes[i][0] * scale
            centre = np.array([left + wide / 2, top - high / 2])
            places.append((centre, (left + wide / 2, top - high - 0.75 * LINE)))
            left += wide + space
        top -= high + LINE + GAP
    return scale, height, places


def light(plotter, axes: np.ndarray, tall: float) -> None:
    """Camera, white ground, key, fill and rim light that stand still against the picture."""
    import pyvista

    right, up, towards = axes
    plotter.set_background("white")
    plotter.camera_position = [tuple(1000.0 * towards), (0.0, 0.0, 0.0), tuple(up)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = tall / 2
    plotter.camera.clipping_range = (1.0, 2000.0)
    for place, strength in ((-1.0 * right + 1.4 * up + 1.6 * towards, 0.75),
                            (1.5 * right + 0.2 * up + 1.2 * towards, 0.35),
                            (-0.4 * up + 0.9 * towards, 0.2)):
        plotter.add_light(pyvista.Light(position=tuple(1000.0 * place), focal_point=(0, 0, 0),
                                        intensity=strength, positional=False))
    plotter.enable_anti_aliasing("msaa", multi_samples=4)


def caption(plotter, text: str, at: tuple[float, float], size: int = 22, colour: Colour = INK,
            centred: bool = True, plate: float = 0.0) -> None:
    """A label centred at `at`, pixels from the lower left, or starting there.

    `plate` is the opacity, 0 to 1, of a white plate behind it.
    """
    from vtkmodules.vtkRenderingCore import vtkTextActor

    actor = vtkTextActor()
    actor.SetInput(text)
    actor.SetPosition(*at)
    style = actor.GetTextProperty()
    style.SetFontSize(size)
    style.SetFontFamilyToArial()
    style.SetColor(*colour)
    style.SetBackgroundColor(1.0, 1.0, 1.0)
    style.SetBackgroundOpacity(plate)
    if centred:
        style.SetJustificationToCentered()
    style.SetVerticalJustificationToCentered()
    plotter.add_actor(actor)


def _check_window(plotter) -> None:
    """VTK falls back to a library that it does not bring, and would crash without it."""
    import ctypes

    if type(plotter.render_window).__name__ == "vtkOSOpenGLRenderWindow":
        try:
            ctypes.CDLL("libOSMesa.so.8")
        except OSError:
            raise EngineError("no OpenGL to draw with") from None
