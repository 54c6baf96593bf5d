"""What acts in a finger beside its elements, and the whole of it: tangents, resultants, closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from handgen.simulation import cavity, contact, fibre, friction
from handgen.simulation.system import Load, System
from tests.fingers import assembler, case, only_pairs, shaken
from tests.small_solids import slope_error

STEP = 2e-6
"""mm and rad, of differences."""


def swollen(system: System) -> np.ndarray:
    """Unknowns of a general state in which the actuator presses on its bore nearly everywhere."""
    q, nodes = shaken(system), np.unique(system.actuator.outside)
    out = system.actuator.grid.nodes[nodes] * [0, 1, 1]
    push = 0.15 * out / np.linalg.norm(out, axis=1)[:, None]
    dofs = system.node_dofs[nodes]
    q[dofs[dofs >= 0]] += push[dofs >= 0]
    return q


def rubbed(system: System, q: np.ndarray) -> None:
    """Give every pair that touches an anchor, near and far, as after some sliding."""
    rng = np.random.default_rng(6)
    system.assemble(q, Load(), exact=True)
    system.accept(q)
    system.anchors += rng.uniform(-3, 3, len(system.anchors)) * friction.STICK


class TestTangents:
    """Force against differences of energy, stiffness against differences of force; every part on its own."""

    @pytest.fixture(params=[
        "actuator", "strips and bones", "weights", "contact", "friction", "bonds", "plane", "whole",
        "bonded", "soft base", "turned plane", "closing slots", "lost stiffness", "strained by a curl"])
    def system_at(self, request):
        """(system, unknowns, load) with one part only, or with all."""
        what, load = request.param, Load()
        if what == "actuator":
            system, load = System(case("actuator")), Load(0.7, 0.02, 0.0)
        elif what == "strips and bones":
            system = System(case("exoskeleton"))
        elif what == "weights":
            system, load = System(case("exoskeleton", tip_loads=[0.3])), Load(0.7, 0.0, 0.3)
            system.blocks = []
        elif what == "lost stiffness":
            system, load = System(replace(case("actuator"), offset=0.4)), Load(0.0, 0.02, 0.0, 0.3)
        elif what == "strained by a curl":
            curled = case("assembly", params="thesis_hand.yaml")
            system = System(replace(curled, root_angle=0.3, curl_taken=0.2))
            load = Load(0.7, 0.02, 0.0, 0.2, 0.6)
        elif what == "soft base":
            system = System(replace(case("exoskeleton", tip_loads=[0.3]), base_compliance=0.01))
            system.blocks, load = [], Load(0.7, 0.0, 0.3)
        elif what == "closing slots":
            system = System(replace(case("exoskeleton"), edges_left=1.02))
            system.blocks = []
        elif what in ("plane", "turned plane"):
            system = System(replace(case("exoskeleton"), obstacle=0.3,
                                    base_compliance=0.01 if what == "turned plane" else 0.0))
            system.blocks = []
        else:
            mu = 0.4 if what in ("friction", "whole") else 0.0
            system = System(case("assembly", friction=mu, bonded=what in ("bonds", "bonded")))
            load = Load(1.0, 0.03, 0.2) if what in ("whole", "bonded") else Load()
        q = swollen(system) if what in ("contact", "friction", "whole") else shaken(system)
        if what in ("plane", "turned plane"):
            q[system.body_dofs[1:, 1]] = -0.6
        if what in ("contact", "friction", "bonds"):
            only_pairs(system, np.full(len(system.pair_bodies), True))
        if what in ("friction", "whole"):
            rubbed(system, q)
        return system, q, load

    def test_agree_with_differences(self, system_at):
        system, q, load = system_at
        force, tangent = slope_error(assembler(system, load), q, STEP)
        assert force < 1e-8 or system.coupling(), "but for friction, which has no energy"
        assert tangent < 1e-6

    def test_of_extrapolated_stresses_without_a_step_is_the_same(self, system_at):
        system, q, load = system_at
        _, force, exact, _ = system.assemble(q, load, exact=True)
        system.extrapolate(q, np.zeros_like(q))
        _, other, values, _ = system.assemble(q, load, exact=False)
        assert other == pytest.approx(force, abs=0)
        assert values == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())


class TestContact:
    @pytest.mark.parametrize("kind", ["sliding", "rubbing", "bonded"])
    @pytest.mark.parametrize("bone", [1, 3])
    def test_moves_rigidly_with_a_bone_at_no_cost(self, kind, bone):
        """A bone and the points it meets, turned and shifted together: the same energy, forces turned along;
        forces and moments on points and bone cancel."""
        system = System(case("assembly", friction=0.4 * (kind == "rubbing"), bonded=kind == "bonded"))
        free = (system.node_dofs[system.pair_nodes, 0] >= 0).all(axis=1)
        only_pairs(system, free & (system.pair_bodies == bone))
        q = shaken(system) if kind == "bonded" else swollen(system)
        if kind == "rubbing":
            rubbed(system, q)
        energy, force, _, _ = system.assemble(q, Load(), exact=True)
        assert energy > 0

        x, (dx, dz, turn) = system.positions(q), system.bone_states(q)[bone]
        nodes, dofs = np.unique(system.pair_nodes), system.body_dofs[bone]
        at = system.node_dofs[nodes][:, [0, 2]]
        pivot = np.array([system.bones.origin[bone, 0] + dx, system.bones.origin[bone, 1] + dz])
        arm, pulled = x[nodes][:, [0, 2]] - pivot, force[at]
        assert pulled.sum(axis=0) == pytest.approx(-force[dofs[:2]], abs=1e-10 * np.abs(force).sum())
        # A flexion of a moves x by z a and z by -x a.
        moment = (arm[:, 1] * pulled[:, 0] - arm[:, 0] * pulled[:, 1]).sum()
        assert moment == pytest.approx(-force[dofs[2]], abs=1e-8 * np.abs(force).sum())

        by, shift = 0.8, np.array([7.0, -31.0])
        flexed = np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])
        moved = q.copy()
        moved[at] += arm @ flexed - arm + shift
        moved[dofs] = dx + shift[0], dz + shift[1], turn + by
        there, turned, _, _ = system.assemble(moved, Load(), exact=True)
        assert there == pytest.approx(energy, rel=1e-9)
        assert turned[at] == pytest.approx(pulled @ flexed, abs=1e-9 * np.abs(force).max())

    @pytest.mark.parametrize("gap", [0.15, 0.05, -0.05, -0.3])
    def test_onset_is_a_spring_that_begins_smoothly(self, gap):
        stiff, soft, h = 3.0, 0.1, 1e-6
        w, w1, w2 = contact.onset(gap, stiff, soft)
        ahead, behind = contact.onset(gap + h, stiff, soft), contact.onset(gap - h, stiff, soft)
        assert w1 == pytest.approx((ahead[0] - behind[0]) / (2 * h), abs=1e-8)
        assert w2 == pytest.approx((ahead[1] - behind[1]) / (2 * h), abs=1e-6)
        assert (w > 0) == (gap < 0)
        if gap < -2 * soft:
            assert w1 == pytest.approx(stiff * (gap + soft))

    def test_bore_is_the_profiles_with_rounded_rims(self):
        finger = case("assembly").finger
        pieces = np.array([(p.x0, p.x1, p.y0, p.y1, p.m0, p.m1) for p in finger.bore.pieces])
        low, high, rim = 30.0, 50.0, contact.RIM
        for x in np.linspace(low - 2, high + 2, 41):
            r, d, c = contact.bore_at(pieces, x, low, high, rim)
            beyond = max(low + rim - x, x - (high - rim), 0.0)
            assert r == pytest.approx(finger.bore(x) + beyond**2 / (2 * rim))
            ahead, behind = (contact.bore_at(pieces, x + h, low, high, rim) for h in (1e-6, -1e-6))
            assert d == pytest.approx((ahead[0] - behind[0]) / 2e-6, abs=1e-8)
            assert c == pytest.approx((ahead[1] - behind[1]) / 2e-6, abs=1e-6)

    def test_plane_takes_what_the_bones_give(self):
        system = System(replace(case("exoskeleton"), obstacle=0.3))
        system.blocks = []
        q = shaken(system)
        q[system.body_dofs[1:, 1]] = -0.6
        _, force, _, _ = system.assemble(q, Load(), exact=True)
        assert system.pushed > 0
        assert force[system.body_dofs[1:, 1]].sum() == pytest.approx(-system.pushed)


class TestChamber:
    def test_volume_and_thrust_are_those_of_the_profile(self):
        """Polygons as large as their circles: half the volume of the small core, half its opening's area."""
        one = case("actuator")
        system = System(one)
        a, core = system.actuator, one.actuator.small_core
        whole = quad(lambda x: np.pi / 2 * core(x) ** 2, 0, one.actuator.small_core_end, limit=200)[0]
        x = np.ascontiguousarray(a.grid.nodes)
        assert cavity.volume(x, np.ascontiguousarray(a.chamber)) == pytest.approx(whole, rel=2e-3)
        dofs = np.arange(x.size).reshape(-1, 3)[a.chamber].reshape(-1, 12)
        force, none = np.zeros(x.size), np.full((len(a.chamber), 12, 12), -1, np.int32)
        energy = cavity.add_pressure(x, a.chamber, 0.05, dofs, none, force, np.zeros(0))
        assert energy == pytest.approx(-0.05 * whole, rel=2e-3)
        # Its opening is held: where all the rest moves on, the first ring of faces grows as a frustum does.
        stations = np.unique(x[:, 0])
        first, second = (np.pi / 2 * core(s) ** 2 for s in stations[:2])
        thrust = force.reshape(-1, 3)[x[:, 0] > stations[0], 0].sum()
        assert thrust == pytest.approx(-0.05 / 3 * (first + np.sqrt(first * second) + second), rel=1e-6)


