"""Evaluate a part's tree with manifold3d: the mesh that is printed.

manifold3d is guaranteed to give a closed, oriented 2-manifold from every boolean, which OCCT's
tessellation is not (its revolved caps have zero-area triangles on the axis).
"""

from __future__ import annotations

import functools
import math
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from handgen.geometry import csg
from handgen.geometry.lettering import outlines
from handgen.geometry.measure import FLAT

if TYPE_CHECKING:
    import trimesh
    from manifold3d import Manifold

CHORD = 0.005
"""Largest distance of a chord from its curve, mm: a tenth of what a good printer resolves."""
MIN_SEGMENTS = 64
"""Least chords around a circle: the polygon then lacks 0.16 % of its area, however small it is."""
FLATNESS = 1 / 40
SMOOTH_STEPS = 8
"""Straight steps of a smooth loft from one section to the next."""
SLIVER = 1e-3
"""Detail below this, mm, is dropped from the mesh before it is rounded for export."""


@functools.lru_cache(maxsize=256)
def evaluate(shape: csg.Shape) -> Manifold:
    """The solid bounded by `shape`, in mm.

    Raises:
        ValueError: a primitive is not a valid solid (crossing outline, radius below zero).
    """
    from manifold3d import Error, Manifold

    match shape:
        case csg.Revolve(path):
            result = _revolve(path)
        case csg.Extrude(path, height):
            result = _extrude([sample(path)], height)
        case csg.Text(text, size, height):
            rings = [r for outer, holes in outlines(text, size) for r in (outer, *holes)]
            result = _extrude(rings, height)
        case csg.Loft():
            result = _loft(shape)
        case csg.Field(recipe, pitch):
            result = _field(recipe, pitch)
        case csg.Placed(inner, rotation, origin):
            result = evaluate(inner).transform(np.c_[np.array(rotation), np.array(origin)])
        case csg.Mirrored(inner, axis):
            result = evaluate(inner).mirror(tuple(float(a == axis) for a in "xyz"))
        case csg.Union(shapes):
            from manifold3d import OpType

            result = Manifold.batch_boolean([evaluate(s) for s in shapes], OpType.Add)
        case csg.Difference(base, tools):
            from manifold3d import OpType

            parts = [evaluate(s) for s in (base, *tools)]
            result = Manifold.batch_boolean(parts, OpType.Subtract)
        case csg.Intersection(shapes):
            from manifold3d import OpType

            result = Manifold.batch_boolean([evaluate(s) for s in shapes], OpType.Intersect)
        case _:
            raise TypeError(f"no mesh for a {type(shape).__name__}")
    if result.status() != Error.NoError:
        raise ValueError(f"{type(shape).__name__} is not a closed solid: {result.status().name}")
    return result


def forget() -> None:
    """Let go of all solids that `evaluate` remembers."""
    evaluate.cache_clear()


class Triangles(NamedTuple):
    """Vertices (n, 3) float32, mm, and faces (m, 3) of a closed mesh."""

    vertices: np.ndarray
    faces: np.ndarray


def printable(solid: Manifold) -> trimesh.Trimesh:
    """`triangles` of the solid as a trimesh."""
    import trimesh

    return trimesh.Trimesh(*triangles(solid), process=False)


def triangles(solid: Manifold) -> Triangles:
    """The mesh of `solid` as a binary STL can hold it.

    Rounding to float32 can flatten a sliver or make two corners one, so the rounded mesh is
    simplified once more (that only takes corners away, it moves none) until neither is left.

    Raises:
        ValueError: nothing is left, the solid falls into several bodies, or keeps slivers.
    """
    from manifold3d import Manifold, Mesh

    for tolerance in (SLIVER, 4 * SLIVER, 16 * SLIVER):
        mesh = solid.simplify(tolerance).to_mesh()
        vertices = np.array(mesh.vert_properties[:, :3], np.float32, order="C")
        faces = np.array(mesh.tri_verts, np.uint32, order="C")
        rounded = Manifold(Mesh(vertices, faces)).simplify(tolerance)
        if rounded.is_empty():
            raise ValueError("the solid is empty")
        bodies = rounded.decompose()
        if len(bodies) > 1:
            sizes = sorted((b.volume() for b in bodies), reverse=True)
            raise ValueError(
                f"the solid falls into {len(bodies)} bodies of "
                + ", ".join(f"{v:.3g}" for v in sizes[:4]) + " mm3")
        final = rounded.to_mesh()
        vertices, faces = final.vert_properties[:, :3], final.tri_verts.astype(int)
        a, b, c = vertices[faces].astype(float).transpose(1, 0, 2)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        if len(np.unique(vertices.view("V12"))) == len(vertices) and areas.min() > FLAT:
            return Triangles(vertices, faces)
    raise ValueError("rounded to the precision of an STL the mesh keeps slivers")


def sample(path: csg.Path, chord: float = CHORD) -> np.ndarray:
    """Points (n, 2) of a closed path, within `chord` mm of its curves, no point twice."""
    ring = _points(path, _steps(path, chord))
    keep = np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > 1e-7
    return ring[keep]


def _steps(path: csg.Path, chord: float) -> list[int]:
    """Straight steps per segment; a cubic's chord error is |second derivative| / (8 n^2)."""
    steps, start = [], np.array(path.start)
    for segment in path.segments:
        points = np.array([start, *segment], float)
        start = points[-1]
        if len(points) == 2:
            steps.append(1)
        else:
            bend = 6.0 * np.hypot(*np.diff(points, 2, axis=0).T).max()
            steps.append(max(2, math.ceil(math.sqrt(bend / (8.0 * chord)))))
    return steps


