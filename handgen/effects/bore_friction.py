"""Friction between actuator and bore that the model leaves out."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior

MOST = 2.0
"""Coefficient beyond which nothing slides here."""


class BoreFriction(Effect):
    """Adds to the model's coefficient, in a bore that may be too narrow for its actuator.

    Friction needs something that presses: pressure does, and at rest, where own weight does but little, a
    bore that came out too small. An actuator that is gripped bends with its strips, and the unloaded finger
    hangs higher.
    """

    id = "bore_friction"
    name = "friction in the bore"
    sentence = ("The actuator rubs in its bore, with a coefficient {more:.2f} larger than the model's, and "
                "is gripped by {grip:.2f} mm all around")
    signature = ("the assembly's angle stays behind going up and stays ahead coming down: a loop of degrees; "
                 "gripped, it hangs higher at rest; at high pressure it bends less and does not fold; single "
                 "parts are untouched")
    source = ("Section 5.2.3 lets it slide without friction; dry silicone rubber slides at 1 and more: "
              "Tribology Transactions 53 (2010) 1-6; round holes out of a nozzle are some 0.1 to 0.3 mm "
              "narrower than drawn unless compensated, and TPU shrinks by 0.5 to 1 % (assumed)")
    settle = ("read the assembly going down as well as up; or powder the actuator with talc and read again; "
              "measure bore and actuator with a calliper")
    parameters = (
        Parameter("more", "1", 0.0, 1.5, 0.0, Prior("lognormal", (0.6, 0.5)),
                  "Coulomb's coefficient beyond the model's"),
        Parameter("grip", "mm", 0.0, 0.25, 0.0, Prior("normal", (0.06, 0.07)),
                  "by which the bore's radius is too small for its actuator"))

    def on_case(self, case, p):
        if case.part != "assembly":
            return case
        found = case.contact
        friction = max(min(MOST, found.friction + p["more"]), found.friction)
        return replace(case, contact=replace(found, friction=friction, clearance=found.clearance - p["grip"]))


EFFECT = BoreFriction()
