"""A balance that shows only the part of a slanting force that acts along its own axis."""

from __future__ import annotations

import math
from types import MappingProxyType

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class ContactAngle(Effect):
    """The fingertip pushes at an angle; the balance shows the cosine's share."""

    id = "contact_angle"
    name = "angle of the fingertip's force"
    sentence = ("The fingertip pushes at {angle:.0f} degrees to the balance's axis, which shows the cosine's "
                "share")
    signature = "fingertip forces read low by the same share at every pressure; nothing else changes"
    source = 'Section 5.2.4: "the balance only measures the vertical component"'
    settle = "a photograph from the side at the largest pressure; or a balance tilted by a known angle"
    settled_by = ("force_angle",)
    parameters = (Parameter(
        "angle", "deg", 0.0, 60.0, 0.0, Prior("normal", (30.0, 12.0)),
        "between the force and the balance's axis"),)

    told_by = MappingProxyType({"base_compliance": ("force_angle",)})

    def on_reading(self, quantity, loads, values, p):
        if quantity == "force_angle":
            return [None if value is None else value + p["angle"] for value in values]
        if quantity != "tip_force":
            return values
        share = math.cos(math.radians(p["angle"]))
        return [None if value is None else share * value for value in values]


EFFECT = ContactAngle()
