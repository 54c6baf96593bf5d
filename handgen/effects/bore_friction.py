"""Friction between actuator and bore that the model leaves out."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior

MOST = 2.0
"""Coefficient beyond which nothing slides here."""


class BoreFriction(Effect):
    """Adds to the model's coefficient."""

    id = "bore_friction"
    name = "friction in the bore"
    sentence = "The actuator rubs in its bore, with a coefficient larger by {more:.2f} than the model's"
    signature = ("the assembly's angle stays behind going up and stays ahead coming down: a loop of degrees; "
                 "at high pressure it bends less and does not fold; single parts are untouched")
    source = ("Section 5.2.3 lets it slide without friction; dry silicone rubber slides at 1 and more: "
              "Tribology Transactions 53 (2010) 1-6")
    settle = "read the assembly going down as well as up; or powder the actuator with talc and read again"
    parameters = (Parameter(
        "more", "1", 0.0, 1.5, 0.0, Prior("lognormal", (0.6, 0.5)),
        "Coulomb's coefficient beyond the model's"),)

    def on_case(self, case, p):
        if case.part != "assembly":
            return case
        friction = min(MOST, case.contact.friction + p["more"])
        return replace(case, contact=replace(case.contact, friction=max(friction, case.contact.friction)))


EFFECT = BoreFriction()
