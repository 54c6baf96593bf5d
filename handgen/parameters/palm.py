"""The palm and the thumb's opposition hinge (Section 4.2.1; the source gives few numbers)."""

from __future__ import annotations

from handgen.parameters.finger import Extents, Point
from handgen.parameters.quantity import Model, item, quantity


class Section(Model):
    """One cross-section of the palm's body, a superellipse normal to x."""

    x: float = quantity("mm", 0, 200, "distance from the wrist")
    y: float = quantity("mm", -100, 100, "centre, towards the thumb")
    z: float = quantity("mm", -60, 60, "centre, dorsal")
    width: float = quantity("mm", 20, 200, "extent along y")
    thickness: float = quantity("mm", 10, 100, "extent along z")


class Palm(Model):
    """The palm's body: a blended skin around the channels that lead from the wrist to the bores."""

    length: float | None = item(
        "wrist to middle fingertip, mm, which roots and finger lengths must then add up to; "
        "left out: whatever they add up to", source="Section 4.2.1", default=None, ge=40, le=400)
    sections: list[Section] = item("from the wrist to the knuckles", min_length=3, max_length=12)
    exponent: float = quantity("1", 2, 6, "of the superelliptic sections: 2 an ellipse, more is squarer",
                               default=2.6, assumed="between an ellipse and a slab, as a palm is")
    mouth: float = quantity("mm", 16, 180, "width over which the channels open at the wrist", default=50.0,
                            assumed="leaves a wall of 5 mm at the sides of an adult's wrist")
    wall: float = quantity("mm", 1, 10, "least wall around the channels", default=2.3,
                           assumed="a little more than the fingers' 2 mm, because a palm should not give")
    channel_clearance: float = quantity(
        "mm", 0, 3, "how much wider a channel's radius is than the bore that it leads to", default=0.4,
        assumed="a soft actuator is pushed through by hand")
    seat_clearance: float = quantity(
        "mm", 0.02, 0.5, "radial clearance of the seat behind the root against the bore", default=0.05,
        assumed="lets the collar, pressed in, stop square to the bore")
    blend: float = quantity("mm", 0.5, 25, "radius of the blends between palm, fingers, thumb", default=5.0,
                            assumed="looks like skin and brings the hand near the volume of Eq. 5.1")
    web: float = quantity("mm", 0, 20, "how far the webs reach past the finger roots", default=5.0,
                          assumed="ends before the first slot begins")
    hypothenar: Extents = item(
        "half-axes of the mass below the little finger: along its channel, across it, dorsal, mm",
        default_factory=lambda: [34.0, 12.0, 11.0],
        assumed="from the wrist to the knuckle; as wide as the channel and its walls")
    hypothenar_drop: float = quantity("mm", -20, 40, "how far palmar of the channel its middle lies",
                                      default=5.0, assumed="rounds the palm's side, leaves the back flat")
    resolution: float = quantity("mm", 0.3, 2, "grid pitch of the blended skin", default=0.8,
                                 assumed="half a millimetre of skin detail after marching cubes")


class Opposition(Model):
    """The hinge that turns the thumb: two actuators on a thin palmar sheet (Sections 3.2, 4.2.3).

    The frame of the hinge: origin in the palm-side wall of the gap at the height of the actuators'
    axes, u across the fold to the thumb (`direction`), v along the fold to the wrist, w dorsal.
    """

    origin: Point = item("middle of the palm-side wall, at the height of the actuators' axes")
    direction: float = quantity("deg", 20, 110, "direction across the fold, from x towards y")
    free_length: float = quantity("mm", 8, 80, "gap that the actuators bridge; length of the sheet")
    spacing: float = quantity("mm", 6, 80, "distance between the two actuators' axes")
    sheet_width: float = quantity("mm", 10, 120, "width of the palmar sheet along the fold")
    sheet_thickness: float = quantity("mm", 0.6, 20, "thickness of the palmar sheet")
    sheet_fillet: float = quantity("mm", 0, 6, "radius where the sheet meets the gap's walls", default=1.5,
                                   assumed="as at the fingers' joints: a sharp corner starts a tear")
    thenar_across: float = quantity(
        "mm", 1, 100, "half-axis of the palm's mass at the gap, across the fold", default=15.0,
        assumed="buries the sockets of the actuators' bases")
    thenar_along: float = quantity(
        "mm", 1, 100, "half-axis of the palm's mass at the gap, along the fold", default=18.0,
        assumed="a little wider than the sheet, as a thenar runs out to the wrist")
    ball: Extents = item(
        "half-axes of the ball of the thumb: along the thumb's axis, across it, dorsal, mm",
        default_factory=lambda: [15.0, 12.5, 14.0],
        assumed="a little more than half the thumb's root all round, as a hand's thenar pad")
    tip_socket: float = quantity("mm", 2, 30, "depth that holds an actuator's tip", default=6.0,
                                 assumed="half an actuator diameter")
    base_socket: float = quantity("mm", 2, 30, "depth that holds an actuator's base", default=6.0,
                                  assumed="half an actuator diameter")
    clearance: float = quantity("mm", 0.02, 2, "radial clearance of the sockets", default=0.25,
                                assumed="half the clearance of Table A.2, note 2")
