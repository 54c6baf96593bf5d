"""Rules on walls: thresholds, designs that break them by one number, defects cut into good meshes."""

from types import SimpleNamespace

import numpy as np
import pytest

from handgen.checks import walls
from handgen.checks.limits import standard
from handgen.checks.voids import voids
from handgen.geometry import csg, palm
from handgen.geometry.actuator import actuator
from handgen.geometry.finger import exoskeleton
from handgen.geometry.hand import hand_part
from handgen.geometry.mesh_kernel import evaluate, triangles
from handgen.geometry.part import Part
from handgen.geometry.surface import Surface
from handgen.geometry.thumb import Hinge
from handgen.geometry.tooling import tooling
from handgen.parameters.load import load
from tests.conftest import PARAMS
from tests.variant import changed, limits, named

HAND = "exoskeleton/hand"
NEAR = 3.0
"""mm: a defect is found where it is."""


def tube(wall, name, role, material):
    """A tube of 6 mm bore with a wall of `wall` mm."""
    shape = csg.cylinder(6 + wall, 0, 20) - csg.cylinder(6, -1, 21)
    return named([Part(name, role, material, shape, (1, 1, 1), "fingers.index")])


FINGER = ("exoskeleton/index", "exoskeleton", "Filaflex 82A", 2 * 0.35 / 0.95)
TOOL = ("tooling/index/mould_a", "mould_a", "PLA", 2 * 0.35)
CAST = ("actuators/index", "actuator", "Ecoflex 00-50", 1.5)


@pytest.mark.parametrize("name, role, material, limit", [FINGER, TOOL, CAST])
def test_minimum_at_its_threshold(adult, name, role, material, limit):
    for wall, severe in ((limit - 0.01, True), (limit, False), (limit + 0.01, False)):
        outcome = walls.minimum(adult, tube(wall, name, role, material), standard())
        assert [f.severity for f in outcome.findings if f.severity == "error"] == ["error"] * severe
        assert outcome.measured == pytest.approx(wall, abs=0.02)
        for f in outcome.findings:
            assert f.part == name and f.measured == pytest.approx(wall, abs=0.02)
            assert np.hypot(*f.where[1:]) == pytest.approx(6 + wall / 2, abs=0.02)


@pytest.mark.parametrize("wall, severities", [(1.19, ["warning"]), (1.2, []), (0.65, ["error"])])
def test_tooling_that_breaks_when_handled(adult, wall, severities):
    outcome = walls.minimum(adult, tube(wall, *TOOL[:3]), standard())
    assert [f.severity for f in outcome.findings] == severities


def test_under_extrusion_asks_for_thicker_walls(adult):
    parts = tube(0.8, *FINGER[:3])
    assert walls.minimum(adult, parts, standard()).status == "pass"
    assert walls.minimum(adult, parts, limits("wall.minimum", under_extrusion=0.2)).status == "fail"
    wide = changed(adult, printing__finger__nozzle_size=0.6)
    assert walls.minimum(wide, parts, standard()).status == "fail"


def test_a_bore_too_wide_for_its_finger(adult):
    good = named([exoskeleton(adult, "index")])
    assert walls.minimum(adult, good, standard()).status == "pass"
    wide = changed(adult, fingers__index__base_bore_diameter=18.8)
    outcome = walls.minimum(wide, named([exoskeleton(wide, "index")]), standard())
    assert outcome.status == "fail"
    assert outcome.measured == pytest.approx(0.6, abs=0.02)
    assert outcome.findings[0].where[0] < 10.0


def test_shipped_parts_have_sound_walls(adult):
    parts = [exoskeleton(adult, "little"), actuator(adult, "little"), *tooling(adult, "little")]
    outcome = walls.minimum(adult, named(parts), standard())
    assert [f for f in outcome.findings if f.severity == "error"] == []


def test_no_parts_no_verdict(adult):
    for rule in (walls.minimum, walls.between_bores, walls.breakthrough):
        assert rule(adult, {}, standard()).status == "skipped"


