"""How the parts are made: casting, mould fits, printing (Section 4, Tables 3.1 and B.1)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from handgen.parameters.quantity import Model, item, quantity

ROLES = {
    "finger": ("exoskeleton",),
    "hand": ("exoskeleton",),
    "tooling": (
        "mould_a",
        "mould_b",
        "mould_base",
        "core_large",
        "core_small",
        "suspender",
        "plug",
        "collar",
    ),
}
"""Print process -> the roles of the parts printed with it (Figure 4.7)."""


class Silicone(Model):
    """A two-part platinum silicone (Table 3.1, Appendix C)."""

    name: str = item("trade name", source="Table 3.1", max_length=60)
    density: float = quantity("g/cm3", 0.8, 2, "density, cured", source="Table 3.1")
    pot_life: float = quantity("min", 1, 300, "time to pour after mixing", source="Table 3.1")
    cure_time: float = quantity("h", 0.05, 72, "time to demould at room temperature", source="Table 3.1")
    elongation: float = quantity("%", 50, 2000, "elongation at break", source="Table 3.1")
    tensile_strength: float = quantity("MPa", 0.1, 20, "tensile strength", source="Table 3.1")
    modulus_100: float = quantity("MPa", 0.005, 5, "nominal stress at 100 % strain", source="Table 3.1")
    mix_ratio: float = quantity(
        "1", 0.1, 10, "part A over part B by volume", source="Section 4.2.2", default=1.0
    )


class PostCure(Model):
    """One step of the heat treatment after the room-temperature cure."""

    temperature: float = quantity("degC", 20, 200, "oven temperature", source="Section 4.2.2")
    hours: float = quantity("h", 0.1, 48, "time at temperature", source="Section 4.2.2")


class Casting(Model):
    """The pouring of the actuators and the fits of their tooling (Sections 4.1.2, 4.2.2)."""

    silicone: Silicone
    mixing_time: float = quantity(
        "min", 1, 30, "stirring A and B together", source="Section 4.2.2", default=3.0
    )
    settling_time: float = quantity(
        "min", 0, 30, "letting air rise before pouring", source="Section 4.2.2", default=1.0
    )
    cure_temperature: float = quantity(
        "degC", 15, 60, "room temperature of the cure", source="Section 4.2.2", default=23.0
    )
    minimum_cure_temperature: float = quantity(
        "degC", 10, 40, "never cure below", source="Section 4.2.2", default=18.0
    )
    post_cure: list[PostCure] = item(
        "heat treatment", source="Section 4.2.2", default_factory=list, max_length=8
    )
    mixing_loss: float = quantity(
        "%", 0, 100, "silicone mixed beyond what is poured", default=15.0,
        assumed="stays on cup, stirrer and gates; weigh your own cups")
    cup_fill: float = quantity(
        "%", 0, 100, "share of the pouring cup's height that is filled", default=50.0,
        assumed="sinks while air leaves, and is trimmed off")
    mould_sets: int = item(
        "moulds that stand filled at once", default=7, ge=1, le=50,
        assumed="the tooling of all seven actuators is printed, and there is room for it")
    thread_ends: float = quantity(
        "mm", 0, 1000, "thread to hold and to tie off at each end", default=150.0,
        assumed="a hand's breadth and a knot")
    winding_rate: float = quantity(
        "turns/min", 0.5, 60, "turns of thread wound by hand", default=5.0,
        assumed="12 s a turn, looking at the pitch")
    assembly_time: float = quantity(
        "min", 0.5, 120, "closing a mould and hanging its core", default=5.0,
        assumed="by hand, with two bands")
    pour_time: float = quantity(
        "min", 0.2, 60, "pouring one mould, slowly", default=2.0,
        assumed="about 10 ml through a gate of 3.5 mm")
    opening_time: float = quantity(
        "min", 0.5, 240, "opening a mould, pulling its core, trimming the base", default=10.0,
        assumed="the source calls it the step that needs most care")
    cooling_time: float = quantity(
        "h", 0, 24, "back to room temperature after the oven", default=0.5,
        assumed="thin silicone cools quickly")
    adhesive: str = item(
        "glue of plug and collar", source="Section 4.2.2", default="Loctite 401", max_length=60
    )
    tip: Literal["cast", "filled afterwards"] = item(
        "cast: cores hang from the suspender, the tip is poured with the layers (Section 4.2.2); "
        "filled afterwards: cores stand in a groove of the mould's floor and the hole they leave is "
        "filled from inside (Section 4.1.2)",
        default="cast",
    )
    tip_fill: float = quantity(
        "mm",
        0,
        10,
        "silicone added at the tip from inside, part of `layers.tip`; only with `tip: filled afterwards`",
        source="Section 4.1.2",
        default=2.0,
    )
    minimum_core_tip_diameter: float = quantity(
        "mm",
        0.8,
        10,
        "thinnest small core that prints and can be pulled",
        default=2.5,
        assumed="seven lines of a 0.35 mm nozzle; the thinnest PLA rod of 75 mm that survives demoulding",
    )
    core_fit: float = quantity(
        "mm",
        0,
        1,
        "radial clearance of a core's shank in the suspender",
        default=0.1,
        assumed="a hand-pressed fit for PLA from a 0.35 mm nozzle",
    )
    mould_fit: float = quantity(
        "mm",
        0,
        1,
        "clearance of pins, base and suspender on the mould",
        default=0.2,
        assumed="a sliding fit for PLA from a 0.35 mm nozzle",
    )
    mould_wall: float = quantity(
        "mm",
        2,
        30,
        "least material around the cavity",
        default=5.0,
        assumed="stiff enough at 20 % infill to stay shut by a rubber band",
    )
    pour_height: float = quantity(
        "mm",
        2,
        40,
        "height of the pouring cup above the actuator's base",
        default=8.0,
        assumed="takes the silicone that sinks while air leaves",
    )
    label_height: float = quantity(
        "mm",
        0,
        2,
        "height of the embossed part numbers; 0 leaves them out",
        default=0.6,
        assumed="three layers of 0.2 mm",
    )


class Seal(Model):
    """The PLA parts that close an actuator's base and hold it in the exoskeleton (Figure 4.7 g, h)."""

    plug_length: float = quantity(
        "mm",
        3,
        40,
        "depth of the plug inside the actuator",
        default=10.0,
        assumed="about one bore radius of glued length",
    )
    plug_squeeze: float = quantity(
        "mm",
        0,
        1.5,
        "how much wider than the channel the plug's radius is",
        default=0.2,
        assumed="seats the silicone before the glue sets",
    )
    collar_length: float = quantity(
        "mm",
        2,
        30,
        "length of the collar behind the actuator",
        default=8.0,
        assumed="guides the base squarely into the bore",
    )
    collar_fit: float = quantity(
        "mm",
        0,
        1,
        "radial clearance of the collar in the exoskeleton's bore",
        default=0.1,
        assumed="Ninjaflex gives; the collar is pressed in",
    )
    glue_gap: float = quantity(
        "mm", 0, 0.5, "radial gap between plug and collar", default=0.1, assumed="thin cyanoacrylate film"
    )
    tube_outer_diameter: float = quantity(
        "mm",
        1.5,
        10,
        "outside diameter of the air tube",
        default=3.0,
        assumed="common 3 x 2 mm tube; the little finger's channel is 4 mm wide",
    )
    tube_fit: float = quantity(
        "mm", 0, 1, "radial clearance of the tube in its hole", default=0.05, assumed="glued in"
    )
    tube_length: float = quantity(
        "mm", 20, 5000, "air tube of one actuator", default=400.0,
        assumed="from the fingertip's base to a valve behind the wrist")
    leak_pressure: float = quantity(
        "kPa", 1, 200, "pressure of the leak test, the actuator free under water", default=20.0,
        assumed="a third of the working pressure: free of its finger an actuator folds above 50 kPa")
    leak_time: float = quantity(
        "min", 0.1, 60, "how long it must hold without a bubble", default=1.0,
        assumed="long enough to look at it from all sides")


