"""Rules on the moving hand, and the limits that all rules read."""

import math

import numpy as np
import pytest

from handgen.checks.curl import CurlingFinger
from handgen.checks.limits import standard
from handgen.checks.motion import interference, strain, strip_strain
from handgen.checks.sections import Triangles
from handgen.errors import InputError
from handgen.geometry import csg
from handgen.geometry.finger import exoskeleton
from handgen.geometry.mesh_kernel import evaluate, printable
from handgen.geometry.palm import finger_placement
from tests.variant import changed, limits, named

LEVEL = [[0.0, 0.0], [1.0, 1.0]]


def surface(shape):
    return Triangles.of(printable(evaluate(shape)))


def fingers(hand, *names):
    return named(exoskeleton(hand, name) for name in names or hand.fingers.present())


@pytest.fixture(scope="module")
def plain(adult):
    """Index and middle as plain tubes, straight ahead side by side, sharp corners at their strips."""
    hand = changed(adult, exoskeleton__joint_fillet=0.0)
    for name, y in (("index", 24.0), ("middle", 0.0)):
        path = f"fingers__{name}__"
        hand = changed(hand, **{
            path + "base_outer_diameter": 20.0, path + "tip_outer_diameter": 20.0,
            path + "base_bore_diameter": 16.0, path + "tip_bore_diameter": 16.0, path + "taper": LEVEL,
            path + "placement__root": [80.0, y, 0.0], path + "placement__splay": 0.0})
    return hand


class TestSections:
    def test_of_a_box_off_the_origin(self):
        cut = surface(csg.box((0, 0, 0), (4, 6, 8)).moved(1, 2, 3)).section(0, 2.0)
        assert cut.area == pytest.approx(48)
        assert cut.centroid == pytest.approx([5, 7])
        assert cut.second_moment(0) == pytest.approx(8 * 6**3 / 12)
        assert cut.second_moment(1) == pytest.approx(6 * 8**3 / 12)

    def test_of_a_tube(self):
        tube = csg.Difference(csg.cylinder(5.0, 0.0, 20.0), (csg.cylinder(3.0, -1.0, 21.0),))
        cut = surface(tube.moved(0, 1, 2)).section(0, 7.0)
        assert cut.area == pytest.approx(math.pi * 16, rel=2e-3)
        assert cut.second_moment(1) == pytest.approx(math.pi / 4 * (5**4 - 3**4), rel=4e-3)
        hole = cut.facing(False, (1.0, 2.0))
        assert hole.circle()[0] == pytest.approx([1, 2], abs=1e-3)
        assert hole.circle()[1] == pytest.approx(3, abs=6e-3)


