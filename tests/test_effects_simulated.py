"""Effects at work in the finite elements: signs of their signatures, closed forms, what they leave alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from handgen.bending import model
from handgen.bending.model import load_model
from handgen.bending.request import request
from handgen.effects import Course, catalogue
from handgen.simulation import mesh
from handgen.simulation.base import Base
from handgen.simulation.offcentre import shifted
from handgen.simulation.solid import simulate
from handgen.simulation.solve import Solver
from handgen.simulation.system import Load, System
from tests.fingers import PARAMS, case

HAND = PARAMS / "thesis_hand.yaml"


def asked(part: str, name: str = "", path: str = "loading", **arguments):
    """The case of a finger with one effect on; a parameter of the effect under its name."""
    known = {one.name for one in catalogue()[name].parameters} if name else set()
    own = {k: v for k, v in arguments.items() if k in known}
    effects = [model.Effect(id=name, parameters=own)] if name else []
    wanted = load_model("calibrated")[0].model_copy(update={"effects": effects})
    rest = {k: v for k, v in arguments.items() if k not in known}
    return request(HAND, part=part, model=wanted, path=path, **rest).case


def curve(quantity: str, wanted) -> list[float]:
    found = simulate(wanted)
    assert not found.stopped
    return [getattr(state, quantity) for state in found.states]


# The free actuator

UP = [20, 40, 60]


@pytest.fixture(scope="module")
def plain():
    return curve("elongation", asked("actuator", pressures=UP, orientation="weightless"))


def elongation(name: str, path: str = "loading", pressures=None, **parameters) -> list[float]:
    return curve("elongation", asked("actuator", name, path, pressures=pressures or UP,
                                     orientation="weightless", **parameters))


def test_soft_silicone_stretches_further_and_a_uniaxial_law_less(plain):
    softer = np.divide(elongation("silicone_softening", softening=0.2), plain)
    stiffer = np.divide(elongation("uniaxial_only_law", share=0.25), plain)
    assert (softer > 1.2).all() and (stiffer < 0.9).all()
    assert stiffer[-1] < stiffer[0] - 0.03


def test_wide_turns_let_the_wall_out_and_the_tip_go_less_far_at_first(plain):
    case = asked("actuator", "thread_spacing", pressures=UP, orientation="weightless", wider=2.0)
    assert case.winding.pitch == pytest.approx(4.0) and case.winding.bulge > 5.0
    found = simulate(case)
    narrow = simulate(asked("actuator", pressures=UP, orientation="weightless"))
    assert grown(found).max() > 2.0 * grown(narrow).max()
    once, twice = (elongation("thread_spacing", wider=w) for w in (1.4, 2.0))
    moved = np.subtract([once, twice], plain)
    assert (np.abs(moved[1]) > np.abs(moved[0])).all() and (np.sign(moved[0]) == np.sign(moved[1])).all()


def grown(found, state: int = -1) -> np.ndarray:
    """How much farther from the axis each node of the actuator lies, mm."""
    drawn, there = found.grids["actuator"].nodes, found.states[state].positions["actuator"]
    return np.hypot(*there[:, 1:].T) - np.hypot(*drawn[:, 1:].T)


def test_turns_that_give_do_what_turns_do_one_by_one(monkeypatch):
    """Of a short actuator, pitch 4 less 2 mm: smeared against rings on a mesh that resolves the bulge."""
    def moved(one) -> np.ndarray:
        found = simulate(one)
        nodes = found.grids["actuator"].nodes
        wall = (nodes[:, 0] > 12) & (nodes[:, 0] < one.actuator.length - 8) & (
            np.hypot(nodes[:, 1], nodes[:, 2]) > 0.95 * nodes[:, 2].max())
        return np.array([[state.elongation, grown(found, i)[wall].mean()]
                         for i, state in enumerate(found.states)])

    usual, wide = (asked("actuator", "thread_spacing", finger="opposition_1", pressures=[20, 40],
                         orientation="weightless", wider=w) for w in (1.0, 2.0))
    smeared = moved(wide) - moved(usual)
    fine = {"EDGE": 0.5, "END_EDGE": 0.5, "GROWTH": 1.0, "WALL": (2, 2)}
    for name, value in fine.items():
        monkeypatch.setattr(mesh, name, value)

    def rings(self):
        turns = np.arange(self.winding.start, self.winding.end + 1e-9, self.winding.pitch)
        at = np.abs(self.x[:, None] - turns).argmin(axis=0)
        s, k = np.meshgrid(at, np.arange(self.around), indexing="ij")
        ends = np.stack([self.node(s, self.inner, k), self.node(s, self.inner, k + 1)], -1).reshape(-1, 2)
        return ends, np.full(len(ends), self.winding.pitch)

    monkeypatch.setattr(mesh._Rings, "_threads", rings)
    one_by_one = [moved(replace(usual, winding=replace(usual.winding, pitch=pitch))) for pitch in (4.0, 2.0)]
    assert smeared == pytest.approx(one_by_one[0] - one_by_one[1], rel=0.2)


def test_an_actuator_off_its_centre_bends_to_its_thick_side(plain):
    dorsal, palmar = (simulate(asked("actuator", "asymmetric_winding", pressures=UP, orientation="weightless",
                                     offset=by)) for by in (0.3, -0.3))
    bend = [state.bend_angle for state in dorsal.states]
    assert 0.0 < bend[0] < bend[1] < bend[2]
    assert [state.bend_angle for state in palmar.states] == pytest.approx([-b for b in bend], rel=2e-2)
    assert dorsal.states[-1].elongation < plain[-1]


def test_the_outside_and_the_chamber_s_size_stay_where_the_core_is_off_centre():
    one = asked("actuator", pressures=[0], orientation="weightless")
    drawn = mesh.actuator_mesh(one.actuator, one.winding, one.held, 0)
    moved = shifted(drawn, one.actuator, one.winding.depth, 0.4).grid.nodes - drawn.grid.nodes
    outside = np.unique(drawn.outside)
    assert moved[outside] == pytest.approx(0.0, abs=1e-9)
    chamber, thread = np.unique(drawn.chamber), np.unique(drawn.threads)
    assert moved[chamber] == pytest.approx(np.tile([0, 0, 0.4], (len(chamber), 1)))
    assert moved[thread] == pytest.approx(np.tile([0, 0, 0.4], (len(thread), 1)), abs=1e-9)


def test_silicone_that_was_stretched_lies_further_out_coming_down(plain):
    down = elongation("mullins", "unloading", UP[::-1], depth=0.3)[::-1]
    assert down[-1] == pytest.approx(plain[-1], rel=1e-3)
    assert (np.array(down[:-1]) > 1.1 * np.array(plain[:-1])).all()
    assert elongation("mullins", depth=0.3) == pytest.approx(plain, abs=0)


def test_a_held_finger_creeps_by_the_same_share_a_decade():
    case = asked("actuator", "creep", "hold", pressures=[30, 30, 30], orientation="weightless", rate=0.05,
                 onset=10.0, times=[90.0, 990.0, 9990.0])
    assert case.softening == pytest.approx([0.05, 0.10, 0.15])
    sooner = asked("actuator", "creep", "hold", pressures=[30, 30, 30], orientation="weightless", rate=0.05,
                   onset=1.0, times=[9.0, 99.0, 999.0])
    assert sooner.softening == pytest.approx(case.softening)
    first, second, third = curve("elongation", case)
    softer = elongation("silicone_softening", pressures=[30], softening=0.10)
    assert first < second < third
    assert second == pytest.approx(softer[0], rel=2e-3)  # bulk apart, the same material


def test_repeats_of_a_fresh_actuator_are_softer_but_the_first():
    course, depth = Course((20.0, 40.0, 60.0), repeats=3), {"depth": 0.3}
    alone = catalogue()["mullins"].on_course(replace(course, repeats=1), depth)
    mean = catalogue()["mullins"].on_course(course, depth)
    down = catalogue()["mullins"].on_course(Course((60.0, 40.0, 20.0)), depth)
    assert alone == [0.0, 0.0, 0.0]
    assert mean == pytest.approx([2 / 3 * lost for lost in down[::-1]])


# The bare exoskeleton


def hanging(name: str = "", orientation: str = "palm_down", **parameters):
    return asked("exoskeleton", name, tip_loads=[0.0, 0.1, 0.3], orientation=orientation, **parameters)


@pytest.fixture(scope="module")
def hung():
    return simulate(hanging())


@pytest.mark.parametrize(("name", "parameters"), [
    ("print_porosity", {"porosity": 0.2}), ("rest_curl", {"angle": 15.0}),
    ("base_compliance", {"compliance": 0.2})])
def test_what_bends_the_bare_finger_further(hung, name, parameters):
    """A curled finger that hangs straight down is shorter, so of its drops only the first is larger."""
    found = simulate(hanging(name, **parameters))
    more = [(a.tip_drop - b.tip_drop, a.bend_angle - b.bend_angle)
            for a, b in zip(found.states, hung.states, strict=True)]
    assert more[0][0] > 0.3 and all(angle > 0.0 for _, angle in more)
    assert name == "rest_curl" or all(drop > 0.3 for drop, _ in more)


def test_a_root_turns_by_compliance_times_moment_and_takes_the_whole_finger_along():
    """Weightless, a weight at the tip: the moment is its force times its lever; seen from the root nothing
    but the direction of the force has changed."""
    soft = replace(case("exoskeleton", tip_loads=[0.2], orientation="weightless"), base_compliance=0.01)
    system = System(soft)
    solver = Solver(system)
    point, there = solver.advance(solver.begin(), Load(0.0, 0.0, 0.2))
    assert there and isinstance(system.base, Base)
    turn = system.base.angle(point.q)
    tip = np.array([[soft.finger.length, 0.0, 0.0]])
    at = system.bones.carried(len(system.bones.start) - 1, tip, system.bone_states(point.q))
    lever = system.base.carried(at, point.q)[0, 0]
    assert turn == pytest.approx(0.01 * 0.2 * lever, rel=1e-4) and turn > 0.1

    force = 9806.65 * np.array([np.sin(turn), 0.0, -np.cos(turn)])
    massless = replace(soft.tpu, density=1e-20)
    stiff = System(replace(soft, base_compliance=0.0, gravity=tuple(force), tpu=massless))
    other = Solver(stiff)
    same, there = other.advance(other.begin(), Load(1.0, 0.0, 0.2))
    assert there
    assert point.q[:-1] == pytest.approx(same.q, abs=2e-3)


def test_a_slot_that_closes_stops_the_finger_and_nothing_else(hung):
    free, open_still, closed = (simulate(hanging("self_contact", left=left)) for left in (0.0, 0.3, 0.9))
    drops = [[state.tip_drop for state in found.states] for found in (hung, free, open_still, closed)]
    assert drops[0] == drops[1]
    assert drops[2] == pytest.approx(drops[0], abs=1e-3)
    assert drops[3][-1] < drops[0][-1] - 1.0


# The finger: slow, so few points


def test_friction_leaves_a_loop():
    """With the model's friction of 0.8: silicone that has slid out on the way up is held there."""
    found = simulate(asked("assembly", path="cycle", pressures=[10, 30, 10]))
    up, top, down = found.states
    assert up.bend_angle + 0.004 < down.bend_angle < top.bend_angle
    assert up.elongation < down.elongation < top.elongation
    smooth = asked("assembly", path="cycle", pressures=[10, 30, 10])
    smooth = simulate(replace(smooth, contact=replace(smooth.contact, friction=0.0)))
    assert smooth.states[2].bend_angle == pytest.approx(smooth.states[0].bend_angle, abs=1e-4)


def test_a_finger_whose_bore_grips_hangs_higher_at_rest_and_under_pressure_as_far():
    """Friction alone has only the weight to press it at rest."""
    rests = {}
    for more, grip in ((0.0, 0.0), (0.6, 0.0), (0.6, 0.08)):
        rests[more, grip] = curve("tip_drop", asked("assembly", "bore_friction", pressures=[0, 60], more=more,
                                                    grip=grip))
    plain, rubbing, gripped = rests.values()
    by_friction, by_grip = plain[0] - rubbing[0], rubbing[0] - gripped[0]
    assert by_grip > 1.0 and by_grip > 3 * by_friction
    assert abs(rubbing[1] - gripped[1]) < by_grip / 3
