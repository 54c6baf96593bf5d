"""The format of a measurements file, `schema: handgen.measurements/1`: tests, repeats, how they were read."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from handgen.parameters.quantity import Model, item, quantity

SCHEMA = "handgen.measurements/1"
Reading = Annotated[float, Field(ge=-1e3, le=1e3)]
Row = list[Reading | None]
UNITS = {"pressure": "kPa", "tip_load": "N", "tip_drop": "mm", "elongation": "mm", "bend_angle": "deg",
         "tip_force": "N", "chamber_pressure": "kPa", "force_angle": "deg"}
"""Quantities of loads and observables, and the one unit that each is written in."""
DIRECT = ("chamber_pressure", "force_angle")
"""Observables that say themselves what an effect does: no bend has to be simulated for them."""


class Load(Model):
    """What was changed from reading to reading."""

    quantity: Literal["pressure", "tip_load"] = item("gauge pressure, or a weight hung on the fingertip")
    unit: Literal["kPa", "N"] = item("kPa of a pressure, N of a tip load")
    values: list[Annotated[float, Field(ge=0, le=1e3)]] = item(
        "in the order applied", min_length=1, max_length=1000)


class Observable(Model):
    """What was read."""

    quantity: Literal["tip_drop", "elongation", "bend_angle", "tip_force", "chamber_pressure",
                      "force_angle"] = item(
        "the tip's lowest point below the plane of the palm's bottom surface; axial travel of the actuator's "
        "tip; rotation of the fingertip; force on a plane below the finger; a manometer at the actuator's "
        "inlet; angle of the fingertip's force to the balance's axis")
    unit: Literal["mm", "deg", "N", "kPa"] = item("mm of lengths, deg of angles, N of forces, kPa")


class Sensor(Model):
    """What the loads are known to."""

    pressure_sigma: float | None = quantity(
        "kPa", 0, 100, "of the pressure gauge, one number for all readings: an offset", default=None)


class Simulated(Model):
    """What somebody else's simulation gave for a test."""

    name: str = item("whose, in a legend's words", min_length=1, max_length=60)
    loads: list[float] = item("in the test's unit of loads", min_length=1)
    values: list[float] = item("in the observable's unit", min_length=1)
    source: str = item("where the numbers come from", min_length=1)


class Test(Model):
    """Readings of one quantity over one row of loads, taken once or more."""

    id: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,63}$")] = item("names the test")
    part: Literal["assembly", "exoskeleton", "actuator"] = item("what was tested")
    orientation: Literal["palm_down", "palm_up", "sideways", "weightless"] = item(
        "how own weight acts; weightless: something carries it")
    path: Literal["loading", "unloading", "hold", "cycle"] = item("how the loads follow one another")
    load: Load = item("what was changed")
    times: list[Annotated[float, Field(ge=0, le=1e7)]] | None = item(
        "s since the first load at which each reading was taken, what a hold is about; null: not noted",
        default=None)
    observable: Observable = item("what was read")
    repeats: list[Row] = item(
        "one row a repeat, in the order taken; null: not read", min_length=1, max_length=1000)
    resolution: float | None = quantity(
        "unit of the observable", 0, 100, "of a reading", default=None)
    sensor: Sensor = item("what the loads are known to", default_factory=Sensor)
    obstacle: float | None = quantity(
        "mm", 0.1, 200, "distance of a rigid plane below the palm side", default=None)
    held_out: bool = item("never fitted, only predicted", default=False)
    fit_up_to: float | None = quantity(
        "unit of the loads", 0, 1e3, "load above which readings are never fitted", default=None)
    title: str = item("of tables and figures", default="", max_length=80)
    note: str = item("what a user of the numbers should know", default="", max_length=800)
    simulated: list[Simulated] = item("others' simulations of this test", default_factory=list)

    @property
    def direct(self) -> bool:
        """Whether it is answered without a bend."""
        return self.observable.quantity in DIRECT

    @property
    def fitted(self) -> tuple[bool, ...]:
        """Of each load, whether a calibration may use its readings."""
        most = float("inf") if self.fit_up_to is None else self.fit_up_to
        return tuple(not self.held_out and load <= most for load in self.load.values)


class Weighed(Model):
    """A part on the balance."""

    what: str = item("which part", min_length=1, max_length=100)
    mass: float = quantity("g", 0, 1e4, "what it weighs")
    volume: float | None = quantity("cm3", 0, 1e4, "of its CAD model", default=None)
    source: str = item("where the numbers come from", min_length=1)


class Measurements(Model):
    """A measurements file."""

    schema_: Literal["handgen.measurements/1"] = Field(alias="schema", description="version of this format")
    name: str = item("of the campaign, for people", min_length=1, max_length=100)
    hand: str = item("parameter file of the hand that was measured, relative to this file", min_length=1)
    finger: str = item("which finger", min_length=1, max_length=40)
    source: str = item("where the numbers come from", min_length=1, max_length=800)
    weighed: list[Weighed] = item("parts on the balance", default_factory=list)
    tests: list[Test] = item("what was measured", min_length=1, max_length=100)
