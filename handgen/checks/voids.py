"""The hand's bores, channels and pockets by name, and what each may open into.

Everything is round about a straight axis, so that it is known exactly where a wall has to be.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from handgen.geometry import csg, palm
from handgen.geometry.bay import junctions
from handgen.geometry.mesh_kernel import evaluate
from handgen.geometry.palm import Hole
from handgen.geometry.profile import FingerProfile
from handgen.geometry.thumb import Hinge
from handgen.parameters.model import OPPOSITION, Hand

FIT = 0.05
"""A place this near to a void belongs to it, mm: cutters overlap, chords fall short."""
STEP = 0.4
"""Distance of the places at which a void's wall is asked for, mm: a hole of a line's width is met."""
OPEN_END = 0.5
"""How far before an end the places on the mantle stop, mm: ends meet their neighbours there."""


@dataclass(frozen=True)
class Void:
    """A round hollow: its radius along the axis, whose actuator it is for, what it may open into.

    `rows` are the axes as columns, x along the hollow; `into` are the names of other voids.
    `closed` are the stretches of the axis along which a wall must lie all round, mm from `start`;
    `strips` those with a wall on the palmar side only, each with its arc in degrees.
    """

    name: str
    owner: str
    path: str
    start: np.ndarray
    rows: np.ndarray
    length: float
    radius: Callable[[np.ndarray], np.ndarray]
    into: tuple[str, ...]
    closed: tuple[tuple[float, float], ...]
    blind: bool
    strips: tuple[tuple[float, float, float], ...] = ()

    def holds(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """Which points (n, 3) lie inside, or within `margin` mm of it."""
        ends = np.array([self.start, self.start + self.length * self.rows[:, 0]])
        reach = self.widest + margin
        inside = ((points > ends.min(axis=0) - reach) & (points < ends.max(axis=0) + reach)).all(axis=1)
        x, y, z = ((points[inside] - self.start) @ self.rows).T
        within = (x > -margin) & (x < self.length + margin)
        inside[inside] = within & (np.hypot(y, z) < self.radius(np.clip(x, 0.0, self.length)) + margin)
        return inside

    @cached_property
    def widest(self) -> float:
        """Largest radius, mm."""
        return float(np.max(self.radius(np.linspace(0.0, self.length, 9))))

    def wall(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Where a wall must be: (points in the hollow, directions, distances to the wall, mm2 each)."""
        origins, directions, distances = [], [], []
        turns = np.linspace(0.0, 2 * np.pi, max(12, int(2 * np.pi * self.widest / STEP)), endpoint=False)
        around = np.c_[np.zeros(len(turns)), np.cos(turns), np.sin(turns)]
        for low, high, arc in (*((*ends, 360.0) for ends in self.closed), *self.strips):
            # As far from a strip's edges as from its ends.
            half = np.deg2rad(arc / 2) - (OPEN_END / self.widest if arc < 360.0 else -1.0)
            there = around[np.arccos(np.clip(-around[:, 2], -1.0, 1.0)) < half]
            for x in np.arange(low + STEP / 2, high, STEP):
                origins.append(np.tile((x, 0.0, 0.0), (len(there), 1)))
                directions.append(there)
                distances.append(np.full(len(there), float(self.radius(np.array(x)))))
        if self.blind:
            end = float(self.radius(np.array(self.length)))
            for r in np.arange(STEP / 2, end - OPEN_END, STEP):
                some = around[:: max(1, int(len(turns) * (1 - r / end)))]
                origins.append(some * r + (self.length - 2 * OPEN_END, 0.0, 0.0))
                directions.append(np.tile((1.0, 0.0, 0.0), (len(some), 1)))
                distances.append(np.full(len(some), 2 * OPEN_END))
        if not origins:
            return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), STEP**2
        origin, direction = np.vstack(origins), np.vstack(directions)
        return origin @ self.rows.T + self.start, direction @ self.rows.T, np.concatenate(distances), STEP**2


