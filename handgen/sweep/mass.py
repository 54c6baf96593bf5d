"""Volumes of a finger and its actuator from their profiles, mm3, and what they weigh, g."""

from __future__ import annotations

import math

import numpy as np

from handgen.geometry.actuator import profile_of
from handgen.geometry.profile import FingerProfile
from handgen.geometry.strip import strip_sections
from handgen.parameters.model import Hand

STATIONS = 800
"""Sections along a finger; along a slot a twentieth of them."""


def exoskeleton(hand: Hand, name: str) -> float:
    """Volume of finger `name` on its own: the tube with its rounded tip, less what the slots leave open."""
    profile = FingerProfile(getattr(hand.fingers, name))
    f = profile.finger

    def ring(x):
        return math.pi * (profile.outer(x) ** 2 - profile.bore(x) ** 2)

    tube = _integral(ring, 0.0, f.inner_length)
    # Half an ellipsoid on the tip's radius.
    dome = 2 / 3 * math.pi * float(profile.outer(f.inner_length)) ** 2 * (f.outer_length - f.inner_length)
    gone = 0.0
    for joint in f.joints:
        a, b = joint.position - joint.slot_length / 2, joint.position + joint.slot_length / 2
        strip = _integral(lambda x, j=joint: strip_sections(profile, j, hand.exoskeleton.joint_fillet, x)[0],
                          a, b, STATIONS // 20)
        gone += _integral(ring, a, b, STATIONS // 20) - strip
    return tube + dome - gone


def actuator(hand: Hand, name: str) -> tuple[float, float]:
    """(volume of the silicone, of the chamber in it)."""
    cast = profile_of(hand, name)
    whole = _integral(lambda x: math.pi * cast.outer(x) ** 2, 0.0, cast.length)
    chamber = _integral(lambda x: math.pi * cast.small_core(x) ** 2, 0.0, cast.small_core_end)
    return whole - chamber, chamber


def _integral(area, start: float, end: float, stations: int = STATIONS) -> float:
    edges = np.linspace(start, end, stations + 1)
    return float(area((edges[1:] + edges[:-1]) / 2).sum() * (end - start) / stations)
