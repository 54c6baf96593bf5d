"""A part's triangles, and sections through them, as plain arrays that rules measure.

A section is a bag of directed straight pieces with the material on their left, never chained into
loops: areas, moments and radii are sums over the pieces, so that one takes a millisecond.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from handgen.geometry import mesh_kernel


@dataclass(frozen=True)
class Outline:
    """Pieces from `start` to `end`, (n, 2) mm, in the plane's two coordinates."""

    start: np.ndarray
    end: np.ndarray

    def __len__(self) -> int:
        return len(self.start)

    def where(self, keep: np.ndarray) -> Outline:
        return Outline(self.start[keep], self.end[keep])

    @cached_property
    def middle(self) -> np.ndarray:
        return (self.start + self.end) / 2

    @cached_property
    def lengths(self) -> np.ndarray:
        return np.linalg.norm(self.end - self.start, axis=1)

    @cached_property
    def outward(self) -> np.ndarray:
        """Unit normals (n, 2) that point out of the material."""
        along = (self.end - self.start) / np.maximum(self.lengths, 1e-12)[:, None]
        return np.c_[along[:, 1], -along[:, 0]]

    @cached_property
    def area(self) -> float:
        """Of the closed section, mm2."""
        return float(self._cross.sum() / 2)

    @cached_property
    def centroid(self) -> np.ndarray:
        """Of the closed section's area."""
        return (self._cross[:, None] * (self.start + self.end)).sum(0) / (6 * self.area)

    def second_moment(self, axis: int) -> float:
        """Of the area about its centroid, of coordinate `axis` squared, mm4."""
        a, b = self.start[:, axis], self.end[:, axis]
        about_origin = (self._cross * (a * a + a * b + b * b)).sum() / 12
        return float(about_origin - self.area * self.centroid[axis] ** 2)

    def facing(self, outwards: bool, centre=(0.0, 0.0)) -> Outline:
        """The pieces whose material lies towards `centre` (`outwards`), or beyond them: holes."""
        away = np.einsum("ij,ij->i", self.outward, self.middle - centre)
        return self.where(away > 0 if outwards else away < 0)

    def radii(self, centre=(0.0, 0.0)) -> np.ndarray:
        """Distances of the pieces' ends from `centre`: on a circle drawn in chords, its radius."""
        return np.linalg.norm(np.vstack([self.start, self.end]) - centre, axis=1)

    def circle(self) -> tuple[np.ndarray, float]:
        """(centre, radius) of the circle that fits the pieces' ends best (Kasa's least squares)."""
        points = np.vstack([self.start, self.end])
        about = points.mean(0)
        u = points - about
        solution, *_ = np.linalg.lstsq(np.c_[2 * u, np.ones(len(u))], (u * u).sum(1), rcond=None)
        return about + solution[:2], float(np.sqrt(solution[2] + solution[:2] @ solution[:2]))

    @cached_property
    def _cross(self) -> np.ndarray:
        return self.start[:, 0] * self.end[:, 1] - self.start[:, 1] * self.end[:, 0]


@dataclass(frozen=True)
class Triangles:
    """The triangles of a closed mesh: `vertices` (n, 3) mm, `faces` (m, 3), outward by right hand."""

    vertices: np.ndarray
    faces: np.ndarray

    @classmethod
    def of(cls, mesh: mesh_kernel.Triangles) -> Triangles:
        """The triangles of a part, in double precision."""
        return cls(np.array(mesh.vertices, float), np.array(mesh.faces))

    @cached_property
    def corners(self) -> np.ndarray:
        """(m, 3 corners, 3)."""
        return self.vertices[self.faces]

    @cached_property
    def centres(self) -> np.ndarray:
        return self.corners.mean(axis=1)

    @cached_property
    def areas(self) -> np.ndarray:
        return np.linalg.norm(self._crosses, axis=1) / 2

    @cached_property
    def normals(self) -> np.ndarray:
        return self._crosses / np.maximum(2 * self.areas, 1e-15)[:, None]

    @cached_property
    def _crosses(self) -> np.ndarray:
        a, b, c = self.corners.transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    def seen_from(self, rotation, origin=(0.0, 0.0, 0.0)) -> Triangles:
        """In the frame whose axes are the columns of `rotation`, at `origin`."""
        return Triangles((self.vertices - np.array(origin)) @ np.array(rotation), self.faces)

    def where(self, keep: np.ndarray) -> Triangles:
        """Some of the faces, and their vertices only."""
        used, renumbered = np.unique(self.faces[keep], return_inverse=True)
        return Triangles(self.vertices[used], renumbered.reshape(-1, 3))

    def section(self, axis: int, at: float) -> Outline:
        """The section where coordinate `axis` is `at`, in the two coordinates that follow it.

        For x that is (y, z), for y (z, x), for z (x, y), so that areas come out positive. Vertices
        that lie exactly in the plane count as below it.
        """
        height = self.vertices[:, axis] - at
        above = height > 0
        upper = above[self.faces]
        count = upper.sum(1)
        cut = (count == 1) | (count == 2)
        crossing, upper, lone_above = self.faces[cut], upper[cut], count[cut] == 1
        # The corner that stands alone on its side comes first.
        lone = np.argmax(upper == lone_above[:, None], axis=1)
        a, b, c = (crossing[np.arange(len(crossing)), (lone + k) % 3] for k in range(3))
        plane = self.vertices[:, [(axis + 1) % 3, (axis + 2) % 3]]

        def point(other: np.ndarray) -> np.ndarray:
            share = height[a] / (height[a] - height[other])
            return plane[a] + share[:, None] * (plane[other] - plane[a])

        p, q = point(b), point(c)
        # A triangle runs counter-clockwise seen from outside: with its lone corner above, the
        # material lies left of the way from the far edge to the near one.
        forward = lone_above[:, None]
        return Outline(np.where(forward, p, q), np.where(forward, q, p))