class TestThread:
    def test_all_rings_together_are_as_long_as_the_thread(self):
        one = case("actuator")
        system, w = System(one), one.winding
        turns = system.actuator.thread_span / w.pitch
        ends = system.actuator.grid.nodes[system.actuator.threads]
        drawn = (np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) * turns).sum()
        wound = quad(lambda x: np.pi * (one.actuator.large_core(x) + w.depth) / w.pitch, w.start, w.end,
                     limit=200)[0]
        assert drawn == pytest.approx(wound, rel=1e-2)

    def test_a_widened_ring_stores_half_e_a_strain_squared_of_its_length(self):
        system = System(case("actuator"))
        w, strain = system.case.winding, 0.01
        x = system.drawn * [1.0, 1 + strain, 1 + strain]
        dofs, none = np.full((len(system.threads), 6), -1), np.full((len(system.threads), 6, 6), -1, np.int32)
        energy = fibre.add_threads(
            x, system.threads, system.thread_length, system.thread_stiffness, system.compressive,
            system.tension, True, dofs, none, np.zeros(0), np.zeros(0))
        turns = system.thread_stiffness / (w.young * np.pi / 4 * w.diameter**2)
        length = (system.thread_length * turns).sum()
        assert energy == pytest.approx(w.young * np.pi / 8 * w.diameter**2 * strain**2 * length, rel=1e-9)

    @pytest.mark.parametrize("strain", [0.02, 1e-4, -1e-4, -3.9e-4, -4.1e-4, -0.02])
    def test_pulls_and_hardly_pushes(self, strain):
        h, share = 1e-7, 0.02
        value, force, stiff = fibre.pull(strain, share)
        (above, up, _), (below, down, _) = fibre.pull(strain + h, share), fibre.pull(strain - h, share)
        assert force == pytest.approx((above - below) / (2 * h), abs=1e-9)
        assert stiff == pytest.approx((up - down) / (2 * h), abs=3e-4)
        assert value > 0
        if strain == -0.02:
            assert stiff == share
            assert 0 < -force < 0.04 * 0.02
