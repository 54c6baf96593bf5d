"""Wall thickness of a closed mesh: a gauge that is set on the surface everywhere.

A wall is material between two surfaces that face one another. The gauge is a ray into the material,
along the inward normal and then square to the surface that was struck. It counts only where the two
surfaces include less than FACING degrees: at a convex edge the distance between neighbouring faces
goes to zero, but no wall is there. A place belongs to a thin spot only if within it the surfaces run
within PARALLEL degrees of one another: so a wedge, a cone's tip or a chamfer is no finding, while a
feather edge below PARALLEL is one (it cannot be printed). A sharp inner edge (the bottom of a
notch, the rim of a bore's end) faces every direction between the normals of its two faces.

Spots narrower than BREADTH are dropped: the sides of embossed letters are walls to a ray, not to a
maker. What is left is measured again, exactly: the least distance of the two surfaces around it.
"""

from __future__ import annotations

import math
import weakref
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from handgen.geometry.surface import Edges, Surface, nearest

if TYPE_CHECKING:
    from handgen.geometry.mesh_kernel import Triangles

FACING = math.cos(math.radians(37.0))
"""Surfaces that include a larger angle are no wall."""
PARALLEL = math.cos(math.radians(20.0))
"""A thin spot needs a place where the surfaces include less than this."""
BREADTH = 0.9
"""A thin spot holds a disc of about this diameter, mm; two lines of a common nozzle, half as much
again as letters are high. Every round spot of 1 mm2 does."""
COARSE = 5.0
"""Samples per mm2 that look for thin places: ten for a spot of 1 mm2, counting both its sides."""
FINE = 60.0
"""Samples per mm2 that measure a thin place: an eighth of a millimetre apart."""
MOST = 120_000
"""Fine samples at most; a part that is thin all over is sampled more coarsely."""
ROUGHLY = 30_000
"""The same where only the thinnest place is wanted: a small spot shows at a limit below it, finely."""
SEARCH = 1.4
"""Coarse samples up to this multiple of the limit are looked at closely: a ray along the normal
overestimates by up to 1 / FACING, and a spot may be thinnest between samples."""
ROUNDING = 6e-3
"""mm; a wall drawn at the limit may come out of chords (mesh_kernel.CHORD) and rounding so much thinner."""
AROUND = 1.0
"""How far around a thin place is looked at closely, mm: beyond the edge of a spot of BREADTH."""
EDGE_STEP = 0.2
"""Distance of samples along a sharp inner edge, mm."""
ASTRIDE = math.sin(math.radians(15.0))
"""A line to a sharp inner edge must meet both its faces at more than this: along a step's side runs
no wall."""
TURNS = 3
"""Times that a ray is turned towards the square to the surface that it struck."""
GLANCING = 0.3
"""Cosine up to which a struck surface may show the way to a nearer one that faces."""
NEIGHBOURS = 12
"""Nearest readings looked at for the edge of a spot: those of the wall's far side do not count."""
ABREAST = 0.5
"""Cosine of the angle under which the faces of a notch may be seen from below: so far to either side
of its edge the surface below it is as thin as its distance from that edge."""
STARTS = 4
"""Places of a spot from which its least thickness is searched."""
STEPS = 60
"""Slides at most; each halves the way left, more or less."""
SLACK = 0.02
"""Cosine; the chords of a curve around an end still belong to it."""


@dataclass(frozen=True)
class Spot:
    """A thin place: least `thickness` mm, from `point` to `opposite` (mm), over `area` mm2."""

    thickness: float
    area: float
    point: tuple[float, float, float]
    opposite: tuple[float, float, float]

    @property
    def middle(self) -> tuple[float, float, float]:
        return tuple((np.add(self.point, self.opposite) / 2).tolist())


