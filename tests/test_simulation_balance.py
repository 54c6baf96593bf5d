"""States that the solver calls balanced, judged by `independent_balance`."""

from __future__ import annotations

import numpy as np
import pytest

from handgen.simulation import solid
from handgen.simulation.observe import state
from handgen.simulation.solve import Solver
from handgen.simulation.system import Load, System
from tests.fingers import case
from tests.independent_balance import Judge

LIMIT = 1e-4
"""Ten times the solver's own tolerance: a node's acting force is counted a little differently."""


@pytest.mark.parametrize(("part", "arguments"), [
    ("actuator", dict(pressures="0,25")),
    ("exoskeleton", dict(tip_loads="0,0.2")),
    ("assembly", dict(pressures="25")),
    ("assembly", dict(pressures="20", bonded=True, orientation="weightless")),
    ("assembly", dict(pressures="25", orientation="weightless")),
])
def test_states_are_in_balance_by_other_means(part, arguments):
    one = case(part, **arguments)
    curve, judge = solid.simulate(one), Judge(one)
    for found in curve.states:
        assert found.converged
        judged = judge.judge(found.positions, found.pressure, found.tip_load)
        assert judged.least > 0
        assert judged.unbalanced < LIMIT
    # And it does see what is not: a hundredth of the last pressure or weight more.
    more = judge.judge(found.positions, 1.01 * found.pressure, 1.01 * found.tip_load)
    assert more.unbalanced > 3 * LIMIT


@pytest.mark.parametrize("pressures", [[0.025], [0.01, 0.02, 0.03]])
def test_friction_rests_on_the_normal_forces_of_the_state_itself(pressures):
    """However long the steps: `Judge` lets each point rub by mu times what presses on it now."""
    one = case("assembly", friction=0.8)
    system = System(one)
    solver, judge = Solver(system), Judge(one)
    point = solver.begin()
    for pressure in pressures:
        point, there = solver.advance(point, Load(1.0, pressure, 0.0))
        assert there
        found = state(system, point)
        assert judge.judge(found.positions, found.pressure).unbalanced < LIMIT
    assert judge.judge(found.positions, found.pressure, rubbing=0 * system.normal).unbalanced > 30 * LIMIT


@pytest.mark.parametrize(("left", "room", "last", "expected"), [
    (1.0, np.inf, 0.1, 0.3),   # as long as steps are
    (0.5, np.inf, 0.1, 0.25),  # two equal ones to the end
    (0.2, np.inf, 0.1, 0.2),
    (0.9, 0.2, 0.2, 0.2),      # where one failed before, from no farther than the last one went
    (0.9, 0.2, 0.1, 0.1),
    (0.3, 0.3, 0.1, 0.15),
])
def test_steps_come_nearer_to_where_one_failed(left, room, last, expected):
    solver = Solver(System(case("actuator")))
    solver._steps = [1.0, 0.03, 1.0, 1.0, 1.0]
    assert solver._ahead(np.array([0.0, 0.1, 0.0, 0.0, 0.0]), left, room, last) == pytest.approx(expected)
