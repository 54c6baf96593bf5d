"""The thread's rules, and the formula for ballooning against equations and elements that assume less."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from handgen.checks import thread
from handgen.checks.limits import standard
from handgen.geometry.actuator import actuator, profile_of, thread_length, thread_turns
from handgen.mechanics.bulge import HALF_CIRCLE, Wall, height
from handgen.mechanics.silicone import shear_modulus
from handgen.parameters.load import load
from handgen.parameters.model import Actuators
from handgen.simulation import solid
from handgen.simulation.system import System
from tests import reference_wall
from tests.conftest import PARAMS
from tests.fingers import case as simulated
from tests.variant import named

MU = shear_modulus(0.0827)
"""Ecoflex 00-50."""
LIMITS = standard()


def with_thread(hand, **values):
    """`hand` with its index actuator only and another thread."""
    return hand.model_copy(update={
        "actuators": Actuators(index=hand.actuators.index),
        "thread": hand.thread.model_copy(update=values)})


def own(rule, name, value):
    return LIMITS.beside({rule: {name: {"value": value, "reason": "test"}}})


def parts(hand):
    return named(actuator(hand, name) for name in hand.actuators.present())


def judge(rule, hand, limits):
    return rule(hand, parts(hand), limits)


def errors(outcome):
    return [f for f in outcome.findings if f.severity == "error"]


def test_the_modulus_gives_the_bulletins_stress_at_twice_the_length():
    assert pytest.approx(0.0827) == MU * (2 - 1 / 4)


@pytest.mark.parametrize("wall", [(4.5, 6.0), (2.0, 3.5), (1.25, 2.04)])
@pytest.mark.parametrize("share", [0.5, 0.8, 0.95])
def test_the_arc_agrees_with_the_membranes_equations(wall, share):
    """Height within 8 % up to just below the limit, in three walls."""
    sleeveless = Wall(*wall, wall[1], MU)
    gap = share * sleeveless.widest_gap(0.1)
    arc = height(sleeveless.half_angle(0.1, gap), gap)
    assert arc == pytest.approx(reference_wall.membrane(0.1, gap, *wall, MU), rel=0.08)


def test_over_a_wide_radius_the_limit_is_the_flat_strips():
    wall = Wall(9999.0, 10000.5, 10000.5, MU)
    flat = 2 * MU * 1.5 / 0.1 * (math.pi / 2 - (2 / math.pi) ** 3)
    assert wall.widest_gap(0.1) == pytest.approx(flat, rel=1e-3)


def test_the_limit_is_where_the_half_circle_stands():
    wall = Wall(4.5, 6.0, 8.0, MU)
    assert wall.half_angle(0.1, wall.widest_gap(0.1)) == pytest.approx(HALF_CIRCLE, abs=1e-6)
    assert wall.half_angle(0.1, 3 * wall.widest_gap(0.1)) == math.inf


@pytest.mark.parametrize("angle", [0.5, 1.0, HALF_CIRCLE])
def test_the_external_layer_presses_back_as_a_thick_tube(angle):
    """Against the integral of hoop stress over radius through the blown-up tube."""
    bare, sleeved, gap = Wall(4.5, 6.0, 6.0, MU), Wall(4.5, 6.0, 8.0, MU), 2.0
    grown = (6.0 + 2 / 3 * height(angle, gap)) ** 2 - 36.0

    def stress(r):
        hoop = r / math.sqrt(r * r - grown)
        return MU * (hoop**2 - hoop**-2) / r

    by_integral, _ = quad(stress, math.sqrt(36 + grown), math.sqrt(64 + grown))
    assert sleeved.pressure(angle, gap) - bare.pressure(angle, gap) == pytest.approx(by_integral, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("wall", "low", "high"), [
    ((4.5, 6.0, 8.0), 0.85, 1.15), ((3.0, 4.5, 6.0), 0.85, 1.15), ((1.25, 2.0, 3.0), 1.0, 1.8)])
def test_elements_with_both_layers_bulge_as_far_or_less(wall, low, high):
    """At 60 kPa, 2 mm pitch: within 15 % in wide walls, on the safe side in the thinned thumb's tip."""
    found = Wall(*wall, MU)
    arc = height(found.half_angle(0.06, 1.85), 1.85)
    assert low < arc / reference_wall.solid(0.06, 2.0, 0.15, *wall, MU) < high


