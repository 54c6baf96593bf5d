"""Rules on cores, moulds and seals."""

import dataclasses
import math

import numpy as np
import pytest

from handgen.checks.casting import Pull, behind, demould, draft, pin_rooms, split, undercut
from handgen.checks.fits import Play, centring, seal
from handgen.checks.limits import standard
from handgen.checks.sections import Triangles
from handgen.errors import GeometryError
from handgen.geometry import csg
from handgen.geometry.actuator import actuator
from handgen.geometry.casting import Setup
from handgen.geometry.finger import exoskeleton
from handgen.geometry.mesh_kernel import evaluate, printable
from handgen.geometry.palm import seat
from handgen.geometry.part import Part
from handgen.geometry.tooling import tooling
from tests.variant import changed, limits, named

PARTS = {}


def surface(shape):
    return Triangles.of(printable(evaluate(shape)))


def made(hand, name="little"):
    """Tooling, actuator and exoskeleton of one finger; made once a variant."""
    key = (name, hand.model_dump_json())
    if key not in PARTS:
        PARTS[key] = named([*tooling(hand, name), actuator(hand, name), exoskeleton(hand, name)])
    return dict(PARTS[key])


def with_shape(parts, name, change):
    """`parts` with one part's shape changed."""
    return parts | {name: dataclasses.replace(parts[name], shape=change(parts[name].shape))}


def findings(outcome, part):
    return [f for f in outcome.findings if f.part.endswith(part) and f.severity == "error"]


@pytest.fixture(scope="module")
def little(adult):
    return made(adult)


class TestDemould:
    def test_adult_passes(self, adult, little):
        outcome = demould(adult, little, standard())
        assert outcome.status == "pass" and not outcome.findings
        assert outcome.measured == pytest.approx(0, abs=1e-5)

    def test_depth_of_a_ring_groove(self):
        core = csg.cylinder(5.0, 0.0, 40.0) - (csg.cylinder(6.0, 20.0, 21.0) - csg.cylinder(4.7, 19.0, 22.0))
        depth, where = undercut(surface(core).vertices, -1)
        assert depth == pytest.approx(0.3, abs=6e-3)
        assert where[0] == pytest.approx(20.5, abs=0.51)

    def test_a_core_that_narrows_to_its_tip_has_none_and_the_other_way_all(self):
        cone = surface(csg.cone(5.0, 3.0, 0.0, 40.0))
        assert undercut(cone.vertices, -1)[0] == pytest.approx(0, abs=1e-6)
        assert undercut(cone.vertices, 1)[0] == pytest.approx(2, abs=1e-3)

    def test_a_salience_at_the_tip_is_none(self, adult):
        hand = changed(adult, casting__tip="filled afterwards", casting__tip_fill=1.5)
        outcome = demould(hand, made(hand), standard())
        assert outcome.status == "pass" and outcome.measured == pytest.approx(0, abs=1e-5)

    def test_draft_of_a_cone(self):
        slope = math.degrees(math.atan(2 / 40))
        assert draft(surface(csg.cone(5.0, 3.0, 0.0, 40.0))) == pytest.approx(slope, rel=1e-3)
        assert draft(surface(csg.cylinder(4.0, 0.0, 40.0))) == pytest.approx(0, abs=1e-6)

    def test_pull_of_a_cylinder(self, adult, little):
        setup = Setup(adult, "little")
        part = dataclasses.replace(little["tooling/little/core_small"], shape=csg.cylinder(3.0, -20.0, 50.0))
        pull = Pull.of(setup, part, surface(part.shape), standard())
        wetted = 2 * math.pi * 3 * (50 - setup.top)
        assert pull.total == pytest.approx(0.002 * wetted + 0.1013 * math.pi * 9, rel=3e-3)
        assert pull.force[-1] < pull.force[0]

    def test_a_deep_groove_for_a_thick_thread_holds_the_core(self, adult):
        values = {}
        for groove in (False, True):
            hand = changed(adult, actuators__little__thread__diameter=0.4,
                           actuators__little__thread__groove=groove)
            values[groove] = demould(hand, made(hand), standard())
        assert values[False].status == "pass"
        assert values[True].status == "fail"
        assert values[True].measured == pytest.approx(0.2, abs=0.02) and values[True].limit == 0.1
        assert "groove" in findings(values[True], "core_large")[0].fix

    @pytest.mark.parametrize("factor, status", [(1.001, "pass"), (1.0, "pass"), (0.99, "fail")])
    def test_undercut_at_the_limit(self, adult, factor, status):
        hand = changed(adult, actuators__little__thread__groove=True)
        parts = made(hand)
        depth = demould(hand, parts, standard()).measured
        assert depth == pytest.approx(0.075, abs=0.01)
        own = limits("core.demould", undercut__core_large=factor * depth)
        assert demould(hand, parts, own).status == status

    @pytest.mark.parametrize("more, status", [(-0.01, "pass"), (0.0, "pass"), (0.01, "fail")])
    def test_draft_at_the_limit(self, adult, little, more, status):
        slopes = [draft(Triangles.of(little[f"tooling/little/core_{c}"].mesh)) for c in ("small", "large")]
        own = limits("core.demould", draft=min(slopes) + more)
        outcome = demould(adult, little, own)
        assert outcome.status == status
        assert [f.part for f in outcome.findings] == ["tooling/little/core_small"] * (status == "fail")

    def test_a_bent_core_is_found_where_it_bends(self, adult, little):
        def bent(shape):
            ends = (csg.box((-60, -30, -30), (40, 30, 30)), csg.box((39, -30, -30), (90, 30, 30)))
            straight, rest = (csg.Intersection((shape, end)) for end in ends)
            return csg.Union((straight, rest.moved(y=0.8)))

        outcome = demould(adult, with_shape(little, "tooling/little/core_small", bent), standard())
        found = findings(outcome, "core_small")
        assert found and found[0].unit == "mm" and found[0].where[0] == pytest.approx(39, abs=3)

    def test_silicone_that_tears(self, adult, little):
        weak = limits("core.demould", **{"tear_strength__Ecoflex 00-50": 1.0})
        outcome = demould(adult, little, weak)
        assert outcome.status == "fail"
        assert {f.unit for f in outcome.findings} == {"1"} and "nick" in outcome.findings[0].message

    def test_a_core_that_breaks(self, adult, little):
        outcome = demould(adult, little, limits("core.demould", core_strength__PLA=1.0))
        assert {f.unit for f in outcome.findings} == {"MPa"}
        assert "small" in outcome.findings[-1].part

    def test_unknown_materials_are_said(self, adult):
        hand = changed(adult, casting__silicone__name="Mine")
        assert "no strength known: Mine" in demould(hand, made(hand), standard()).reason

    def test_no_cores_is_no_pass(self, adult):
        assert demould(adult, {}, standard()).status == "skipped"


