"""A finger that curls: its phalanges as rigid bodies about the hinge lines of its palmar strips.

Each joint turns about the line through the middle of its strip's section, measured on the mesh.
That leaves out the strip's own length (a slot is a tenth of a finger) and any sideways give.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from handgen.checks.limits import Limits
from handgen.checks.sections import Outline, Triangles
from handgen.geometry.finger import Axis
from handgen.geometry.palm import finger_placement
from handgen.geometry.part import Part
from handgen.geometry.profile import FingerProfile
from handgen.parameters.finger import Joint
from handgen.parameters.model import Hand

COARSE = 0.02
"""How far the phalanges' hulls may be simplified, mm."""


class CurlingFinger:
    """Finger `name` of `hand`, measured on its part's mesh; frame of the finger unless said."""

    def __init__(self, hand: Hand, name: str, part: Part):
        self.hand, self.name, self.part = hand, name, part
        self.finger = getattr(hand.fingers, name)
        self.profile = FingerProfile(self.finger)
        self.axis = Axis(self.profile, hand.exoskeleton.joint_fillet)

    @cached_property
    def surface(self) -> Triangles:
        return Triangles.of(self.part.triangles)

    def around(self, joint: Joint) -> Triangles:
        """The triangles that the sections across a joint's slot cut, and few others."""
        rotation, origin = self.axis.placement(joint.position)
        along = ((self.surface.vertices - origin) @ np.array(rotation)[:, 0])[self.surface.faces]
        return self.surface.where((along.min(1) < joint.slot_length) & (along.max(1) > -joint.slot_length))

    def section_at(self, x: float, surface: Triangles) -> Outline:
        """The section of `surface` across the axis at arc length x, (y, z) about the axis there."""
        cut = surface.seen_from(*self.axis.placement(x)).section(0, 0.0)
        return cut.where(np.linalg.norm(cut.middle, axis=1) < self.profile.outer_radius(x) + 1.0)

    @cached_property
    def hinges(self) -> list[np.ndarray]:
        """The point of every joint's hinge line in the plane of curling, as printed."""
        points = []
        for joint in self.finger.joints:
            y, z = self.section_at(joint.position, self.around(joint)).centroid
            rotation, origin = self.axis.placement(joint.position)
            points.append(np.array(rotation) @ (0.0, y, z) + origin)
        return points

    def full_curl(self, limits: Limits, rule: str) -> np.ndarray:
        """Flexion that every joint has still to go from its rest angle, rad."""
        full = [limits.get(rule, "full_curl", j.name).value for j in self.finger.joints]
        rest = [j.rest_angle for j in self.finger.joints]
        return np.radians(np.maximum(np.subtract(full, rest), 0.0))

    def poses(self, angles: np.ndarray, splay: float = 1.0) -> list[np.ndarray]:
        """Transforms (3, 4) of the phalanges into the right hand's frame.

        `angles`: flexion beyond rest, rad, a joint; `splay`: share of the splay as built.
        """
        rows, origin = finger_placement(self.hand, self.name)
        back = np.radians(-self.finger.placement.splay * (1.0 - splay))
        c, s = np.cos(back), np.sin(back)
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.array(rows)
        shift = np.array(origin, float)
        result = [np.c_[rotation, shift]]
        for hinge, angle in zip(self.hinges, angles, strict=True):
            c, s = np.cos(angle), np.sin(angle)
            turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
            shift = shift + rotation @ (hinge - turn @ hinge)
            rotation = rotation @ turn
            result.append(np.c_[rotation, shift])
        return result

    @cached_property
    def hulls(self) -> list:
        """The phalanges' convex hulls (manifold3d), each with its halves of the strips."""
        from manifold3d import Manifold

        points, result = self.surface.vertices, []
        for joint in self.finger.joints:
            rotation, origin = self.axis.placement(joint.position)
            beyond = (points - origin) @ np.array(rotation)[:, 0] > 0
            result.append(Manifold.hull_points(points[~beyond]).simplify(COARSE))
            points = points[beyond]
        return [*result, Manifold.hull_points(points).simplify(COARSE)]

    @cached_property
    def phalanges(self) -> list:
        """The phalanges themselves (manifold3d), cut apart in the middle of the joints."""
        rest, result = as_solid(self.surface), []
        for joint in self.finger.joints:
            rotation, origin = self.axis.placement(joint.position)
            normal = np.array(rotation)[:, 0]
            beyond, before = rest.split_by_plane(tuple(normal), float(normal @ np.array(origin)))
            result.append(before)
            rest = beyond
        return [*result, rest]


def as_solid(surface: Triangles):
    """Closed triangles as a manifold3d solid."""
    from manifold3d import Manifold, Mesh

    return Manifold(Mesh(np.array(surface.vertices, np.float32, order="C"),
                         np.array(surface.faces, np.uint32, order="C")))


def curling_fingers(hand: Hand, parts: Mapping[str, Part]) -> dict[str, CurlingFinger]:
    """Those fingers of `hand` whose exoskeletons are among `parts`."""
    names = {name: f"exoskeleton/{name}" for name in hand.fingers.present()}
    return {name: CurlingFinger(hand, name, parts[key]) for name, key in names.items() if key in parts}
