"""Joints that close before their strip is bent as far as it could."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class SelfContact(Effect):
    """The palmar edges of neighbouring bones meet what lies between them, and push."""

    id = "self_contact"
    name = "closing joints"
    sentence = ("A joint closes on itself when {left:.2f} of the distance of its palmar edges is left, and "
                "bends no further")
    signature = ("nothing at small curl; from some angle on the finger stops bending, joint by joint, under "
                 "weights as under pressure; the free actuator is untouched")
    source = ("nothing in the source's model stops a joint: its slots are 9 mm, a joint bent by 70 degrees "
              "leaves 7 mm between its palmar edges")
    settle = "bend a bare joint by hand until it stops and photograph its angle"
    parameters = (Parameter(
        "left", "1", 0.0, 0.98, 0.0, Prior("normal", (0.85, 0.08)),
        "share of the distance at rest of a slot's palmar edges that the strip's crease and rests of support "
        "take up"),)

    def on_case(self, case, p):
        if case.part == "actuator":
            return case
        return replace(case, edges_left=max(case.edges_left, p["left"]))


EFFECT = SelfContact()
