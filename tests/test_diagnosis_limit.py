"""The judge that knows the worlds: its predictions against worlds that were drawn, its probabilities against
how often they come true."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tests.benchmarks import diagnosis_limit as limit
from tests.worlds.effects import EFFECTS
from tests.worlds.finger import calibrated
from tests.worlds.made import lab
from tests.worlds.noise import campaign
from tests.worlds.world import Test as Asked

TESTS = (Asked("weights", "exoskeleton", "tip_drop", (0.0, 0.16, 0.4)),
         Asked("pressure", "actuator", "elongation", (20.0, 40.0, 60.0)),
         Asked("bend", "assembly", "tip_drop", (0.0, 20.0, 40.0, 60.0)))
KNOWN = ("rest_curl", "pressure_offset", "print_porosity")


@pytest.fixture(scope="module")
def explained():
    return {name: limit.explanation((name,), TESTS) for name in KNOWN}


def read(name: str, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    world, _ = EFFECTS[name](lab(rng), rng)
    return np.concatenate([one.repeats.mean(axis=0) for one in campaign(world, TESTS, rng)])


def test_without_a_word_the_finger_is_as_drawn():
    assert lab(limit.Told()).finger == calibrated()


def test_numbers_that_are_told_scatter_as_those_that_are_drawn():
    rng = np.random.default_rng(0)
    for draw in (lambda g: g.uniform(2.0, 5.0), lambda g: g.triangular(-1.0, 0.0, 1.0),
                 lambda g: g.standard_normal()):
        drawn = np.array([draw(rng) for _ in range(20_000)])
        middle, above = draw(limit.Told()), draw(limit.Told({0: 1.0}))
        assert middle == pytest.approx(drawn.mean(), abs=0.03)
        assert above - middle == pytest.approx(drawn.std(), rel=0.02)
    shares = np.array([rng.dirichlet([6.0, 6.0, 6.0]) for _ in range(20_000)])
    moves = np.array([limit.Told({i: 1.0}).dirichlet([6.0, 6.0, 6.0]) - 1 / 3 for i in (0, 1)])
    assert moves.T @ moves == pytest.approx(np.cov(shares.T), abs=4e-4)


def test_only_effects_of_either_sign_have_two_branches(explained):
    assert {name: len(branches) for name, branches in explained.items()} == {
        "rest_curl": 1, "pressure_offset": 2, "print_porosity": 1}


def test_means_and_scatter_are_those_of_worlds_that_are_drawn(explained):
    """All sizes together: the law of total covariance."""
    (one,) = explained["rest_curl"]
    drawn = np.array([read("rest_curl", seed) for seed in range(600)])
    weight = np.bincount(one.nearest, minlength=len(one.opens)) / len(one.nearest)
    foreseen = np.tensordot(weight, one.opens, axes=1) + np.cov(one.predictions.T) + limit.reading(TESTS)
    assert np.abs(drawn.mean(axis=0) - one.predictions.mean(axis=0)).max() < 1.0
    assert np.sqrt(np.diag(foreseen)) == pytest.approx(drawn.std(axis=0), rel=0.15)


def test_its_probabilities_come_true(explained):
    data = np.array([read(name, seed) for name in KNOWN for seed in range(40)])
    truth = np.repeat(np.arange(3), 40)
    everything = np.arange(data.shape[1])
    logs = np.stack([limit.log_evidence(explained[name], data, limit.reading(TESTS), everything)
                     for name in KNOWN], axis=1)
    shares = np.exp(logs - np.logaddexp.reduce(logs, axis=1)[:, None])
    right = shares.argmax(axis=1) == truth
    assert right.mean() > 0.9
    assert right.mean() == pytest.approx(shares.max(axis=1).mean(), abs=0.06)


def test_two_effects_are_moved_together():
    """Not the sum of what each does alone."""
    two = limit.branch(("silicone_softening", "pressure_offset"), (1.0, 1.0), TESTS)
    assert two.predictions.shape == (limit.DENSE**2, 10) and len(two.opens) == limit.OPEN**2
    corners = two.predictions.reshape(limit.DENSE, limit.DENSE, -1)[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert np.abs(corners[3] - corners[1] - corners[2] + corners[0]).max() > 1.0


def test_an_evidence_is_the_mean_of_gaussians_each_with_what_is_open_at_its_size():
    rng = np.random.default_rng(0)
    predictions, opens = rng.normal(size=(4, 3)), np.array([np.eye(3), 5 * np.eye(3) + 1])
    one = limit.Branch(predictions, opens, np.array([0, 1, 1, 0]))
    data, errors, scored = rng.normal(size=(2, 2)), 0.1 * np.eye(3), np.array([0, 2])
    spreads = (opens + errors)[:, scored][:, :, scored]
    wanted = [np.log(np.mean([multivariate_normal(p[scored], spreads[k]).pdf(y)
                              for p, k in zip(predictions, one.nearest, strict=True)])) for y in data]
    found = limit.log_evidence([one, one], data, errors, scored)
    assert found - np.log(2 * np.pi) == pytest.approx(wanted)


def test_each_draw_is_judged_by_the_tests_that_were_done_in_it():
    rng = np.random.default_rng(1)
    pairs = {two: [limit.Branch(rng.normal(size=(3, 4)), np.eye(4)[None], np.zeros(3, int))]
             for two in (("a", "b"), ("a", "c"))}
    data, odds, owner = rng.normal(size=(3, 4)), np.ones(3), np.array(["one", "one", "two", "three"])
    known = [frozenset({"one"}), frozenset({"one", "three"}), frozenset({"one"})]
    found = limit.by_each(pairs, data, odds, np.eye(4), owner, known)
    for i, scored in enumerate(([0, 1], [0, 1, 3], [0, 1])):
        alone = limit.posterior(pairs, data[i:i + 1], odds[i:i + 1], np.eye(4), np.array(scored))
        assert found[i] == pytest.approx(alone[0])
