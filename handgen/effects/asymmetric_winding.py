"""An actuator that is stiffer on one side."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior

THINNEST = 0.3
"""mm of silicone that must be left outside the thread."""


class AsymmetricWinding(Effect):
    """Core and thread lie off the middle of the wall, in the plane of bending: the thick side gives less."""

    id = "asymmetric_winding"
    name = "asymmetric winding"
    sentence = ("Core and thread lie {offset:+.2f} mm off the middle of the wall (+: towards its back): it "
                "bends by itself")
    signature = ("the free actuator bends, and its tip travels less far along the axis; the assembly flexes "
                 "more (thick side palmar) or less; the bare exoskeleton is untouched")
    source = "Section 5.2.2: above 50 kPa the actuator folds to one side, its thread being wound by hand"
    settle = ("cut a spoiled actuator across and measure the wall on both sides; photograph a free one at 40 "
              "kPa")
    parameters = (Parameter(
        "offset", "mm", -0.6, 0.6, 0.0, Prior("normal", (0.0, 0.25)),
        "of core and thread, towards the back"),)

    def on_case(self, case, p):
        if case.actuator is None:
            return case
        offset = case.offset + p["offset"]
        left = case.actuator.layers.external - abs(offset)
        if left < THINNEST:
            raise ValueError(f"{left:.2f} mm of silicone would be left outside the thread")
        return replace(case, offset=offset)


EFFECT = AsymmetricWinding()
