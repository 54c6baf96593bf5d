"""A gauge whose zero is off."""

from __future__ import annotations

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class PressureOffset(Effect):
    """The chamber sees so much more than the gauge says, but never suction."""

    id = "pressure_offset"
    name = "pressure offset"
    sentence = "The chamber sees {offset:+.1f} kPa beside what the gauge says, at every reading"
    signature = ("free actuator and assembly are shifted along the pressure by the same amount everywhere, "
                 "also at 0 kPa; weights on the bare exoskeleton are untouched")
    source = ("data sheet of the MPX4250AP, an absolute sensor: 1.4 % of 250 kPa, and the weather's air "
              "pressure")
    settle = "open the line to the air and read the gauge; a water column for a second point"
    settled_by = ("chamber_pressure",)
    parameters = (Parameter(
        "offset", "kPa", -12.0, 12.0, 0.0, Prior("normal", (0.0, 5.0)),
        "pressure in the chamber less that of the gauge"),)

    def on_pressures(self, kilopascals, p):
        return [max(0.0, pressure + p["offset"]) for pressure in kilopascals]


EFFECT = PressureOffset()
