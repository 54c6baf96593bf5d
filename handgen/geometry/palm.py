"""The palm: where the fingers stand, the channels that lead to their bores, the skin around them.

Every finger's bore carries on behind its root plane as a seat for the actuator's collar and then
as a straight channel to the wrist's mouth. Towards the wrist the channels run into one another,
two and two: the bays (`geometry.bay`), through which the actuators are pushed in and in which the
tubes lie.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from handgen.errors import GeometryError
from handgen.geometry import csg
from handgen.geometry.skin import Cone, Ellipsoid, Limb, Slab
from handgen.parameters.finger import Finger
from handgen.parameters.model import Hand
from handgen.parameters.palm import Palm

PART = "exoskeleton/hand"
MARGIN = 1.0
"""How far cutters overshoot, mm."""
INSET = 0.4
"""How far the skin stays inside a finger's own surface where nothing blends with it, mm: the
finger is united with it exactly, and two surfaces that nearly coincide make slivers."""
STUB = 2.0
"""How far past the root plane the skin follows a finger, mm; farther, the blend would fill the
narrow space between two neighbours."""


@dataclass(frozen=True)
class Hole:
    """A round hole: `radius` mm about the straight axis from `start` to `end`."""

    name: str
    path: str
    start: csg.Point3
    end: csg.Point3
    radius: float

    @property
    def length(self) -> float:
        return math.dist(self.start, self.end)

    @property
    def shape(self) -> csg.Shape:
        direction = np.subtract(self.end, self.start) / self.length
        return csg.cylinder(self.radius, 0.0, self.length).placed(facing(direction), self.start)

    @property
    def heading(self) -> float:
        """Angle of the axis to x in the palm's plane, degrees."""
        return math.degrees(math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0]))

    def nearest(self, point: Sequence[float]) -> csg.Point3:
        """The point of the axis, between its ends, that is nearest to `point`."""
        a, axis = np.array(self.start), np.subtract(self.end, self.start)
        share = min(max(float(np.subtract(point, a) @ axis / (axis @ axis)), 0.0), 1.0)
        return tuple((a + share * axis).tolist())

    def at(self, x: float) -> np.ndarray:
        """The point of the (endless) axis at hand coordinate x."""
        a, b = np.array(self.start), np.array(self.end)
        return a + (b - a) * (x - a[0]) / (b[0] - a[0])


def facing(direction: Sequence[float]) -> tuple:
    """Rotation rows that turn x into `direction` (a unit vector), keeping y level."""
    x = np.array(direction, float)
    level = np.array([-x[1], x[0], 0.0])
    y = level / np.linalg.norm(level) if np.linalg.norm(level) > 1e-9 else np.array([0.0, 1.0, 0.0])
    return tuple(map(tuple, np.c_[x, y, np.cross(x, y)].tolist()))


def finger_placement(hand: Hand, name: str) -> tuple[tuple, csg.Point3]:
    """(rotation rows, origin) that carry finger `name` from its own frame to a right hand's."""
    place = getattr(hand.fingers, name).placement
    turns = (csg.rotation("z", place.splay), csg.rotation("y", place.palmar_tilt),
             csg.rotation("x", -place.roll))
    rows = np.linalg.multi_dot([np.array(t) for t in turns])
    return tuple(map(tuple, rows.tolist())), tuple(place.root)


def on_axis(hand: Hand, name: str, x: float) -> csg.Point3:
    """The point of finger `name`'s (straight) axis `x` mm from its root, hand frame."""
    rows, origin = finger_placement(hand, name)
    return tuple((np.array(origin) + x * np.array(rows)[:, 0]).tolist())


def first_slot(finger: Finger) -> float:
    """Where the first joint's slot begins, mm from the root: skin must end before."""
    joint = finger.joints[0]
    return joint.position - joint.slot_length / 2


def row(hand: Hand) -> list[str]:
    """The fingers whose channels open at the wrist, from the thumb's side on."""
    names = [n for n in hand.fingers.present() if n != "thumb" or hand.opposition is None]
    return sorted(names, key=lambda n: -getattr(hand.fingers, n).placement.root[1])


def seat(hand: Hand, name: str, depth: float) -> Hole:
    """The collar's seat: from `depth` behind the root plane through the finger's first phalanx."""
    finger = getattr(hand.fingers, name)
    return Hole(f"{name} seat", f"fingers.{name}.placement.root", on_axis(hand, name, -depth),
                on_axis(hand, name, first_slot(finger) + MARGIN),
                finger.base_bore_diameter / 2 + hand.palm.seat_clearance)


