"""A finger whose root gives in its clamp."""

from __future__ import annotations

import math
from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class BaseCompliance(Effect):
    """The whole finger turns about the middle of its root, against a spring."""

    id = "base_compliance"
    name = "soft base"
    sentence = "The finger's root turns in its clamp, by {compliance:.3f} degrees for every N mm"
    signature = ("exoskeleton and assembly sink further the more hangs on them, angles of the fingertip by "
                 "just as much; a fingertip that is stopped pushes less; the free actuator is untouched")
    source = ("Section 5.2.1: the palm lay on a surface and was not clamped, its fingers hung over the edge; "
              "a palm 10 mm thick and as soft as Table 5.5 gives some 0.15 degrees a N mm over 20 mm; the "
              "model holds the root rigidly")
    settle = "a marker on the palm beside the root: photograph it without and with the largest weight"
    parameters = (Parameter(
        "compliance", "deg/(N mm)", 0.0, 0.8, 0.0, Prior("lognormal", (0.25, 0.7)),
        "turn of the root for a moment; own weight and 0.5 N at the tip make some 30 N mm"),)

    def on_case(self, case, p):
        if case.part == "actuator":
            return case
        return replace(case, base_compliance=case.base_compliance + math.radians(p["compliance"]))


EFFECT = BaseCompliance()
