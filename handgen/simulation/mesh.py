"""The actuator as structured hexahedra, straight from its profile; half of it (y >= 0).

Rings of nodes around the axis, from the chamber's wall through the thread to the outside; the tip's disc
is an O-grid, so that no element degenerates at the axis. A ring of straight edges encloses less than its
circle: all radii are drawn larger by one factor (`Rings.swell`), so that every polygon has the circle's
area and chamber, wall and thread their real sections.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from handgen.geometry.profile import ActuatorProfile
from handgen.simulation.case import Grid, Winding

EDGE = 2.4
"""Length of elements along the axis, mm."""
END_EDGE, GROWTH = 1.0, 1.5
"""The same where the wall is held and where it meets the tip, mm, and how it grows from there."""
AROUND = 8
"""Elements around half the circle; a multiple of four for the O-grid."""
WALL = (1, 1)
"""Elements through the wall, inside and outside the thread."""
TIP_EDGE = 1.0
"""Length of elements along the axis in the closed tip, mm."""
CORE = 0.5
"""Half width of the O-grid's inner square, in radii of the chamber."""
DISC = 0.9
"""Radius of the closed tip's disc over that of the thread around it, at most: a tip may taper below the
chamber's radius."""


@dataclass(frozen=True)
class ActuatorMesh:
    """Nodes, cells and what the loads and contacts act on; indices are those of `grid.nodes`."""

    grid: Grid
    swell: float
    """Drawn radius over real radius."""
    threads: np.ndarray
    """(k, 2) nodes at the ends of the thread's edges."""
    thread_span: np.ndarray
    """(k,) length along the axis, mm, that an edge's ring stands for."""
    chamber: np.ndarray
    """(f, 4) faces of the chamber, seen from inside counterclockwise (their normals point outwards)."""
    outside: np.ndarray
    """(o, 2) nodes before and behind points of the lateral surface, and ..."""
    outside_share: np.ndarray
    """(o, 2) ... their shares in them."""
    outside_area: np.ndarray
    """(o,) area, mm2, of the half surface that each point stands for."""
    face: np.ndarray
    """(t,) nodes of the tip's face."""
    face_area: np.ndarray
    axis: np.ndarray
    """(s,) nodes of the palmar outside line and ..."""
    back: np.ndarray
    """(s,) ... of the dorsal one, station by station: their middle is the centre line."""
    tip: int
    """The node in the middle of the tip's face."""


def actuator_mesh(profile: ActuatorProfile, winding: Winding | None, held: float,
                  refine: int) -> ActuatorMesh:
    """Mesh of `profile`, whose base is held over `held` mm; `refine` halves the edges so many times."""
    rings = _Rings(profile, winding, held, refine)
    return rings.mesh()


def graded(start: float, end: float, fine: int, first: float = END_EDGE) -> np.ndarray:
    """Stations from `start` to `end`, closer at both ends, where edges are `first` mm; with `fine` elements
    for each of the standard."""
    edges, half = [], (end - start) / 2
    while sum(edges) < half:
        edges.append(min(EDGE, first * GROWTH ** len(edges)))
    edges = np.array(edges) * half / sum(edges)
    ends = np.concatenate([[0.0], np.cumsum(edges), half + np.cumsum(edges[::-1])])
    return start + np.interp(np.arange(fine * (len(ends) - 1) + 1) / fine, np.arange(len(ends)), ends)


def layers(profile: ActuatorProfile, winding: Winding | None, x: np.ndarray) -> np.ndarray:
    """(stations, 3) radii, mm, of the chamber's wall, the thread's centre and the outside at `x`."""
    inside = profile.small_core(x)
    middle = profile.large_core(x) + (winding.depth if winding else 0.0)
    inside = np.where(x > profile.small_core_end, np.minimum(inside, DISC * middle), inside)
    return np.stack([inside, middle, profile.outer(x)], -1)