@pytest.mark.parametrize("diameter", [0.15, 0.25])
def test_both_threads_of_the_source_fit_and_hold(adult, diameter):
    """Section 5.2.2: no increase in diameter. That they lie loose in 0.5 mm is said, not judged."""
    hand = with_thread(adult, diameter=diameter)
    loose, held = judge(thread.layer, hand, LIMITS), judge(thread.gap, hand, LIMITS)
    assert loose.status == "pass" and loose.measured == pytest.approx(0.5 - diameter)
    (said,) = loose.findings
    lies = profile_of(hand, "index").large_core(said.where[0]) + diameter / 2
    assert said.severity == "info" and f"radius {lies:.2f} mm" in said.message
    assert held.status == "pass" and held.measured == pytest.approx(2 - diameter)
    assert f"{thread_turns(hand, 'index'):.1f} turns" in held.reason
    assert f"{thread_length(hand, 'index') / 1000:.2f} m" in held.reason


def test_the_prototype_of_section_4_1_holds():
    hand = load(PARAMS / "thesis_finger.yaml").hand
    assert judge(thread.layer, hand, LIMITS).status == judge(thread.gap, hand, LIMITS).status == "pass"


@pytest.mark.parametrize(("diameter", "status"), [(0.49, "pass"), (0.5, "pass"), (0.51, "fail")])
def test_a_thread_may_fill_its_layer_but_no_more(adult, diameter, status):
    outcome = judge(thread.layer, with_thread(adult, diameter=diameter), LIMITS)
    assert outcome.status == status
    assert outcome.measured == pytest.approx(0.5 - diameter)


def test_a_groove_takes_half_of_the_thread(adult):
    assert judge(thread.layer, with_thread(adult, diameter=1.0, groove=True), LIMITS).status == "pass"
    assert judge(thread.layer, with_thread(adult, diameter=1.02, groove=True), LIMITS).status == "fail"


@pytest.mark.parametrize(("most", "status"), [(0.36, "pass"), (0.35, "pass"), (0.34, "fail")])
def test_a_thread_may_lie_loose_up_to_the_limit(adult, most, status):
    outcome = judge(thread.layer, with_thread(adult), own("thread.layer", "most_slack", most))
    assert outcome.status == status


def test_turns_balloon_beyond_the_limit_and_not_on_it(adult):
    limit = judge(thread.gap, with_thread(adult), LIMITS).limit
    for beside, status in ((-0.01, "pass"), (0.0, "pass"), (0.01, "fail")):
        outcome = judge(thread.gap, with_thread(adult, pitch=limit + beside + 0.15), LIMITS)
        assert outcome.status == status
        assert outcome.limit == pytest.approx(limit)


def test_turns_too_near_keep_the_silicone_out(adult):
    least = LIMITS.get("thread.gap", "least_gap").value
    for beside, status in ((0.01, "pass"), (0.0, "pass"), (-0.01, "fail")):
        outcome = judge(thread.gap, with_thread(adult, pitch=least + beside + 0.15), LIMITS)
        assert outcome.status == status
    assert outcome.measured == pytest.approx(least - 0.01) and outcome.limit == least


def test_turns_on_one_another_are_found_not_raised(adult):
    outcome = judge(thread.gap, with_thread(adult, pitch=0.15), LIMITS)
    assert outcome.status == "fail" and "lie on one another" in outcome.findings[0].message


def test_a_turn_gives_beyond_the_limit_and_not_on_it(adult):
    """p r pitch over the thread's section and Young's modulus (2.76 GPa, Section 5.2.2), r where it lies."""
    profile = profile_of(with_thread(adult), "index")
    radius = float(profile.large_core(adult.thread.held_back)) + 0.075
    stretch = 0.1 * radius * adult.thread.pitch / (2760 * math.pi / 4 * 0.15**2)
    for beside, status in ((1e-5, "pass"), (0.0, "pass"), (-1e-5, "fail")):
        limits = own("thread.gap", "most_stretch", stretch + beside)
        assert judge(thread.gap, with_thread(adult, diameter=0.15), limits).status == status


