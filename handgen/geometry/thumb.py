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
from handgen.geometry import csg
from handgen.geometry.palm import INSET, MARGIN, PART, STUB, Hole, channels, facing, finger_placement, finger_stub, on_axis
from handgen.geometry.skin import Block, Cone, Ellipsoid, Limb, fitted_loft
from handgen.parameters.model import OPPOSITION, Hand

FAR = 80.0
"""Beyond everything that the gap's cutters must reach, mm."""
RECESS = 0.5
"""How far the sheet's palm side lies inside the skin beside it, mm: no coincident faces."""


class Hinge:
    """The hinge of `hand`: its frame, and the solids and voids that make it work."""

    def __init__(self, hand: Hand):
        self.hand, self.o = hand, hand.opposition
        self.rotation = csg.rotation("z", self.o.direction)
        self.origin = tuple(self.o.origin)
        diameter = max(getattr(hand.actuators, n).base_outer_diameter for n in OPPOSITION)
        self.socket_radius = diameter / 2 + self.o.clearance
        self.top = -self.socket_radius - self.o.clearance
        self.bottom = self.top - self.o.sheet_thickness
        self.seat_end = -(self.o.base_socket + hand.seal.collar_length)
        self.rows = (self.o.spacing / 2, -self.o.spacing / 2)

    def point(self, u: float, v: float, w: float) -> csg.Point3:
        """Hinge coordinates -> hand coordinates."""
        return tuple((np.array(self.rotation) @ (u, v, w) + np.array(self.origin)).tolist())

    def local(self, point) -> np.ndarray:
        """Hand coordinates -> hinge coordinates."""
        return np.array(self.rotation).T @ np.subtract(point, self.origin)

    def placed(self, shape: csg.Shape) -> csg.Shape:
        return shape.placed(self.rotation, self.origin)

    @property
    def gap(self) -> csg.Shape:
        """All that is cut away between palm and ball, but for the wall of the nearest channel."""
        whole = self.placed(csg.box((0.0, -self.o.sheet_width, -FAR), (self.o.free_length, FAR, FAR)))
        return whole - self._beside_channel()

    def _beside_channel(self) -> csg.Shape:
        """The half-space on the palm's side of the wall of the channel nearest to the thumb."""
        channel = channels(self.hand)[0]
        wall = channel.radius + self.hand.palm.wall + 2 * MARGIN
        heading = math.degrees(math.atan2(channel.end[1] - channel.start[1], channel.end[0] - channel.start[0]))
        reach = 3 * FAR
        half = csg.box((-reach, -reach, -wall), (reach, wall, reach))
        return half.placed(csg.rotation("z", heading), channel.end)

    @property
    def sheet(self) -> csg.Shape:
        """The palmar sheet, rounded into both walls, reaching a little into them."""
        o, top, r = self.o, self.top, self.o.sheet_fillet
        length, stub = o.free_length, 3.0
        path = csg.Path((-stub, self.bottom), ()).line((length + stub, self.bottom), (length + stub, top + r))
        path = path.line((length, top + r)).quarter((length, top), (length - r, top))
        path = path.line((r, top)).quarter((0.0, top), (0.0, top + r)).line((-stub, top + r))
        return self.placed(csg.Extrude(path, o.sheet_width).turned("x", 90).moved(y=o.sheet_width / 2))

    def holes(self) -> list[Hole]:
        """Sockets, collar seats and tube holes of both actuators; the thumb's bore and tube hole."""
        o, hand = self.o, self.hand
        tube = hand.seal.tube_outer_diameter / 2 + hand.palm.channel_clearance
        out = []
        for name, v in zip(OPPOSITION, self.rows, strict=True):
            actuator, where = getattr(hand.actuators, name), f"{name} "
            base = actuator.base_outer_diameter / 2
            tip = actuator.tip_outer_diameter / 2
            end = self.seat_end
            out += [
                Hole(where + "base", "opposition.origin", self.point(-o.base_socket, v, 0.0),
                     self.point(2 * MARGIN, v, 0.0), base + o.clearance),
                Hole(where + "seat", "opposition.origin", self.point(end, v, 0.0),
                     self.point(0.0, v, 0.0), base + hand.palm.seat_clearance),
                Hole(where + "tip", "opposition.free_length", self.point(o.free_length - 2 * MARGIN, v, 0.0),
                     self.point(o.free_length + o.tip_socket, v, 0.0), tip + o.clearance),
                Hole(where + "tube", "opposition.origin", self.point(end + 2 * tube, v, 0.0),
                     self.point(end + 2 * tube + o.origin[2], v, -o.origin[2]), tube),
            ]
        return [*out, self.thumb_bore(), self._thumb_tube(tube)]

    def thumb_bore(self) -> Hole:
        """The thumb's seat, carried on backwards until it is open to the gap all round."""
        thumb = self.hand.fingers.thumb
        forward = np.array(finger_placement(self.hand, "thumb")[0])[:, 0]
        root = self.local(thumb.placement.root)
        across = float(np.array(self.rotation)[:, 0] @ forward)
        if across < 0.3:
            raise GeometryError(PART, "fingers.thumb.placement.splay",
                                "the thumb's bore runs along the gap: its actuator cannot go in")
        radius = thumb.base_bore_diameter / 2 + self.hand.palm.seat_clearance
        back = (root[0] - self.o.free_length / 2) / across
        start = on_axis(self.hand, "thumb", -back)
        return Hole("thumb seat", "fingers.thumb.placement.root", start,
                    on_axis(self.hand, "thumb", thumb.joints[0].position - thumb.joints[0].slot_length / 2 + MARGIN),
                    radius)

    def _thumb_tube(self, radius: float) -> Hole:
        """From the gap through the palm-side wall into the nearest channel, at its height."""
        channel = channels(self.hand)[0]
        start = self.point(2 * MARGIN, 0.0, channel.end[2] - self.origin[2])
        u = np.array(self.rotation)[:, 0]
        along = np.subtract(channel.end, channel.start)
        # Solve start - s u = channel.start + t along in the palm's plane.
        s, _ = np.linalg.solve(np.c_[-u[:2], -along[:2]], np.subtract(channel.start, start)[:2])
        return Hole("thumb tube", "opposition.origin", start, tuple((start - s * u).tolist()), radius)

    def unblended(self) -> list[csg.Shape]:
        """Thenar mass, ball and thumb seat for the B-rep."""
        o, bore = self.o, self.thumb_bore()
        cover = self.hand.fingers.thumb.base_outer_diameter / 2 - INSET
        end = on_axis(self.hand, "thumb", STUB)
        palm_side, ball = self.limbs()
        across = o.free_length + o.tip_socket + 11.0
        return [
            fitted_loft(palm_side, self.rotation, self.origin, np.linspace(self.seat_end - 7.0, 4.0, 5).tolist()),
            fitted_loft(ball, self.rotation, self.origin, np.linspace(o.free_length - 4.0, across, 5).tolist()),
            replace(bore, end=end, radius=cover).shape,
        ]

    def limbs(self) -> list:
        """The ball of the thumb and the thenar mass that hold all this, for the skin."""
        o, hand = self.o, self.hand
        wall, length = hand.palm.wall, o.free_length
        r = self.socket_radius + wall - o.clearance
        soft = 0.95 * r
        side = max(o.spacing / 2 + r,
                   o.sheet_width / 2 + soft - math.sqrt(soft**2 - (soft - RECESS) ** 2))
        low, high = self.bottom - RECESS, r
        middle = length / 2

        def pillow(u0: float, u1: float) -> Block:
            return Block(self.rotation, self.origin, (u0, -side, low), (u1, side, high), soft)

        wrist = hand.palm.sections[0]
        edge = (wrist.x, wrist.y + wrist.width / 2 - r, wrist.z - 2.0)
        root, axis = np.array(on_axis(hand, 'thumb', 0.0)), np.array(finger_placement(hand, 'thumb')[0])[:, 0]
        bore = self.thumb_bore()
        cover = bore.radius + wall
        soft_blend = 1.2 * hand.palm.blend
        ball = Ellipsoid(facing(axis), tuple((root - 5.0 * axis - (0, 0, 5.0)).tolist()), (15.0, 12.5, 14.0))
        thenar = Ellipsoid(self.rotation, self.point(-9.0, 3.0, 2.0), (15.0, 18.0, 0.5 - low))
        stub = Limb((Cone(bore.start, on_axis(hand, "thumb", 0.0), cover, cover), *finger_stub(hand, "thumb", cover)))
        return [
            Limb((Cone(edge, self.point(0.0, self.rows[0] - 1.0, 1.0), 0.9 * r, 0.9 * r), pillow(self.seat_end - 4.0, middle), thenar), soft_blend),
            Limb((pillow(middle, length + o.tip_socket + 4.0), stub, ball), soft_blend),
        ]
