"""Factorisers of the tangent against dense algebra, and the crew that shares their work."""

from __future__ import annotations

import sys
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handgen.simulation.block import Crew
from handgen.simulation.sparse import Pattern, factoriser
from handgen.simulation.system import Load, System
from tests.fingers import case, stiffness

NAMES = "envelope", "CHOLMOD", "SuperLU"


def dense(pattern: Pattern, values: np.ndarray) -> np.ndarray:
    """The symmetric matrix whose lower triangle has `values`."""
    whole = np.zeros((pattern.size, pattern.size))
    whole[pattern.rows, pattern.columns] = values
    return whole + np.tril(whole, -1).T


def slender(size: int, across: int, wide: int, seed: int) -> Pattern:
    """Elements of up to `across` unknowns that follow one another, and `wide` unknowns that all may meet."""
    rng = np.random.default_rng(seed)
    along = np.arange(size)[:, None] + rng.integers(0, across, (size, 4))
    groups = np.where(along < size, along, -1)
    touched = rng.integers(0, size, (3, wide))
    pairs = np.stack(np.broadcast_arrays(touched, size + np.arange(wide)), -1).reshape(-1, 2)
    return Pattern([groups, pairs], size + wide)


class TestFactorisers:
    @pytest.mark.parametrize("name", NAMES)
    def test_factorise_solve_and_count_negative_pivots(self, name):
        rng = np.random.default_rng(0)
        pattern = Pattern([rng.integers(-1, 30, (40, 6))], 30)
        values = rng.normal(size=pattern.entries)
        whole = dense(pattern, values)
        lift = 1.0 - np.linalg.eigvalsh(whole)[0]
        for more, positive in ((lift, True), (0.2 * lift, False)):
            now = values.copy()
            now[pattern.diagonal] += more
            factor = factoriser(pattern, Crew(1), name)
            assert factor.factorise(now) is positive
            assert factor.indefinite(now) == (np.linalg.eigvalsh(dense(pattern, now)) < 0).sum()
            right = rng.normal(size=30)
            assert dense(pattern, now) @ factor.solve(right) == pytest.approx(right, abs=1e-9)

    @given(size=st.integers(1, 200), across=st.integers(1, 40), wide=st.integers(0, 5),
           seed=st.integers(0, 99), threads=st.integers(1, 3), unstable=st.booleans())
    def test_the_envelope_holds_any_slender_matrix(self, size, across, wide, seed, threads, unstable):
        """Whatever its length, more than once by one pattern. A dominant diagonal allows every order of
        elimination, and its signs are the eigenvalues'."""
        pattern, rng = slender(size, across, wide, seed), np.random.default_rng(seed)
        factor = factoriser(pattern, Crew(threads))
        for _ in range(2):
            values = rng.normal(size=pattern.entries)
            values[pattern.diagonal] = 0.0
            signs = rng.choice([-1, 1], pattern.size) if unstable else np.ones(pattern.size)
            values[pattern.diagonal] = signs * (1.0 + np.abs(dense(pattern, values)).sum(axis=1))
            negative = int((signs < 0).sum())
            assert factor.factorise(values) is (negative == 0)
            assert factor.indefinite(values) == negative
            right = rng.normal(size=pattern.size)
            assert dense(pattern, values) @ factor.solve(right) == pytest.approx(right, abs=1e-9)

    @pytest.mark.parametrize("threads", [1, 2])
    def test_the_envelope_solves_a_fingers_tangent_as_cholmod_does(self, threads):
        system = System(case("assembly"))
        _, _, values, _ = system.assemble(np.zeros(system.size), Load(0.0, 0.02, 0.0), exact=True)
        values[system.pattern.diagonal] += 1.0  # what nothing touches yet is held
        ours, other = (factoriser(system.pattern, Crew(threads), name) for name in ("envelope", "CHOLMOD"))
        assert ours.factorise(values)
        assert other.factorise(values)
        right = np.random.default_rng(1).normal(size=system.size)
        assert ours.solve(right) == pytest.approx(other.solve(right), rel=1e-9, abs=1e-12)
        values[system.pattern.diagonal[::100]] -= 1e4
        assert ours.factorise(values) is False
        assert ours.indefinite(values) == other.indefinite(values) > 10

    def test_a_name_that_is_none_and_a_package_that_is_missing_are_told(self, monkeypatch):
        pattern = slender(5, 2, 0, 0)
        with pytest.raises(ValueError, match="no factoriser 'cholmod'; there are envelope, CHOLMOD"):
            factoriser(pattern, Crew(1), "cholmod")
        monkeypatch.setitem(sys.modules, "cvxopt", None)
        with pytest.raises(ImportError, match=r"CHOLMOD is missing: pip install 'handgen\[cholmod\]'"):
            factoriser(pattern, Crew(1), "CHOLMOD")

    def test_the_envelope_says_that_what_is_not_finite_is_not_positive_definite(self):
        pattern = slender(50, 5, 1, 0)
        factor = factoriser(pattern, Crew(1))
        assert factor.factorise(np.full(pattern.entries, np.nan)) is False
        assert factor.factorise(np.zeros(pattern.entries)) is False

    def test_the_systems_pattern_is_that_of_its_tangent(self):
        system = System(case("actuator"))
        _, _, values, _ = system.assemble(np.zeros(system.size), Load(0.0, 0.02, 0.0), exact=True)
        matrix = stiffness(system, values)
        assert abs(matrix - matrix.T).max() == 0
        assert len(values) == system.pattern.entries


class TestCrew:
    @pytest.mark.parametrize("count", [1, 2, 3])
    def test_everyone_works_and_answers_in_order(self, count):
        crew = Crew(count)
        for _ in range(50):
            assert crew.shared(lambda number: number**2) == [n**2 for n in range(count)]

    @pytest.mark.parametrize("who", [0, 1])
    def test_raises_what_a_thread_raised_and_works_on(self, who):
        crew = Crew(2)

        def work(number):
            if number == who:
                raise KeyError(who)
            return number

        with pytest.raises(KeyError):
            crew.shared(work)
        assert crew.shared(lambda number: number) == [0, 1]

    def test_its_threads_end_with_it(self):
        before = threading.active_count()
        crew = Crew(3)
        assert threading.active_count() == before + 2
        del crew
        end = time.monotonic() + 5
        while threading.active_count() > before and time.monotonic() < end:
            time.sleep(0.01)
        assert threading.active_count() == before
