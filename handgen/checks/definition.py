"""Rules that need no mesh: a hand judged from its definition alone, in milliseconds.

Five rules read nothing but parameters anyway. Three more are put in closed form, for the fingers and their
actuators: `wall.minimum` and `hinge.strain` from the profiles instead of the mesh. Whatever else the mesh
shows (lines, overhangs, openings, moulds, the palm) is not judged here: a hand that passes is one worth
meshing, not one worth printing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from handgen.checks import actuators, thread
from handgen.checks.limits import Limit, Limits
from handgen.checks.motion import STRIP_SECTIONS, allowed_strain
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.checks.run import report
from handgen.geometry.actuator import profile_of
from handgen.geometry.profile import FingerProfile
from handgen.geometry.strip import strip_sections
from handgen.parameters.finger import Joint
from handgen.parameters.model import Hand

ROUNDING = 1e-6
STATIONS = 65
"""Places along a profile at which walls are read."""


def judge(hand: Hand, limits: Limits) -> dict[str, Any]:
    """The contract's `handgen.checks/1` of the rules that a definition can answer.

    Raises:
        GeometryError: an actuator without wall or chamber.
    """
    named = dict.fromkeys(f"actuators/{name}" for name in hand.actuators.present())
    rules = (thread.gap, thread.layer, actuators.layers, actuators.clearance, actuators.length)
    return report(hand, [walls(hand, limits), strain(hand, limits), *(r(hand, named, limits) for r in rules)])


def walls(hand: Hand, limits: Limits) -> Outcome:
    """`wall.minimum` of fingers and actuators, radially."""
    rule, findings, nearest = "wall.minimum", [], None
    for part, path, least, thickness, x in _walls(hand, limits):
        at = int(np.argmin(thickness))
        wall = float(thickness[at])
        if nearest is None or wall - least.value < nearest[0]:
            nearest = wall - least.value, wall, least.value, part
        if wall < least.value - ROUNDING:
            findings.append(Finding(
                rule, "error", part, wall, least.value, "mm",
                f"the wall is {wall:.2f} mm thin; {least.value:.2f} mm are needed",
                f"widen {path}", least.source, (float(x[at]), 0.0, 0.0)))
    if nearest is None:
        return skipped(rule, "no finger and no actuator")
    _, wall, least_value, part = nearest
    return judged(rule, wall, least_value, f"thinnest for its process: {part}", findings)


def _walls(hand: Hand, limits: Limits) -> Iterator[tuple[str, str, Limit, np.ndarray, np.ndarray]]:
    """(part, key paths, least thickness, thickness at x, x)."""
    rule = "wall.minimum"
    process = hand.printing.finger
    kinds = ("exoskeleton", process.material, "finger")
    lines, less = (limits.get(rule, name, *kinds) for name in ("lines", "under_extrusion"))
    least = Limit(lines.value * process.nozzle_size / (1.0 - less.value), "mm", lines.source)
    for name, finger in hand.fingers.present().items():
        profile = FingerProfile(finger)
        x = np.linspace(0.0, finger.inner_length, STATIONS)
        yield f"exoskeleton/{name}", f"fingers.{name}", least, profile.outer(x) - profile.bore(x), x
    pourable = limits.get(rule, "pourable", hand.casting.silicone.name)
    for name in hand.actuators.present():
        cast = profile_of(hand, name)
        x = np.linspace(0.0, cast.small_core_end, STATIONS)
        yield (f"actuators/{name}", f"layers or actuators.{name}", pourable,
               cast.outer(x) - cast.small_core(x), x)


def strain(hand: Hand, limits: Limits) -> Outcome:
    """`hinge.strain` on the strips' sections as they are drawn: ring sectors with rounded corners."""
    rule, findings, worst = "hinge.strain", [], (0.0, "")
    processes = [hand.printing.finger, *([hand.printing.hand] if hand.palm else [])]
    limit = min((a for p in processes if (a := allowed_strain(limits, p.material))),
                key=lambda one: one.value, default=None)
    if limit is None or not hand.fingers.present():
        return skipped(rule, "no finger, or neither yield nor break is known for its material")
    for name, finger in hand.fingers.present().items():
        profile = FingerProfile(finger)
        for i, joint in enumerate(finger.joints):
            full = limits.get(rule, "full_curl", joint.name).value
            angle = math.radians(max(0.0, full - joint.rest_angle))
            value, x = strip_strain(profile, joint, hand.exoskeleton.joint_fillet, angle)
            worst = max(worst, (value, f"{name} {joint.name}"))
            if value > limit.value + ROUNDING:
                findings.append(Finding(
                    rule, "error", f"exoskeleton/{name}", value, limit.value, "1",
                    f"{joint.name}'s strip is stretched by {100 * value:.0f} % at full curl;"
                    f" {100 * limit.value:.0f} % are allowed",
                    f"lengthen fingers.{name}.joints.{i}.slot_length or narrow its palmar_arc",
                    limit.source, (x, 0.0, -float(profile.outer(x)))))
    return judged(rule, worst[0], limit.value, f"largest at {worst[1]}", findings)


def strip_strain(profile: FingerProfile, joint: Joint, fillet: float, angle: float) -> tuple[float, float]:
    """(largest strain, its x) of a joint's strip bent by `angle`, rad, under an even moment."""
    step = joint.slot_length / STRIP_SECTIONS
    x = joint.position - joint.slot_length / 2 + step * (np.arange(STRIP_SECTIONS) + 0.5)
    _, centroid, second, near, far = strip_sections(profile, joint, fillet, x)
    curvature = angle / (second * (step / second).sum())
    strains = curvature * np.maximum(np.abs(near - centroid), np.abs(far - centroid))
    at = int(np.argmax(strains))
    return float(strains[at]), float(x[at])

