"""The finger's exoskeleton, measured on the mesh that is printed (Table A.1)."""

import io
import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from handgen.geometry import brep_kernel
from handgen.geometry import finger as fingers
from handgen.geometry.csg import Revolve
from handgen.geometry.mesh_kernel import evaluate, printable
from handgen.geometry.profile import Curve, FingerProfile
from handgen.parameters.load import load
from handgen.parameters.model import FINGERS
from tests.conftest import PARAMS
from tests.probe import assert_printable, section_radii, walls_along

JUST = 0.3
"""Where a caliper's jaw sits beside an edge, mm."""


@pytest.fixture(scope="module", params=FINGERS)
def measured(request, adult):
    return getattr(adult.fingers, request.param), fingers.exoskeleton(adult, request.param)


@pytest.mark.parametrize("file", sorted(PARAMS.glob("*.yaml")), ids=lambda p: p.stem)
def test_table_a1(file):
    """Lengths and diameters of every shipped finger, on the STL that is written."""
    hand = load(file).hand
    for name, finger in hand.fingers.present().items():
        part = fingers.exoskeleton(hand, name)
        mesh = trimesh.load(io.BytesIO(part.mesh.export(file_type="stl")), file_type="stl")
        assert_printable(mesh)
        assert mesh.bounds[0][0] == pytest.approx(0.0, abs=1e-3)
        base = section_radii(mesh, JUST)
        assert 2 * base == pytest.approx([finger.base_bore_diameter, finger.base_outer_diameter], abs=0.1)
        distal = at_the_tip(mesh, finger, hand.exoskeleton.joint_fillet)
        tip = section_radii(distal, finger.inner_length - JUST)[-2:]
        assert 2 * tip == pytest.approx([finger.tip_bore_diameter, finger.tip_outer_diameter], abs=0.1)
        # A rod pushed on in the distal phalanx stops at the inner length; the solid tip follows.
        start = finger.inner_length - 5.0
        passed = walls_along(distal, (start, 0.03, 0.02), (1, 0, 0)) + start
        assert passed == pytest.approx([finger.inner_length, finger.outer_length], abs=0.1)


def at_the_tip(mesh, finger, fillet):
    """The mesh turned back by its rest curl, so that the distal phalanx lies along x again."""
    x = finger.inner_length
    rotation, origin = fingers.Axis(FingerProfile(finger), fillet).placement(x)
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = rotation, origin
    back = np.linalg.inv(placed)
    back[0, 3] += x
    return mesh.copy().apply_transform(back)


def test_a_slot_leaves_its_palmar_arc(measured):
    finger, part = measured
    for joint in finger.joints:
        section = part.mesh.section(plane_origin=(joint.position, 0, 0), plane_normal=(1, 0, 0))
        points = np.vstack(section.discrete)
        arc = np.degrees(2 * np.arctan2(abs(points[:, 1]), -points[:, 2])).max()
        assert arc == pytest.approx(joint.palmar_arc, abs=0.5)
        profile = FingerProfile(finger)
        wall = profile.outer_radius(joint.position) - profile.bore_radius(joint.position)
        passed = walls_along(part.mesh, (joint.position, 0.01, 0), (0, 0, -1))
        assert passed[-1] - passed[0] == pytest.approx(wall, abs=0.05)
        # Dorsally the slot is as long as asked.
        dorsal = (joint.position, 0.01, profile.outer_radius(joint.position) - 0.5)
        assert 2 * walls_along(part.mesh, dorsal, (1, 0, 0))[0] == pytest.approx(joint.slot_length, abs=0.05)


def test_strip_meets_the_phalanx_in_a_round_corner(adult):
    index = adult.fingers.index
    joint = index.joints[0]
    profile = FingerProfile(index)
    radius = profile.fillet(joint, adult.exoskeleton.joint_fillet)
    mesh = fingers.exoskeleton(adult, "index").mesh
    start = joint.position - joint.slot_length / 2
    middle = (profile.outer_radius(start) + profile.bore_radius(start)) / 2
    half_arc = math.radians(joint.palmar_arc / 2)
    edge = np.array([0.0, math.sin(half_arc), -math.cos(half_arc)])
    tangent = np.array([0.0, math.cos(half_arc), math.sin(half_arc)])
    for depth in (0.2, 0.5, 1.0):
        # Seen from the slot's middle, the corner's wall stands where a circle puts it.
        origin = edge * middle + tangent * depth + np.array([joint.position, 0, 0])
        hit = joint.position - walls_along(mesh, origin, (-1, 0, 0))[0]
        expected = start + radius - math.sqrt(radius**2 - (radius - depth) ** 2)
        assert hit == pytest.approx(expected, abs=0.02)


def test_mesh_and_brep_are_the_same_finger(measured):
    _, part = measured
    assert part.solid.isValid() and len(part.solid.Solids()) == 1
    assert part.mesh.volume == pytest.approx(part.solid.Volume(), rel=5e-3)