class _Rings:
    """Numbering: stations along the axis, layers through the wall, places around; then the tip's core."""

    def __init__(self, profile: ActuatorProfile, winding: Winding | None, held: float, refine: int):
        self.profile, self.winding = profile, winding
        fine = 2**refine
        self.around = AROUND * fine
        self.layers = sum(WALL) * fine
        chamber, tip = profile.small_core_end, profile.length - profile.small_core_end
        base = np.linspace(0.0, held, max(1, round(held / EDGE)) + 1)[:-1] if held > 0 else []
        cap = np.linspace(chamber, profile.length, max(1, round(tip / TIP_EDGE)) * fine + 1)[1:]
        self.x = np.concatenate([base, graded(held, chamber, fine), cap])
        self.cap = len(self.x) - 1 - len(cap)
        """Station of the chamber's end."""
        step = math.pi / self.around
        self.swell = math.sqrt(step / math.sin(step))
        self.inner = WALL[0] * fine
        self.m = self.around // 4

    def radii(self, x: np.ndarray) -> np.ndarray:
        """(stations, layers + 1) drawn radii, mm."""
        inside, middle, outside = layers(self.profile, self.winding, x).T
        share_in = np.linspace(0.0, 1.0, self.inner + 1)
        share_out = np.linspace(0.0, 1.0, self.layers - self.inner + 1)[1:]
        within = inside[:, None] + (middle - inside)[:, None] * share_in
        beyond = middle[:, None] + (outside - middle)[:, None] * share_out
        return self.swell * np.hstack([within, beyond])

    def node(self, station, layer, place):
        return (station * (self.layers + 1) + layer) * (self.around + 1) + place

    def mesh(self) -> ActuatorMesh:
        radii, angles = self.radii(self.x), np.linspace(0.0, math.pi, self.around + 1)
        y, z = np.sin(angles), -np.cos(angles)
        y[-1] = 0.0
        wall = np.stack(np.broadcast_arrays(
            self.x[:, None, None], radii[:, :, None] * y, radii[:, :, None] * z), -1).reshape(-1, 3)
        i, j, k = np.meshgrid(np.arange(len(self.x) - 1), np.arange(self.layers), np.arange(self.around),
                              indexing="ij")
        n = self.node
        cells = np.stack([n(i, j, k), n(i + 1, j, k), n(i + 1, j + 1, k), n(i, j + 1, k),
                          n(i, j, k + 1), n(i + 1, j, k + 1), n(i + 1, j + 1, k + 1), n(i, j + 1, k + 1)],
                         -1).reshape(-1, 8)
        disc, core, ring = self._core(len(wall), radii)
        grid = Grid(np.vstack([wall, core]), np.vstack([cells, disc]))
        return ActuatorMesh(grid, self.swell, *self._threads(), self._chamber(ring),
                            *self._outside(radii), *self._face(grid, ring),
                            n(np.arange(len(self.x)), self.layers, 0),
                            n(np.arange(len(self.x)), self.layers, self.around), self._tip(ring))

    def _core(self, first: int, radii: np.ndarray):
        """(cells, nodes, numbers (stations, m + 1, 2 m + 1)) of the square inside the tip's O-grid."""
        m, stations = self.m, np.arange(self.cap, len(self.x))
        number = first + np.arange(len(stations) * (m + 1) * (2 * m + 1)).reshape(-1, m + 1, 2 * m + 1)
        half = CORE * radii[stations, 0]
        y = half[:, None, None] * np.linspace(0, 1, m + 1)[None, :, None]
        z = half[:, None, None] * np.linspace(-1, 1, 2 * m + 1)[None, None, :]
        nodes = np.stack(np.broadcast_arrays(self.x[stations][:, None, None], y, z), -1).reshape(-1, 3)
        s, a, b = np.meshgrid(np.arange(len(stations) - 1), np.arange(m), np.arange(2 * m), indexing="ij")
        inner = np.stack([number[s + d, a + e, b + f] for d, e, f in
                          ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1),
                           (0, 1, 1))], -1).reshape(-1, 8)
        rim = self._rim(number)
        s, k = np.meshgrid(np.arange(len(stations) - 1), np.arange(self.around), indexing="ij")
        at = self.cap + s
        outer = np.stack([rim[s, k], rim[s + 1, k], self.node(at + 1, 0, k), self.node(at, 0, k),
                          rim[s, k + 1], rim[s + 1, k + 1], self.node(at + 1, 0, k + 1),
                          self.node(at, 0, k + 1)], -1).reshape(-1, 8)
        return np.vstack([inner, outer]), nodes, number

    def _rim(self, number: np.ndarray) -> np.ndarray:
        """(stations, around + 1) numbers on the square's edge, from the palmar to the dorsal side."""
        m = self.m
        return np.concatenate([number[:, :, 0], number[:, m, 1:], number[:, m - 1::-1, 2 * m]], axis=1)

    def _threads(self):
        """Edges of the thread's rings and the length along the axis that each ring stands for."""
        if self.winding is None:
            return np.zeros((0, 2), int), np.zeros(0)
        start, end = self.winding.start, self.winding.end
        middles = np.concatenate([[0.0], (self.x[1:] + self.x[:-1]) / 2, [self.x[-1]]])
        span = np.clip(np.minimum(middles[1:], end) - np.maximum(middles[:-1], start), 0.0, None)
        s, k = np.meshgrid(np.flatnonzero(span > 0), np.arange(self.around), indexing="ij")
        ends = np.stack([self.node(s, self.inner, k), self.node(s, self.inner, k + 1)], -1)
        return ends.reshape(-1, 2), span[s].ravel()

    def _chamber(self, number: np.ndarray) -> np.ndarray:
        """Faces of the tube's inside and of its closed end."""
        n, m = self.node, self.m
        i, k = np.meshgrid(np.arange(self.cap), np.arange(self.around), indexing="ij")
        tube = np.stack([n(i, 0, k), n(i, 0, k + 1), n(i + 1, 0, k + 1), n(i + 1, 0, k)], -1).reshape(-1, 4)
        a, b = np.meshgrid(np.arange(m), np.arange(2 * m), indexing="ij")
        flat = number[0]
        square = np.stack([flat[a, b], flat[a + 1, b], flat[a + 1, b + 1], flat[a, b + 1]], -1)
        rim, k = self._rim(number)[0], np.arange(self.around)
        ring = np.stack([rim[k], n(self.cap, 0, k), n(self.cap, 0, k + 1), rim[k + 1]], -1)
        return np.vstack([tube, square.reshape(-1, 4), ring])

    def _outside(self, radii: np.ndarray):
        """Points on the lateral surface's lines along the axis: two an element, where Gauss has his.

        Nodes alone would stand too far apart, once stretched, to slide around a slot's edge without a jerk.
        """
        share = np.full(self.around + 1, math.pi / self.around)
        share[[0, -1]] /= 2
        i, k, g = np.meshgrid(np.arange(len(self.x) - 1), np.arange(self.around + 1), np.arange(2),
                              indexing="ij")
        ahead = (1 + np.array([-1.0, 1.0]) / math.sqrt(3)) / 2
        area = np.diff(self.x)[i] / 2 * share[k] / self.swell * (
            (1 - ahead[g]) * radii[i, -1] + ahead[g] * radii[i + 1, -1])
        nodes = np.stack([self.node(i, self.layers, k), self.node(i + 1, self.layers, k)], -1)
        return nodes.reshape(-1, 2), np.stack([1 - ahead[g], ahead[g]], -1).reshape(-1, 2), area.ravel()

    def _face(self, grid: Grid, number: np.ndarray):
        """Nodes of the tip's face and their areas."""
        last = len(self.x) - 1
        j, k = np.meshgrid(np.arange(self.layers + 1), np.arange(self.around + 1), indexing="ij")
        nodes = np.concatenate([self.node(last, j, k).ravel(), number[-1].ravel()])
        area = np.zeros(len(grid.nodes))
        member = np.zeros(len(grid.nodes), bool)
        member[nodes] = True
        for quad in ((1, 2, 6, 5),):
            faces = grid.cells[:, quad]
            faces = faces[member[faces].all(axis=1)]
            p = grid.nodes[faces]
            size = np.linalg.norm(np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]), axis=1) / 2
            np.add.at(area, faces, size[:, None] / 4)
        return nodes, area[nodes] / self.swell**2

    def _tip(self, number: np.ndarray) -> int:
        return int(number[-1, 0, self.m])
