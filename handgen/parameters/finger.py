"""What a finger's exoskeleton and its actuator are, in the source's terms (Figure A.1)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handgen.parameters.quantity import Model, item, quantity

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,31}$")]
Station = Annotated[list[Annotated[float, Field(ge=0.0, le=1.0)]], Field(min_length=2, max_length=2)]
Point = Annotated[
    list[Annotated[float, Field(ge=-400.0, le=400.0)]], Field(min_length=3, max_length=3)
]
Extents = Annotated[list[Annotated[float, Field(ge=1.0, le=100.0)]], Field(min_length=3, max_length=3)]

TAPER_REASON = (
    "Table A.1 gives base and tip diameters only and says that those between are not "
    "proportional; a phalanx that stays full towards the PIP joint and thins beyond it"
)


class Joint(Model):
    """A place where the exoskeleton is free on the dorsal side; a palmar strip stays as hinge."""

    name: Name = item("MCP, PIP, DIP or IP; any name is allowed")
    position: float = quantity("mm", 1, 300, "centre of the slot from the finger's root, along the axis")
    slot_length: float = quantity("mm", 2, 40, "length of the slot along the axis")
    palmar_arc: float = quantity("deg", 30, 180, "arc of the palmar strip that stays closed")
    rest_angle: float = quantity(
        "deg", 0, 75, "flexion of the joint as printed, unloaded", default=0.0,
        assumed="the source shows no rest curl in its drawings",
    )


class Placement(Model):
    """Where a finger stands on the palm (hand axes: x to the fingertips, y to the thumb, z dorsal)."""

    root: Point = item("centre of the root plane, [x, y, z] mm")
    splay: float = quantity(
        "deg", -60, 100, "angle of the axis to x in the palm's plane, positive to the thumb")
    palmar_tilt: float = quantity(
        "deg", -30, 60, "angle of the axis below the palm's plane", default=0.0,
        assumed="the source draws the fingers in the palm's plane")
    roll: float = quantity(
        "deg", -120, 120, "turn about the axis; positive turns the pad towards the little finger",
        default=0.0, assumed="the source gives no roll")


class Finger(Model):
    """One finger's exoskeleton: Table A.1 and what that table leaves open."""

    outer_length: float = quantity(
        "mm", 20, 250, "L_Ext: root plane to the outside of the tip", source="Table A.1")
    inner_length: float = quantity(
        "mm", 15, 240, "L_Int: root plane to the end of the bore", source="Table A.1")
    base_outer_diameter: float = quantity(
        "mm", 6, 60, "D_Base: outside, at the root plane", source="Table A.1")
    base_bore_diameter: float = quantity("mm", 4, 56, "d_Base: bore, at the root plane", source="Table A.1")
    tip_outer_diameter: float = quantity(
        "mm", 4, 60, "D_Tip: outside, where the bore ends and the rounded tip begins", source="Table A.1")
    tip_bore_diameter: float = quantity("mm", 2, 56, "d_Tip: bore, at its end", source="Table A.1")
    taper: list[Station] = item(
        "stations [share of the inner length, share of the way from base to tip diameter], "
        "from [0, 0] to [1, 1]",
        default_factory=lambda: [[0.0, 0.0], [0.5, 0.36], [1.0, 1.0]],
        assumed=TAPER_REASON, min_length=2, max_length=12)
    joints: list[Joint] = item("from root to tip", min_length=1, max_length=5)
    placement: Placement


class Layers(Model):
    """Radial stack of an actuator's wall, outside to inside, and its closed tip (Table A.2)."""

    external: float = quantity("mm", 0.3, 6, "silicone outside the thread", source="Table A.2")
    thread: float = quantity("mm", 0.05, 2, "radial room drawn for the thread", source="Table A.2")
    internal: float = quantity("mm", 0.3, 6, "silicone inside the thread", source="Table A.2")
    tip: float = quantity("mm", 1, 15, "closed end, along the axis", source="Table A.2")

    @property
    def stack(self) -> float:
        """Radial thickness of the whole wall, mm."""
        return self.external + self.thread + self.internal

    def core_room(self, outer_diameter: float) -> float:
        """Diameter that the full stack leaves for the small core, mm; below zero: none at all."""
        return outer_diameter - 2 * self.stack


class Thread(Model):
    """The helical reinforcement that stops radial growth (Sections 3.2, 4.2.2)."""

    material: str = item("what it is made of", source="Section 4.2.2", max_length=60)
    diameter: float = quantity("mm", 0.02, 2, "diameter of the thread", source="Section 4.2.2")
    pitch: float = quantity(
        "mm", 0.1, 20, "advance per turn", default=2.0,
        assumed="the source models 44 rings along the index actuator (Figure 5.8): about 2 mm apart")
    held_back: float = quantity(
        "mm", 0, 20, "axial distance of the first and last turn from base and core tip", default=2.0,
        assumed="room to tie the thread off on the core")
    groove: bool = item("cut the thread's path into the large core", default=False,
                        assumed="the source winds on a plain core")


class Actuator(Model):
    """One fibre-reinforced silicone actuator: Table A.2."""

    outer_length: float = quantity(
        "mm", 12, 240, "length from the base to the outside of the tip", source="Table A.2")
    base_outer_diameter: float = quantity("mm", 4, 56, "outside diameter at the base", source="Table A.2")
    tip_outer_diameter: float = quantity("mm", 2, 56, "outside diameter at the tip", source="Table A.2")
    taper: list[Station] | None = item(
        "as for a finger; left out: that of the finger it fills, straight for an opposition actuator",
        default=None, min_length=2, max_length=12)
    layers: Layers | None = item("left out: the hand's `layers`", default=None)
    thread: Thread | None = item("left out: the hand's `thread`", default=None)
    adapt: bool = item(
        "true: thin the layers where they leave no room for the small core, and record it; "
        "false: such a place is an error", default=True)