def _points(path: csg.Path, steps: list[int]) -> np.ndarray:
    """The path's start and `steps[i]` points along each segment."""
    points = [np.array([path.start])]
    for segment, n in zip(path.segments, steps, strict=True):
        if len(segment) == 1:
            points.append(np.array(segment, float))
            continue
        start = points[-1][-1]
        c1, c2, end = np.array(segment, float)
        t = np.linspace(0.0, 1.0, n + 1)[1:, None]
        u = 1.0 - t
        points.append(u**3 * start + 3 * u * u * t * c1 + 3 * u * t * t * c2 + t**3 * end)
    return np.vstack(points)


def segments_for(radius: float) -> int:
    """Chords around a circle so that none lies more than CHORD inside it: 64, 128, 256 ...

    Doubling keeps the corners of one part on those of the next: an actuator that fills its bore
    without clearance then touches it everywhere and cuts into it nowhere.
    """
    exact = math.pi / math.acos(1.0 - CHORD / max(radius, 2 * CHORD))
    return MIN_SEGMENTS * 2 ** max(0, math.ceil(math.log2(exact / MIN_SEGMENTS)))


def _revolve(path: csg.Path) -> Manifold:
    from manifold3d import Manifold

    points = sample(path)
    if points[:, 1].min() < -1e-9:
        raise ValueError(f"revolved outline reaches radius {points[:, 1].min():.3g} mm, below 0")
    section = _cross_section([np.c_[np.maximum(points[:, 1], 0.0), points[:, 0]]])
    turned = Manifold.revolve(section, segments_for(points[:, 1].max()))
    # manifold3d turns (radius, height) about its z axis; ours is x: (x, y, z) <- (z, x, y).
    return turned.transform(np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]], float))


def _extrude(rings: list, height: float) -> Manifold:
    return _cross_section(rings).extrude(height)


def _cross_section(rings: list):
    from manifold3d import CrossSection, FillRule

    section = CrossSection([np.asarray(r, float) for r in rings], FillRule.EvenOdd)
    if section.area() <= 0.0:
        raise ValueError("an outline encloses no area")
    return section


def _loft(loft: csg.Loft) -> Manifold:
    """Triangulated skin through the sections; the caps are triangulated in their planes."""
    from manifold3d import Manifold, Mesh64, triangulate

    sections = loft.sections
    steps = np.max([_steps(s.path, CHORD) for s in sections], axis=0)
    rings = [_points(s.path, steps) for s in sections]
    if all(np.hypot(*(r[0] - r[-1])) < 1e-7 for r in rings):
        rings = [r[:-1] for r in rings]
    m, n = len(rings), len(rings[0])
    vertices = np.vstack([
        np.c_[ring, np.zeros(n)] @ np.array(s.rotation).T + np.array(s.origin)
        for ring, s in zip(rings, sections, strict=True)
    ])
    if loft.smooth:
        vertices = _smoothed(loft.stations, vertices.reshape(m, n, 3)).reshape(-1, 3)
        m = len(vertices) // n
    i = np.arange(n)
    j = (i + 1) % n
    faces = []
    for k in range(m - 1):
        a, b = k * n, (k + 1) * n
        faces += [np.c_[a + i, a + j, b + j], np.c_[a + i, b + j, b + i]]
    # manifold3d triangulates rings that run counter-clockwise.
    def cap(ring):
        x, y = ring.T
        clockwise = x @ np.roll(y, -1) < y @ np.roll(x, -1)
        triangles = np.asarray(triangulate([ring[::-1] if clockwise else ring]), int)
        return n - 1 - triangles[:, ::-1] if clockwise else triangles

    faces += [cap(rings[0])[:, ::-1], cap(rings[-1]) + (m - 1) * n]
    faces = np.vstack(faces)
    v = vertices[faces]
    if np.einsum("ij,ij->", v[:, 0], np.cross(v[:, 1], v[:, 2])) < 0.0:
        faces = faces[:, ::-1]
    return Manifold(Mesh64(vertices, np.array(faces, np.uint64, order="C")))


def _smoothed(at: tuple[float, ...], rings: np.ndarray) -> np.ndarray:
    """Rings (m, n, 3) at the stations `at`, with more between them on cubic splines."""
    from scipy.interpolate import make_interp_spline

    between = np.concatenate([np.linspace(a, b, SMOOTH_STEPS, endpoint=False) for a, b in pairwise(at)])
    return make_interp_spline(at, rings, k=min(3, len(at) - 1))(np.r_[between, at[-1]])


def _field(recipe, pitch: float) -> Manifold:
    """Marching cubes (Lewiner, scikit-image) over the field, as a closed solid.

    Neighbouring triangles that are flat within FLATNESS of the pitch are merged: far below what
    the grid resolves, and it takes two thirds of the triangles out of the file.
    """
    from manifold3d import Manifold, Mesh
    from skimage.measure import marching_cubes

    values, origin = recipe.sample(pitch)
    vertices, faces, _, _ = marching_cubes(values, 0.0, spacing=(pitch,) * 3)
    mesh = Mesh((vertices + origin).astype(np.float32), faces.astype(np.uint32))
    mesh.merge()
    return Manifold(mesh).simplify(FLATNESS * pitch)
