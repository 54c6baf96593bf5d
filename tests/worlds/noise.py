"""Readings as a lab writes them down: repeats that scatter as the source's, to half a millimetre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.worlds.world import Test, World, run

SCATTER = {
    ("exoskeleton", "tip_drop"): 1.42, ("actuator", "elongation"): 0.41, ("assembly", "tip_drop"): 0.54,
    ("assembly", "elongation"): 0.5, ("assembly", "bend_angle"): 1.5, ("exoskeleton", "bend_angle"): 1.5,
    ("actuator", "bend_angle"): 1.5, ("assembly", "tip_force"): 0.02,
    ("actuator", "chamber_pressure"): 0.5, ("assembly", "force_angle"): 3.0}
"""Standard deviation of one reading; of the first three the source's, pooled over its repeats (Tables 5.4,
5.6, 5.8). mm, deg, N, kPa."""
RESOLUTION = {"tip_drop": 0.5, "elongation": 0.5, "bend_angle": 1.0, "tip_force": 0.01,
              "chamber_pressure": 0.1, "force_angle": 1.0}
TOGETHER = 0.4
"""Of the variance, what a whole repeat has in common: the hand was laid down anew."""
REPEATS = 3


@dataclass(frozen=True)
class Record:
    """One test as written down."""

    test: Test
    repeats: np.ndarray
    """(repeats, loads)."""
    truth: np.ndarray
    """(repeats, loads) before the noise."""


def campaign(world: World, tests: tuple[Test, ...], rng: np.random.Generator, *, repeats: int = REPEATS,
             noise: float = 1.0, first: int = 0) -> list[Record]:
    """All `tests` one after the other; `first`: tests that were made before."""
    found = []
    for order, test in enumerate(tests):
        truth = np.array([run(world, test, k, first + order) for k in range(repeats)])
        sigma = noise * SCATTER[test.part, test.quantity]
        shift = np.sqrt(TOGETHER) * sigma * rng.standard_normal((repeats, 1))
        own = np.sqrt(1 - TOGETHER) * sigma * rng.standard_normal(truth.shape)
        step = RESOLUTION[test.quantity]
        found.append(Record(test, np.round((truth + shift + own) / step) * step, truth))
    return found