class TestSplit:
    def test_adult_passes(self, adult, little):
        outcome = split(adult, little, standard())
        assert outcome.status == "pass" and outcome.measured == 0

    @pytest.mark.parametrize("fit, status", [
        (0.0, "fail"), (0.09, "fail"), (0.11, "pass"), (0.29, "pass"), (0.32, "fail")])
    def test_pins_need_room_but_not_too_much(self, adult, fit, status):
        hand = changed(adult, casting__mould_fit=fit)
        outcome = split(hand, made(hand), standard())
        assert outcome.status == status
        if status == "fail":
            assert len(outcome.findings) == 4
            assert outcome.findings[0].measured == pytest.approx(fit, abs=0.01)
            assert "mould_fit" in outcome.findings[0].fix

    def test_room_of_a_pin_beside_the_middle_of_its_hole(self):
        pin = surface(csg.cylinder(2.0, -3.0, 3.0).turned("y", 90).moved(5, 7)).section(2, 1.0)
        hole = csg.cylinder(2.5, -9.0, 9.0).turned("y", 90).moved(5.2, 7)
        block = surface(csg.box((-9, -9, -3), (20, 20, 3)) - hole).section(2, 1.0)
        (room, where), = pin_rooms(pin, block)
        assert room == pytest.approx(0.3, abs=0.01) and where == pytest.approx((5, 7), abs=1e-3)
        assert pin_rooms(pin, surface(csg.box((-9, -9, -3), (20, 20, 3))).section(2, 1.0))[0][0] < 0

    def test_pins_at_the_limit(self, adult, little):
        room = 0.2
        measured = [r for r, _ in pin_rooms(
            Triangles.of(little["tooling/little/mould_a"].mesh).section(2, 1.0),
            Triangles.of(little["tooling/little/mould_b"].mesh).section(2, 1.0))]
        assert measured == pytest.approx([room] * 4, abs=0.01)
        for more, status in ((1e-3, "fail"), (0.0, "pass"), (-1e-3, "pass")):
            own = limits("mould.split", least_pin_clearance=min(measured) + more)
            assert split(adult, little, own).status == status

    def test_a_lip_in_the_cavity_hooks_the_cast(self, adult, little):
        setup = Setup(adult, "little")
        radius = setup.profile.outer(40.0)
        lip = csg.box((38, radius - 1.0, -2.0), (42, radius + 1.0, -0.5))
        parts = with_shape(little, "tooling/little/mould_a", lambda s: csg.Union((s, lip)))
        outcome = split(adult, parts, standard())
        reaches = math.sqrt(radius**2 - 4.0) - (radius - 1.0)
        assert outcome.status == "fail" and outcome.measured == pytest.approx(reaches, abs=0.08)
        assert outcome.findings[0].where == pytest.approx((40, radius - 0.5, -2.0), abs=1.5)

    def test_undercut_at_the_limit(self, adult, little):
        setup = Setup(adult, "little")
        radius = setup.profile.outer(40.0)
        lip = csg.box((38, radius - 1.0, -2.0), (42, radius + 1.0, -0.5))
        parts = with_shape(little, "tooling/little/mould_a", lambda s: csg.Union((s, lip)))
        depth = behind(Triangles.of(parts["tooling/little/mould_a"].mesh), setup, -1.0)[0]
        for more, status in ((1e-3, "pass"), (0.0, "pass"), (-1e-3, "fail")):
            assert split(adult, parts, limits("mould.split", undercut=depth + more)).status == status

    @pytest.mark.parametrize("gap, status", [(0.04, "pass"), (0.06, "fail")])
    def test_halves_that_do_not_meet(self, adult, little, gap, status):
        parts = with_shape(little, "tooling/little/mould_b", lambda s: s.moved(z=gap))
        outcome = split(adult, parts, standard())
        assert outcome.status == status
        if status == "fail":
            assert outcome.findings[0].measured == pytest.approx(gap, abs=1e-3)

    def test_no_mould_is_no_pass(self, adult):
        assert split(adult, {}, standard()).status == "skipped"


