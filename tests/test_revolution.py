"""The free actuator as a section of revolution: against its own energy, the solid and NGSolve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from handgen.simulation import cavity, revolution, solid
from handgen.simulation.loads import Load
from handgen.simulation.revolution import Revolution
from handgen.simulation.solve import Solver
from tests.bend_case import ADULT_FILE, command
from tests.fingers import assembler, case, shaken
from tests.small_solids import slope_error


def free(**arguments):
    return case("actuator", orientation="weightless", **arguments)


@pytest.fixture(scope="module")
def blown():
    """(system, unknowns) at 40 kPa."""
    system = Revolution(free())
    solver = Solver(system)
    point, there = solver.advance(solver.begin(), Load(pressure=0.04))
    assert there
    return system, point.q


@pytest.mark.parametrize("wound", [True, False])
def test_forces_and_tangent_are_the_energys(wound):
    one = free()
    system = Revolution(one if wound else replace(one, winding=None))
    force, stiffness = slope_error(assembler(system, Load(pressure=0.05)), shaken(system, 0.02), 1e-5)
    assert force < 1e-6 and stiffness < 1e-6


def test_under_a_law_of_stretches_too():
    system = Revolution(replace(free(), silicone=case("assembly", params="thesis_finger.yaml").silicone))
    assert max(slope_error(assembler(system, Load(pressure=0.05)), shaken(system, 0.02), 1e-5)) < 1e-6


def test_the_solid_comes_nearer_the_finer_it_is():
    one = free(pressures="20,60")
    exact = revolution.simulate(replace(one, refine=1))
    off = [max(abs(a.elongation / b.elongation - 1) for a, b in zip(
        solid.simulate(replace(one, refine=refine)).states, exact.states, strict=True)) for refine in (0, 1)]
    assert off[0] < 0.015 and off[1] < 0.4 * off[0]


def test_halved_edges_leave_less_than_half_of_the_error():
    found = [revolution.simulate(replace(free(pressures="60"), refine=refine)).states[0].elongation
             for refine in (0, 1, 2)]
    assert 0 < found[2] - found[1] < 0.5 * (found[1] - found[0])
    assert found[0] == pytest.approx(found[2], rel=0.005)


def test_ngsolve_says_the_same():
    pytest.importorskip("ngsolve")
    from handgen.simulation import reference
    from handgen.simulation.reference.tube import Division

    one = free(pressures="30,60")
    other = reference.simulate(one, division=Division(22, 2, 1, 1, 4, 2))  # itself 0.3 % off
    for a, b in zip(revolution.simulate(one).states, other.states, strict=True):
        assert a.elongation == pytest.approx(b.elongation, rel=0.004)


def test_without_thread_it_swells_as_the_solid_does():
    """That is coarser, and the nearer the finer."""
    one = replace(free(pressures="5,15"), winding=None)
    curves = revolution.simulate(one), solid.simulate(one), solid.simulate(replace(one, refine=1))
    ours, coarse, fine = (np.array([state.elongation for state in curve.states]) for curve in curves)
    assert (np.abs(fine / ours - 1) < 0.02).all()
    assert (np.abs(fine / ours - 1) < 0.5 * np.abs(coarse / ours - 1)).all()


@pytest.mark.parametrize("finger", ["middle", "ring", "little", "thumb", "opposition_1", "opposition_2"])
def test_every_actuator_of_the_hand_lengthens_as_its_solid_does(finger):
    one = free(pressures="30,60", finger=finger)
    for a, b in zip(revolution.simulate(one).states, solid.simulate(one).states, strict=True):
        assert a.converged
        assert 0.97 * a.elongation < b.elongation < a.elongation  # trilinear elements are too stiff


def test_rings_stand_for_the_turns_from_the_first_to_the_last():
    one = free()
    third = replace(one.winding, start=one.actuator.length / 3, end=2 * one.actuator.length / 3)
    system = Revolution(replace(one, winding=third))
    at = system.section.nodes[system.section.wound, 0]
    assert at.min() == pytest.approx(third.start) and at.max() == pytest.approx(third.end)
    assert system.section.span.sum() == pytest.approx(third.end - third.start)


def test_the_mesh_that_is_shown_is_the_section_turned(blown):
    system, q = blown
    x, mesh = system.positions(q), system.actuator
    tip = system._own[system.section.number[-1, 0], 0]
    assert x[mesh.tip, 0] - mesh.grid.nodes[mesh.tip, 0] == pytest.approx(q[tip], abs=1e-12)
    # Every ring stays a circle about the axis, and the chamber grows as the section's frusta do.
    rings = np.hypot(x[:mesh.axis[-1] + 9, 1], x[:mesh.axis[-1] + 9, 2]).reshape(-1, 9)
    assert np.ptp(rings, axis=1).max() < 1e-9
    room = np.zeros(system.size), np.zeros(system.pattern.entries)
    revolved = [-revolution.add_pressure(system._straight + system._moved(at), system.section.chamber, 1.0,
                                         *system._line_group, *room) for at in (q, 0 * q)]
    grown = cavity.volume(x, mesh.chamber) - cavity.volume(system.drawn, mesh.chamber)
    assert grown == pytest.approx(revolved[0] - revolved[1], rel=0.01)


@pytest.mark.parametrize("change", [
    dict(gravity=(0.0, 0.0, -9806.65)), dict(offset=0.3), dict(softening=(0.1,)), dict(part="assembly")])
def test_what_is_not_round_is_refused(change):
    with pytest.raises(ValueError, match="body of revolution"):
        revolution.simulate(replace(free(pressures="10"), **change))


def test_the_command_says_how_to_ask(capsys, tmp_path):
    code, data, _ = command(capsys, ADULT_FILE, "--part", "actuator", "--solver", "revolution", "--out",
                            str(tmp_path / "out"))
    assert code == 2 and [(e["path"], e["allowed"]) for e in data["errors"]] == [
        ("--orientation", "weightless")]
    code, data, _ = command(capsys, ADULT_FILE, "--solver", "revolution")
    assert code == 2 and data["errors"][0]["path"] == "--solver"
    assert not (tmp_path / "out").exists()
