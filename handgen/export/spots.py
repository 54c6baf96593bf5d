"""Pictures of what the rules found: the part with the place marked, and the part cut open there.

The left half shows the whole part from the side that sees the place best, the right half a slice
across the part through the place, enlarged. Marks are drawn on top, so that nothing hides them.
"""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handgen.export import preview
from handgen.export.preview import INK, WIDTH, Camera, Colour, Solid
from handgen.geometry.surface import Surface, nearest

SPLIT = 560
"""Width of the left half, pixels."""
HIGH = 560
"""Height of both halves, pixels."""
LINE, PAD = 27, 16
"""Height of a line of the caption, and around it, pixels."""
LETTERS = 108
"""In a line of the caption."""
FILLED = 0.84
"""Of its half that the part takes."""
DETAIL = 0.3
"""Of the part's longest side that the slice shows, within DETAIL_RANGE, mm."""
DETAIL_RANGE = (14.0, 40.0)
RINGS = (16.0, 8.0)
"""Radius of the ring around the worst place and around the others, pixels."""
PLATE = 0.75
"""Opacity of the ground behind a label that lies on the part."""
RULERS = (20.0, 10.0, 5.0, 2.0)
"""Lengths, mm, of which the first that fits is drawn as a scale."""
TILT = 0.38
"""By which the six main views are turned towards their neighbours (a tangent)."""
HIDDEN = 0.4
"""What a surface between place and viewer counts against seeing the part broadside."""
MOST_HIDDEN = 4
"""Surfaces in front of a place beyond which it makes no difference."""
CUT: Colour = (0.98, 0.80, 0.55)
"""Where the part is cut."""
COLOURS: dict[str, Colour] = {"error": (0.80, 0.04, 0.08), "warning": (0.78, 0.40, 0.0)}


@dataclass(frozen=True)
class Caption:
    """What is written above a picture: a heading in the colour of `severity`, and paragraphs."""

    severity: str
    heading: str
    paragraphs: tuple[str, ...]


@dataclass(frozen=True)
class View:
    """A camera that shows `focus`, mm, at `centre`, pixels from the lower left, and `scale` pixels a mm."""

    axes: np.ndarray
    focus: np.ndarray
    centre: tuple[float, float]
    scale: float

    def onto(self, points: np.ndarray) -> np.ndarray:
        """Pixels (n, 3) of `points` (n, 3), mm: right, up, and towards the viewer."""
        return (points - self.focus) @ self.axes.T * self.scale + (*self.centre, 0.0)