class TestCentring:
    def test_adult_passes_and_says_to_hold_the_flange_down(self, adult, little):
        outcome = centring(adult, little, standard())
        assert outcome.status == "pass"
        assert 0.25 < outcome.measured < 0.6
        info, = outcome.findings
        assert info.severity == "info" and info.measured > 1.0

    def test_play_of_a_hung_core(self):
        play = Play(shank=0.1, mould=0.2, lean=0.003, loose=0.02, middle=-10.0, foot=None, foot_play=0.0)
        assert play.at(90.0) == pytest.approx(0.1 + 0.2 + 0.3)
        assert play.loose_at(90.0) == pytest.approx(0.2 + 2.0)

    def test_a_salience_holds_the_tip(self, adult):
        hand = changed(adult, casting__tip="filled afterwards", casting__tip_fill=1.5)
        held, hung = (centring(h, made(h), standard()) for h in (hand, adult))
        assert held.measured > hung.measured
        assert not held.findings

    @pytest.mark.parametrize("key", ["casting__core_fit", "casting__mould_fit"])
    def test_a_loose_fit_fails(self, adult, key):
        hand = changed(adult, **{key: 0.4})
        outcome = centring(hand, made(hand), standard())
        assert outcome.status == "fail"
        finding = findings(outcome, "core_small")[0]
        assert key.replace("__", ".") in finding.fix and finding.where[0] > 60

    def test_play_is_measured_on_the_meshes(self, adult, little):
        """A fit widened by 0.1 mm takes 0.1 mm from the layer."""
        loose = changed(adult, casting__core_fit=adult.casting.core_fit + 0.1)
        values = [centring(h, made(h), standard()).measured for h in (adult, loose)]
        assert values[0] - values[1] == pytest.approx(0.1, abs=0.01)

    def test_a_core_drawn_beside_the_axis(self, adult, little):
        name = "tooling/little/core_large"
        values = []
        for offset in (0.0, 0.3):
            parts = with_shape(little, name, lambda s, d=offset: s.moved(y=d))
            own = limits("suspender.centring", least_layer=2.0)
            values.append(findings(centring(adult, parts, own), "core_large")[0].measured)
        assert values[0] - values[1] == pytest.approx(0.3, abs=0.01)

    def test_at_the_limit(self, adult, little):
        left = centring(adult, little, standard()).measured
        for more, status in ((-1e-3, "pass"), (0.0, "pass"), (1e-3, "fail")):
            own = limits("suspender.centring", least_layer=left + more)
            assert centring(adult, little, own).status == status

    def test_no_mould_is_no_pass(self, adult):
        assert centring(adult, {}, standard()).status == "skipped"