class TestHingeStrain:
    def test_adult_passes_far_from_yield(self, adult):
        outcome = strain(adult, fingers(adult), standard())
        assert outcome.status == "pass" and not outcome.findings
        assert 0.3 < outcome.measured < outcome.limit == pytest.approx(0.65 / 1.1)

    def test_a_plain_strip_follows_beam_theory(self, plain):
        part = exoskeleton(plain, "index")
        joint = plain.fingers.index.joints[1]
        half, outer, inner = math.radians(joint.palmar_arc / 2), 10.0, 8.0
        centroid = 2 * math.sin(half) * (outer**3 - inner**3) / (3 * half * (outer**2 - inner**2))
        lever = max(outer - centroid, centroid - inner * math.cos(half))
        expected = math.radians(100) * lever / joint.slot_length
        value, _ = strip_strain(CurlingFinger(plain, "index", part), 1, math.radians(100))
        assert value == pytest.approx(expected, rel=0.01)

    def test_rounded_corners_shorten_the_strip_but_by_less_than_their_radii(self, plain):
        values = []
        for radius in (0.0, 2.0):
            hand = changed(plain, exoskeleton__joint_fillet=radius)
            finger = CurlingFinger(hand, "index", exoskeleton(hand, "index"))
            values.append(strip_strain(finger, 1, 1.0)[0])
        length = plain.fingers.index.joints[1].slot_length
        assert 1.05 * values[0] < values[1] < values[0] * length / (length - 2 * 2.0)

    def test_the_strip_is_measured_on_the_mesh(self, plain):
        """A strip that is thicker on the mesh than in the parameters is strained more."""
        joint = plain.fingers.index.joints[1]
        part = exoskeleton(plain, "index")
        extra = csg.box((joint.position - 6, -3.0, -12.0), (joint.position + 6, 3.0, -9.0))
        thicker = type(part)(part.name, part.role, part.material, csg.Union((part.shape, extra)),
                             part.colour, part.path, part.up)
        before, after = (strip_strain(CurlingFinger(plain, "index", p), 1, 1.0)[0] for p in (part, thicker))
        assert after > 1.05 * before

    def test_a_short_slot_fails_and_the_finding_names_it(self, adult):
        hand = changed(adult, fingers__ring__joints__1__slot_length=5.0)
        outcome = strain(hand, fingers(hand, "ring"), standard())
        assert outcome.status == "fail"
        finding = outcome.findings[0]
        assert finding.part == "exoskeleton/ring" and "fingers.ring.joints.1.slot_length" in finding.fix
        assert finding.where[0] == pytest.approx(56, abs=2.5) and finding.where[2] < -6

    def test_at_the_limit(self, adult):
        parts = fingers(adult, "index")
        value = strain(adult, parts, standard()).measured
        for factor, status in ((1.001, "pass"), (1.0, "pass"), (0.999, "fail")):
            own = limits("hinge.strain", elongation_at_yield__Ninjaflex=factor * value, yield_safety=1.0)
            assert strain(adult, parts, own).status == status

    def test_a_curled_finger_has_less_to_go(self, adult):
        curled = changed(adult, **{f"fingers__index__joints__{i}__rest_angle": 30.0 for i in range(3)})
        values = [strain(h, fingers(h, "index"), standard()).measured for h in (adult, curled)]
        assert values[1] == pytest.approx(values[0] * 0.7, rel=0.06)

    def test_an_unknown_filament_is_no_pass(self, adult):
        hand = changed(adult, printing__hand__material="X", printing__finger__material="Y")
        outcome = strain(hand, fingers(hand, "index"), standard())
        assert outcome.status == "skipped" and "X, Y" in outcome.reason

    def test_no_finger_is_no_pass(self, adult):
        assert strain(adult, {}, standard()).status == "skipped"


def rolled(hand):
    """`hand` with an index finger whose pad is turned by 35 degrees towards the middle finger."""
    hands = [changed(hand, fingers__index__placement__roll=roll) for roll in (35.0, -35.0)]
    return min(hands, key=lambda h: np.array(finger_placement(h, "index")[0])[1] @ (0.0, 0.0, -1.0))