@dataclass(frozen=True)
class Region:
    """A place that voids may open into without being one: the wrist, the hinge's gap, the bay."""

    planes: tuple[tuple[np.ndarray, float], ...]
    """(outward normal, distance from the origin) of the half-spaces that meet in it."""

    def holds(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        return np.all([points @ normal < distance + margin for normal, distance in self.planes], axis=0)


def voids(hand: Hand) -> list[Void]:
    """All voids of a right hand's exoskeleton, in its frame."""
    names = palm.row(hand)
    channels = palm.channels(hand)
    depth = hand.seal.collar_length
    hinge = Hinge(hand) if hand.opposition else None
    tubes = tuple(hole.name for hole in hinge.tubes()) if hinge else ()
    every = tuple(c.name for c in channels)
    found = [_hole(c, n, (*every, *tubes, f"{n} seat", "bay", "wrist"))
             for n, c in zip(names, channels, strict=True)]
    found += [_hole(palm.seat(hand, n, depth), n, (f"{n} channel",), short=palm.MARGIN) for n in names]
    found += [_bore(hand, n) for n in hand.fingers.present()]
    if hinge:
        found.append(_hole(hinge.thumb_bore(), "thumb", ("gap",), short=palm.MARGIN))
        *base_tubes, wall_hole = hinge.tubes()
        for name, base, tip, tube in zip(OPPOSITION, hinge.bases(), hinge.tips(), base_tubes, strict=True):
            found += [_hole(base, name, ("gap", tube.name)), _hole(tip, name, ("gap",), blind=True),
                      _hole(tube, name, (base.name, *every))]
        # Only a hole through the wall between the gap and a channel: it is open at both ends.
        found.append(replace(_hole(wall_hole, "thumb", ()), closed=()))
    return found


def regions(hand: Hand) -> dict[str, list[Region]]:
    """The regions of a right hand that voids may open into, by name."""
    found = {"wrist": [Region(((np.array((1.0, 0.0, 0.0)), 0.0),))],
             "bay": [_convex(shape) for shape in junctions(hand)]}
    if hand.opposition:
        across = np.array(csg.rotation("z", hand.opposition.direction))[:, 0]
        low = float(across @ np.array(hand.opposition.origin))
        found["gap"] = [Region(((across, low + hand.opposition.free_length), (-across, -low)))]
    return found


def _hole(hole: Hole, owner: str, into: tuple[str, ...], short: float = 0.0, blind: bool = False) -> Void:
    """A void from a hole of the geometry; `short`: how far before its end another void takes over."""
    rows = np.array(palm.facing(np.subtract(hole.end, hole.start) / hole.length))
    return Void(hole.name, owner, hole.path, np.array(hole.start), rows, hole.length,
                lambda x: np.full(np.shape(x), hole.radius), into,
                ((OPEN_END, hole.length - short - OPEN_END),), blind)


def _bore(hand: Hand, name: str) -> Void:
    """A finger's bore, in the hand."""
    rows, origin = palm.finger_placement(hand, name)
    return replace(alone(hand, name), start=np.array(origin), rows=np.array(rows))


def alone(hand: Hand, name: str) -> Void:
    """A finger's bore, in the finger's own frame.

    Of a finger printed with rest angles only as far as its axis is straight.
    """
    f = getattr(hand.fingers, name)
    profile = FingerProfile(f)
    curled = any(j.rest_angle for j in f.joints)
    length = palm.first_slot(f) if curled else f.inner_length
    slots = [] if curled else [
        (j.position - j.slot_length / 2, j.position + j.slot_length / 2) for j in f.joints]
    starts, ends = [0.0, *(b for _, b in slots)], [*(a for a, _ in slots), length]
    closed = tuple((a + OPEN_END, b - OPEN_END) for a, b in zip(starts, ends, strict=True))
    strips = () if curled else tuple(
        (a - OPEN_END, b + OPEN_END, j.palmar_arc) for (a, b), j in zip(slots, f.joints, strict=True))
    return Void(f"{name} bore", name, f"fingers.{name}", np.zeros(3), np.eye(3), length,
                profile.bore, (f"{name} seat",), closed, not curled, strips)


def _convex(shape: csg.Shape) -> Region:
    """The convex hull of `shape`: a twisted junction is all but convex."""
    mesh = evaluate(shape).hull().to_mesh()
    a, b, c = mesh.vert_properties[:, :3].astype(float)[mesh.tri_verts].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return Region(tuple(zip(normals, np.einsum("ij,ij->i", normals, a), strict=True)))
