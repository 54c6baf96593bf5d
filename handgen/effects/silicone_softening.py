"""Silicone that is softer than its bulletin."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.laws import softened
from handgen.effects.parameter import Parameter, Prior


class SiliconeSoftening(Effect):
    """All stresses of the silicone by one factor."""

    id = "silicone_softening"
    name = "soft silicone"
    sentence = "The silicone is softer than its law by a share of {softening:.2f} at every stretch"
    signature = ("free actuator and assembly move further by much the same share at every pressure; loads "
                 "and unloads alike, does not change with time; the bare exoskeleton is untouched")
    source = ("Section 5.2.2 lowers the mu of Ecoflex 00-50 by a quarter from set 2 to set 3; Appendix C: "
              "mixing off 1A:1B and a cold or short cure soften it")
    settle = "pull a strip of the same pour to 100 % and compare with the bulletin's stress"
    parameters = (Parameter(
        "softening", "1", 0.0, 0.5, 0.0, Prior("normal", (0.2, 0.12)),
        "share of its stresses that is missing"),)

    def on_case(self, case, p):
        if case.silicone is None:
            return case
        return replace(case, silicone=softened(case.silicone, 1.0 - p["softening"]))


EFFECT = SiliconeSoftening()
