"""The two solid elements against the laws they integrate, their own differences, rotations and patches."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handgen.materials import tensors
from handgen.simulation import lanes, principal, shapes
from handgen.simulation.block import kernel_law
from tests.small_solids import LAWS, Body, crooked, slope_error

BULK = 1e4
"""MPa."""


@pytest.fixture(params=LAWS)
def some_law(request):
    return LAWS[request.param]


@pytest.fixture(params=(8, 20), ids=["Q1P0", "quadratic"])
def nodes(request):
    return request.param


def gradients() -> np.ndarray:
    """Deformation gradients: general ones, two and three equal stretches, nearly equal ones."""
    rng = np.random.default_rng(3)
    general = np.eye(3) + 0.35 * rng.normal(size=(40, 3, 3))
    general = general[np.linalg.det(general) > 0.2]
    turn = Rotation.random(random_state=4).as_matrix()
    special = [np.eye(3), np.diag([1.3, 1.3, 0.7]), np.diag([1.3, 1.3 * (1 + 1e-8), 0.7])]
    return np.concatenate([general, special, [turn @ s for s in special]])


def outside(unit: np.ndarray) -> np.ndarray:
    return ((unit < 1e-9) | (unit > 1 - 1e-9)).any(axis=1)


def strained(body: Body, by: float = 0.1, seed: int = 1) -> np.ndarray:
    """A general state of finite strain."""
    rng = np.random.default_rng(seed)
    affine = np.eye(3) + by * rng.normal(size=(3, 3))
    return body.nodes @ affine.T + 0.1 * by * rng.normal(size=body.nodes.shape)


class TestLawsInTheKernel:
    def test_energy_stress_and_moduli_are_those_of_the_library(self, some_law):
        """W, S and 2 dS/dC of W(J^-2/3 C), put together from principal axes; random and degenerate F."""
        form, constants = kernel_law(some_law)
        for f in gradients():
            metric, w = f.T @ f, lanes.room()

            def rows(first, count, w=w):
                return w[first:first + count * lanes.LANES].reshape(count, lanes.LANES)[:, 3]

            rows(lanes.METRIC, 6)[:] = metric[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            rows(lanes.VOLUME, 1)[:] = np.linalg.det(f)
            principal.principal(w)
            x, axes = rows(lanes.SQUARED, 3), rows(lanes.AXES, 9).reshape(3, 3)
            assert axes @ np.diag(x) @ axes.T == pytest.approx(metric, abs=1e-14 * x.max())
            assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-14)
            principal.respond(form, constants, w)
            energy, s, q = rows(lanes.ENERGY, 1)[0], rows(lanes.STRESS, 3), rows(lanes.SHEAR, 3)
            d = rows(lanes.MODULI, 6)[[[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
            moduli = np.einsum("ab,ia,ja,kb,lb->ijkl", d, axes, axes, axes, axes)
            for a, b in ((0, 1), (1, 2), (2, 0)):
                shear = np.outer(axes[:, a], axes[:, b]) + np.outer(axes[:, b], axes[:, a])
                moduli += q[a] * np.einsum("ij,kl->ijkl", shear, shear)
            w, stress, c = tensors.isochoric(some_law, metric)
            assert energy == pytest.approx(w, rel=1e-10, abs=1e-13)
            assert (axes * s) @ axes.T == pytest.approx(stress, rel=1e-9, abs=1e-11)
            assert moduli == pytest.approx(c, rel=1e-8, abs=2e-8 * np.abs(c).max())

    def test_an_unknown_law_is_refused(self):
        class Strange:
            name, constants = "gent", (1.0, 2.0)

        with pytest.raises(ValueError, match="neo_hookean, mooney_rivlin, yeoh, ogden, not gent"):
            kernel_law(Strange())


class TestShapes:
    def test_are_one_at_their_node_and_sum_to_one(self, nodes):
        at = shapes.nodes_of(nodes)
        assert shapes.values(nodes, at) == pytest.approx(np.eye(nodes), abs=1e-15)
        points = np.random.default_rng(0).uniform(-1, 1, (9, 3))
        assert shapes.values(nodes, points).sum(axis=1) == pytest.approx(1)
        for i, step in enumerate(1e-6 * np.eye(3)):
            rate = (shapes.values(nodes, points + step) - shapes.values(nodes, points - step)) / 2e-6
            assert shapes.slopes(nodes, points)[:, :, i] == pytest.approx(rate, abs=1e-8)

    def test_volume_is_the_bodys(self, nodes):
        x, cells, _ = crooked((3, 2, 2), nodes)
        assert shapes.gradients(x, cells)[1].sum() == pytest.approx(3.0, rel=2e-3)


class TestTangent:
    def test_is_the_derivative_of_force_and_force_of_energy(self, nodes, some_law):
        x, cells, _ = crooked((2, 1, 1), nodes)
        body = Body(x, cells, some_law, 30.0)

        def assemble(q):
            energy, force, stiff = body.assemble(q.reshape(-1, 3))
            return energy, force.ravel(), stiff

        force, stiffness = slope_error(assemble, strained(body).ravel(), 1e-4)
        assert force < 1e-9
        assert stiffness < 1e-8

    def test_extrapolated_stress_of_no_step_is_the_states_own(self, nodes, some_law):
        x, cells, _ = crooked((2, 1, 1), nodes)
        body = Body(x, cells, some_law, 30.0)
        q = strained(body)
        body.extrapolate(q, np.zeros_like(q))
        energy, force, stiff = body.assemble(q, exact=False)
        own = body.assemble(q)
        assert energy == own[0]
        assert force == pytest.approx(own[1], abs=0)
        assert stiff.toarray() == pytest.approx(own[2].toarray(), abs=1e-11)

    def test_extrapolated_stress_is_right_to_first_order(self, nodes, some_law):
        """Half the step, a quarter of the error; and the residual never depends on it."""
        x, cells, _ = crooked((2, 1, 1), nodes)
        body = Body(x, cells, some_law, 30.0)
        q = strained(body)
        way = np.random.default_rng(8).normal(size=q.shape)
        errors = []
        for size in (2e-3, 1e-3):
            body.extrapolate(q + size * way, np.zeros_like(q))
            there = body.stress.copy(), body.pressure.copy()
            body.extrapolate(q, size * way)
            errors.append([np.abs(body.stress - there[0]).max(), np.abs(body.pressure - there[1]).max()])
            force = body.assemble(q, exact=False)[1]
        assert np.log2(errors[0]) - np.log2(errors[1]) == pytest.approx([2, 2], abs=0.1)
        assert force == pytest.approx(body.assemble(q)[1], abs=0)


class TestRotation:
    def test_energy_stays_and_forces_turn(self, nodes, some_law):
        x, cells, _ = crooked((2, 2, 1), nodes)
        body = Body(x, cells, some_law, 30.0)
        q = strained(body)
        turn = Rotation.from_rotvec([1.0, -2.0, 0.7]).as_matrix()
        energy, force, _ = body.assemble(q)
        turned_energy, turned_force, _ = body.assemble(q @ turn.T + [3.0, -50.0, 9.0])
        assert turned_energy == pytest.approx(energy, rel=1e-10)
        assert turned_force == pytest.approx(force @ turn.T, abs=1e-9 * np.abs(force).max())
        assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).sum()
        assert np.abs(np.cross(q, force).sum(axis=0)).max() < 1e-12 * np.abs(force).sum()

    def test_a_rigid_motion_costs_nothing_and_has_no_stiffness(self, nodes, some_law):
        x, cells, _ = crooked((2, 1, 1), nodes)
        body = Body(x, cells, some_law, 30.0)
        turn = Rotation.from_rotvec([0.4, 2.0, -0.7]).as_matrix()
        moved = x @ turn.T + [1.0, 2.0, 3.0]
        energy, force, stiff = body.assemble(moved)
        assert abs(energy) < 1e-12
        assert np.abs(force).max() < 1e-11
        rigid = [np.tile(e, (len(x), 1)) for e in np.eye(3)] + [np.cross(e, moved) for e in np.eye(3)]
        largest = np.abs(stiff.toarray()).max()
        for way in rigid:
            assert np.abs(stiff @ way.ravel()).max() < 1e-9 * largest

    def test_nothing_but_a_rigid_motion_is_free_in_a_strip_of_two(self, nodes):
        """Elements of 20 nodes and 2 x 2 x 2 points have six mechanisms each; two abreast, as in a finger's
        strip, have none in common (a single row would)."""
        x, cells, _ = crooked((2, 2, 1), nodes)
        eigen = np.linalg.eigvalsh(Body(x, cells, LAWS["mooney_rivlin"], 30.0).assemble(x)[2].toarray())
        assert (eigen < 1e-9 * eigen[-1]).sum() == 6


class TestPatch:
    @pytest.mark.parametrize("bulk", [5.0, BULK])
    def test_an_affine_boundary_makes_an_affine_body(self, nodes, some_law, bulk):
        """Irons' patch test at finite strain, on distorted elements: one stress in all of them."""
        x, cells, unit = crooked((3, 3, 2), nodes)
        body = Body(x, cells, some_law, bulk)
        f = np.array([[1.25, 0.2, 0.0], [0.1, 0.9, -0.1], [0.0, 0.15, 1.05]])
        f /= np.linalg.det(f) ** (1 / 3) / 1.002
        fixed = np.repeat(outside(unit)[:, None], 3, axis=1)
        found, held = body.solve(fixed, lambda s: x @ (np.eye(3) + s * (f - np.eye(3))).T)
        assert np.abs(found - x @ f.T).max() < 1e-9
        _, stress, _ = tensors.isochoric(some_law, f.T @ f)
        j = np.linalg.det(f)
        pulled = f @ stress + bulk * (j - 1) * j * np.linalg.inv(f).T
        # What holds the boundary makes the mean stress: sum f X = integral of P.
        total = np.einsum("ni,nj->ij", held, x)
        assert total == pytest.approx(body.weight.sum() * pulled, rel=1e-8, abs=1e-8 * np.abs(pulled).max())
