"""The palm and the thumb's opposition hinge (Section 4.2.1; the source gives few numbers)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handgen.parameters.finger import Point
from handgen.parameters.quantity import Model, item, quantity


class Section(Model):
    """One cross-section of the palm's body, a superellipse normal to x."""

    x: float = quantity("mm", 0, 200, "distance from the wrist")
    y: float = quantity("mm", -100, 100, "centre, towards the thumb")
    z: float = quantity("mm", -60, 60, "centre, dorsal")
    width: float = quantity("mm", 20, 200, "extent along y")
    thickness: float = quantity("mm", 10, 100, "extent along z")


class Palm(Model):
    """The palm's body: an outer skin and the bay inside it."""

    length: float = quantity("mm", 120, 300, "wrist to middle fingertip", source="Section 4.2.1")
    sections: list[Section] = item("from the wrist to the knuckles", min_length=3, max_length=12)
    wall: float = quantity("mm", 1, 10, "least wall around the bay", default=3.0,
                           assumed="between the fingers' 2 mm and what prints in one night")
    blend: float = quantity("mm", 0.5, 25, "radius of the blends between palm, fingers and thumb", default=6.0,
                            assumed="looks like skin; shorter than the distance to the first slot")
    web: float = quantity("mm", 0, 20, "how far the webs reach past the finger roots", default=7.0,
                          assumed="ends before the first slot begins")
    resolution: float = quantity("mm", 0.3, 2, "grid pitch of the blended skin", default=0.8,
                                 assumed="half a millimetre of skin detail after marching cubes")


class Opposition(Model):
    """The hinge that turns the thumb: two actuators on a thin palmar sheet (Sections 3.2, 4.2.3).

    The frame of the hinge: origin on the palm-side wall of the gap at the actuators' axis height,
    `direction` across the fold to the thumb, dorsal up.
    """

    origin: Point = item("middle of the palm-side wall, at the height of the actuators' axes")
    direction: float = quantity("deg", 0, 110, "direction across the fold, from x towards y")
    free_length: float = quantity("mm", 8, 80, "gap that the actuators bridge; length of the sheet")
    spacing: float = quantity("mm", 6, 80, "distance between the two actuators' axes")
    sheet_width: float = quantity("mm", 10, 120, "width of the palmar sheet along the fold")
    sheet_thickness: float = quantity("mm", 0.6, 20, "thickness of the palmar sheet")
    tip_socket: float = quantity("mm", 2, 30, "depth that holds an actuator's tip", default=6.0,
                                 assumed="half an actuator diameter")
    base_socket: float = quantity("mm", 2, 30, "depth that holds an actuator's base", default=6.0,
                                  assumed="half an actuator diameter")
    clearance: float = quantity("mm", 0, 2, "radial clearance of the sockets", default=0.25,
                                assumed="half the clearance of Table A.2, note 2")
