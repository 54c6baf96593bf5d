"""The finger's exoskeleton: closed where the bones are, free at the joints (Sections 3.2, 4.2.1).

A tapered tube with a solid rounded tip. At every joint the dorsal side is cut away between two
planes; a palmar strip stays as hinge, so that the actuator's elongation becomes flexion towards
the palm. The strip meets the closed phalanges in rounded corners: a sharp inner corner is where a
soft print tears. With a rest curl the phalanges stay straight and the strips are printed bent.
"""

from __future__ import annotations

import math

import numpy as np

from handgen.geometry import csg
from handgen.geometry.part import Part
from handgen.geometry.profile import FingerProfile
from handgen.parameters.finger import Finger, Joint
from handgen.parameters.model import Hand

COLOUR = (0.86, 0.72, 0.60)
MARGIN = 1.0
"""How far cutters reach beyond what they cut, mm: coincident faces are left to no kernel."""
OVERLAP = 0.2
"""How far a curled strip reaches into the straight phalanges, mm, so that the union is one body."""
INSET = 0.02
"""How far a curled strip's faces lie inside the phalanges' there, mm: faces that nearly coincide
make OCCT lose a part of the union without a word."""


def exoskeleton(hand: Hand, name: str) -> Part:
    """The exoskeleton of finger `name` on its own, x from the root plane to the fingertip."""
    finger = getattr(hand.fingers, name)
    return Part(
        name=f"exoskeleton/{name}",
        role="exoskeleton",
        material=hand.printing.finger.material,
        shape=shape(finger, hand.exoskeleton.joint_fillet),
        colour=COLOUR,
        path=f"fingers.{name}",
        up=lying(finger),
    )


def lying(finger: Finger) -> tuple[float, float, float]:
    """Up on the print bed: palm down, the palmar side level from base to tip.

    The slots then open upwards; standing on its root, every phalanx but the first would begin
    in the air.
    """
    fall = (finger.base_outer_diameter - finger.tip_outer_diameter) / 2 / finger.inner_length
    return (-fall / math.hypot(fall, 1.0), 0.0, 1.0 / math.hypot(fall, 1.0))


def shape(finger: Finger, fillet: float) -> csg.Shape:
    """Tube with slots in the finger's frame (origin on the axis at the root, z dorsal), mm."""
    profile = FingerProfile(finger)
    if any(j.rest_angle for j in finger.joints):
        return _curled(profile, fillet)
    cuts = tuple(slot(profile, j, fillet) for j in finger.joints)
    return csg.Difference(csg.Revolve(tube(profile)), cuts)


def tube(profile: FingerProfile) -> csg.Path:
    """Meridian of the finger without slots, in (x, radius)."""
    f, stop = profile.finger, profile.finger.inner_length
    path = csg.Path((0.0, profile.bore(0.0)), ()).line((0.0, profile.outer(0.0)))
    path = profile.outer.append_to(path)
    path = path.quarter((f.outer_length, profile.outer(stop)), (f.outer_length, 0.0))
    return profile.bore.append_reversed_to(path.line((stop, 0.0), (stop, profile.bore(stop))))


def envelope(profile: FingerProfile, start: float = 0.0) -> csg.Path:
    """Meridian of the finger's outside as a full solid from x = `start` <= 0, in (x, radius)."""
    f = profile.finger
    path = csg.Path((start, 0.0), ()).line((start, profile.outer(0.0)), (0.0, profile.outer(0.0)))
    path = profile.outer.append_to(path)
    return path.quarter((f.outer_length, profile.outer.pieces[-1].y1), (f.outer_length, 0.0))


def slot(profile: FingerProfile, joint: Joint, wanted_fillet: float) -> csg.Shape:
    """What is cut away at a joint: all but the palmar arc, with rounded corners at the strip.

    The open side is the union of two half-spaces, each bounded by the radial plane through one
    edge of the strip; each is cut by a prism along that plane's radius whose outline, in x and
    the tangent, carries the rounded corners.
    """
    length, half_arc = joint.slot_length, math.radians(joint.palmar_arc / 2)
    start = joint.position - length / 2
    reach = profile.outer_radius(start) + MARGIN
    radius = profile.fillet(joint, wanted_fillet)
    if radius > 0.0:
        outline = csg.Path((0.0, reach), ()).line((0.0, radius)).quarter((0.0, 0.0), (radius, 0.0))
        outline = outline.line((length - radius, 0.0)).quarter((length, 0.0), (length, radius))
        outline = outline.line((length, reach))
    else:
        outline = csg.Path.polygon([(0.0, reach), (0.0, 0.0), (length, 0.0), (length, reach)])
    prism = csg.Extrude(outline, 2 * reach).moved(z=-reach)
    s, c = math.sin(half_arc), math.cos(half_arc)
    side = prism.placed(((1, 0, 0), (0, -c, -s), (0, s, -c)), (start, 0.0, 0.0))
    # One cutter, not two: OCCT then finds each of its edges on the tube once.
    return side + side.mirrored("y")


