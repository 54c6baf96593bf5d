"""Silicone that is softer below the largest stretch it has seen."""

from __future__ import annotations

import math

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior

SPREAD = 0.6
"""beta of Ogden and Roxburgh, their m left out: how soon below the largest energy the softening sets in."""


class Mullins(Effect):
    """Pseudo-elastic softening of the silicone as a whole; its energy goes with the pressure's square.

    eta = 1 - depth erf((1 - (p / p_most)^2) / SPREAD): a run that goes further than any before follows the
    law; coming down, and in every repeat, the same pressure finds it softer. What is compared is the mean
    over the repeats, the first of which finds the actuator as it was cast.
    """

    id = "mullins"
    name = "Mullins effect"
    sentence = ("Silicone that was stretched before is softer below that stretch, by a share of up to "
                "{depth:.2f}")
    signature = ("coming down lies above going up, and later repeats above the first, most at low pressure "
                 "and not at the largest; only where silicone is stretched: not the bare exoskeleton")
    source = ("R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. Lond. A 455 (1999) 2861-2877; the source reads "
              "loading only")
    settle = "read the free actuator going up, down and up again, beginning with a fresh one"
    parameters = (Parameter(
        "depth", "1", 0.0, 0.5, 0.0, Prior("normal", (0.2, 0.1)), "largest share of stiffness lost, 1/r"),)

    def on_course(self, course, p):
        most, count = max(course.pressures), course.repeats
        return [p["depth"] * (_softness(now, before) + (count - 1) * _softness(now, most)) / count
                for now, before in zip(course.pressures, course.before, strict=True)]


def _softness(now: float, most: float) -> float:
    """erf term at pressure `now` after `most`; no pressure at all has stretched nothing."""
    return math.erf((1.0 - (now / most) ** 2) / SPREAD) if most > 0.0 else 0.0


EFFECT = Mullins()