def draw(path: Path, part: Solid, places: Sequence[tuple[float, float, float]], label: str,
         caption: Caption) -> None:
    """Picture `part` with `places` (mm) marked to the PNG at `path`; `label` stands beside the first.

    Without a place the whole part is shown, cut through its middle, and nothing is marked.

    Raises:
        EngineError: this machine cannot draw off screen.
    """
    vertices, faces, colour = part
    lines = [line for text in caption.paragraphs for line in textwrap.wrap(text, LETTERS)]
    height = HIGH + 2 * PAD + LINE * (len(lines) + 1)
    mark, surface = COLOURS[caption.severity], Surface(vertices, faces)
    worst = np.array(places[0]) if places else (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    whole, slice_ = _views(surface, worst)
    plotter = preview.canvas(height)
    middle = np.array([WIDTH / 2, height / 2, 0.0])
    for points, triangles, tint in ((whole.onto(vertices), faces, colour), *_sliced(part, slice_, worst)):
        preview.add(plotter, points - middle, triangles, tint)
    if places:
        _mark(plotter, whole, places, mark)
        _mark(plotter, slice_, places[:1], mark)
        _label(plotter, whole.onto(worst)[:2], label, mark)
    _ruler(plotter, slice_)
    preview.caption(plotter, caption.heading, (PAD, height - PAD - LINE / 2), colour=mark, centred=False)
    for row, line in enumerate(lines):
        preview.caption(plotter, line, (PAD, height - PAD - LINE * (row + 1.5)), 18,
                        centred=False)
    preview.light(plotter, np.eye(3), height)
    preview.save(plotter, path)


def figure(value: float, unit: str) -> str:
    """A measured value as a label: 0.41 mm, 27.9 deg; shares and counts without a unit."""
    return f"{value:.3g}" if unit in ("1", "faults") else f"{value:.3g} {unit}"


def _views(surface: Surface, place: np.ndarray) -> tuple[View, View]:
    """(the whole part, a slice through `place`)."""
    points = surface.corners.reshape(-1, 3)
    axes = side(surface, place).axes()
    flat = points @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = FILLED * min(SPLIT / (high - low)[0], HIGH / (high - low)[1])
    whole = View(axes, (low + high) / 2 @ axes, (SPLIT / 2, HIGH / 2), scale)
    shown = np.clip(DETAIL * np.ptp(points, axis=0).max(), *DETAIL_RANGE)
    beside = ((SPLIT + WIDTH) / 2, HIGH / 2)
    right = View(across(surface, place).axes(), place, beside, (WIDTH - SPLIT) / shown)
    return whole, right


def side(surface: Surface, place: np.ndarray) -> Camera:
    """The view that shows the part broadside and has little in front of `place`."""
    looks = [np.roll([sign, a, b], axis)
             for axis, sign, a, b in itertools.product(range(3), (1.0, -1.0), (TILT, -TILT), (TILT, -TILT))]
    cameras = [_camera(look) for look in looks]
    points = surface.corners.reshape(-1, 3)
    shown = np.array([np.ptp(points @ camera.axes()[:2].T, axis=0).prod() for camera in cameras])
    towards = np.array([camera.axes()[2] for camera in cameras])
    return cameras[int(np.argmax(shown / shown.max() - HIDDEN * covers(surface, place, towards)))]


def _camera(look: np.ndarray) -> Camera:
    """Upright as the part lies on a table; seen from above or below, a finger points to the right."""
    steep = np.argmax(np.abs(look)) == 2
    return Camera(tuple(look.tolist()), (0.0, 1.0, 0.0) if steep else (0.0, 0.0, 1.0))


def covers(surface: Surface, place: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """How many surfaces, at most MOST_HIDDEN, lie between `place` and viewers in the directions (n, 3)."""
    reached, count = np.zeros(len(towards)), np.zeros(len(towards))
    for _ in range(MOST_HIDDEN):
        open_ = np.isfinite(reached)
        start = place + np.where(open_, reached, 0.0)[:, None] * towards
        distance = np.where(open_, surface.sight(start, towards), np.inf)
        count += np.isfinite(distance)
        # A little beyond, or the next ray would strike the same surface again.
        reached = reached + distance + 0.01
    return count


def across(surface: Surface, place: np.ndarray) -> Camera:
    """A look along the part and along the wall at `place`, so that the slice shows how thick it is."""
    feet = nearest(surface.corners, place)
    away = feet - place
    normal = surface.normals[np.einsum("ij,ij->i", away, away).argmin()]
    for axis in np.argsort(-np.ptp(surface.corners.reshape(-1, 3), axis=0)):
        look = np.eye(3)[axis] - normal[axis] * normal
        if np.linalg.norm(look) > 0.5:
            break
    return _camera(look)


def _sliced(part: Solid, view: View, place: np.ndarray) -> list[Solid]:
    """The part beyond the plane through `place`, within the right half, in pixels; its cut by itself."""
    from manifold3d import Error, Manifold, Mesh

    vertices, faces, colour = part
    flat = view.onto(vertices)
    size = WIDTH - SPLIT
    low = np.array([SPLIT, view.centre[1] - size / 2, -size])
    solid = Manifold(Mesh(flat.astype(np.float32), faces.astype(np.uint32)))
    if solid.status() != Error.NoError:
        return _beyond(flat, faces, low, size, colour)
    box = Manifold.cube((size, size, size)).translate(low.tolist())
    cut = (solid ^ box).to_mesh()
    points, triangles = cut.vert_properties[:, :3].astype(float), cut.tri_verts.astype(int)
    # The box's near face passes through the place, at depth 0.
    front = (np.abs(points[triangles][:, :, 2]) < 1e-2).all(axis=1)
    return [(points, triangles[rows], tint) for rows, tint in ((~front, colour), (front, CUT)) if rows.any()]


def _beyond(points: np.ndarray, faces: np.ndarray, low: np.ndarray, size: float, colour: Colour
            ) -> list[Solid]:
    """Triangles cut to the box of `size` at `low`: what is not closed has no inside to show."""
    import trimesh

    inward = np.vstack([np.eye(3), -np.eye(3)])
    corners = np.vstack([np.tile(low, (3, 1)), np.tile(low + size, (3, 1))])
    kept = trimesh.intersections.slice_mesh_plane(
        trimesh.Trimesh(points, faces, process=False), inward, corners)
    return [(kept.vertices, kept.faces, colour)] if len(kept.faces) else []


def _mark(plotter, view: View, places: Sequence[tuple[float, float, float]], colour: Colour) -> None:
    """Rings around the places; a dot and cross lines at the first."""
    turn = np.linspace(0.0, 2 * np.pi, 49)
    for number, at in enumerate(view.onto(np.array(places))[:, :2]):
        ring = RINGS[min(number, 1)]
        _line(plotter, at + ring * np.c_[np.cos(turn), np.sin(turn)], colour, 3.0 if number == 0 else 2.0)
    worst = view.onto(np.array(places[:1]))[0, :2]
    for direction in np.array([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        _line(plotter, worst + np.array([[0.55], [1.6]]) * RINGS[0] * direction, colour, 3.0)


def _label(plotter, at: np.ndarray, text: str, colour: Colour) -> None:
    """`text` towards the middle of the left half, with a line that leads to the ring at `at`."""
    aside = np.array([1.0 if at[0] < SPLIT / 2 else -1.0, 1.0 if at[1] < HIGH / 2 else -1.0])
    start, end = at + 0.75 * RINGS[0] * aside, at + 4.0 * RINGS[0] * aside
    _line(plotter, np.array([start, end]), colour, 2.0)
    preview.caption(plotter, text, tuple(end + aside * (0.0, LINE / 2)), colour=colour, plate=PLATE)


def _ruler(plotter, view: View) -> None:
    """A bar of so many millimetres at the foot of the right half."""
    length = next(r for r in RULERS if r * view.scale < 0.4 * (WIDTH - SPLIT))
    end = np.array([WIDTH - 2 * PAD, PAD])
    start = end - (length * view.scale, 0.0)
    _line(plotter, np.array([start, end]), INK, 3.0)
    preview.caption(plotter, f"{length:g} mm", tuple((start + end) / 2 + (0, LINE / 2)), size=18)


def _line(plotter, points: np.ndarray, colour: Colour, width: float) -> None:
    """A line through `points` (n, 2), pixels, over whatever is drawn there."""
    import pyvista
    from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

    mapper = vtkPolyDataMapper2D()
    mapper.SetInputData(pyvista.MultipleLines(np.c_[points, np.zeros(len(points))]))
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().SetLineWidth(width)
    plotter.add_actor(actor)
