"""The thumb's opposition hinge (Sections 3.2 and 4.2.3).

Two actuators lie side by side across a gap between the palm and the ball of the thumb. Only a
thin sheet on the palm side joins the two: everything above it is free, so the actuators'
elongation folds the sheet and turns the thumb to the palm. Their bases sit in sockets of the
palm, their tips in sockets of the ball; the thumb's own actuator goes in through the gap.

Hinge frame: u across the fold to the thumb, v along the fold to the wrist, w dorsal (mm).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from handgen.errors import GeometryError
from handgen.geometry import csg, palm
from handgen.geometry.palm import INSET, MARGIN, PART, STUB, Hole
from handgen.geometry.seals import FLANGE
from handgen.geometry.skin import Block, Common, Cone, Ellipsoid, Limb, fitted_loft
from handgen.parameters.model import OPPOSITION, Hand

FAR = 80.0
"""Beyond everything that the gap's cutters must reach, mm."""
RECESS = 0.5
"""How far the sheet's palm side lies inside the skin beside it, mm: no coincident faces."""
ANCHOR = 3.0
"""How far the sheet reaches into the walls of the gap, mm."""
TUBE_SLOPE = 7.0
"""How far towards the middle of the palm a tube's hole climbs before it meets a channel, mm."""
THENAR = (-9.0, 3.0, 2.0)
"""Middle of the palm's mass at the gap, mm in the hinge's frame: about the sockets."""
BALL = 5.0
"""How far behind the thumb's root, and how far palmar of it, the middle of its ball lies, mm."""
OBLIQUE = 0.3
"""Least cosine between the thumb's axis and the direction across the gap: below it, the bore
would run along the gap instead of opening into it."""


