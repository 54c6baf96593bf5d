"""Sections of a joint's palmar strip, from the profile."""

from __future__ import annotations

import math

import numpy as np

from handgen.geometry.profile import FingerProfile
from handgen.parameters.finger import Joint


def strip_sections(profile: FingerProfile, joint: Joint, fillet: float, x: np.ndarray):
    """(area mm2, centroid mm, second moment mm4, nearest and farthest fibre mm) of a strip's sections at `x`.

    A sector of the ring between bore and outside, half as wide as the palmar arc and wider in the slot's
    rounded corners (wanted radius `fillet`); distances are palmar of the axis. The rounded corner is offset
    along the tangent, at the middle of the wall.
    """
    a, b = profile.bore(x), profile.outer(x)
    r = profile.fillet(joint, fillet)
    inside = np.clip(np.minimum(x - joint.position, joint.position - x) + joint.slot_length / 2, 0.0, r)
    more = r - np.sqrt(np.maximum(r * r - (r - inside) ** 2, 0.0))
    wider = np.arcsin(np.minimum(2 * more / (a + b), 1.0))
    half = np.minimum(math.radians(joint.palmar_arc / 2) + wider, np.pi)
    area = half * (b**2 - a**2)
    centroid = 2 * np.sin(half) * (b**3 - a**3) / 3 / area
    second = (half + np.sin(half) * np.cos(half)) * (b**4 - a**4) / 4 - area * centroid**2
    return area, centroid, second, a * np.cos(half), b