@dataclass(frozen=True)
class Readings:
    """What the gauge reads at n places of the surface."""

    points: np.ndarray
    normals: np.ndarray
    thickness: np.ndarray
    """mm; inf where no surface faces this one."""
    opposite: np.ndarray
    parallel: np.ndarray
    """Cosine of the angle between the two surfaces; -1 where there is no wall."""
    towards: np.ndarray
    """Cosine between the far surface's normal and the line to it."""

    def where(self, chosen: np.ndarray) -> Readings:
        return Readings(*(getattr(self, name)[chosen] for name in self.__dataclass_fields__))

    def __add__(self, other: Readings) -> Readings:
        return Readings(*(np.concatenate([getattr(self, name), getattr(other, name)])
                          for name in self.__dataclass_fields__))


class Gauge:
    """Measures the walls of `mesh`, which is closed and wound outward (mm).

    Deterministic: the same triangles give the same readings.
    """

    def __init__(self, mesh: Triangles):
        self.surface = Surface(mesh.vertices, mesh.faces)

    @cached_property
    def walls(self) -> Readings:
        """The gauge at COARSE samples per mm2 of the whole surface."""
        return self._read(*self.surface.samples(COARSE), turns=0)

    def histogram(self, edges: np.ndarray) -> np.ndarray:
        """Area, mm2, of the surface under which the wall's thickness lies between `edges`, mm."""
        counts, _ = np.histogram(self.walls.thickness[self.walls.parallel > PARALLEL], edges)
        return counts * self.surface.area / len(self.walls.points)

    def least(self) -> Spot | None:
        """The thinnest wall; None for a body without walls.

        Found by raising a limit until a spot as broad as BREADTH lies below it.
        """
        walls = self.walls + self.contacts
        known = walls.thickness[walls.parallel > PARALLEL]
        if not len(known):
            return None
        limit, highest = 1.1 * known.min() + 0.05, 1.1 * known.max() + 0.1
        while not (spots := self.thin_spots(limit, ROUGHLY)) and limit < highest:
            limit *= 1.5
        return spots[0] if spots else None

    def thin_spots(self, limit: float, most: int = MOST) -> list[Spot]:
        """Places thinner than `limit` mm and at least BREADTH broad, the thinnest first.

        `most`: samples at most; the broader the thin places, the fewer it takes to see them.
        """
        walls, density = self._close_look(limit, most)
        thin = walls.thickness < limit - ROUNDING
        walls, core = _opened(walls, thin, self._edges, 1.0 / math.sqrt(density))
        labels = _clusters(walls, 3.0 / math.sqrt(density))
        seeds = core & (walls.parallel > PARALLEL)
        spots = [self._spot(walls.where((labels == label) & seeds), (labels == label).sum() / density / 2)
                 for label in np.unique(labels[seeds])]
        return sorted((s for s in spots if s.thickness < limit - ROUNDING), key=lambda s: s.thickness)

    def _close_look(self, limit: float, most: int) -> tuple[Readings, float]:
        """(readings around every place that may be thinner than `limit`, samples per mm2)."""
        reach = SEARCH * limit
        contacts = self.contacts.where(self.contacts.thickness < reach)
        places = np.vstack([self.walls.points[self.walls.thickness < reach], contacts.points])
        if not len(places):
            return self.walls.where(slice(0)), FINE
        points, faces, density = self.surface.samples_around(places, AROUND, FINE, most)
        return _with_edges(self._read(points, faces), contacts), density

    def _read(self, points: np.ndarray, faces: np.ndarray, turns: int = TURNS) -> Readings:
        """Set the gauge on `points` of `faces`: along the normal, then square to what was struck."""
        surface, normals = self.surface, self.surface.normals[faces]
        inward = -normals
        thickness, far, parallel = surface.shoot(points, inward)
        # The side of a small pit is struck first; its bottom, which faces, is found from there.
        index = np.flatnonzero((parallel > GLANCING) & (parallel < 1.0 - 1e-9))
        wall = parallel > FACING
        thickness, parallel = np.where(wall, thickness, np.inf), np.where(wall, parallel, -1.0)
        direction, towards, aim = inward.copy(), parallel.copy(), inward[index]
        struck = far[index]
        for _ in range(turns):
            # Halfway only: all the way, it would swing from side to side of a sharp bend.
            aim = aim + surface.normals[struck]
            aim /= np.linalg.norm(aim, axis=1)[:, None]
            distance, struck, square = surface.shoot(points[index], aim)
            facing = np.einsum("ij,ij->i", surface.normals[struck], inward[index])
            better = (struck >= 0) & (facing > FACING) & (distance < thickness[index] - 1e-6)
            at = index[better]
            thickness[at], direction[at], towards[at] = distance[better], aim[better], square[better]
            parallel[at] = facing[better]
        wall = parallel > FACING
        opposite = points + np.where(wall, thickness, 0.0)[:, None] * direction
        return Readings(points, normals, thickness, opposite, parallel, towards)

    @cached_property
    def _edges(self) -> Edges:
        return self.surface.sharp_edges(EDGE_STEP)

    @cached_property
    def contacts(self) -> Readings:
        """What faces the sharp inner edges squarely, read where it is nearest to the edge."""
        inner = self._edges.inner
        points, one, two = (v[inner] for v in (self._edges.points, self._edges.one, self._edges.two))
        found = []
        for share in (0.25, 0.5, 0.75):
            away = share * one + (1.0 - share) * two
            _, far, facing = self.surface.shoot(points, -away / np.linalg.norm(away, axis=1)[:, None])
            inward = self.surface.normals[far]
            astride = -np.maximum(np.einsum("ij,ij->i", one, inward), np.einsum("ij,ij->i", two, inward))
            faced = (facing > FACING) & (astride > ASTRIDE)
            start, inward = points[faced], inward[faced]
            distance, far, square = self.surface.shoot(start, inward)
            hit = square > PARALLEL
            struck = start + np.where(hit, distance, 0.0)[:, None] * inward
            normals = self.surface.normals[far]
            found.append(Readings(struck, normals, distance, start, square, astride[faced]).where(hit))
        return found[0] + found[1] + found[2]

    def _spot(self, seeds: Readings, area: float) -> Spot:
        """The exact least distance within a spot, from a few of its thinnest readings."""
        best = None
        left = seeds.where(np.argsort(seeds.thickness, kind="stable"))
        for _ in range(STARTS):
            pair = self._narrowest(left.where(slice(0, 1)))
            distance = math.dist(*pair)
            if best is None or distance < best.thickness:
                best = Spot(distance, float(area), *(tuple(p.tolist()) for p in pair))
            apart = np.linalg.norm(left.points - left.points[0], axis=1) > BREADTH
            left = left.where(apart)
            if not len(left.points):
                break
        return best

    def _narrowest(self, start: Readings) -> tuple[np.ndarray, np.ndarray]:
        """Slide the two ends of one reading along their surfaces until they are nearest."""
        surface = self.surface
        here, there, thickness = start.points[0], start.opposite[0], float(start.thickness[0])
        line = (there - here) / max(thickness, 1e-12)
        faces = surface.near(here, thickness + AROUND)
        along = surface.normals[faces] @ line
        # Only surfaces that face as the two ends do: never around a corner.
        near = faces[along < -min(PARALLEL, -start.normals[0] @ line) + SLACK]
        far = faces[along > min(PARALLEL, start.towards[0]) - SLACK]
        edge = start.towards[0] < FACING
        normal = start.normals[0]
        for _ in range(STEPS):
            before = thickness
            opposing = far if edge else far[surface.normals[far] @ normal < SLACK - PARALLEL]
            there, normal = _across(surface, opposing, here, line, (there, -normal))
            opposing = near if edge else near[surface.normals[near] @ normal < SLACK - PARALLEL]
            here, normal = _across(surface, opposing, there, -line, (here, -normal))
            thickness = math.dist(here, there)
            if before - thickness < 1e-6:
                break
        return here, there