@pytest.fixture(scope="module")
def body(adult):
    """The adult hand as it is printed, to cut defects into."""
    return evaluate(hand_part(adult).shape)


def printed(solid):
    part = SimpleNamespace(name=HAND, role="exoskeleton", material="Ninjaflex", path="palm",
                           triangles=triangles(solid))
    return {HAND: part}


def test_shipped_hand(adult, body):
    parts = printed(body)
    for rule in (walls.minimum, walls.between_bores, walls.breakthrough):
        outcome = rule(adult, parts, standard())
        assert (outcome.status, outcome.findings) == ("pass", ())
    wide = changed(adult, printing__hand__nozzle_size=0.8)
    assert walls.between_bores(wide, parts, standard()).status == "fail"


def test_left_hand_is_judged_as_the_right_one(adult, body):
    """The same hole in both: found in the same place, mirrored."""
    cutter = evaluate(csg.cylinder(1.0, 0, 30).turned("y", -90).moved(x=50.0, y=20.0))
    left = changed(adult, side="left")
    right_found, left_found = (
        walls.breakthrough(hand, printed(solid), standard()).findings
        for hand, solid in ((adult, body - cutter), (left, (body - cutter).mirror((0, 1, 0)))))
    assert len(right_found) == len(left_found) > 0
    for right, other in zip(right_found, left_found, strict=True):
        assert np.array(other.where) * (1, -1, 1) == pytest.approx(np.array(right.where), abs=0.5)


@pytest.fixture(scope="module")
def places(adult, body):
    """Where the bores of the hand have a wall: (points, directions out of the bore)."""
    surface, known = Surface(*triangles(body)), [v.wall() for v in voids(adult)]
    origins, directions, distances = (np.concatenate([w[k] for w in known]) for k in range(3))
    there = abs(surface.sight(origins, directions) - distances) < 0.02
    return (origins + distances[:, None] * directions)[there], directions[there]


@pytest.mark.parametrize("seed", range(6))
def test_punched_hole(adult, body, places, seed):
    """A hole of 1.5 mm from a random place of a bore's wall straight out of the hand."""
    k = np.random.default_rng(seed).integers(len(places[0]))
    place, direction = places[0][k], places[1][k]
    drill = csg.cylinder(0.75, -0.5, 60.0).placed(palm.facing(direction), place)
    outcome = walls.breakthrough(adult, printed(body - evaluate(drill)), standard())
    assert outcome.status == "fail"
    assert min(np.linalg.norm(np.subtract(f.where, place)) for f in outcome.findings) < NEAR


@pytest.mark.parametrize("sockets", ["bases", "tips"])
def test_socket_beside_its_place(adult, body, sockets):
    """A socket cut nearer to its neighbour: what is left between them is measured."""
    one, two = getattr(Hinge(adult), sockets)()
    line = np.subtract(two.start, one.start)
    gap = np.linalg.norm(line) - one.radius - two.radius
    for left, found in ((0.6, True), (1.0, True), (1.05, False)):
        shifted = evaluate(one.shape.moved(*((gap - left) * line / np.linalg.norm(line))))
        outcome = walls.between_bores(adult, printed(body - shifted), standard())
        between = [f for f in outcome.findings if one.name in f.message and two.name in f.message]
        assert len(between) == found
        if found:
            assert between[0].measured == pytest.approx(left, abs=0.02)
            axis = np.subtract(one.end, one.start)
            middle = two.start - line / np.linalg.norm(line) * (two.radius + left / 2)
            away = between[0].where - middle
            assert np.linalg.norm(np.cross(away, axis)) / np.linalg.norm(axis) < NEAR


def test_thesis_hand():
    """As built: its sheet is too thick, its walls are sound."""
    hand = load(PARAMS / "thesis_hand.yaml").hand
    parts = named([hand_part(hand)])
    for rule in (walls.minimum, walls.between_bores, walls.breakthrough):
        assert rule(hand, parts, standard()).status == "pass"
