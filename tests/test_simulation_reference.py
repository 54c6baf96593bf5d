"""The solid model beside NGSolve at equal refinement; benchmarks/bend_reference.py has the whole table."""

from __future__ import annotations

from dataclasses import replace

import pytest

from handgen.simulation import reference, solid
from handgen.simulation.reference.tube import Division
from tests.fingers import case

pytest.importorskip("ngsolve")
COARSE = Division(12, 1, 1, 1, 3, 1)
"""2272 unknowns; within 0.9 % of 37 000."""


def test_the_free_actuator_lengthens_as_ngsolve_says():
    one = case("actuator", pressures="30,60", orientation="weightless")
    ours, other = solid.simulate(one), reference.simulate(one, division=COARSE)
    for a, b in zip(ours.states, other.states, strict=True):
        assert b.converged
        assert a.elongation == pytest.approx(b.elongation, rel=0.015)
        assert a.bend_angle == pytest.approx(b.bend_angle, abs=1e-6)


@pytest.mark.slow
def test_the_finger_that_slides_bends_as_ngsolve_says():
    one = case("assembly", pressures="10,30", orientation="weightless")
    ours = solid.simulate(one)
    other = reference.simulate(replace(one, refine=-1), division=Division(32, 1, 1, 1, 5, 1))
    for a, b in zip(ours.states, other.states, strict=True):
        assert a.bend_angle == pytest.approx(b.bend_angle, rel=0.04)
        assert a.elongation == pytest.approx(b.elongation, rel=0.04)


def test_friction_is_refused_and_not_left_out():
    with pytest.raises(ValueError, match="friction"):
        reference.simulate(case("assembly", pressures="10", friction=0.3))