_GAUGES: dict[int, Gauge] = {}


def gauge_of(mesh: Triangles) -> Gauge:
    """The gauge on `mesh`, made once for as long as its array of vertices lives."""
    key = id(mesh.vertices)
    if key not in _GAUGES:
        _GAUGES[key] = Gauge(mesh)
        weakref.finalize(mesh.vertices, _GAUGES.pop, key)
    return _GAUGES[key]


def _across(surface: Surface, faces: np.ndarray, point: np.ndarray, line: np.ndarray,
            known: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """(nearest point of `faces` to `point` that lies from it along `line`, normal), else `known`."""
    found = nearest(surface.corners[faces], point)
    step = found - point
    distance = np.linalg.norm(step, axis=1)
    present = math.dist(point, known[0])
    # What is very much nearer is no continuation of this wall but the face of another one.
    distance[(step @ line < FACING * distance) | (distance < FACING * present)] = np.inf
    if not len(distance) or distance.min() >= present:
        return known
    best = distance.argmin()
    return found[best], surface.normals[faces[best]]


def _with_edges(walls: Readings, edges: Readings) -> Readings:
    """Readings corrected where a sharp inner edge is nearer than what the ray struck."""
    from scipy.spatial import cKDTree

    if not len(edges.points) or not len(walls.points):
        return walls
    distance, index = cKDTree(edges.points).query(walls.points)
    line = edges.opposite[index] - walls.points
    length = np.maximum(np.linalg.norm(line, axis=1), 1e-12)
    parallel = -np.einsum("ij,ij->i", line, walls.normals) / length
    same = np.einsum("ij,ij->i", walls.normals, edges.normals[index]) > FACING
    nearer = same & (parallel > ABREAST) & (distance < length) & (length < walls.thickness)
    pick = nearer[:, None]
    return Readings(
        walls.points, walls.normals, np.where(nearer, length, walls.thickness),
        np.where(pick, edges.opposite[index], walls.opposite), np.where(nearer, parallel, walls.parallel),
        np.where(nearer, edges.towards[index], walls.towards))


def _opened(walls: Readings, thin: np.ndarray, edges: Edges, spacing: float) -> tuple[Readings, np.ndarray]:
    """(thin readings within discs of BREADTH that are thin all over, which are such a disc's centre).

    A disc ends where the wall is thicker and at the sharp edges of its surface.
    """
    from scipy.spatial import cKDTree

    inside, around = walls.where(thin), walls.where(~thin)
    reach = BREADTH / 2
    core = _clear(inside, around.points, around.normals, -ABREAST, reach)
    for normals in (edges.one, edges.two):
        core &= _clear(inside, edges.points, normals, FACING, reach)
    if not core.any():
        return inside.where(core), core[core]
    disc = cKDTree(inside.points[core]).query(inside.points, distance_upper_bound=reach + spacing)[0] < np.inf
    return inside.where(disc), core[disc]


def _clear(
    walls: Readings, points: np.ndarray, normals: np.ndarray, facing: float, reach: float,
) -> np.ndarray:
    """Which readings have none of `points` within `reach` mm whose normal agrees to cosine `facing`.

    By the normal, because the far side of a thin wall is no end of this side.
    """
    from scipy.spatial import cKDTree

    if not len(points) or not len(walls.points):
        return np.ones(len(walls.points), bool)
    k = min(NEIGHBOURS, len(points))
    distance, index = cKDTree(points).query(walls.points, k=k, distance_upper_bound=reach)
    distance, index = distance.reshape(-1, k), np.minimum(index.reshape(-1, k), len(points) - 1)
    agrees = np.einsum("ijk,ik->ij", normals[index], walls.normals) > facing
    return ~(agrees & (distance < np.inf)).any(axis=1)


def _clusters(walls: Readings, link: float) -> np.ndarray:
    """A label per reading: neighbours within about `link` mm, and both sides of a wall, are one spot."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not len(walls.points):
        return np.zeros(0, int)
    cells, cell = np.unique(np.floor(walls.points / link).astype(int), axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    tree = cKDTree(cells)
    pairs = tree.query_pairs(1.8, output_type="ndarray")
    distance, across = tree.query(np.floor(walls.opposite / link), distance_upper_bound=1.8)
    met = distance < np.inf
    one, two = np.r_[pairs[:, 0], cell[met]], np.r_[pairs[:, 1], across[met]]
    graph = coo_array((np.ones(len(one), bool), (one, two)), shape=(len(cells), len(cells)))
    return connected_components(graph, directed=False)[1][cell]
