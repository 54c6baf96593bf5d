"""What hangs in the air while a part is printed: patches steeper than a limit, and what holds them.

Frame of printing: z up, any place on the bed. A patch is held along those edges from which the
surface goes on downwards; a place of it is a bridge where it is held on two opposite sides, an
overhang where it is held on one, and starts in the air where it is held nowhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handgen.checks.sections import Triangles

PITCH = 1.0
"""Distance of the places looked at on a patch, mm."""
EDGE_PITCH = 0.5
"""Distance of the points that stand for an edge that holds, mm."""
SECTORS = 32
"""Directions in which a bridge's two sides are looked for."""
CHUNK = 200
"""Places judged at once, so that the table of distances stays small."""
EXACT = 0.01
"""A face may be this much steeper, deg, before it counts: rounding to STL tilts small triangles."""
PLASTIC = (0.7548776662, 0.5698402910)
"""Steps of the sequence that fills a square evenly (Roberts' R2, powers of the plastic number)."""


@dataclass(frozen=True)
class Patch:
    """One connected patch: its area (mm2), steepest angle (deg), places (n, 3) that stand for equal
    shares of the area, and points (m, 2) along the edges that hold it."""

    area: float
    angle: float
    places: np.ndarray
    holds: np.ndarray

    @property
    def share(self) -> float:
        """Area that one place stands for, mm2."""
        return self.area / len(self.places)

    def reach(self) -> np.ndarray:
        """Horizontal distance of every place to what holds it, mm; infinite: nothing does."""
        from scipy.spatial import cKDTree

        if not len(self.holds):
            return np.full(len(self.places), np.inf)
        return cKDTree(self.holds).query(self.places[:, :2])[0]

    def span(self, of: np.ndarray) -> np.ndarray:
        """Least distance, mm, of two opposite sides that hold, through the places `of` (a mask)."""
        rows = np.flatnonzero(of)
        result = np.full(len(self.places), np.inf)
        for k in range(0, len(rows) if len(self.holds) else 0, CHUNK):
            chunk = rows[k:k + CHUNK]
            result[chunk] = _spans(self.places[chunk, :2], self.holds)
        return result


def angles(surface: Triangles) -> np.ndarray:
    """Angle of every face from the vertical, deg: 90 a ceiling, 0 a wall, below 0 a roof."""
    return np.degrees(np.arcsin(np.clip(-surface.normals[:, 2], -1.0, 1.0)))


def steep(surface: Triangles, limit: float, bed: float) -> np.ndarray:
    """Which faces overhang by more than `limit` deg and lie higher than `bed` mm above the lowest."""
    floor = surface.vertices[:, 2].min() + bed
    return (angles(surface) > limit + EXACT) & (surface.corners[:, :, 2].max(1) > floor + 1e-6)


def patches(surface: Triangles, hanging: np.ndarray) -> list[Patch]:
    """The connected patches of the faces `hanging` (a mask)."""
    chosen = np.flatnonzero(hanging)
    if not len(chosen):
        return []
    edges, tilt = _edges_that_hold(surface, hanging), angles(surface)
    result = []
    for rows in _connected(surface.faces[chosen]):
        faces = chosen[rows]
        along = edges[np.isin(edges[:, 0], surface.faces[faces])]
        result.append(Patch(float(surface.areas[faces].sum()), float(tilt[faces].max()),
                            _places(surface, faces), _points_along(surface.vertices, along)[:, :2]))
    return result