class TestSeal:
    def test_adult_passes(self, adult, little):
        outcome = seal(adult, little, standard())
        assert outcome.status == "pass" and not outcome.findings
        assert outcome.measured == pytest.approx(adult.seal.plug_squeeze, abs=0.01)

    @pytest.mark.parametrize("key, value, part, word", [
        ("seal__plug_squeeze", 0.0, "plug", "squeeze"),
        ("seal__plug_squeeze", 0.6, "plug", "stretch"),
        ("seal__tube_fit", 0.2, "plug", "tube"),
        ("seal__glue_gap", 0.0, "collar", "glue gap"),
        ("seal__glue_gap", 0.3, "collar", "glue gap"),
        ("seal__collar_fit", 0.4, "collar", "bore"),
    ])
    def test_one_fit_off(self, adult, key, value, part, word):
        hand = changed(adult, **{key: value})
        outcome = seal(hand, made(hand), standard())
        assert outcome.status == "fail"
        finding, = outcome.findings
        assert finding.part.endswith(part) and word in finding.message
        assert key.replace("__", ".") in finding.fix

    @pytest.mark.parametrize("name, value, sign", [
        ("least_squeeze", 0.25, 1), ("most_tube_clearance", 0.05, -1), ("least_glue_gap", 0.1, 1),
        ("most_glue_gap", 0.1, -1), ("most_collar_clearance", 0.1, -1)])
    def test_at_the_limit(self, adult, little, name, value, sign):
        for more, status in ((-0.012, "pass"), (0.012, "fail")):
            own = limits("seal.fit", **{name: value + sign * more})
            assert seal(adult, little, own).status == status, more

    def test_exactly_at_the_limit_passes(self, adult, little):
        squeeze = seal(adult, little, standard()).measured
        for more, status in ((1e-4, "fail"), (0.0, "pass")):
            assert seal(adult, little, limits("seal.fit", least_squeeze=squeeze + more)).status == status

    @pytest.mark.parametrize("side", ["right", "left"])
    @pytest.mark.parametrize("wider, status", [(0.05, "pass"), (0.2, "fail")])
    def test_a_hand_is_measured_where_the_collar_sits(self, adult, little, side, wider, status):
        """A block with the seat's hole stands for the hand; on the left it is the mirror image."""
        hand = changed(adult, side=side, palm__seat_clearance=wider)
        hole = seat(hand, "little", hand.seal.collar_length)
        middle = np.add(hole.start, hole.end) / 2
        block = csg.box((-7, -12, -12), (7, 12, 12)).moved(*middle.tolist()) - hole.shape
        shape = block.mirrored("y") if side == "left" else block
        palm = Part("exoskeleton/hand", "exoskeleton", "Ninjaflex", shape, (1, 1, 1), "palm")
        outcome = seal(hand, little | {palm.name: palm}, standard())
        assert outcome.status == status
        if status == "fail":
            assert outcome.findings[0].measured == pytest.approx(wider + hand.seal.collar_fit, abs=0.01)

    def test_a_collar_too_wide_to_press_in(self, adult, little):
        radius = adult.fingers.little.base_bore_diameter / 2 + 0.3
        parts = with_shape(little, "tooling/little/collar", lambda s: csg.Union(
            (s, csg.cylinder(radius, -7.0, -1.0) - csg.cylinder(radius - 1.0, -8.0, 0.0))))
        finding, = seal(adult, parts, standard()).findings
        assert "room in the bore is too small" in finding.message
        assert finding.measured == pytest.approx(-0.3, abs=0.01)

    def test_a_plug_that_lost_its_wall(self, adult, little):
        drill = csg.cylinder(2.0, 7.0, 20.0)
        parts = with_shape(little, "tooling/little/plug", lambda s: s - drill)
        finding, = seal(adult, parts, standard()).findings
        assert "wall around the tube" in finding.message and finding.measured < 0.3

    def test_no_seal_is_no_pass(self, adult):
        assert seal(adult, {}, standard()).status == "skipped"


def test_cores_that_cannot_be_made_are_refused_before(adult):
    hand = changed(adult, actuators__little__tip_outer_diameter=12.0)
    with pytest.raises(GeometryError):
        made(hand)


def test_sections_of_both_halves_make_the_cavity(adult, little):
    """The cavity is round, centred, and as wide as the actuator."""
    from handgen.checks.fits import _cavity

    setup = Setup(adult, "little")
    mould = [Triangles.of(little[f"tooling/little/mould_{h}"].mesh) for h in "ab"]
    for x in (5.0, 40.0, 70.0):
        centre, radius = _cavity(setup, mould, x)
        assert np.linalg.norm(centre) < 1e-3
        assert radius == pytest.approx(setup.profile.outer(x), abs=6e-3)
