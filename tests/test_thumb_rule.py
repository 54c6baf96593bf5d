"""The thumb's rule: its formula against finite elements, its sections against the mesh, its verdicts."""

import dataclasses
import math

import numpy as np
import pytest

from handgen.checks import thumb
from handgen.checks.limits import standard
from handgen.geometry import csg
from handgen.geometry.hand import hand_part
from handgen.geometry.thumb import Hinge
from handgen.mechanics import hinge
from handgen.parameters.load import load
from tests import reference_thumb
from tests.conftest import PARAMS

LIMITS = standard()
ROOF = 1.0
"""Thickness, mm, of what is built over the gap to be found."""


def of_thickness(hand, thickness):
    """`hand` with another sheet and a coarser skin, which the hinge does not have."""
    return hand.model_copy(update={
        "opposition": hand.opposition.model_copy(update={"sheet_thickness": thickness}),
        "palm": hand.palm.model_copy(update={"resolution": 1.6})})


def judge(hand, part, limits=LIMITS):
    return thumb.palm_stiffness(hand, {"exoskeleton/hand": part}, limits)


@pytest.fixture(scope="module")
def thin(adult):
    hand = of_thickness(adult, adult.opposition.sheet_thickness)
    return hand, hand_part(hand)


@pytest.fixture(scope="module")
def thick():
    hand = load(PARAMS / "thesis_hand.yaml").hand
    hand = of_thickness(hand, hand.opposition.sheet_thickness)
    return hand, hand_part(hand)


def formula(t: reference_thumb.Thumb) -> float:
    """The rule's angle for the same idealised hinge, its sections those of sheet and fillet."""
    stations = (np.arange(48) + 0.5) / 48 * t.length
    beside = np.minimum(stations, t.length - stations)
    rise = t.fillet - np.sqrt(t.fillet**2 - np.maximum(t.fillet - beside, 0.0) ** 2)
    sections = np.array([hinge.rectangle(t.width, t.top - t.thickness, t.top + r) for r in rise])
    pushers = [hinge.Pusher(v, t.chamber, t.inside, t.thread, t.outside)
               for v in (-t.spacing / 2, t.spacing / 2)]
    return hinge.opposition_angle(hinge.flexibility(sections, t.length), pushers, t.pressure, t.young, t.mu)