def _curled(profile: FingerProfile, fillet: float) -> csg.Shape:
    """The finger as printed with its rest angles: straight phalanges, bent strips.

    Phalanges are cut out of the whole tube: were each drawn on its own, its mesh would take other
    stations along the taper than the actuator's, and the two would cut into one another.
    """
    axis = Axis(profile, fillet)
    joints, whole = profile.finger.joints, csg.Revolve(tube(profile))
    reach = profile.outer(0.0) + MARGIN
    pieces = []
    for i, (start, end) in enumerate(axis.phalanges):
        cuts = [slot(profile, j, fillet) for j in joints[max(i - 1, 0):i + 1]]
        if i > 0:
            cuts.append(csg.box((-MARGIN, -reach, -reach), (start, reach, reach)))
        if end is not None:
            cuts.append(csg.box((end, -reach, -reach), (profile.length + MARGIN, reach, reach)))
        rotation, origin = axis.placement(start)
        pieces.append(csg.Difference(whole, tuple(cuts)).moved(x=-start).placed(rotation, origin))
    return csg.Union((*pieces, *(axis.strip(i) for i in range(len(joints)))))


class Axis:
    """The curled axis of a finger: straight along phalanges, a circular arc in every slot.

    The arc spans the slot between its rounded corners; the axis keeps its length, so that the
    actuator, cast straight, fits the curled finger. `root`: flexion of the whole at its root, rad.
    """

    def __init__(self, profile: FingerProfile, fillet: float, root: float = 0.0):
        self.profile, self.root = profile, root
        self.bends = []
        for j in profile.finger.joints:
            half = j.slot_length / 2 - profile.fillet(j, fillet)
            self.bends.append((j.position - half, j.position + half, math.radians(j.rest_angle)))
        starts = [0.0] + [b for _, b, _ in self.bends]
        ends: list[float | None] = [*(a for a, _, _ in self.bends), None]
        self.phalanges = list(zip(starts, ends, strict=True))

    def frame(self, x: float) -> tuple[float, float, float]:
        """(x, z, flexion in rad) of the axis point at arc length `x`."""
        px = pz = at = 0.0
        angle = self.root
        for a, b, bend in self.bends:
            straight = min(x, a) - at
            px, pz = px + straight * math.cos(angle), pz - straight * math.sin(angle)
            if x <= a:
                return px, pz, angle
            share = (min(x, b) - a) / (b - a)
            turn = bend * share
            chord = (min(x, b) - a) * (math.sin(turn / 2) / (turn / 2) if turn else 1.0)
            px += chord * math.cos(angle + turn / 2)
            pz -= chord * math.sin(angle + turn / 2)
            angle, at = angle + turn, b
            if x <= b:
                return px, pz, angle
        straight = x - at
        return px + straight * math.cos(angle), pz - straight * math.sin(angle), angle

    def placement(self, x: float):
        """(rotation rows, origin) that carries a straight cross-section at x = 0 to `x`."""
        px, pz, angle = self.frame(x)
        return csg.rotation("y", math.degrees(angle)), (px, 0.0, pz)

    def carry(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the straight finger, mm, carried into the curled one."""
        frames = np.array([self.frame(x) for x in points[:, 0]])
        px, pz, angle = frames.T
        y, z = points[:, 1], points[:, 2]
        return np.c_[px + z * np.sin(angle), y, pz + z * np.cos(angle)]

    def strip(self, index: int) -> csg.Shape:
        """The bent palmar strip of joint `index`, reaching a hair into both phalanges."""
        a, b, bend = self.bends[index]
        half_arc = math.radians(self.profile.finger.joints[index].palmar_arc / 2)
        steps = max(2, math.ceil(math.degrees(bend) / 3.0))
        sections = []
        for x in (a - OVERLAP, *np.linspace(a, b, steps + 1)[1:-1], b + OVERLAP):
            inner, outer = self.profile.bore(x) + INSET, self.profile.outer(x) - INSET
            path = _sector(inner, outer, half_arc - INSET / outer)
            px, pz, angle = self.frame(float(x))
            c, s = math.cos(angle), math.sin(angle)
            # The section's (u, v, normal) are the finger's (y, z, x) at this place.
            sections.append(csg.Section(path, ((0.0, s, c), (1.0, 0.0, 0.0), (0.0, c, -s)), (px, 0.0, pz)))
        return csg.Loft(tuple(sections))


def _sector(inner: float, outer: float, half_arc: float) -> csg.Path:
    """Ring sector about the palmar direction (0, -1), drawn in (y, z)."""

    def arc(path: csg.Path, radius: float, start: float, end: float) -> csg.Path:
        n = max(1, math.ceil(abs(end - start) / (math.pi / 4)))
        for k in range(n):
            t0, t1 = (start + (end - start) * i / n for i in (k, k + 1))
            h = 4.0 / 3.0 * math.tan((t1 - t0) / 4.0) * radius
            p0, p1 = ((radius * math.sin(t), -radius * math.cos(t)) for t in (t0, t1))
            path = path.cubic((p0[0] + h * math.cos(t0), p0[1] + h * math.sin(t0)),
                              (p1[0] - h * math.cos(t1), p1[1] - h * math.sin(t1)), p1)
        return path

    s, c = math.sin(half_arc), math.cos(half_arc)
    path = arc(csg.Path((-outer * s, -outer * c), ()), outer, -half_arc, half_arc)
    path = arc(path.line((inner * s, -inner * c)), inner, half_arc, -half_arc)
    return path.line((-outer * s, -outer * c))
