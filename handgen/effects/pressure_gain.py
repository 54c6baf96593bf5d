"""A gauge whose scale is off."""

from __future__ import annotations

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class PressureGain(Effect):
    """The chamber sees a fixed share more than the gauge says."""

    id = "pressure_gain"
    name = "pressure gain"
    sentence = "The chamber sees {factor:.3f} times the pressure that the gauge says"
    signature = ("free actuator and assembly move as at another pressure, off by the same share everywhere: "
                 "right at 0 kPa, most off at the top; the bare exoskeleton is untouched")
    source = ("the MPX4250AP is ratiometric: a supply 5 % off reads 5 % off (data sheet); leaks lose "
              "pressure on the way to the chamber")
    settle = "a manometer or a water column at the actuator's own tube, at two pressures"
    settled_by = ("chamber_pressure",)
    parameters = (Parameter(
        "factor", "1", 0.75, 1.25, 1.0, Prior("normal", (1.0, 0.1)),
        "pressure in the chamber over that of the gauge"),)

    def on_pressures(self, kilopascals, p):
        return [p["factor"] * pressure for pressure in kilopascals]


EFFECT = PressureGain()
