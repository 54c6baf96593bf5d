"""Rules on the moving hand: fingers that meet one another, and hinges that are bent too far."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from handgen.checks.curl import CurlingFinger, curling_fingers
from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.checks.worst import telling
from handgen.geometry.part import Part
from handgen.parameters.model import Hand

ROUNDING = 1e-6
SEARCH = 12.0
"""Fingers farther apart than this, mm, need no closer look."""
MARGIN = 0.01
"""How much farther than a known gap is searched, mm."""
CURL_STEPS = 6
SPLAYS = (1.0, 0.0)
"""Shares of the splay at which fingers are moved: as built, and pressed together."""
STRIP_SECTIONS = 12


@dataclass(frozen=True)
class Meeting:
    """How near two fingers come in one pose: gap in mm, or the volume in mm3 that both would fill."""

    pose: str
    gap: float
    overlap: float = 0.0
    where: tuple[float, float, float] | None = None


def interference(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Neighbouring fingers keep apart as printed, and clear one another however they curl.

    All fingers curl together, and each alone beside a straight one, from rest to full curl, with
    the splay as built and with none. The thumb counts as printed only: it is made to meet the fingers.
    """
    rule = "fingers.interference"
    fingers = curling_fingers(hand, parts)
    if len(fingers) < 2:
        return skipped(rule, "fewer than two fingers")
    least, most = limits.get(rule, "least_gap"), limits.get(rule, "overlap")
    findings, nearest, overlap = [], Meeting("", SEARCH), 0.0
    for a, b in _neighbours(fingers):
        worst = rest = _meet(a, b, "as printed", a.poses(_still(a)), b.poses(_still(b)), Meeting("", SEARCH))
        if rest.gap < least.value - ROUNDING:
            findings.append(_too_near(rule, a, b, rest, least))
        if "thumb" not in (a.name, b.name):
            for pose in _sweep(a, b, limits, rule):
                worst = min(worst, _meet(a, b, *pose, worst), key=lambda m: (m.gap, -m.overlap))
        if worst.overlap > most.value + ROUNDING:
            findings.append(_overlapping(rule, a, b, worst, most))
        overlap, nearest = max(overlap, worst.overlap), min(nearest, worst, key=lambda m: m.gap)
    reason = (f"least gap {nearest.gap:.2f} mm, {nearest.pose}" if nearest.pose
              else f"no two fingers within {SEARCH:g} mm")
    return telling(rule, overlap, most.value, reason, findings)


def _neighbours(fingers: Mapping[str, CurlingFinger]) -> list[tuple[CurlingFinger, CurlingFinger]]:
    """Fingers side by side along the knuckles, and the thumb with the one next to it."""
    row = sorted((f for n, f in fingers.items() if n != "thumb"), key=lambda f: -f.finger.placement.root[1])
    pairs = list(pairwise(row))
    if "thumb" in fingers and row:
        pairs.append((fingers["thumb"], row[0]))
    return pairs


def _still(finger: CurlingFinger) -> np.ndarray:
    return np.zeros(len(finger.finger.joints))


def _sweep(a: CurlingFinger, b: CurlingFinger, limits: Limits, rule: str):
    """(description, poses of a, poses of b) on the way to full curl, together and alone."""
    full = [f.full_curl(limits, rule) for f in (a, b)]
    for splay in SPLAYS:
        beside = "as built" if splay else "at splay 0"
        poses = [[f.poses(t * angles, splay) for t in np.linspace(0.0, 1.0, CURL_STEPS + 1)]
                 for f, angles in zip((a, b), full, strict=True)]
        for i in range(CURL_STEPS + 1):
            share = f"{100 * i / CURL_STEPS:.0f} % curled"
            yield f"both {share}, {beside}", poses[0][i], poses[1][i]
            if i:
                yield f"{a.name} alone {share}, {beside}", poses[0][i], poses[1][0]
                yield f"{b.name} alone {share}, {beside}", poses[0][0], poses[1][i]


