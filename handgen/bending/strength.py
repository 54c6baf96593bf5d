"""What an actuator's wall bears: the pressure beyond which no bend of it is worth computing."""

from __future__ import annotations

import numpy as np

from handgen.geometry.profile import ActuatorProfile
from handgen.materials.law import Law
from handgen.materials.states import PLANAR, nominal_stress

STATIONS, STRETCHES = 50, 200


def tearing_pressure(profile: ActuatorProfile, depth: float, held: float, law: Law,
                     elongation: float) -> float:
    """Pressure, MPa, at which a free actuator's weakest section is stretched by `elongation` (1 = 100 %).

    The thread, whose centre lies `depth` mm outside the large core, keeps every circle as long as it is:
    the wall is in planar tension, P(l) A = p pi r_f^2 with the nominal stress P, the wall's section A and
    the thread's radius r_f. A law whose stress falls again bears no more than its peak. Between `held` and
    the chamber's end, mm.
    """
    x = np.linspace(held, profile.small_core_end, STATIONS)
    thread = profile.large_core(x) + depth
    share = (profile.outer(x) ** 2 - profile.small_core(x) ** 2) / thread**2
    stretch = np.linspace(1.0, 1.0 + elongation, STRETCHES)[1:]
    return float(nominal_stress(law, PLANAR, stretch).max() * share.min())