def test_a_thicker_thread_mends_turns_that_give(adult):
    (found,) = errors(judge(thread.gap, with_thread(adult, diameter=0.05), LIMITS))
    assert found.unit == "1" and "holds no wall" in found.message
    thicker = float(re.search("thread of (.*?) mm", found.fix)[1])
    assert not errors(judge(thread.gap, with_thread(adult, diameter=thicker), LIMITS))
    again = judge(thread.gap, with_thread(adult, diameter=thicker - 0.01), LIMITS)
    assert [f.unit for f in errors(again)] == ["1"]


def test_a_thread_of_unknown_modulus_is_not_passed_in_silence(adult):
    outcome = judge(thread.gap, with_thread(adult, material="cotton"), LIMITS)
    assert "no modulus of cotton" in next(f for f in outcome.findings if f.severity == "info").message


def test_turns_stretch_in_elements_as_the_rule_says():
    """What the silicone bears, and that turns move apart as the actuator grows longer, leave 15 %."""
    case = simulated("actuator", orientation="weightless", pressures=[0, 60])
    thin = replace(case, winding=replace(case.winding, diameter=0.08))
    mesh, state = System(thin).actuator, solid.simulate(thin).states[-1]
    rest, now = mesh.grid.nodes[mesh.threads], state.positions["actuator"][mesh.threads]
    length, before = (np.linalg.norm(x[:, 1] - x[:, 0], axis=1) for x in (now, rest))
    middle = np.abs(rest[:, 0, 0] - thin.actuator.length / 2) < 10
    stretch = float(np.mean((length / before)[middle])) - 1
    radius = float(np.mean(np.hypot(*rest[middle, 0, 1:].T)))
    alone = 0.06 * radius * thin.winding.pitch / (thin.winding.young * math.pi / 4 * 0.08**2)
    assert stretch == pytest.approx(alone, rel=0.15)


def test_where_no_pitch_suits_the_mend_says_so(adult):
    """An inner layer of half a millimetre: turns near enough to hold it keep the silicone out."""
    thin = with_thread(adult).model_copy(update={
        "layers": adult.layers.model_copy(update={"internal": 0.5})})
    (found,) = errors(judge(thread.gap, thin, LIMITS))
    assert "pitch of" not in found.fix and "thicken layers.internal" in found.fix
    assert found.limit < LIMITS.get("thread.gap", "least_gap").value
    near = thin.model_copy(update={"thread": thin.thread.model_copy(update={"pitch": found.limit + 0.15})})
    (still,) = errors(judge(thread.gap, near, LIMITS))
    assert "silicone fills that badly" in still.message


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_a_pitch_halved_or_tripled_fails(adult, factor):
    outcome = judge(thread.gap, with_thread(adult, pitch=2 * factor), LIMITS)
    assert outcome.status == "fail" and errors(outcome)


def test_turns_slide_down_a_taper_steeper_than_their_friction(adult):
    hand = with_thread(adult)
    core = profile_of(hand, "index").large_core
    (w,) = thread._windings(hand, parts(hand))
    steepest = max(abs(core.slope(x)) for x in w.stations)
    for beside, status in ((1e-4, "pass"), (0.0, "pass"), (-1e-4, "fail")):
        outcome = judge(thread.gap, hand, own("thread.gap", "friction", steepest + beside))
        assert outcome.status == status
    assert "slide" in outcome.findings[0].message
    grooved = judge(thread.gap, with_thread(adult, groove=True), own("thread.gap", "friction", steepest / 2))
    assert grooved.status == "pass"


def test_the_place_is_where_the_wall_is_thinnest_and_free(adult):
    """The little finger's layers are thinned at its last joint: its slot's far edge is named."""
    little = adult.model_copy(update={
        "actuators": Actuators(little=adult.actuators.little.model_copy(update={"thread": None})),
        "thread": adult.thread.model_copy(update={"pitch": 2.0})})
    outcome = judge(thread.gap, little, LIMITS)
    (found,) = errors(outcome)
    joint = adult.fingers.little.joints[-1]
    assert found.where[0] == pytest.approx(joint.position + joint.slot_length / 2)
    profile = profile_of(little, "little")
    assert found.where[2] == pytest.approx(profile.large_core(found.where[0]))
    inside_bore = [f for f in outcome.findings if f.severity == "info"]
    assert inside_bore and "closed bore" in inside_bore[0].message
    mended = float(found.fix.split("pitch of ")[1].split(" mm")[0])
    thinner = little.model_copy(update={"thread": little.thread.model_copy(update={"pitch": mended})})
    assert judge(thread.gap, thinner, LIMITS).status == "pass"
