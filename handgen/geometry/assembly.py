"""The assembled hand: exoskeleton, seven actuators, their plugs and collars, each in its place.

Actuators are cast straight; in a finger with a rest curl they lie bent along its axis, and the
meshes here show them so. A plug is drawn larger than its channel, so that it seals: silicone yields to
it, and the meshes here show the silicone that is left beside it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from handgen.geometry import csg
from handgen.geometry.actuator import actuator
from handgen.geometry.finger import Axis
from handgen.geometry.hand import hand_part
from handgen.geometry.palm import finger_placement
from handgen.geometry.part import Part
from handgen.geometry.profile import FingerProfile
from handgen.geometry.thumb import Hinge
from handgen.geometry.tooling import tooling
from handgen.parameters.model import OPPOSITION, Hand

if TYPE_CHECKING:
    import trimesh

SEALS = ("plug", "collar")
BENT_EDGE = 2.0
"""Longest edge, mm, of a mesh that is bent: its straight triangles must follow the curl."""


@dataclass(frozen=True)
class Seated:
    """A part in the hand: without what `pressed_by` takes of its room, bent along `axis` if there is one,
    then turned, moved, and mirrored."""

    part: Part
    rotation: tuple = csg.rotation("x", 0.0)
    origin: csg.Point3 = (0.0, 0.0, 0.0)
    axis: Axis | None = None
    mirrored: bool = False
    pressed_by: Part | None = None

    @cached_property
    def installed(self) -> Part:
        """The part in its own frame as it is in the hand; its files show it as it is made."""
        if self.pressed_by is None:
            return self.part
        return replace(self.part, shape=csg.Difference(self.part.shape, (self.pressed_by.shape,)))

    @property
    def name(self) -> str:
        return self.part.name

    def carry(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the part's own frame in the hand's, mm."""
        if self.axis:
            points = self.axis.carry(points)
        placed = points @ np.array(self.rotation).T + self.origin
        return placed * (1.0, -1.0, 1.0) if self.mirrored else placed

    @property
    def mesh(self) -> trimesh.Trimesh:
        """The part's mesh in the hand's frame."""
        import trimesh

        mesh = self.installed.mesh
        vertices, faces = mesh.vertices, mesh.faces
        if self.axis:
            vertices, faces = trimesh.remesh.subdivide_to_size(vertices, faces, BENT_EDGE)
        placed = trimesh.Trimesh(self.carry(vertices), faces, process=bool(self.axis))
        if self.mirrored:
            placed.invert()
        return placed


def assembly(hand: Hand) -> list[Seated]:
    """Everything that makes the hand, in place; the exoskeleton first.

    Raises:
        GeometryError: a part cannot be made.
    """
    seated = [Seated(hand_part(hand))]
    hinge = Hinge(hand) if hand.opposition else None
    for name in hand.actuators.present():
        if name in OPPOSITION:
            place = hinge.rotation, hinge.point(-hinge.o.base_socket, hinge.lines[name], 0.0), None
        else:
            place = *finger_placement(hand, name), _curl(hand, name)
        tools = {p.name.rsplit("/", 1)[-1]: p for p in tooling(hand, name)}
        place = *place, hand.side == "left"
        seated.append(Seated(actuator(hand, name), *place, pressed_by=tools["plug"]))
        seated += [Seated(tools[seal], *place) for seal in SEALS]
    return seated


def _curl(hand: Hand, name: str) -> Axis | None:
    finger = getattr(hand.fingers, name)
    if not any(joint.rest_angle for joint in finger.joints):
        return None
    return Axis(FingerProfile(finger), hand.exoskeleton.joint_fillet)