def _meet(a: CurlingFinger, b: CurlingFinger, pose: str, poses_a: list, poses_b: list,
          worst: Meeting) -> Meeting:
    """Gap of the phalanges' hulls; where these touch, the overlap of the phalanges themselves.

    A pose that is no worse than `worst` is measured only as far as it takes to see that.
    """
    pose, gap, touching = f"{a.name} and {b.name} {pose}", worst.gap, []
    hulls_a = [h.transform(t) for h, t in zip(a.hulls, poses_a, strict=True)]
    hulls_b = [h.transform(t) for h, t in zip(b.hulls, poses_b, strict=True)]
    for i, first in enumerate(hulls_a):
        for j, second in enumerate(hulls_b):
            if _box_gap(first, second) > gap:
                continue
            between = first.min_gap(second, gap + MARGIN)
            gap = min(gap, between)
            if between <= 0.0:
                touching.append((i, j))
    if not touching:
        return Meeting(pose, gap)
    if sum((hulls_a[i] ^ hulls_b[j]).volume() for i, j in touching) <= worst.overlap:
        return Meeting(pose, 0.0)
    shared = [a.phalanges[i].transform(poses_a[i]) ^ b.phalanges[j].transform(poses_b[j])
              for i, j in touching]
    volumes = [s.volume() for s in shared]
    if max(volumes) <= 0.0:
        return Meeting(pose, 0.0)
    box = np.array(shared[int(np.argmax(volumes))].bounding_box()).reshape(2, 3)
    return Meeting(pose, 0.0, sum(volumes), tuple(box.mean(0).tolist()))


def _box_gap(a, b) -> float:
    """Distance of two solids' boxes, mm: never more than their own."""
    p, q = a.bounding_box(), b.bounding_box()
    return math.hypot(*(max(0.0, p[i] - q[i + 3], q[i] - p[i + 3]) for i in range(3)))


def _too_near(rule: str, a: CurlingFinger, b: CurlingFinger, rest: Meeting, limit: Limit) -> Finding:
    return Finding(
        rule, "error", "exoskeleton/hand", rest.gap, limit.value, limit.unit,
        f"{a.name} and {b.name} are printed {rest.gap:.2f} mm apart: the walls may fuse",
        f"move fingers.{b.name}.placement.root or change its splay", limit.source,
        _as_built(a.hand, rest.where or _nearest(a, b)))


def _overlapping(rule: str, a: CurlingFinger, b: CurlingFinger, worst: Meeting, limit: Limit) -> Finding:
    return Finding(
        rule, "error", "exoskeleton/hand", worst.overlap, limit.value, limit.unit,
        f"{worst.overlap:.1f} mm3 would be filled twice: {worst.pose}",
        f"spread fingers.{a.name}.placement and fingers.{b.name}.placement (root, splay, roll)",
        limit.source, _as_built(a.hand, worst.where))


def _nearest(a: CurlingFinger, b: CurlingFinger) -> tuple[float, float, float]:
    """The middle between the nearest corners of two fingers' meshes as printed, right hand's frame."""
    from scipy.spatial import cKDTree

    first, second = (
        f.surface.vertices @ pose[:, :3].T + pose[:, 3] for f in (a, b) for pose in f.poses(_still(f))[:1])
    distance, at = cKDTree(second).query(first)
    i = int(np.argmin(distance))
    return tuple(((first[i] + second[at[i]]) / 2).tolist())


def _as_built(hand: Hand, point: tuple[float, float, float]) -> tuple[float, float, float]:
    """A point of the right hand's frame on the hand that is built: a left one is the mirror image."""
    x, y, z = point
    return (x, -y if hand.side == "left" else y, z)