class TestInterference:
    def test_adult_passes(self, adult):
        outcome = interference(adult, fingers(adult), standard())
        assert outcome.status == "pass" and outcome.measured == 0
        assert "least gap 2.5" in outcome.reason

    def test_the_gap_of_plain_tubes(self, plain):
        outcome = interference(plain, fingers(plain, "index", "middle"), standard())
        assert outcome.status == "pass" and "least gap 4.0" in outcome.reason

    @pytest.mark.parametrize("y, status", [(20.701, "pass"), (20.7, "pass"), (20.69, "fail")])
    def test_printed_too_near(self, plain, y, status):
        hand = changed(plain, fingers__index__placement__root=[80.0, y, 0.0])
        outcome = interference(hand, fingers(hand, "index", "middle"), standard())
        assert outcome.status == status
        if status == "fail":
            finding, = outcome.findings
            assert finding.measured == pytest.approx(0.69, abs=2e-3)
            assert finding.where[1] == pytest.approx(20.69 / 2, abs=0.3) and abs(finding.where[2]) < 1.5

    def test_on_a_left_hand_the_place_is_mirrored(self, plain):
        hand = changed(plain, side="left", fingers__index__placement__root=[80.0, 20.4, 0.0])
        finding, = interference(hand, fingers(hand, "index", "middle"), standard()).findings
        assert finding.where[1] == pytest.approx(-10.2, abs=0.3)

    def test_fingers_that_are_rolled_towards_one_another_meet_when_they_curl(self, adult):
        hand = rolled(adult)
        outcome = interference(hand, fingers(hand, "index", "middle"), standard())
        assert outcome.status == "fail" and outcome.measured > 10
        finding = outcome.findings[0]
        assert finding.unit == "mm3" and "curled" in finding.message
        assert 5 < finding.where[1] < 32

    def test_the_overlap_is_that_of_the_phalanges(self, plain):
        """Two tubes of 20 mm whose axes are 10 mm apart: the volume of a lens times their length."""
        hand = changed(plain, fingers__index__placement__root=[80.0, 19.0, 0.0])
        outcome = interference(hand, fingers(hand, "index", "middle"), standard())
        half = math.acos(9.5 / 10)
        lens = 2 * 100 * (half - math.sin(half) * math.cos(half))
        # The lens is thinner than the walls, so hollow fingers share it all; the open slots do not.
        assert 0.5 * lens * 80 < outcome.measured < lens * 105

    def test_overlap_at_the_limit(self, adult):
        hand = rolled(adult)
        parts = fingers(hand, "index", "middle")
        volume = interference(hand, parts, standard()).measured
        for factor, status in ((1.001, "pass"), (1.0, "pass"), (0.99, "fail")):
            own = limits("fingers.interference", overlap=factor * volume)
            assert interference(hand, parts, own).status == status

    def test_a_curled_finger_ends_where_its_joints_put_it(self, plain):
        finger = CurlingFinger(plain, "middle", exoskeleton(plain, "middle"))
        right = np.radians([90.0, 0.0, 0.0])
        pose = finger.poses(right)[-1]
        tip = pose[:, :3] @ (112.5, 0.0, 0.0) + pose[:, 3]
        hinge = 16.0, finger.hinges[0][2]
        assert tip == pytest.approx([80 + hinge[0] - hinge[1], 0.0, hinge[1] - (112.5 - 16.0)], abs=0.01)

    def test_one_finger_is_no_pass(self, adult):
        assert interference(adult, fingers(adult, "index"), standard()).status == "skipped"


class TestLimits:
    def test_every_limit_says_what_it_is_and_where_from(self):
        for rule, entries in standard()._table.items():
            for name, entry in entries.items():
                assert entry["unit"] and entry["meaning"], f"{rule}.{name}"
                rows = [*entry.get("for", {}).values(), *([entry] if "value" in entry else [])]
                assert rows
                for row in rows:
                    assert isinstance(row["value"], float)
                    assert ("source" in row) != ("assumed" in row), f"{rule}.{name}"

    def test_the_most_particular_wins(self):
        assert standard().get("core.demould", "undercut", "core_large").value == 0.1
        assert standard().get("core.demould", "undercut", "core_small").value == 0.5
        assert standard().find("hinge.strain", "elongation_at_yield", "unheard of") is None

    def test_a_lab_puts_its_own_beside_with_a_reason(self):
        own = standard().beside({"hinge.strain": {"yield_safety": {"value": 2, "reason": "we flex a lot"}}})
        assert own.get("hinge.strain", "yield_safety").value == 2
        assert own.get("hinge.strain", "yield_safety").source == "own limit: we flex a lot"
        assert standard().get("hinge.strain", "yield_safety").value == 1.1

    def test_all_faults_at_once(self):
        with pytest.raises(InputError) as caught:
            standard().beside({
                "hinge.strian": {}, "seal.fit": {"least_squeze": {"value": 1, "reason": "x"}},
                "hinge.strain": {"yield_safety": {"value": "2"}}})
        texts = [str(p) for p in caught.value.problems]
        assert len(texts) == 4
        assert "'hinge.strain'" in texts[0] and "'least_squeeze'" in texts[1]
        assert "number" in texts[2] and "reason" in texts[3]
