"""Play between actuator and bore."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class BoreClearance(Effect):
    """The bore, and nothing else of the exoskeleton, is wider all around."""

    id = "bore_clearance"
    name = "play in the bore"
    sentence = "The actuator has {gap:.2f} mm of play in its bore all around"
    signature = ("the assembly hangs lower at rest and at low pressure, where the actuator does not yet fill "
                 "its bore and carry it; hardly anything is left above; single parts are untouched")
    source = ("Section 5.2.2: the mould was drawn for 0.5 mm thread and wound with 0.15 mm; prints and casts "
              "shrink, and bores out of a nozzle are off by tenths of a millimetre (assumed)")
    settle = "measure bore and actuator with a calliper, or push wire of known thickness beside the actuator"
    parameters = (Parameter(
        "gap", "mm", 0.0, 1.0, 0.0, Prior("lognormal", (0.3, 0.7)), "radial clearance"),)

    def on_case(self, case, p):
        if case.part != "assembly":
            return case
        return replace(case, contact=replace(case.contact, clearance=case.contact.clearance + p["gap"]))


EFFECT = BoreClearance()
