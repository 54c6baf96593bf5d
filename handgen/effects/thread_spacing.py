"""Turns of thread that lie farther apart than drawn."""

from __future__ import annotations

import math
from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior
from handgen.mechanics.bulge import Wall, height

USUAL = 0.04
"""MPa at which the bulge is judged; it grows a little less than the pressure."""
OUTWARDS = 2.0 / 3.0
"""Of an arc's height, its mean."""


class ThreadSpacing(Effect):
    """Fewer turns, and between them the wall bulges further: the circles are held less.

    What the wall bulges on average between two turns (`mechanics.bulge`), beyond what it does at the hand's
    own pitch, gives way in series with the thread.
    """

    id = "thread_spacing"
    name = "wide thread"
    sentence = ("The turns of the thread lie {wider:.2f} times as far apart as drawn, and the wall bulges "
                "between them")
    signature = ("the free actuator goes less far at low and further at high pressure, and grows thicker; in "
                 "its bore the bulge is stopped, so the assembly shows less; the bare exoskeleton is "
                 "untouched")
    source = "Section 4.2.2: wound by hand, no pitch is given; Figure 5.8 models 44 rings"
    settle = "count the turns over 20 mm through the silicone"
    parameters = (Parameter(
        "wider", "1", 1.0, 2.6, 1.0, Prior("lognormal", (1.5, 0.28)), "pitch over the hand's"),)

    def on_case(self, case, p):
        winding = case.winding
        if winding is None or p["wider"] == 1.0:
            return case
        profile, middle = case.actuator, (case.held + case.actuator.small_core_end) / 2
        wall = Wall(profile.small_core(middle), profile.large_core(middle) + winding.depth,
                    profile.outer(middle), case.silicone.law.shear_modulus)
        wide = p["wider"] * winding.pitch
        more = bulge(wall, wide - winding.diameter) - bulge(wall, winding.pitch - winding.diameter)
        return replace(case, winding=replace(winding, pitch=wide, bulge=winding.bulge + more))


def bulge(wall: Wall, gap: float) -> float:
    """mm/MPa that `wall` moves out on average over a `gap` between two turns.

    Raises:
        ValueError: it balloons there.
    """
    angle = wall.half_angle(USUAL, gap)
    if not math.isfinite(angle):
        raise ValueError(f"turns {gap:.1f} mm apart let the wall balloon at {1e3 * USUAL:g} kPa")
    return OUTWARDS * height(angle, gap) / USUAL


EFFECT = ThreadSpacing()
