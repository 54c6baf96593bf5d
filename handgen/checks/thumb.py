"""Rule on the thumb's hinge: do its two actuators turn the thumb far enough to oppose."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from handgen.checks.limits import Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.geometry.actuator import profile_of
from handgen.geometry.palm import finger_placement, on_axis
from handgen.geometry.part import Part
from handgen.geometry.thumb import Hinge
from handgen.mechanics.hinge import (
    Pusher,
    flexibility,
    opposition_angle,
    rectangle,
    section_matrix,
    turned_out,
)
from handgen.mechanics.silicone import shear_modulus
from handgen.parameters.model import Hand

if TYPE_CHECKING:
    from manifold3d import Manifold

RULE = "thumb.palm-stiffness"
HAND = "exoskeleton/hand"
KPA = 1e-3
"""MPa in a kPa."""
STATIONS = 12
"""Sections across the gap, each in the middle of its part."""
EDGE = 1e-4
"""A triangle this near a cut, mm, lies in it."""
THINNEST = 0.4
"""Thinnest sheet, mm, that is worth proposing: about one line of a nozzle."""
MARGIN = 1.25
"""How much farther than the limit the proposed sheet turns."""


def palm_stiffness(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """The opposition actuators must turn the thumb's metacarpal out of the palm's plane.

    The angle that they reach at working pressure (`handgen.mechanics.hinge`) against sections measured on
    the hand's mesh; the angle needed is what the thumb, as placed, lacks of `abduction`.

    Raises:
        GeometryError: an opposition actuator without wall or chamber.
    """
    if hand.opposition is None or HAND not in parts:
        return skipped(RULE, "no thumb that opposes in this build")
    modulus = limits.find(RULE, "modulus", hand.printing.hand.material)
    if modulus is None:
        return skipped(RULE, f"no modulus is known of {hand.printing.hand.material}")
    pressure = limits.get(RULE, "working_pressure")
    abduction = limits.get(RULE, "abduction")
    hinge, length = Hinge(hand), hand.opposition.free_length
    sections, stations = hinge_sections(hand, parts[HAND].triangles)
    mu, pushing = shear_modulus(hand.casting.silicone.modulus_100), pushers(hand)

    def reached(flexible: np.ndarray) -> float:
        return opposition_angle(flexible, pushing, pressure.value * KPA, modulus.value, mu)

    angle, needed = reached(flexibility(sections, length)), angle_needed(hand, abduction.value)
    stiffest = int(np.argmax(sections[:, 1, 1] - sections[:, 0, 1] ** 2 / sections[:, 0, 0]))
    area, height, _ = sections[stiffest, 0]
    findings = []
    if angle < needed - 1e-9:
        where = hinge.point(stations[stiffest], 0.0, height / area)
        findings.append(Finding(
            RULE, "error", HAND, angle, needed, "deg",
            f"at {pressure.value:g} kPa the two actuators turn the thumb {angle:.1f} of the"
            f" {needed:.1f} degrees that opposition needs; the stiffest section across the hinge has"
            f" {area:.0f} mm2",
            _mend(hand, reached, angle, needed), f"{abduction.source}; modulus: {modulus.source}",
            tuple(float(c) for c in np.multiply(where, (1, -1 if hand.side == "left" else 1, 1)))))
    reason = f"opposition at {pressure.value:g} kPa, sheet of {modulus.value:g} MPa"
    return judged(RULE, angle, needed, reason, findings)


def _mend(hand: Hand, reached, angle: float, needed: float) -> str:
    """What a plain sheet of another thickness would do."""
    from scipy.optimize import brentq

    o, top = hand.opposition, Hinge(hand).top

    def plain(thickness: float) -> float:
        return reached(flexibility(rectangle(o.sheet_width, top - thickness, top)[None], o.free_length))

    if plain(THINNEST) < needed:
        return ("no sheet is thin enough: lengthen opposition.free_length, add to the actuators' thrust"
                " (a larger radius, less silicone), or tilt the thumb towards the palm as printed")
    aims = {f"{goal:.1f}": brentq(lambda t, goal=goal: plain(t) - goal, THINNEST, 40.0)
            for goal in (needed, MARGIN * needed) if plain(THINNEST) >= goal}
    mend = "make opposition.sheet_thickness " + ", or ".join(
        f"{math.floor(10 * t) / 10:g} mm for {goal} degrees" for goal, t in aims.items())
    expected = plain(o.sheet_thickness)
    if angle < 0.8 * expected:
        mend = (f"clear the gap: the sheet of {o.sheet_thickness:g} mm alone would turn"
                f" {expected:.1f} degrees, something beside it holds the thumb; then {mend}")
    return mend


def pushers(hand: Hand) -> list[Pusher]:
    """The opposition actuators: what lies between plug and tip, its radii in the middle."""
    found = []
    for name, v in Hinge(hand).lines.items():
        profile = profile_of(hand, name)
        start, end = hand.seal.plug_length, profile.small_core_end
        middle, thread = (start + end) / 2, hand.thread_of(name)
        lies = profile.large_core(middle) + (0.0 if thread.groove else thread.diameter / 2)
        found.append(Pusher(v, end - start, profile.small_core(middle), lies, profile.outer(middle)))
    return found


def angle_needed(hand: Hand, abduction: float) -> float:
    """Turn of the hinge, deg, that brings the thumb's first phalanx `abduction` deg out of the palm."""
    axis = np.array(finger_placement(hand, "thumb")[0])[:, 0]
    return max(0.0, turned_out(axis @ np.array(Hinge(hand).rotation), abduction))


def hinge_sections(hand: Hand, mesh) -> tuple[np.ndarray, np.ndarray]:
    """(S (n, 3, 3), u (n,)) of all that the thumb hangs on, cut across the gap (hinge frame, mm).

    At each station the hand is cut in two, and of what falls on the thumb's side only the piece with
    the thumb counts: fingers that cross the same plane do not.
    """
    hinge, length = Hinge(hand), hand.opposition.free_length
    mirrored = hand.side == "left"
    vertices = hinge.local(np.asarray(mesh.vertices, float) * ((1, -1, 1) if mirrored else (1, 1, 1)))
    tip = hinge.local(on_axis(hand, "thumb", hand.fingers.thumb.outer_length))
    rest = _solid(vertices, mesh.faces[:, ::-1] if mirrored else mesh.faces)
    stations = (np.arange(STATIONS) + 0.5) / STATIONS * length
    sections = []
    for u in stations:
        rest = _with(rest.trim_by_plane((1.0, 0.0, 0.0), float(u)), tip)
        sections.append(section_matrix(_cut_face(rest, u)))
    return np.array(sections), stations


def _solid(vertices: np.ndarray, faces: np.ndarray) -> Manifold:
    from manifold3d import Manifold, Mesh

    return Manifold(Mesh(np.array(vertices, np.float32, order="C"), np.array(faces, np.uint32, order="C")))


def _with(solid: Manifold, point: np.ndarray) -> Manifold:
    """The piece of `solid` whose surface comes nearest to `point`."""
    def distance(piece: Manifold) -> float:
        return float(np.linalg.norm(piece.to_mesh().vert_properties[:, :3] - point, axis=1).min())

    return min(solid.decompose(), key=distance)


def _cut_face(solid: Manifold, u: float) -> np.ndarray:
    """Triangles (n, 3, 2), (v, w), of the flat face that a cut at `u` has left."""
    mesh = solid.to_mesh()
    corners = mesh.vert_properties[:, :3].astype(float)[mesh.tri_verts]
    return corners[(abs(corners[:, :, 0] - u) < EDGE).all(axis=1)][:, :, 1:]