class Hinge:
    """The hinge of `hand`: its frame, and the solids and voids that make it work."""

    def __init__(self, hand: Hand):
        self.hand, self.o = hand, hand.opposition
        self.rotation = csg.rotation("z", self.o.direction)
        self.origin = tuple(self.o.origin)
        self.lines = dict(zip(OPPOSITION, (self.o.spacing / 2, -self.o.spacing / 2), strict=True))
        self.actuators = {n: getattr(hand.actuators, n) for n in OPPOSITION}
        widest = max(max(a.base_outer_diameter, a.tip_outer_diameter) for a in self.actuators.values())
        self.socket = widest / 2 + self.o.clearance
        self.top = -self.socket - self.o.clearance
        self.bottom = self.top - self.o.sheet_thickness
        self.back = -(self.o.base_socket + hand.seal.collar_length + FLANGE + self.o.clearance)

    def point(self, u: float, v: float, w: float) -> csg.Point3:
        """Hinge coordinates -> hand coordinates."""
        return tuple((np.array(self.rotation) @ (u, v, w) + np.array(self.origin)).tolist())

    def local(self, points: np.ndarray) -> np.ndarray:
        """Hand coordinates -> hinge coordinates."""
        return np.subtract(points, self.origin) @ np.array(self.rotation)

    @property
    def gap(self) -> csg.Shape:
        """All that is cut away between palm and ball, but for the wall of the nearest channel."""
        low, high = (0.0, -self.o.sheet_width, -FAR), (self.o.free_length, FAR, FAR)
        whole = csg.box(low, high).placed(self.rotation, self.origin)
        channel = palm.channels(self.hand)[0]
        wall, reach = self._wall_of(channel), 3 * FAR
        beside = csg.box((-reach, -reach, -wall), (reach, wall, reach))
        return whole - beside.placed(csg.rotation("z", channel.heading), channel.end)

    @property
    def opening(self) -> Common:
        """The gap above the sheet for the skin, INSET smaller: rims are rounded, then cut exactly.

        Those beside and below the sheet stay sharp, for it must join the walls in their full height.
        """
        low = (INSET, -self.o.sheet_width + INSET, self.top + self.o.sheet_fillet)
        high = (self.o.free_length - INSET, FAR, FAR)
        whole = Block(self.rotation, self.origin, low, high, INSET)
        channel = palm.channels(self.hand)[0]
        wall, reach = self._wall_of(channel) + INSET, 3 * FAR
        beside = Block(csg.rotation("z", channel.heading), channel.end, (-reach, wall, -reach),
                       (reach, reach, reach), INSET)
        return Common((whole, beside))

    def _wall_of(self, channel: Hole) -> float:
        """How far from a channel's axis the gap ends, mm."""
        return channel.radius + self.hand.palm.wall + MARGIN / 2

    def corner_room(self) -> float:
        """Distance, mm, of the sheet from the wall of the nearest channel, in the palm's plane."""
        channel, o = palm.channels(self.hand)[0], self.o
        normal = np.array(csg.rotation("z", channel.heading))[:, 1]
        corners = [self.point(u, -o.sheet_width / 2, 0.0) for u in (0.0, o.free_length)]
        return float(min(normal @ np.subtract(c, channel.end) for c in corners)) - self._wall_of(channel)

    @property
    def sheet(self) -> csg.Shape:
        """The palmar sheet, rounded into both walls and anchored in them."""
        o, top, r, length = self.o, self.top, self.o.sheet_fillet, self.o.free_length
        path = csg.Path((-ANCHOR, self.bottom), ())
        path = path.line((length + ANCHOR, self.bottom), (length + ANCHOR, top + r), (length, top + r))
        if r > 0.0:
            path = path.quarter((length, top), (length - r, top)).line((r, top))
            path = path.quarter((0.0, top), (0.0, top + r))
        flat = csg.Extrude(path.line((-ANCHOR, top + r)), o.sheet_width)
        return flat.turned("x", 90).moved(y=o.sheet_width / 2).placed(self.rotation, self.origin)

    def bases(self) -> list[Hole]:
        """Sockets of the actuators' bases and of the collars and plugs behind them."""
        return [
            Hole(f"{n} base", "opposition.origin", self.point(self.back, v, 0.0),
                 self.point(2 * MARGIN, v, 0.0), self.actuators[n].base_outer_diameter / 2 + self.o.clearance)
            for n, v in self.lines.items()
        ]

    def tips(self) -> list[Hole]:
        """Blind sockets of the actuators' tips in the ball of the thumb."""
        start, end = self.o.free_length - 2 * MARGIN, self.o.free_length + self.o.tip_socket
        return [
            Hole(f"{n} tip", "opposition.free_length", self.point(start, v, 0.0), self.point(end, v, 0.0),
                 self.actuators[n].tip_outer_diameter / 2 + self.o.clearance)
            for n, v in self.lines.items()
        ]

    def tubes(self) -> list[Hole]:
        """Tube holes: from both bases up into the bay, and from the gap into the nearest channel."""
        hand = self.hand
        radius = hand.seal.tube_outer_diameter / 2 + hand.palm.channel_clearance
        holes = palm.channels(hand)
        out = []
        for name, v in self.lines.items():
            start = self.point(self.back + radius, v, 0.0)
            aim = self.point(self.back - TUBE_SLOPE, v, holes[0].end[2] - self.origin[2])
            end = min((h.nearest(aim) for h in holes), key=lambda p: math.dist(p, aim))
            out.append(Hole(f"{name} tube", "opposition.origin", start, end, radius))
        start = self.point(2 * MARGIN, 0.0, holes[0].end[2] - self.origin[2])
        return [*out, Hole("thumb tube", "opposition.origin", start, holes[0].nearest(start), radius)]

    def thumb_bore(self) -> Hole:
        """The thumb's seat, carried on backwards until it is open to the gap all round.

        Raises:
            GeometryError: the thumb's axis runs along the gap.
        """
        rows, root = palm.finger_placement(self.hand, "thumb")
        across = float(np.array(self.rotation)[:, 0] @ np.array(rows)[:, 0])
        if across < OBLIQUE:
            raise GeometryError(PART, "fingers.thumb.placement.splay",
                                "the thumb's bore runs along the gap: its actuator cannot go in")
        depth = (float(self.local(root)[0]) - self.o.free_length / 2) / across
        return palm.seat(self.hand, "thumb", max(depth, MARGIN))

    def holes(self) -> list[Hole]:
        """All round holes of the hinge."""
        return [*self.bases(), *self.tips(), *self.tubes(), self.thumb_bore()]

    def limbs(self) -> list[Limb]:
        """The thenar mass and the ball of the thumb that hold all this, for the skin."""
        hand, o, middle = self.hand, self.o, self.o.free_length / 2
        soft = 1.2 * hand.palm.blend
        r = self.socket + hand.palm.wall - o.clearance
        wrist = hand.palm.sections[0]
        edge = (wrist.x, wrist.y + wrist.width / 2 - r, wrist.z - 2.0)
        depth = 0.5 - self.bottom + RECESS
        thenar = Ellipsoid(self.rotation, self.point(*THENAR), (o.thenar_across, o.thenar_along, depth))
        root, axis = (np.array(palm.on_axis(hand, "thumb", x)) for x in (0.0, 1.0))
        axis = axis - root
        heart = tuple((root - BALL * axis - (0.0, 0.0, BALL)).tolist())
        ball = Ellipsoid(palm.facing(axis), heart, tuple(o.ball))
        bore = self.thumb_bore()
        cover = bore.radius + hand.palm.wall
        seat = Limb((Cone(bore.start, palm.on_axis(hand, "thumb", 0.0), cover, cover),
                     *palm.finger_stub(hand, "thumb", cover)))
        side = Cone(edge, self.point(0.0, self.lines[OPPOSITION[0]] - 1.0, 1.0), 0.9 * r, 0.9 * r)
        return [
            Limb((side, self._pillow(self.back - 4.0, middle), thenar), soft),
            Limb((self._pillow(middle, o.free_length + o.tip_socket + 5.0), seat, ball), soft),
        ]

    def _pillow(self, u0: float, u1: float) -> Block:
        """A round cover of both actuators' sockets, wide enough below to take the sheet's corners."""
        o, r = self.o, self.socket + self.hand.palm.wall - self.o.clearance
        soft = 0.95 * r
        corner = soft - math.sqrt(soft**2 - (soft - RECESS) ** 2)
        side = max(o.spacing / 2 + r, o.sheet_width / 2 + corner)
        return Block(self.rotation, self.origin, (u0, -side, self.bottom - RECESS), (u1, side, r), soft)

    def unblended(self) -> list[csg.Shape]:
        """Thenar mass, ball and thumb seat for the B-rep."""
        length = self.o.free_length
        palm_side, ball = self.limbs()
        spans = ((palm_side, self.back - 4.0, 4.0), (ball, length - 4.0, length + self.o.tip_socket + 11.0))
        lofts = [fitted_loft(limb, self.rotation, self.origin, np.linspace(a, b, 5).tolist())
                 for limb, a, b in spans]
        radius = self.hand.fingers.thumb.base_outer_diameter / 2 - INSET
        end = palm.on_axis(self.hand, "thumb", STUB)
        return [*lofts, replace(self.thumb_bore(), end=end, radius=radius).shape]