def channels(hand: Hand) -> list[Hole]:
    """One straight channel a finger of the `row`, from the wrist's mouth to the finger's seat.

    Raises:
        GeometryError: the mouth is narrower than a channel.
    """
    palm, names = hand.palm, row(hand)
    fingers = [getattr(hand.fingers, n) for n in names]
    radii = [f.base_bore_diameter / 2 + palm.channel_clearance for f in fingers]
    roots = [f.placement.root[1] for f in fingers]
    wrist = palm.sections[0]
    if palm.mouth < 2 * max(radii):
        raise GeometryError(PART, "palm.mouth", f"no room for a channel of {2 * max(radii):.1f} mm")
    result = []
    for name, radius, y in zip(names, radii, _mouths(palm, radii, roots), strict=True):
        end = np.array(on_axis(hand, name, -hand.seal.collar_length))
        mouth = np.array([wrist.x, y, wrist.z])
        step = (end - mouth) / np.linalg.norm(end - mouth)
        start = mouth - step * 2 * radius
        result.append(Hole(f"{name} channel", f"fingers.{name}.placement.root",
                           tuple(start.tolist()), tuple((end + MARGIN / 2 * step).tolist()), radius))
    return result


def _mouths(palm: Palm, radii: list[float], roots: list[float]) -> list[float]:
    """y of every channel at the wrist's mouth, mm.

    Two and two they share a bay, with a wall from one bay to the next: a roof over more than two
    channels, printed lying, is too wide to rise to its ridge by itself. A mouth too narrow for
    walls has its channels as the roots stand.
    """
    high, low = (palm.sections[0].y + side * palm.mouth / 2 for side in (1, -1))
    pairs = [radii[i:i + 2] for i in range(0, len(radii), 2)]
    spare = palm.mouth - palm.wall * (len(pairs) - 1) - sum(p[0] + p[-1] for p in pairs)
    if len(radii) < 3 or spare < 0.0:
        first, last = high - radii[0], low + radii[-1]
        span = roots[0] - roots[-1]
        return [last + ((y - roots[-1]) / span if span > 0.0 else 0.5) * (first - last) for y in roots]
    shares = [min(spare / (len(radii) // 2), sum(p) + palm.wall) if len(p) == 2 else 0.0 for p in pairs]
    between = palm.wall + (spare - sum(shares)) / (len(pairs) - 1)
    result, edge = [], high
    for pair, share in zip(pairs, shares, strict=True):
        result += [edge - pair[0], edge - pair[0] - share][:len(pair)]
        edge = result[-1] - pair[-1] - between
    return result


def core(hand: Hand) -> list:
    """The palm's body and a round cover on every channel and seat (`bay.roofs` covers the bays)."""
    palm = hand.palm
    slab = Slab(tuple((s.x - (10.0 if i == 0 else 0.0), s.y, s.z, s.width, s.thickness)
                      for i, s in enumerate(palm.sections)), palm.exponent, 8.0)
    result: list = [slab]
    for name, hole in zip(row(hand), channels(hand), strict=True):
        cover = hole.radius + palm.wall
        result.append(Limb((Cone(hole.start, hole.end, cover, cover), *finger_stub(hand, name, cover))))
    return result


def fullness(hand: Hand) -> list:
    """What makes a palm of it: knuckles, webs, the mass below the little finger."""
    names, last = row(hand), channels(hand)[-1]
    x, y, z = last.at(0.38 * last.end[0])
    return [
        *(_knuckle(hand, name) for name in names),
        *(_web(hand, a, b) for a, b in pairwise(names)),
        Ellipsoid(csg.rotation("z", last.heading), (x, y - 1.0, z - hand.palm.hypothenar_drop),
                  tuple(hand.palm.hypothenar)),
    ]


def covers(hand: Hand) -> list[Hole]:
    """Round solids from inside the palm to the finger roots, for the B-rep."""
    return [
        Hole(name, "", on_axis(hand, name, -hand.seal.collar_length - MARGIN), on_axis(hand, name, STUB),
             getattr(hand.fingers, name).base_outer_diameter / 2 - INSET)
        for name in row(hand)
    ]


def finger_stub(hand: Hand, name: str, cover: float) -> list[Cone]:
    """The cover of a seat and the finger's first millimetres, just inside its own surface."""
    finger = getattr(hand.fingers, name)
    root = finger.base_outer_diameter / 2 - INSET
    return [
        Cone(on_axis(hand, name, -hand.seal.collar_length), on_axis(hand, name, 0.0), cover, root),
        Cone(on_axis(hand, name, 0.0), on_axis(hand, name, STUB), root, root),
    ]


def _knuckle(hand: Hand, name: str) -> Ellipsoid:
    """Fullness on the back of a root; its blend ends before the first slot."""
    finger = getattr(hand.fingers, name)
    rows, _ = finger_placement(hand, name)
    radius = finger.base_outer_diameter / 2
    reach = first_slot(finger) - MARGIN - 0.6 * hand.palm.blend
    x, y, z = on_axis(hand, name, reach - 1.2 * radius)
    return Ellipsoid(rows, (x, y, z + 1.0), (1.2 * radius, radius, radius))


def _web(hand: Hand, a: str, b: str) -> Cone:
    """Skin between two neighbouring fingers, `web` past their roots."""
    radius = 5.0
    ends = [np.add(on_axis(hand, n, hand.palm.web - radius), (0.0, 0.0, -1.5)) for n in (a, b)]
    return Cone(*(tuple(e.tolist()) for e in ends), radius, radius)
