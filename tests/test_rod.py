"""The reduced model: small bends in closed form, own weight, the solid model, its range, its error."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from handgen.bending.request import request
from handgen.parameters.load import load
from handgen.simulation import rod, solid
from handgen.simulation.rod.balance import Balance
from handgen.simulation.rod.chain import PENALTY, ROUNDED, Chain
from handgen.simulation.rod.known import known, measures, state_measures
from handgen.simulation.system import System
from handgen.sweep import draw
from handgen.sweep.evaluate import evaluate
from handgen.sweep.load import prepare
from handgen.sweep.mass import actuator, exoskeleton
from handgen.sweep.variant import task
from tests.bend_case import ADULT_FILE, changed_file, command
from tests.sweep_files import sweep_file

PLAIN = {"reach": 0.0, "strip": 1.0, "rub": 0.0, "chamber": 0.0, "lift": 0.0, "lever": 0.0, "bone": 1.0}
"""Coefficients with which the rod is what its sections say."""


def case(file=ADULT_FILE, pressures="0", **values):
    return request(file, pressures=pressures, **values).case


def stiffness(chain):
    """(axial, bending) of every strip: E A / L, N/mm, and E I / L, N mm."""
    young = 3 * chain.case.tpu.law.shear_modulus
    return young * chain.area / chain.slot, young * chain.second / chain.slot


def test_a_little_pressure_turns_each_joint_by_thrust_times_lever():
    """Linear: strips and actuator are springs in a row between the closed ends."""
    chain = Chain(case(orientation="weightless"))
    pressure = 1e-4
    balance = Balance(chain, PLAIN)
    q = rod.towards(balance, balance.unloaded(1), 0.0, pressure)
    axial, bending = stiffness(chain)
    give = chain.dx / (chain.wall_area * 4 * chain.case.silicone.law.shear_modulus)  # planar tension
    thrust = pressure * (chain.pressed * give).sum() / (
        give.sum() + (1 / axial).sum() + (chain.lever**2 / bending).sum())
    assert q[6] == pytest.approx(thrust, rel=0.01)
    assert q[:3] == pytest.approx(thrust * chain.lever / bending, rel=0.01)
    # The table of the law makes a strip 1 % softer in tension, so that its bending stretches it a little.
    assert q[3:6] == pytest.approx(thrust / axial, rel=0.12)


def test_a_little_weight_turns_each_joint_by_what_hangs_beyond_it():
    whole = case()
    chain = Chain(replace(whole, gravity=(0.0, 0.0, 0.02 * whole.gravity[2])))
    q = Balance(chain, PLAIN).unloaded(1)
    _, bending = stiffness(chain)
    weight = -chain.case.gravity[2] * chain.mass[1:]
    moment = [(weight[j:] * (chain.centre[1 + j:] - chain.position[j])).sum() for j in range(3)]
    assert q[:3] == pytest.approx(moment / bending, rel=0.03)


@pytest.mark.parametrize("values", [{"tip_loads": (0.3,)}, {"obstacle": 20.0}])
def test_moments_and_pulls_are_slopes_of_an_energy(values):
    """Own weight, a weight on the tip, a plane: heights alone, differenced."""
    chain = Chain(replace(case(), **values))
    q = np.random.default_rng(0).uniform(-0.1, 0.9, (20, chain.unknowns))
    q[0] = 0.0

    def energy(q):
        frames, gravity = chain.frames(q), -chain.case.gravity[2]
        ends = np.stack([chain.centre, chain.end], -1)
        middle, far = np.moveaxis(chain.heights(frames, ends, np.zeros_like(ends)), -1, 0)
        found = 0.6 * ((gravity * chain.mass * middle).sum(-1) + chain.case.tip_loads[0] * far[:, -1])
        if chain.case.obstacle is not None:
            level = -float(chain.profile.outer(0.0)) - chain.case.obstacle
            below = level - chain.heights(frames, chain.touch, chain.touch_radius)
            found += PENALTY / 8 * ((below + np.sqrt(below**2 + ROUNDED**2)) ** 2).sum((-1, -2))
        return found

    for i in range(2 * chain.joints):
        step = 1e-5 * np.eye(chain.unknowns)[i]
        slope = (energy(q + step) - energy(q - step)) / 2e-5
        assert chain.forces(q, 0.6)[:, i] == pytest.approx(slope, rel=1e-6, abs=1e-5)


def test_the_bones_weigh_what_the_finger_does():
    hand, asked = load(ADULT_FILE).hand, case()
    tonnes = (asked.tpu.density * exoskeleton(hand, "index")
              + asked.silicone.density * actuator(hand, "index")[0])
    assert Chain(asked).mass.sum() == pytest.approx(tonnes, rel=0.02)


def test_the_solid_model_lies_within_the_stated_error():
    asked = case(model="literature", pressures="0,25,50")
    slim, full = rod.simulate(asked).states, solid.simulate(asked).states
    for mine, truth in zip(slim, full, strict=True):
        assert abs(mine.bend_angle - truth.bend_angle) <= mine.bend_error
        assert mine.tip_drop == pytest.approx(truth.tip_drop, abs=0.15 * truth.tip_drop + 2.0)
        assert mine.elongation == pytest.approx(truth.elongation, abs=0.15 * truth.elongation + 0.5)


def test_outside_its_range_the_answer_says_so(tmp_path):
    inside = rod.simulate(case(model="literature", pressures="0,40")).states[1]
    hand = rod.simulate(case(pressures="0,40")).states[1]  # printed three times as soft
    narrow = rod.simulate(case(changed_file(tmp_path, fingers__index__joints=[
        {"name": "MCP", "position": 20, "slot_length": 3, "palmar_arc": 175, "rest_angle": 0}]),
        pressures="0,40")).states[1]
    assert inside.note == "" and hand.note == ""
    assert "outside the rod's calibration: " in narrow.note
    assert "palmar arc, deg 175" in narrow.note and "joints 1" in narrow.note
    share = known().share
    assert inside.bend_error == pytest.approx(share * inside.bend_angle + known().least)
    assert narrow.bend_error == pytest.approx(
        known().outside * (share * narrow.bend_angle + known().least))


def test_the_range_knows_every_measure():
    chain = Chain(case())
    found = {**measures(chain), **state_measures(chain, np.zeros(3), np.ones(4), 0.01)}
    assert set(found) == set(known().range) and all(low <= high for low, high in known().range.values())
    assert set(known().coefficients) == set(PLAIN)


def test_command_line_reports_the_error(tmp_path, capsys):
    asked = ADULT_FILE, "--solver", "rod", "--pressures", "0,40", "--out", str(tmp_path)
    code, found, _ = command(capsys, *asked)
    point = found["points"][1]
    assert code == 0 and found["solver"] == "rod" and point["bend_angle_error_deg"] > 0
    assert json.loads(next(tmp_path.rglob("bend.json")).read_text())["points"] == found["points"]
    code, wrong, _ = command(capsys, ADULT_FILE, "--solver", "rod", "--part", "actuator", "--refine", "1")
    assert code == 2 and {e["path"] for e in wrong["errors"]} == {"--solver", "--refine"}


def test_an_effect_that_it_does_not_know_is_refused():
    plain = case()
    with pytest.raises(ValueError, match="joints that close"):
        rod.simulate(replace(plain, edges_left=0.5))


@pytest.mark.parametrize("angle", [45, 90, 110, 150])
def test_the_tip_that_meets_a_plane_is_round_on_its_back_too(angle):
    """Both models' points reach as low as the tip's outline; beyond 90 degrees that is its dorsal side."""
    asked = case(obstacle=40)
    f, outer = asked.finger.finger, asked.finger.outer_radius
    x = np.linspace(f.inner_length, f.outer_length, 2000)
    outline = np.stack([np.r_[x, x], np.r_[-outer(x), outer(x)]])
    chain, system = Chain(asked), System(asked)
    last = system.plane_bodies == system.plane_bodies.max()
    down = np.array([-math.sin(math.radians(angle)), math.cos(math.radians(angle))])
    for points in (np.stack([chain.touch[-1], -chain.touch_radius[-1]]), system.plane_points[last][:, ::2].T):
        assert (down @ points).min() == pytest.approx((down @ outline).min(), abs=0.05)


def test_a_nearer_plane_is_pushed_harder():
    near, far = (rod.simulate(case(pressures="0,80", obstacle=d)).states[1].tip_force for d in (20, 40))
    free = rod.simulate(case(pressures="0", obstacle=60)).states[0].tip_force
    assert near > far > 0 and free < 1e-5


def test_a_force_that_is_not_found_says_why(tmp_path):
    """A long slot under a soft strip lets the tip roll under the finger."""
    one = prepare(sweep_file(tmp_path, solver="rod", bend={"pressures": [60]}, vary={
        "force.obstacle": [40]}, force={"pressure": 150, "obstacle": 40}))
    row = evaluate(task(one, next(draw.points(one.sweep))))
    assert row["status"] == "done" and row["fingertip_force_N"] is None
    assert "no force: the rod finds no balance on the way to" in row["flags"]


def test_a_sweep_by_the_rod(tmp_path):
    one = prepare(sweep_file(tmp_path, solver="rod", bend={"pressures": [0, 60]}, vary={
        "fingers.index.joints.*.palmar_arc": [70, 80, 90]}))
    rows = [evaluate(task(one, values)) for values in draw.points(one.sweep)]
    bends = [row["bend_angle_deg"] for row in rows]
    # Wider strips are stiffer.
    assert bends == sorted(bends, reverse=True) and all(row["status"] == "done" for row in rows)
    assert all(row["bend_angle_error_deg"] > 0 for row in rows)
    assert math.isfinite(rows[0]["hinge_strain"])
