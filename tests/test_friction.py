"""Friction in the bore: its law, and that a way in one step or in many leaves the same force."""

from __future__ import annotations

import numpy as np
import pytest

from handgen.simulation import line_search
from handgen.simulation.friction import SLIP, STICK, bond, chord
from handgen.simulation.system import Load, System
from tests.fingers import case, only_pairs
from tests.test_simulation_forces import swollen

MU = 0.4


@pytest.fixture(scope="module")
def system() -> System:
    """Friction between one bone and what it meets, alone."""
    found = System(case("assembly", friction=MU))
    only_pairs(found, np.full(len(found.pair_bodies), True))
    return found


def pulled(system: System, ways: list[float], q: np.ndarray) -> np.ndarray:
    """Force once the last bone has been shifted to each of `ways`, mm, one accepted step after another."""
    system.anchors[:] = np.nan
    for way in ways:
        q = q.copy()
        q[system.body_dofs[-1, 0]] = way
        _, force, _, _ = system.assemble(q, Load(), exact=True)
        system.accept(q)
    return force


def test_a_bond_pulls_fully_from_slip_on_and_its_slope_is_that_of_differences():
    h = 1e-7
    for way in np.linspace(-1.5, 1.5, 30) * SLIP:
        share, slope = bond(way)
        assert slope == pytest.approx((bond(way + h)[0] - bond(way - h)[0]) / (2 * h), abs=1e-6)
        assert chord(way, share, share) == pytest.approx(slope, abs=1e-9)
        assert (abs(share) == 1.0) == (abs(way) >= SLIP)
    assert bond(STICK)[0] == pytest.approx(np.sqrt(5 / 8))


@pytest.mark.parametrize("there", [[0.4], [0.4, 0.33], [0.4, 0.1]])
def test_many_steps_leave_the_force_of_a_few(system, there):
    """Out, and a little or a long way back."""
    q, turning = swollen(system), [0.0, *there]
    fine = [0.0]
    for end in there:
        fine += list(np.linspace(fine[-1], end, 9)[1:])
    few, many = pulled(system, turning, q), pulled(system, fine, q)
    # A few points let go and touch again on the way.
    assert many == pytest.approx(few, abs=1e-4 * np.abs(few).max())
    assert few != pytest.approx(pulled(system, [there[-1]], q), abs=1e-3 * np.abs(few).max())


def test_what_comes_to_touch_has_rubbed_in_that_very_step(system):
    q, free = swollen(system), np.zeros(system.size)
    pulled(system, [0.0], free)
    touching = system.normal > 0
    q[system.body_dofs[-1, 0]] = 0.4
    system.assemble(q, Load(), exact=True)
    mine = (system.pair_bodies == len(system.bones.start) - 1) & (system.normal > 0) & ~touching
    share = system.lever[mine]
    assert mine.sum() > 20
    # The bone's own entries are -mu cos, mu sin of its turn where a bond pulls fully.
    assert np.hypot(share[:, 6], share[:, 7]) == pytest.approx(MU, abs=0.05)


def test_a_step_is_shortened_to_where_contact_stops_it(system):
    """The force of contact and friction at the share that is taken balances, within OVERSHOT, what drives."""
    q, load = np.zeros(system.size), Load()
    system.assemble(q, load, exact=True)
    system.accept(q)
    step = swollen(system) * 5
    drive = -10.0 * step
    part = line_search.share(system, q, step, drive)
    assert line_search.LEAST < part < 1.0
    before = -float(drive @ step)
    _, force, _, _ = system.assemble(q + part * step, load, exact=True)
    assert abs(float(force @ step) - (1 - part) * before) < (line_search.OVERSHOT + 0.02) * before
    inwards = np.zeros_like(step)
    nodes = np.unique(system.actuator.outside)
    dofs = system.node_dofs[nodes][:, 1:]
    inwards[dofs[dofs >= 0]] = -0.1 * system.drawn[nodes][:, 1:][dofs >= 0]
    assert line_search.share(system, q, inwards, -10.0 * inwards) == 1.0


def test_a_step_is_reckoned_with_as_contact_changes_along_it(system):
    """Where extrapolated forces are the state's own: curvature of gaps, turning bones, friction."""
    q, rng = swollen(system), np.random.default_rng(3)
    q[system.turns] = 0.1
    pulled(system, [0.0, 0.02], q)
    q[system.body_dofs[-1, 0]] = 0.03
    system.assemble(q, Load(), exact=True)
    system.extrapolate(q, np.zeros(system.size))
    system.assemble(q, Load(), exact=False)
    what = (*system.touching(q), MU, system.anchors, system.pair_stiffness, system.pressed, system.dragged)
    for _ in range(3):
        moved, turned = system.moved(rng.normal(size=system.size) * 1e-2)
        _, reckoned = line_search.along(system.placed, moved, turned, 0.0, *what)
        after, before = (line_search.along(system.placed, moved, turned, h, *what)[0] for h in (1e-5, -1e-5))
        assert reckoned == pytest.approx((after - before) / 2e-5, rel=1e-5)
