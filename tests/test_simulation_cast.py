"""An actuator cast straight in a finger with a rest curl; a finger that hangs from its root."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.sparse.linalg import spsolve

from handgen.simulation import shapes
from handgen.simulation.case import STANDARD_GRAVITY, Contact
from handgen.simulation.cast import free_of_stress
from handgen.simulation.solid import simulate
from handgen.simulation.solve import Solver
from handgen.simulation.system import Load, System
from tests.fingers import case, stiffness

CURL = math.radians(26.7)


def curled(**changes):
    """The index finger of the thesis, weightless, curled at its MCP joint, frictionless."""
    return replace(case("assembly", params="thesis_hand.yaml", orientation="weightless", pressures=[0.0]),
                   **changes)


# The shape that is free of stress


def test_lies_between_the_curled_and_the_straight_one():
    asked = curled(curl_taken=0.0)
    straight = System(asked).actuator.grid.nodes
    assert free_of_stress(asked, straight, 1.0) == pytest.approx(straight, abs=1e-12)
    assert free_of_stress(asked, straight, 0.0) == pytest.approx(System(asked).grids["actuator"].nodes, abs=0)
    ahead = straight[:, 0] > 30.0
    half = free_of_stress(asked, straight, 0.5)[ahead]
    level = half @ [[math.cos(CURL / 2)], [0.0], [-math.sin(CURL / 2)]]
    assert np.ptp(level[:, 0] - straight[ahead, 0]) < 1e-9, "beyond the joint it is turned by half the angle"


def test_a_straight_finger_asks_for_nothing():
    straight = case("assembly", pressures=[0.0])
    assert replace(straight, curl_taken=0.0).curl_strains == 0.0
    assert curled(curl_taken=0.3).curl_strains == pytest.approx(0.7)
    assert curled(curl_taken=1.0).curl_strains == 0.0


# What it does


@pytest.mark.parametrize("wound", [False, True])
def test_held_straight_an_actuator_that_is_bent_by_nature_pulls_as_a_beam(wound):
    """Base and tip held in place: the moment at the base is that of a beam of EI(x) whose natural curvature
    is taken from it. E is 3 G; the thread, which lets the wall not grow narrower, makes that 4 G at most."""
    asked = case("actuator", orientation="weightless", pressures=[0.0])
    system = System(asked if wound else replace(asked, winding=None))
    held, end = asked.held, asked.actuator.small_core_end
    natural = 5e-4 / asked.actuator.length
    block, = system.blocks
    block.dn, block.weight = shapes.gradients(_bent(system.drawn, natural, held), block.cells)
    moment = _base_moment(system, held, end)

    def soft(n: int) -> float:
        return quad(lambda x: (end - x) ** n / _rigidity(asked, x), held, end)[0]

    length = end - held
    at_tip, force = np.linalg.solve([[soft(0), soft(1)], [soft(1), soft(2)]],
                                    natural * np.array([length, length**2 / 2]))
    beam = at_tip + force * length
    if wound:
        assert beam < moment < 4 / 3 * beam
    else:
        assert moment == pytest.approx(beam, rel=0.03)


def _rigidity(asked, x: float) -> float:
    """3 G I of half the tube at x, N mm2."""
    wall = float(asked.actuator.outer(x)) ** 4 - float(asked.actuator.small_core(x)) ** 4
    return 3 * asked.silicone.law.shear_modulus * math.pi / 8 * wall


def _base_moment(system, held: float, end: float) -> float:
    """What the base of a free actuator takes, N mm, while its tip is held where it was drawn."""
    _, force, values, _ = system.assemble(np.zeros(system.size), Load(), exact=True)
    tip = np.flatnonzero(system.drawn[:, 0] > end - 1e-9)
    rigid = np.zeros(system.size, bool)
    dofs = system.node_dofs[tip]
    rigid[dofs[dofs >= 0]] = True
    matrix, moved = stiffness(system, values), np.zeros(system.size)
    moved[~rigid] = spsolve(matrix[~rigid][:, ~rigid], -force[~rigid])
    acting = (matrix @ moved + force)[dofs]
    arm = system.drawn[tip]
    # Flexion positive, as everywhere: about -y.
    return float(((arm[:, 0] - held) * acting[:, 2] - arm[:, 2] * acting[:, 0]).sum())


def _bent(nodes, curvature: float, start: float):
    """`nodes` along an axis that is curved palmar beyond `start`, to first order."""
    s = np.maximum(nodes[:, 0] - start, 0.0)
    moved = nodes.copy()
    moved[:, 2] -= curvature * s**2 / 2
    moved[:, 0] += nodes[:, 2] * curvature * s
    return moved


def test_finger_and_actuator_share_the_curl_and_give_it_back():
    """The actuator straightens the finger more, the more of the curl strains it; relieved again, without
    friction, the finger stands where it stood, and no energy is left."""
    system = System(curled(curl_taken=0.0))
    solver = Solver(system)
    point, _ = solver.advance(solver.begin(), Load(fit=0.5))
    half = point.q[system.turns[0]]
    point, there = solver.advance(point, Load(fit=1.0))
    strained = system.assemble(point.q, point.load, exact=True)[0]
    assert there and strained > 0.0
    assert -CURL < point.q[system.turns[0]] < half < 0.0
    point, there = solver.advance(point, Load())
    assert there
    assert np.abs(point.q).max() < 1e-4
    assert system.assemble(point.q, point.load, exact=True)[0] < 1e-6 * strained


def test_a_narrow_bore_closes_on_its_actuator():
    """0.2 mm narrower all around, nothing would be in balance as drawn: the bore closes from where it
    touches, and the wall ends pressed in by as much, less what the contact gives."""
    asked = curled(contact=Contact(clearance=-0.2))
    assert (asked.tight, curled().tight, curled(contact=Contact(clearance=0.1)).tight) == (
        pytest.approx(0.2), 0.0, 0.0)
    system = System(asked)
    solver = Solver(system)
    point, there = solver.advance(solver.begin(), Load(fit=1.0))
    assert there
    x, mesh = system.positions(point.q), system.actuator
    ring = np.flatnonzero(np.abs(mesh.grid.nodes[mesh.axis, 0] - 40.0) < 3.0)
    wide = [np.linalg.norm(x[mesh.back[i]] - x[mesh.axis[i]]) / mesh.swell for i in ring]
    drawn = 2 * asked.actuator.outer(mesh.grid.nodes[mesh.axis[ring], 0])
    assert np.all((drawn - wide > 0.2) & (drawn - wide < 0.4))


# The root


def test_hanging_from_the_root_is_gravity_that_turns_the_other_way():
    angle = 0.4
    hung = simulate(replace(case("exoskeleton", tip_loads=[0.0, 0.1]), root_angle=angle))
    turned = (STANDARD_GRAVITY * math.sin(angle), 0.0, -STANDARD_GRAVITY * math.cos(angle))
    other = simulate(replace(case("exoskeleton", tip_loads=[0.0, 0.1]), gravity=turned))
    for one, two in zip(hung.states, other.states, strict=True):
        assert one.bend_angle == pytest.approx(two.bend_angle + angle, abs=1e-5)
