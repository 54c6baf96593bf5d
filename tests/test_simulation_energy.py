"""Energy over a whole cycle of loads: what own weight and air do is stored, and comes back."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import simpson

from handgen.simulation import cavity
from handgen.simulation.solve import Solver
from handgen.simulation.system import Load, System
from tests.fingers import case

STEPS = 12
"""Of own weight, and of pressure; even, for Simpson's rule."""


class Cycle:
    """`system` led through own weight, pressure, and back, both by equal steps."""

    def __init__(self, system: System, pressure: float):
        self.system, solver = system, Solver(system)
        weight = [Load(w, 0.0, 0.0) for w in np.linspace(0, 1, STEPS + 1)]
        air = [Load(1.0, p, 0.0) for p in np.linspace(0, pressure, STEPS + 1)]
        self.ways = {"weight": weight, "air": air, "air off": air[::-1], "weight off": weight[::-1]}
        self.stored, self.worked, self.states = {}, {}, {}
        point = solver.begin()
        for name, loads in self.ways.items():
            states = [point]
            for target in loads[1:]:
                point, there = solver.advance(point, target)
                assert there, f"no balance at {target}"
                states.append(point)
            self.states[name] = [s.q for s in states]
            self.worked[name] = self._work(name, loads)
            self.stored[name] = self.energy(point.q)

    def energy(self, q: np.ndarray) -> float:
        """Stored at `q`, mJ."""
        return self.system.assemble(q, Load(), exact=True)[0]

    def given(self, q: np.ndarray) -> np.ndarray:
        """What all own weight and 1 MPa of air would have given up to `q`, mJ."""
        s, x = self.system, self.system.positions(q)
        fallen = (s.loads.masses[:, None] * s.loads.gravity * x).sum()
        if s.exoskeleton:
            states = s.bone_states(q)
            for b, volume in enumerate(s.exoskeleton.volumes):
                at = s.bones.carried(b, s.exoskeleton.mass_points[b:b + 1], states)[0]
                fallen += volume * s.case.tpu.density * (s.loads.gravity @ at)
        return np.array([fallen, cavity.volume(x, s.faces)])

    def _work(self, name: str, loads: list[Load]) -> float:
        """Integral of (share of weight) dG + p dV, by parts: the loads are spaced evenly, G and V are not."""
        acting = np.array([load.parts[:2] for load in loads])
        given = np.array([self.given(q) for q in self.states[name]])
        changing = acting[0] != acting[-1]
        parts = acting[-1] * given[-1] - acting[0] * given[0]
        for k in np.flatnonzero(changing):
            parts[k] -= simpson(given[:, k], x=acting[:, k])
        return float(parts.sum())


@pytest.mark.parametrize(("part", "pressure"), [
    ("actuator", 0.03),
    ("assembly", 0.03)])
def test_without_friction_all_work_is_stored_and_comes_back(part, pressure):
    system = System(case(part))
    cycle = Cycle(system, pressure)
    stored, total, most = 0.0, 0.0, max(cycle.stored.values())
    for name in cycle.ways:
        total += abs(cycle.worked[name])
        assert cycle.stored[name] - stored == pytest.approx(cycle.worked[name], abs=2e-4 * most), name
        stored = cycle.stored[name]
    assert most > 1.0
    assert stored == pytest.approx(0.0, abs=1e-8 * most)
    assert np.abs(cycle.states["weight off"][-1]).max() < 1e-4
    back = cycle.states["air off"][::-1]
    for there, again in zip(cycle.states["air"], back, strict=True):
        moved = np.abs(system.positions(there) - system.positions(again)).max()
        assert moved < 1e-3, "one curve up and down"


def test_friction_takes_work_and_gives_none_back():
    system = System(case("assembly", friction=0.3, orientation="weightless"))
    solver = Solver(system)
    point, volumes, loads = solver.begin(), [], [*np.linspace(0, 0.03, 16), *np.linspace(0.03, 0, 16)[1:]]
    for pressure in loads:
        point, there = solver.advance(point, Load(0.0, float(pressure), 0.0))
        assert there
        volumes.append(cavity.volume(system.positions(point.q), system.faces))
    lost = sum((p + q) / 2 * (v - u) for (p, q), (u, v) in
               zip(pairwise(loads), pairwise(volumes), strict=True))
    assert lost > 0
