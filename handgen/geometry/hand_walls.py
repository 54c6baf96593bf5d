"""Does the hand hold together? Walls between its holes and around them, before it is built.

Channels and seats have their covers and every socket its pillow, so most walls are there by
construction; what parameters can still spoil is read here from the holes and the skin's field.
Distances are exact for round holes and true to a few per cent for the skin.
"""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np

from handgen.errors import GeometryError
from handgen.geometry import palm
from handgen.geometry.palm import PART, Hole
from handgen.geometry.profile import FingerProfile
from handgen.geometry.skin import Skin
from handgen.geometry.thumb import Hinge
from handgen.parameters.model import Hand

LEAST = 1.5
"""Thinnest wall that is built, mm: four lines of a 0.35 mm nozzle; `checks` judges by its own."""
APART = 0.3
"""Least distance of two neighbouring fingers, mm: nearer, they would print as one."""
STEP = 1.5
"""Distance of the samples on a hole's surface, mm."""


def check(hand: Hand, skin: Skin, hinge: Hinge | None) -> None:
    """Refuse a hand that would not hold together.

    Raises:
        GeometryError: fingers overlap, a wall is thinner than LEAST, or the hinge does not fit;
            names the parameter to change.
    """
    _fingers_apart(hand)
    _seats_apart(hand)
    if hinge:
        _hinge_fits(hand, hinge)
        _pockets_closed(hand, skin, hinge)


def _fingers_apart(hand: Hand) -> None:
    fingers = hand.fingers.present()
    lines = {}
    for name, finger in fingers.items():
        x = np.arange(0.0, finger.outer_length, 2.0)
        rows, origin = palm.finger_placement(hand, name)
        lines[name] = np.outer(x, np.array(rows)[:, 0]) + origin, FingerProfile(finger).outer_radius(x)
    for a, b in combinations(lines, 2):
        (p, r), (q, s) = lines[a], lines[b]
        room = np.linalg.norm(p[:, None] - q, axis=2) - r[:, None] - s
        if room.min() < APART:
            at_root = np.unravel_index(room.argmin(), room.shape)[0] * 2.0 < fingers[a].outer_length / 2
            key = "root" if at_root else "splay"
            raise GeometryError(PART, f"fingers.{b}.placement.{key}",
                                f"{a} and {b} are {room.min():.2f} mm apart; at least {APART} mm are needed")


def _seats_apart(hand: Hand) -> None:
    """Between two seats, and the channels as far as `junctions` keeps them apart."""
    depth = hand.seal.collar_length
    seats = [(n, palm.seat(hand, n, depth)) for n in palm.row(hand)]
    for (a, first), (b, second) in pairwise(seats):
        wall = _between(first, second)
        if wall < LEAST:
            raise GeometryError(PART, f"fingers.{b}.placement.root",
                                f"the seats of {a} and {b} leave {wall:.2f} mm of wall, less than {LEAST} mm")


def _hinge_fits(hand: Hand, hinge: Hinge) -> None:
    room = hinge.corner_room()
    if room < 0.0:
        raise GeometryError(PART, "opposition.origin",
                            f"the sheet reaches {-room:.2f} mm into the wall of the nearest channel")
    root = float(hinge.local(hand.fingers.thumb.placement.root)[0])
    if root < hinge.o.free_length + LEAST:
        raise GeometryError(PART, "fingers.thumb.placement.root",
                            "the thumb's root stands in the gap of the opposition hinge")


def _pockets_closed(hand: Hand, skin: Skin, hinge: Hinge) -> None:
    bases, tips, bore = hinge.bases(), hinge.tips(), hinge.thumb_bore()
    channels = palm.channels(hand)
    *tubes, thumb_tube = hinge.tubes()
    pairs = [*combinations(bases, 2), *((b, c) for b in bases for c in (*channels, thumb_tube)),
             *combinations(tips, 2), *((t, bore) for t in tips)]
    for hole, other in pairs:
        wall = _between(hole, other, hinge)
        if wall < LEAST:
            raise GeometryError(PART, hole.path, f"{hole.name} and {other.name} leave a wall of"
                                                 f" {wall:.2f} mm, less than {LEAST} mm")
    for hole in (*bases, *tips, *tubes):
        points = _walled(_surface(hole), hinge)
        wall = -float(skin.distance(points).max())
        if wall < LEAST:
            raise GeometryError(PART, hole.path, f"{hole.name} breaks through: {wall:.2f} mm of wall"
                                                 f" are left, less than {LEAST} mm")


def _between(a: Hole, b: Hole, hinge: Hinge | None = None) -> float:
    """Thickness of the wall between two holes, mm; with a hinge, outside its gap."""
    points = _surface(a)
    if hinge:
        points = _walled(points, hinge)
    axis = np.subtract(b.end, b.start)
    length = np.linalg.norm(axis)
    along = (points - b.start) @ (axis / length)
    across = np.sqrt(np.maximum(((points - b.start) ** 2).sum(axis=1) - along**2, 0.0)) - b.radius
    beyond = np.maximum(-along, along - length)
    outside = np.hypot(np.maximum(across, 0.0), np.maximum(beyond, 0.0))
    return float((outside + np.minimum(np.maximum(across, beyond), 0.0)).min())


def _walled(points: np.ndarray, hinge: Hinge) -> np.ndarray:
    """Those of `points` that lie beside the gap, where a wall has to be."""
    u = hinge.local(points)[:, 0]
    return points[(u <= 0.0) | (u >= hinge.o.free_length)]


def _surface(hole: Hole) -> np.ndarray:
    """Samples (n, 3) of a hole's mantle and of its far rim's disc."""
    rows = np.array(palm.facing(np.subtract(hole.end, hole.start) / hole.length))
    around = np.linspace(0.0, 2 * np.pi, max(24, int(2 * np.pi * hole.radius / STEP)), endpoint=False)
    x = np.linspace(0.0, hole.length, max(8, int(hole.length / STEP)))
    ring = hole.radius * np.c_[np.cos(around), np.sin(around)]
    points = [np.c_[np.full(len(ring), s), ring] for s in x]
    points += [np.c_[np.full(len(ring), s), f * ring] for s in (0.0, hole.length) for f in (0.0, 0.4, 0.8)]
    return np.vstack(points) @ rows.T + hole.start
