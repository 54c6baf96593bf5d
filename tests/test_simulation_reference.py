"""The solid model beside NGSolve at equal refinement; benchmarks/bend_reference.py has the whole table."""

from __future__ import annotations

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