class Bed:
    """The part's lowest surface above every square millimetre of the bed."""

    CELL = 1.0

    def __init__(self, surface: Triangles):
        below = np.flatnonzero(surface.normals[:, 2] < 0)
        points = np.vstack([_places(surface, below, 0.5 * self.CELL), surface.corners[below].reshape(-1, 3)])
        self.origin = surface.vertices[:, :2].min(0)
        size = np.ceil(np.ptp(surface.vertices[:, :2], axis=0) / self.CELL).astype(int) + 1
        self.lowest = np.full(size, np.inf)
        np.minimum.at(self.lowest, self._cells(points), points[:, 2])

    def _cells(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return tuple(np.floor((points[:, :2] - self.origin) / self.CELL).astype(int).T)

    def seen_from(self, places: np.ndarray) -> np.ndarray:
        """Which of `places` (n, 3) have nothing of the part below them: support stands on the bed."""
        # A patch hardly climbs within a cell; a wall below it lies a line or more deeper.
        return places[:, 2] < self.lowest[self._cells(places)] + self.CELL


def _connected(faces: np.ndarray) -> list[np.ndarray]:
    """Rows of the groups of `faces` that share vertices."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    _, corners = np.unique(faces, return_inverse=True)
    corners = corners.reshape(-1)
    n, size = len(faces), len(faces) + corners.max() + 1
    links = (np.ones(3 * n, bool), (np.repeat(np.arange(n), 3), n + corners))
    _, labels = connected_components(coo_array(links, shape=(size, size)), directed=False)
    order = np.argsort(labels[:n], kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[:n][order])) + 1)


def _edges_that_hold(surface: Triangles, hanging: np.ndarray) -> np.ndarray:
    """Edges (k, 2 vertices) between a hanging face and one that goes on downwards from it."""
    faces, count = surface.faces, len(surface.vertices)
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    opposite = np.roll(faces, -2, axis=1).reshape(-1)
    mine = np.repeat(hanging, 3)
    touched = np.zeros(count, bool)
    touched[faces[hanging]] = True
    beside = np.flatnonzero(~mine & touched[start] & touched[end])
    order = beside[np.argsort((start * count + end)[beside])]
    keys = (start * count + end)[order]
    wanted = np.flatnonzero(mine)
    at = np.searchsorted(keys, (end * count + start)[wanted])
    found = (at < len(keys)) & (keys[np.minimum(at, len(keys) - 1)] == (end * count + start)[wanted])
    edges, beyond = wanted[found], order[at[found]]
    # How the face beyond leaves the edge: square to it, or a slanting edge would mislead.
    along = surface.vertices[end[edges]] - surface.vertices[start[edges]]
    leaves = surface.vertices[opposite[beyond]] - surface.vertices[start[edges]]
    share = np.einsum("ij,ij->i", leaves, along) / np.einsum("ij,ij->i", along, along)
    down = leaves[:, 2] - share * along[:, 2] < -1e-6
    return np.c_[start[edges], end[edges]][down]


def _places(surface: Triangles, faces: np.ndarray, pitch: float = PITCH) -> np.ndarray:
    """Points (n, 3) on `faces`, each standing for the same area of about `pitch` squared."""
    until = np.cumsum(surface.areas[faces])
    n = max(1, round(until[-1] / pitch**2))
    k = np.arange(n)
    of = np.minimum(np.searchsorted(until, (k + 0.5) / n * until[-1]), len(faces) - 1)
    u, v = (k * step % 1.0 for step in PLASTIC)
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    a, b, c = surface.corners[faces[of]].transpose(1, 0, 2)
    return a + u[:, None] * (b - a) + v[:, None] * (c - a)


def _points_along(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Points (n, 3) along `edges`, no farther apart than the pitch."""
    if not len(edges):
        return np.empty((0, 3))
    a, b = vertices[edges[:, 0]], vertices[edges[:, 1]]
    steps = np.maximum(1, np.ceil(np.linalg.norm(b - a, axis=1) / EDGE_PITCH).astype(int))
    of = np.repeat(np.arange(len(edges)), steps + 1)
    first = np.repeat(np.cumsum(steps + 1) - (steps + 1), steps + 1)
    share = ((np.arange(len(of)) - first) / steps[of])[:, None]
    return a[of] + share * (b[of] - a[of])


def _spans(places: np.ndarray, holds: np.ndarray) -> np.ndarray:
    """Least sum of the distances to two opposite points of `holds` (m, 2) from every place (n, 2)."""
    away = holds[None] - places[:, None]
    distance = np.hypot(away[..., 0], away[..., 1])
    turn = np.arctan2(away[..., 1], away[..., 0]) / (2 * np.pi) % 1.0
    sector = np.minimum(np.floor(turn * SECTORS), SECTORS - 1).astype(int)
    nearest = np.full((len(places), SECTORS), np.inf)
    np.minimum.at(nearest, (np.arange(len(places))[:, None], sector), distance)
    # Opposite is the half-turned direction or one of those beside it.
    turned = np.roll(nearest, -SECTORS // 2, axis=1)
    opposite = np.minimum(turned, np.minimum(np.roll(turned, 1, axis=1), np.roll(turned, -1, axis=1)))
    return (nearest + opposite).min(axis=1)