class PrintProcess(Model):
    """One column of Table B.1."""

    material: str = item("filament", source="Table B.1", max_length=60)
    density: float = quantity("g/cm3", 0.5, 3, "density of the filament", source="Table 3.2")
    nozzle_temperature: float = quantity("degC", 150, 320, "nozzle temperature", source="Table B.1")
    nozzle_size: float = quantity("mm", 0.1, 1.5, "nozzle diameter", source="Table B.1")
    speed: float = quantity("mm/s", 3, 300, "printing speed", source="Table B.1")
    infill_pattern: Literal["concentric", "grid", "lines", "gyroid"] = item(
        "infill pattern", source="Table B.1"
    )
    infill_density: float = quantity("%", 0, 100, "infill density", source="Table B.1")
    layer_height: float = quantity("mm", 0.04, 0.6, "layer height", source="Table B.1")
    adhesion: Literal["none", "brim", "raft", "skirt"] = item("build-plate adhesion", source="Table B.1")
    flow: float = quantity("%", 50, 150, "flow", source="Table B.1")
    support: Literal["none", "touching build plate", "everywhere"] = item("support", source="Table B.1")
    support_angle: float = quantity(
        "deg", 0, 90, "overhang from the vertical that gets support", source="Table B.1", default=70.0
    )
    retraction: bool = item("retract the filament on travel", source="Table B.1")
    heated_bed: float | None = item(
        "bed temperature, degC; null: none", source="Table B.1", default=None, ge=20, le=150
    )
    walls: int = item(
        "lines around every outline", default=3, ge=1, le=20,
        assumed="1.2 mm of 0.35 mm lines, as Cura's definition of the BQ Hephestos 2 has it")
    solid_thickness: float = quantity(
        "mm", 0, 10, "solid layers below and above the infill", default=1.2,
        assumed="as Cura's definition of the BQ Hephestos 2 has it")
    support_density: float = quantity(
        "%", 5, 50, "density of the support", default=15.0, assumed="Cura's own")
    brim_width: float = quantity("mm", 1, 40, "width of the brim", default=8.0, assumed="Cura's own")
    retraction_length: float = quantity(
        "mm", 0.1, 12, "filament that is retracted, where it is", default=2.0,
        assumed="usual for a direct drive, which the BQ Hephestos 2 has")
    travel_speed: float = quantity(
        "mm/s", 20, 500, "speed between lines", default=120.0, assumed="Cura's own")
    minimum_layer_time: float = quantity(
        "s", 0, 60, "shorter layers are printed more slowly", default=5.0, assumed="Cura's own")
    part_adhesion: dict[str, Literal["none", "brim", "raft", "skirt"]] = item(
        "adhesion of single parts by their role, where it differs", source="Table B.1", default_factory=dict
    )
    part_support: dict[str, Literal["none", "touching build plate", "everywhere"]] = item(
        "support of single parts by their role, where it differs", source="Table B.1", default_factory=dict
    )

    @property
    def rate(self) -> float:
        """mm3/s that lines lay down side by side, without travel or slowing down: no print is faster."""
        return self.nozzle_size * self.layer_height * self.speed


class Printing(Model):
    """The machine and its three print processes."""

    printer: str = item("name of the machine", source="Section 3.3", max_length=60)
    build_volume: Annotated[
        list[Annotated[float, Field(ge=30, le=2000)]], Field(min_length=3, max_length=3)
    ] = item("x, y, z in mm", source="maker's data for the BQ Hephestos 2")
    filament_diameter: float = quantity(
        "mm", 1, 3.5, "diameter of the filament", default=1.75,
        assumed="what the BQ Hephestos 2 takes; all three filaments are sold in it")
    finger: PrintProcess = item("single fingers: first column of Table B.1")
    hand: PrintProcess = item("the hand: second column of Table B.1")
    tooling: PrintProcess = item("moulds, cores, seals: third column of Table B.1")