@pytest.mark.parametrize("thickness", [2.0, 8.0])
def test_the_formula_agrees_with_finite_elements(thickness):
    model = reference_thumb.Thumb(thickness)
    assert formula(model) == pytest.approx(reference_thumb.angle(model, 4.0), rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize(("thickness", "chamber"), [
    (2.0, 24.0), (3.0, 24.0), (4.0, 24.0), (6.0, 24.0), (8.0, 24.0), (2.0, 18.0), (4.0, 18.0)])
def test_the_formula_agrees_with_fine_finite_elements(thickness, chamber):
    model = reference_thumb.Thumb(thickness, chamber=chamber)
    assert formula(model) == pytest.approx(reference_thumb.angle(model, 2.5), rel=0.10)


def test_a_stiff_sheet_turns_as_the_source_of_the_formula_says():
    """Little stretch, plate bending: L n p pi r^2 d / (E' B t^3 / 12 + n 4 mu (A d^2 + I))."""
    length, width, t, top, mu, young, pressure = 24.0, 26.0, 2.0, -6.5, 0.047, 44.0, 0.001
    sheet = hinge.flexibility(hinge.rectangle(width, top - t, top)[None], length)
    pushers = [hinge.Pusher(v, length, 2.5, 4.0, 6.0) for v in (-7.5, 7.5)]
    bending = young * (1 + 1 / (1 - hinge.POISSON**2)) / 2 * width * t**3 / 12
    d, p = t / 2 - top, pushers[0]
    by_silicone = 2 * 4 * mu * (p.area * d**2 + p.second_moment) * length / p.free_length
    by_hand = math.degrees(length * 2 * pressure * math.pi * 16 * d / (bending + by_silicone))
    assert hinge.opposition_angle(sheet, pushers, pressure, young, mu) == pytest.approx(by_hand, rel=0.02)


def test_the_matrix_of_a_section_holds_area_moments_and_second_moments():
    s = hinge.rectangle(26.0, -8.5, -6.5)
    area, height = 52.0, -7.5
    assert s == pytest.approx(np.array([
        [area, area * height, 0], [area * height, 26 * 2**3 / 12 + area * height**2, 0],
        [0, 0, 2 * 26**3 / 12]]))


def test_the_sections_are_the_meshs(thin):
    """In the middle of the gap the sheet alone, at the walls its fillet too, and no finger."""
    hand, part = thin
    sections, stations = thumb.hinge_sections(hand, part.triangles)
    o, top = hand.opposition, Hinge(hand).top
    plain = hinge.rectangle(o.sheet_width, top - o.sheet_thickness, top)
    for section, u in zip(sections, stations, strict=True):
        if o.sheet_fillet < u < o.free_length - o.sheet_fillet:
            assert section == pytest.approx(plain, rel=0.01, abs=0.01 * plain.max())
    assert sections[0][0, 0] > 1.02 * plain[0, 0]


def test_of_several_pieces_the_thumbs_counts():
    from manifold3d import Manifold

    fist = Manifold.cube((9.0, 9.0, 9.0))
    both = fist + Manifold.cube((1.0, 1.0, 1.0)).translate((20.0, 0.0, 0.0))
    assert thumb._with(both, np.array([21.0, 0.0, 0.0])).volume() == pytest.approx(1.0)


def test_the_adult_hand_opposes_with_a_quarter_to_spare(thin):
    outcome = judge(*thin)
    assert outcome.status == "pass" and not outcome.findings
    assert outcome.measured >= 1.25 * outcome.limit


def test_the_thumb_of_the_source_does_not(thick):
    """Section 4.2.3, and the sheet that the finding asks for would do."""
    hand, part = thick
    outcome = judge(hand, part)
    (found,) = outcome.findings
    assert outcome.status == "fail" and found.severity == "error"
    assert found.measured == outcome.measured < found.limit
    local = Hinge(hand).local(np.array(found.where))
    assert 0 < local[0] < hand.opposition.free_length
    assert local[2] == pytest.approx(Hinge(hand).top - 4, abs=0.5)
    enough = float(found.fix.split("sheet_thickness ")[1].split(" mm")[0])
    mended = of_thickness(hand, enough)
    assert judge(mended, hand_part(mended)).status == "pass"
    too_thick = of_thickness(hand, enough + 0.3)
    assert judge(too_thick, hand_part(too_thick)).status == "fail"


def test_just_inside_passes_just_outside_fails_the_limit_passes(thin):
    """The limit is moved to the angle that is reached."""
    hand, part = thin
    angle = judge(hand, part).measured
    low, high = 20.0, 80.0
    while high - low > 1e-13 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if thumb.angle_needed(hand, middle) < angle else (low, middle)
    for beside, status in ((-0.01, "pass"), (-1e-12, "pass"), (0.01, "fail")):
        moved = {"abduction": {"value": low + beside, "reason": "test"}}
        outcome = judge(hand, part, LIMITS.beside({"thumb.palm-stiffness": moved}))
        assert outcome.status == status
        assert outcome.limit == pytest.approx(angle, abs=0.05)


@pytest.mark.parametrize("where", ["roof", "side"])
def test_what_bridges_the_gap_beside_the_sheet_is_seen(thin, where):
    """A plate over the actuators, or a wall along one side of them, that the parameters know nothing of."""
    hand, part = thin
    frame, length = Hinge(hand), hand.opposition.free_length
    above = frame.socket + 0.5
    low, high = {"roof": ((-3.0, -13.0, above), (length + 3.0, 13.0, above + ROOF)),
                 "side": ((-3.0, 12.0, frame.top - 1.0), (length + 3.0, 12.0 + ROOF, above))}[where]
    plate = csg.box(low, high).placed(frame.rotation, frame.origin)
    spoiled = dataclasses.replace(part, shape=csg.Union((part.shape, plate)))
    before, after = judge(hand, part), judge(hand, spoiled)
    assert after.measured < 0.6 * before.measured
    assert after.status == "fail" and "clear the gap" in after.findings[0].fix


def test_a_left_hand_is_judged_as_its_mirror_image(thick):
    hand, part = thick
    mirror = dataclasses.replace(part, shape=part.shape.mirrored("y"))
    left = hand.model_copy(update={"side": "left"})
    right, mirrored = judge(hand, part), judge(left, mirror)
    assert mirrored.measured == pytest.approx(right.measured, rel=1e-4)
    where = np.multiply(right.findings[0].where, (1, -1, 1))
    assert mirrored.findings[0].where == pytest.approx(where, abs=0.01)


def test_a_thumb_tilted_as_printed_needs_less_turn(adult):
    def tilted(angle):
        place = adult.fingers.thumb.placement.model_copy(update={"palmar_tilt": angle})
        thumb_finger = adult.fingers.thumb.model_copy(update={"placement": place})
        return adult.model_copy(update={"fingers": adult.fingers.model_copy(update={"thumb": thumb_finger})})

    needed = [thumb.angle_needed(tilted(a), 32.0) for a in (0.0, 18.0, 32.0, 40.0)]
    assert needed == sorted(needed, reverse=True)
    assert needed[2] == pytest.approx(0.0, abs=1e-9) and needed[3] == 0.0


def test_without_a_hinge_or_a_modulus_the_rule_is_skipped(thin):
    hand, part = thin
    assert judge(hand.model_copy(update={"opposition": None}), part).status == "skipped"
    assert thumb.palm_stiffness(hand, {}, LIMITS).status == "skipped"
    printing = hand.printing.model_copy(update={
        "hand": hand.printing.hand.model_copy(update={"material": "unheard of"})})
    assert "unheard of" in judge(hand.model_copy(update={"printing": printing}), part).reason
