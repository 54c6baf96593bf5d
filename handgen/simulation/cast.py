"""What the finger that it was slid into strains an actuator by: its rest curl, and a bore that is too narrow.

A finger with a rest curl is simulated from its curled shape on, in which the actuator, cast straight, lies
along the same axis. What share of the curl the silicone has taken since, by set and creep, it does not strain
for: free of stress it follows the axis curled by that share of every joint's angle. A bore that is narrower
than its actuator is opened until the two just touch. From this state, which is in balance as drawn, to the
real one a load leads as any other: the share of the fit.
"""

from __future__ import annotations

import numpy as np

from handgen.geometry.finger import Axis
from handgen.geometry.profile import FingerProfile
from handgen.simulation.case import Case


def free_of_stress(case: Case, straight: np.ndarray, share: float) -> np.ndarray:
    """Nodes `straight` (n, 3) of the actuator in the shape that is free of stress, mm, at a `share` of the
    fit."""
    finger = case.finger.finger
    joints = [joint.model_copy(update={"rest_angle": (1.0 - share * case.curl_strains) * joint.rest_angle})
              for joint in finger.joints]
    profile = FingerProfile(finger.model_copy(update={"joints": joints}))
    return Axis(profile, case.fillet, case.root_angle).carry(straight)