def curl(finger, angles):
    """The finger with other rest angles, degrees, root to tip."""
    joints = [j.model_copy(update={"rest_angle": a}) for j, a in zip(finger.joints, angles, strict=True)]
    return finger.model_copy(update={"joints": joints})


@pytest.mark.parametrize("angles", [(12.0, 10.0, 7.0), (40.0, 0.0, 25.0)])
def test_rest_curl_keeps_the_phalanges_and_turns_the_tip(adult, angles):
    index = adult.fingers.index
    curled = curl(index, angles)
    shape = fingers.shape(curled, adult.exoskeleton.joint_fillet)
    mesh = printable(evaluate(shape))
    assert_printable(mesh)
    axis = fingers.Axis(FingerProfile(curled), adult.exoskeleton.joint_fillet)
    tip = axis.carry(np.array([[index.outer_length, 0, 0]]))[0]
    assert np.linalg.norm(mesh.vertices - tip, axis=1).min() < 0.05
    assert axis.frame(index.outer_length)[2] == pytest.approx(math.radians(sum(angles)))
    # Laid straight again it holds as much: only the strips bend.
    straight = evaluate(fingers.shape(index, adult.exoskeleton.joint_fillet)).volume()
    assert mesh.volume == pytest.approx(straight, rel=0.04)
    palmar = axis.carry(np.array([[30.0, 0, 0], [30.0, 0, -20.0]]))
    direction = (palmar[1] - palmar[0]) / 20.0
    wall = walls_along(mesh, palmar[0], direction)
    profile = FingerProfile(index)
    assert wall[:2] == pytest.approx([profile.bore_radius(30.0), profile.outer_radius(30.0)], abs=0.02)


def test_curled_brep_is_the_same_finger(adult):
    index = adult.fingers.index
    curled = adult.fingers.model_copy(update={"index": curl(index, (11.8, 10.4, 7.4))})
    hand = adult.model_copy(update={"fingers": curled})
    part = fingers.exoskeleton(hand, "index")
    assert part.mesh.volume == pytest.approx(part.solid.Volume(), rel=5e-3)


def test_a_strip_bent_as_sharply_as_it_can_be_is_the_same_in_both_kernels(adult):
    """48 degrees in 9 mm: the corners give way until the strip's palmar side keeps half a millimetre."""
    curled = curl(adult.fingers.index, (48.0, 0.0, 0.0))
    shape = fingers.shape(curled, adult.exoskeleton.joint_fillet)
    (a, b, bend), *_ = fingers.Axis(FingerProfile(curled), adult.exoskeleton.joint_fillet).bends
    assert b - a - bend * curled.base_outer_diameter / 2 == pytest.approx(0.5)
    assert evaluate(shape).volume() == pytest.approx(brep_kernel.evaluate(shape).Volume(), rel=5e-3)


def test_axis_keeps_its_length(adult):
    index = curl(adult.fingers.index, (30.0, 30.0, 30.0))
    axis = fingers.Axis(FingerProfile(index), 1.5)
    x = np.linspace(0, index.outer_length, 4001)
    points = axis.carry(np.c_[x, np.zeros_like(x), np.zeros_like(x)])
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert length == pytest.approx(index.outer_length, abs=1e-3)


@st.composite
def stations(draw):
    """Taper stations in any number of inner points, non-decreasing."""
    along = sorted(draw(st.lists(st.integers(5, 95), max_size=4, unique=True)))
    down = sorted(draw(st.lists(st.floats(0, 1), min_size=len(along), max_size=len(along))))
    return [(0.0, 0.0), *((a / 100, d) for a, d in zip(along, down, strict=True)), (1.0, 1.0)]


@given(stations(), st.floats(5, 30), st.floats(0.1, 5))
@settings(max_examples=200, deadline=None)
def test_a_taper_never_overshoots(points, base, tip):
    curve = Curve.monotone(90.0, base, tip, points)
    radius = curve(np.linspace(0, 90, 500))
    assert np.diff(radius).max() <= 1e-9
    assert radius[0] == pytest.approx(base) and radius[-1] == pytest.approx(tip)
    for share, drop in points:
        assert curve(90.0 * share) == pytest.approx(base + (tip - base) * drop, abs=1e-9)


@given(stations(), st.floats(0.0, 80.0))
@settings(max_examples=100, deadline=None)
def test_a_piece_of_a_curve_is_the_curve(points, start):
    curve = Curve.monotone(90.0, 10.0, 7.0, points)
    part = curve.between(start, 90.0)
    x = np.linspace(start, 90.0, 50)
    assert part(x) == pytest.approx(curve(x), abs=1e-9)


def test_cad_and_profile_agree_between_base_and_tip(adult):
    profile = FingerProfile(adult.fingers.index)
    mesh = printable(evaluate(Revolve(fingers.tube(profile))))
    for x in np.linspace(1, 94, 25):
        expected = [profile.bore_radius(x), profile.outer_radius(x)]
        assert section_radii(mesh, x) == pytest.approx(expected, abs=0.02)
    for x in (96.0, 99.0, 102.0):
        assert section_radii(mesh, x)[-1] == pytest.approx(profile.outer_radius(x), abs=0.02)
