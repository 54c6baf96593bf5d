"""A closed triangle mesh as something to measure from: samples, rays, nearest points (mm)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

LIFT = 2e-4
"""How far inside the surface a ray starts, mm: more than single precision loses within a hand."""
PLASTIC = 1.32471795724474602596
"""Root of x^3 = x + 1: multiples of 1/x and 1/x^2, modulo 1, fill the unit square evenly (Roberts
2018, the R2 sequence)."""
SHARP = math.cos(math.radians(30.0))
"""Faces that turn by more meet in a sharp edge, not in the chords of a curve."""


@dataclass(frozen=True)
class Edges:
    """Points (n, 3) on sharp edges, the outward normals of the two faces that meet there, and
    whether it is an inner edge: one with material around more than half of it, as in a notch."""

    points: np.ndarray
    one: np.ndarray
    two: np.ndarray
    inner: np.ndarray


class Surface:
    """Triangles of a closed mesh, wound outward, with a tree for rays."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self.faces = np.asarray(faces)
        self.corners = np.asarray(vertices, float)[self.faces]
        a, b, c = self.corners.transpose(1, 0, 2)
        cross = np.cross(b - a, c - a)
        length = np.sqrt(np.einsum("ij,ij->i", cross, cross))
        self.areas = length / 2
        self.normals = cross / np.where(length > 0.0, length, 1.0)[:, None]
        self._middle = (a.min(axis=0) + a.max(axis=0)) / 2

    @cached_property
    def area(self) -> float:
        return float(self.areas.sum())

    @cached_property
    def _scene(self):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        scene = EmbreeScene()
        # About the middle: embree works in single precision.
        TriangleMesh(scene, (self.corners - self._middle).astype(np.float32))
        return scene

    @cached_property
    def _boxes(self) -> tuple[np.ndarray, np.ndarray]:
        return self.corners.min(axis=1), self.corners.max(axis=1)

    def shoot(self, points: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where rays (n, 3) from the surface into the material strike it: (distance, face, cosine).

        `directions` are unit vectors; the cosine is that of the ray with the struck face's outward
        normal. inf, -1 and -1 where nothing is struck from inside.
        """
        start = points + LIFT * directions - self._middle
        face = self._scene.run(start.astype(np.float32), directions.astype(np.float32))
        normal = self.normals[face]
        cosine = np.einsum("ij,ij->i", normal, directions)
        along = np.einsum("ij,ij->i", normal, self.corners[face, 0] - points)
        struck = (face >= 0) & (cosine > 1e-3)
        distance = np.divide(along, cosine, out=np.full(len(points), np.inf), where=struck)
        return distance, np.where(struck, face, -1), np.where(struck, cosine, -1.0)

    def sight(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Distance (n,) from `points` along unit vectors to the first surface, struck from either side."""
        start = (points - self._middle).astype(np.float32)
        face = self._scene.run(start, directions.astype(np.float32))
        normal = self.normals[face]
        along = np.einsum("ij,ij->i", normal, self.corners[face, 0] - points)
        cosine = np.einsum("ij,ij->i", normal, directions)
        struck = (face >= 0) & (np.abs(cosine) > 1e-6)
        return np.divide(along, cosine, out=np.full(len(points), np.inf), where=struck)

    def samples(self, density: float) -> tuple[np.ndarray, np.ndarray]:
        """(points (n, 3), face of each): `density` per mm2, evenly spread, always the same."""
        return spread(self.corners, density)

    def samples_around(
        self, places: np.ndarray, reach: float, density: float, most: int,
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """As `samples`, only within about `reach` mm of `places` (m, 3); the density that became of it.

        No more than `most` samples: then they are spread more thinly.
        """
        from scipy.spatial import cKDTree

        # One place a cell of a quarter of the reach is enough to know what is near.
        cells = np.floor(places / (reach / 4)).astype(int)
        tree = cKDTree(places[np.unique(cells, axis=0, return_index=True)[1]])
        pieces, face, found = self.corners, np.arange(len(self.faces)), []
        while len(pieces):
            middles = pieces.mean(axis=1)
            sizes = np.sqrt(((pieces - middles[:, None]) ** 2).sum(axis=2).max(axis=1))
            close = tree.query(middles, distance_upper_bound=sizes.max() + reach)[0] < sizes + reach
            large = close & (sizes > reach)
            found.append((pieces[close & ~large], face[close & ~large]))
            pieces, face = halves(pieces[large]), np.tile(face[large], 2)
        pieces, face = (np.concatenate(part) for part in zip(*found, strict=True))
        a, b, c = pieces.transpose(1, 0, 2)
        area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
        density = min(density, most / max(area, 1e-9))
        points, piece = spread(pieces, density)
        return points, face[piece], density

    def near(self, point: np.ndarray, reach: float) -> np.ndarray:
        """Faces whose boxes come within `reach` mm of `point`."""
        low, high = self._boxes
        return np.flatnonzero(((low <= point + reach) & (high >= point - reach)).all(axis=1))

    def sharp_edges(self, spacing: float) -> Edges:
        """Points about every `spacing` mm along the edges at which neighbours turn by more than SHARP."""
        start, end = self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()
        count = int(self.faces.max()) + 1
        forward, backward = start * count + end, end * count + start
        order = np.argsort(forward)
        other = order[np.minimum(np.searchsorted(forward, backward, sorter=order), len(order) - 1)]
        edge = np.flatnonzero(start < end)
        one, two = self.normals[edge // 3], self.normals[other[edge] // 3]
        sharp = np.einsum("ij,ij->i", one, two) < SHARP
        edge, one, two = edge[sharp], one[sharp], two[sharp]
        a = self.corners.reshape(-1, 3)[edge]
        along = np.roll(self.corners, -1, axis=1).reshape(-1, 3)[edge] - a
        inner = np.einsum("ij,ij->i", np.cross(one, two), along) < 0.0
        steps = np.ceil(np.linalg.norm(along, axis=1) / spacing).astype(int)
        own = np.repeat(np.arange(len(steps)), steps)
        rank = np.arange(len(own)) - np.repeat(np.cumsum(steps) - steps, steps)
        share = ((rank + 0.5) / steps[own])[:, None]
        return Edges(a[own] + share * along[own], one[own], two[own], inner[own])


def spread(corners: np.ndarray, density: float) -> tuple[np.ndarray, np.ndarray]:
    """(points (n, 3), triangle of each) on triangles (m, 3, 3), `density` per mm2.

    Triangles take turns by their area; within one the points follow a low-discrepancy sequence.
    """
    a, b, c = corners.transpose(1, 0, 2)
    reached = density / 2 * np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    triangle = np.repeat(np.arange(len(corners)), np.diff(np.round(reached).astype(int), prepend=0))
    k = np.arange(len(triangle))
    u, v = k / PLASTIC % 1.0, k / PLASTIC**2 % 1.0
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    weights = np.stack([1.0 - u - v, u, v], axis=1)
    return np.einsum("ij,ijk->ik", weights, corners[triangle]), triangle


def halves(corners: np.ndarray) -> np.ndarray:
    """Triangles (m, 3, 3) cut in two across their longest sides: first all one halves, then the others."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    first = sides.argmax(axis=1)
    row = np.arange(len(corners))
    a, b, c = (corners[row, (first + k) % 3] for k in range(3))
    middle = (a + b) / 2
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])


def nearest(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """The point (m, 3) of each triangle (m, 3, 3) that is nearest to `point`."""
    sides = np.roll(corners, -1, axis=1) - corners
    away = point - corners
    share = np.einsum("ijk,ijk->ij", away, sides) / np.maximum(np.einsum("ijk,ijk->ij", sides, sides), 1e-30)
    on_sides = corners + np.clip(share, 0.0, 1.0)[..., None] * sides
    gaps = np.einsum("ijk,ijk->ij", on_sides - point, on_sides - point)
    best = on_sides[np.arange(len(corners)), gaps.argmin(axis=1)]
    normal = np.cross(sides[:, 0], sides[:, 1])
    square = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-30)
    foot = point - (np.einsum("ij,ij->i", away[:, 0], normal) / square)[:, None] * normal
    inside = (np.einsum("ijk,ik->ij", np.cross(sides, foot[:, None] - corners), normal) >= 0.0).all(axis=1)
    return np.where(inside[:, None], foot, best)