def strain(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """No palmar strip is stretched near yield, nor near break, when its joint is fully curled.

    Beam theory on the strip's sections as they are on the mesh, rounded corners included: under an
    even moment each stretch of the strip bends by M dx / (E I), so the outer fibre's strain is
    angle (c / I) / sum(dx / I). The neutral axis is taken through the sections' centroids.
    """
    rule = "hinge.strain"
    fingers = curling_fingers(hand, parts)
    if not fingers:
        return skipped(rule, "no finger")
    processes = [hand.printing.finger, *([hand.printing.hand] if hand.palm else [])]
    allowed = {m: limit for m in sorted({p.material for p in processes})
               if (limit := allowed_strain(limits, m))}
    if not allowed:
        return skipped(rule, "neither yield nor break is known for " + ", ".join(
            sorted({p.material for p in processes})))
    findings, worst = [], (0.0, "")
    for name, finger in fingers.items():
        for i, angle in enumerate(finger.full_curl(limits, rule)):
            joint = finger.finger.joints[i]
            value, x = strip_strain(finger, i, angle)
            worst = max(worst, (value, f"{name} {joint.name}"))
            findings += [
                _overbent(finger, i, angle, value, x, material, limit)
                for material, limit in allowed.items() if value > limit.value + ROUNDING
            ]
    least = min(allowed.values(), key=lambda limit: limit.value)
    unknown = sorted({p.material for p in processes} - allowed.keys())
    reason = f"largest at {worst[1]}"
    if unknown:
        reason += f"; not judged, neither yield nor break is known: {', '.join(unknown)}"
    return judged(rule, worst[0], least.value, reason, findings)


def strip_strain(finger: CurlingFinger, index: int, angle: float) -> tuple[float, float]:
    """(largest strain, its x along the axis) of a joint's strip bent by `angle`, rad."""
    joint = finger.finger.joints[index]
    step = joint.slot_length / STRIP_SECTIONS
    xs = joint.position - joint.slot_length / 2 + step * (np.arange(STRIP_SECTIONS) + 0.5)
    bending, levers, near = [], [], finger.around(joint)
    for x in xs:
        cut = finger.section_at(float(x), near)
        z = np.r_[cut.start[:, 1], cut.end[:, 1]] - cut.centroid[1]
        bending.append(cut.second_moment(1))
        levers.append(np.abs(z).max())
    curvature = angle / (np.array(bending) * (step / np.array(bending)).sum())
    strains = curvature * levers
    at = int(np.argmax(strains))
    return float(strains[at]), float(xs[at])


def allowed_strain(limits: Limits, material: str) -> Limit | None:
    """The smaller of yield and break, each over its safety; None: neither is known."""
    found = []
    for what in ("yield", "break"):
        elongation = limits.find("hinge.strain", f"elongation_at_{what}", material)
        if elongation:
            safety = limits.get("hinge.strain", f"{what}_safety", material)
            found.append(Limit(elongation.value / safety.value, "1",
                               f"{elongation.source}: {elongation.value:g} at {what}, over {safety.value:g}"))
    return min(found, key=lambda limit: limit.value, default=None)


def _overbent(finger: CurlingFinger, index: int, angle: float, value: float, x: float,
              material: str, limit: Limit) -> Finding:
    joint = finger.finger.joints[index]
    rotation, origin = finger.axis.placement(x)
    z = -(finger.profile.bore(x) + finger.profile.outer(x)) / 2
    where = np.array(rotation) @ (0.0, 0.0, z) + origin
    path = f"fingers.{finger.name}.joints.{index}"
    return Finding(
        "hinge.strain", "error", f"exoskeleton/{finger.name}", value, limit.value, limit.unit,
        f"{joint.name}'s strip of {material} is stretched by {100 * value:.0f} % when bent by"
        f" {np.degrees(angle):.0f} deg; {100 * limit.value:.0f} % are allowed",
        f"lengthen {path}.slot_length, or narrow {path}.palmar_arc", limit.source, tuple(where.tolist()))
