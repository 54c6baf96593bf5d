"""Minimal residuals against direct solution."""

from __future__ import annotations

import numpy as np
import pytest

from handgen.simulation.krylov import gmres


@pytest.fixture
def equations():
    rng = np.random.default_rng(5)
    return np.eye(60) + 0.08 * rng.normal(size=(60, 60)), rng.normal(size=60)


def counted(matrix: np.ndarray):
    def product(x):
        product.count += 1
        return matrix @ x

    product.count = 0
    return product


class TestMinimalResiduals:
    @pytest.mark.parametrize("tolerance", (1e-2, 1e-6, 1e-12))
    def test_leave_the_residual_asked_for_and_not_much_less(self, equations, tolerance):
        matrix, right = equations
        x = gmres(counted(matrix), right, tolerance, 60)
        left = np.linalg.norm(matrix @ x - right) / np.linalg.norm(right)
        assert 0.01 * tolerance < left <= 1.001 * tolerance

    def test_each_product_leaves_the_least_residual_that_its_space_allows(self, equations):
        matrix, right = equations
        powers = np.stack([np.linalg.matrix_power(matrix, k) @ right for k in range(6)], -1)
        for most in range(1, 6):
            product = counted(matrix)
            x = gmres(product, right, 0.0, most)
            best = matrix @ powers[:, :most]
            least = np.linalg.norm(best @ np.linalg.lstsq(best, right)[0] - right)
            assert np.linalg.norm(matrix @ x - right) == pytest.approx(least, rel=1e-8)
            assert product.count == most

    def test_end_where_the_space_holds_the_solution(self):
        """I + a b': two products at most."""
        rng = np.random.default_rng(1)
        a, b, right = rng.normal(size=(3, 40))
        product = counted(np.eye(40) + np.outer(a, b) / 40)
        x = gmres(product, right, 1e-12, 30)
        assert product.count == 2
        assert product(x) == pytest.approx(right, abs=1e-10)

    def test_nothing_is_solved_by_nothing(self):
        assert not gmres(counted(np.eye(3)), np.zeros(3), 1e-3, 5).any()
