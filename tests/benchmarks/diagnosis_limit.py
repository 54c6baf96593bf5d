"""How many pairs any diagnosis could name: `python -m tests.benchmarks.diagnosis_limit FOLDER [--seed N]`.

Judges the study's pairs by the very worlds that made them. This judge knows their laws, how their fingers
and gauges scatter and from which ranges their effects are drawn; it has no model error, and it is told that
two effects are hidden. What it cannot name is not in the readings, for any diagnosis. An explanation is a
Gaussian about the world's own predictions at every two sizes; what else is drawn (fingers, gauges, powers of
laws) goes in to first order. It reads the three tests, these and what the study in FOLDER asked for, and all.
Twenty minutes on two cores.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from itertools import combinations, product
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from handgen.discrepancy.library import Library, Series
from handgen.discrepancy.verdict import SURE
from tests.benchmarks.diagnosis import FRESH, GIVEN, askable, judgeable, plan, rows_file, rows_of
from tests.benchmarks.diagnosis_draws import Draw, asked, checked, hidden
from tests.benchmarks.diagnosis_table import FORCED, share
from tests.worlds.effects import EFFECTS
from tests.worlds.made import lab
from tests.worlds.noise import REPEATS, RESOLUTION, SCATTER, TOGETHER
from tests.worlds.world import Test, World, run

NODES, DENSE, OPEN = 7, 31, 3
"""Sizes of each effect that are run, that are summed over, and at which it is found what else moves."""
STEP = 1.0
"""Standard deviations by which what else is drawn is moved."""


@dataclass
class Told:
    """Stands in for a random generator: every number is at its mean but for those that are told.

    A number is told by its place among all that are asked for, in its own standard deviations.
    """

    told: dict[int, float] = field(default_factory=dict)
    sign: float = 1.0
    asked: int = 0

    def _next(self) -> float:
        self.asked += 1
        return self.told.get(self.asked - 1, 0.0)

    def standard_normal(self) -> float:
        return self._next()

    def uniform(self, low: float, high: float) -> float:
        return (low + high) / 2 + self._next() * (high - low) / np.sqrt(12)

    def triangular(self, low: float, mode: float, high: float) -> float:
        return mode + self._next() * (high - low) / np.sqrt(24)

    def choice(self, signs: Sequence[float]) -> float:
        return self.sign

    def dirichlet(self, weights: Sequence[float]) -> np.ndarray:
        """Of three equal weights."""
        total = sum(weights)
        wide = np.sqrt(1 / (3 * (total + 1)))
        across = np.array([[1.0, -1.0, 0.0], [1.0, 1.0, -2.0]]) / np.sqrt([[2.0], [6.0]])
        return 1 / 3 + wide * (self._next() * across[0] + self._next() * across[1])


def signed(effect: str) -> bool:
    """Whether its size has either sign."""
    def size(sign: float) -> float:
        return EFFECTS[effect](lab(Told()), Told(sign=sign))[1]

    return size(1.0) != size(-1.0)


def world(effects: Sequence[str], made: Told, drawn: Sequence[Told]) -> World:
    found = lab(made)
    for name, one in zip(effects, drawn, strict=True):
        found, _ = EFFECTS[name](found, one)
    return found


def means(tests: Sequence[Test], found: World, worn: bool) -> np.ndarray:
    """(n,) of the repeats; the first differs from the others where the wall remembers."""
    rows = []
    for test in tests:
        first = run(found, test)
        rows.append((first + (REPEATS - 1) * run(found, test, 1)) / REPEATS if worn else first)
    return np.concatenate(rows)


def reading(tests: Sequence[Test]) -> np.ndarray:
    """(n, n) covariance of the means of the repeats."""
    blocks = []
    for test in tests:
        m, sigma = len(test.loads), SCATTER[test.part, test.quantity]
        noise = sigma**2 * (TOGETHER * np.ones((m, m)) + (1 - TOGETHER) * np.eye(m))
        blocks.append((noise + RESOLUTION[test.quantity]**2 / 12 * np.eye(m)) / REPEATS)
    n = sum(len(block) for block in blocks)
    found, at = np.zeros((n, n)), 0
    for block in blocks:
        found[at:at + len(block), at:at + len(block)] = block
        at += len(block)
    return found


@dataclass(frozen=True)
class Branch:
    """Predictions of some effects, each of one sign, at all of their sizes."""

    predictions: np.ndarray
    """(m, n)."""
    opens: np.ndarray
    """(k, n, n) covariance of what else is drawn."""
    nearest: np.ndarray
    """(m,) which of these each size has."""


def branch(effects: Sequence[str], signs: Sequence[float], tests: Sequence[Test]) -> Branch:
    """All sizes from -sqrt 3 to sqrt 3 deviations, as they are drawn: evenly."""
    from scipy.interpolate import RegularGridInterpolator

    worn = "mullins" in effects
    axis, dense = (np.linspace(-np.sqrt(3), np.sqrt(3), count) for count in (NODES, DENSE))
    few = axis[np.linspace(1, NODES - 2, OPEN).astype(int)]

    def at(sizes: Sequence[float], made: dict | None = None, more: dict | None = None) -> np.ndarray:
        drawn = [Told({0: size, **(more or {}).get(i, {})}, sign)
                 for i, (size, sign) in enumerate(zip(sizes, signs, strict=True))]
        return means(tests, world(effects, Told(made or {}), drawn), worn)

    nodes = np.array([at(sizes) for sizes in product(axis, repeat=len(effects))])
    table = nodes.reshape(*(NODES,) * len(effects), -1)
    values = np.array(list(product(dense, repeat=len(effects))))
    if effects:
        nodes = RegularGridInterpolator((axis,) * len(effects), table, method="cubic")(values)
    counts = [Told() for _ in (None, *effects)]
    world(effects, counts[0], counts[1:])
    opens = []
    for sizes in product(few, repeat=len(effects)):
        moves = [({n: sign * STEP}, None) for n in range(counts[0].asked) for sign in (1, -1)]
        moves += [(None, {i: {n: sign * STEP}}) for i, one in enumerate(counts[1:])
                  for n in range(1, one.asked) for sign in (1, -1)]
        rows = np.array([at(sizes, *move) for move in moves])
        slopes = (rows[::2] - rows[1::2]) / (2 * STEP)
        opens.append(slopes.T @ slopes)
    where = np.array(list(product(few, repeat=len(effects))))
    nearest = ((values[:, None] - where[None]) ** 2).sum(axis=2).argmin(axis=1)
    return Branch(nodes, np.array(opens), nearest)


def explanation(effects: Sequence[str], tests: Sequence[Test]) -> list[Branch]:
    """Of every sign that they may have."""
    of = [(1.0, -1.0) if signed(name) else (1.0,) for name in effects]
    return [branch(effects, signs, tests) for signs in product(*of)]


def log_evidence(branches: Sequence[Branch], data: np.ndarray, errors: np.ndarray,
                 scored: np.ndarray) -> np.ndarray:
    """(draws,) of `data` (draws, s) at the points `scored`."""
    found = []
    for one in branches:
        terms = np.full((len(data), len(one.predictions)), -np.inf)
        for k, open_ in enumerate(one.opens):
            mine = np.flatnonzero(one.nearest == k)
            lower = np.linalg.cholesky((open_ + errors)[np.ix_(scored, scored)])
            inverse = np.linalg.inv(lower)
            left, right = data @ inverse.T, one.predictions[np.ix_(mine, scored)] @ inverse.T
            squares = (left**2).sum(1)[:, None] + (right**2).sum(1)[None] - 2 * left @ right.T
            terms[:, mine] = -squares / 2 - np.log(np.diag(lower)).sum()
        found.append(np.logaddexp.reduce(terms, axis=1) - np.log(terms.shape[1]))
    return np.logaddexp.reduce(found, axis=0) - np.log(len(found))


def read(draw: Draw, tests: Sequence[Series], library: Library) -> tuple[np.ndarray, float]:
    """(means of all `tests`, by what the data sheet multiplies the odds of misread constants)."""
    found = hidden(draw, library, draw.ids)
    for test in tests:
        if test.id not in draw.ids:
            found.measure([test])
    return (np.concatenate([found.records[test.id].repeats.mean(axis=0) for test in tests]),
            checked(library, found).prior_odds["wrong_convention"])


def posterior(pairs: dict[tuple[str, str], list[Branch]], data: np.ndarray, odds: np.ndarray,
              errors: np.ndarray, scored: np.ndarray) -> np.ndarray:
    """(draws, pairs), all pairs as probable before any reading."""
    logs = np.stack([log_evidence(branches, data[:, scored], errors, scored)
                     + np.log(odds) * ("wrong_convention" in two) for two, branches in pairs.items()], axis=1)
    return np.exp(logs - np.logaddexp.reduce(logs, axis=1)[:, None])


def by_each(pairs: dict[tuple[str, str], list[Branch]], data: np.ndarray, odds: np.ndarray,
            errors: np.ndarray, owner: np.ndarray, known: Sequence[frozenset[str]]) -> np.ndarray:
    """`posterior`, each draw by the tests `known` of it; `owner`: the test of each reading."""
    found = np.empty((len(data), len(pairs)))
    for tests in set(known):
        mine = np.flatnonzero([one == tests for one in known])
        scored = np.flatnonzero(np.isin(owner, list(tests)))
        found[mine] = posterior(pairs, data[mine], odds[mine], errors, scored)
    return found


def said(probabilities: np.ndarray, truth: np.ndarray) -> str:
    """What the judge names at SURE, and what if it always names the most probable pair."""
    first, sure = probabilities.argmax(axis=1), probabilities.max(axis=1) >= SURE
    right, n = first == truth, len(truth)
    both = int((right & sure).sum())
    return (f"both named {share(both, n)}; where it names both are right {share(both, int(sure.sum()))}; did "
            f"it always name the most probable pair, both would be right {share(int(right.sum()), n)}, by "
            f"its own probabilities {100 * probabilities.max(axis=1).mean():.0f} %")


def explained(job: tuple[tuple[str, str], Sequence[Test]]) -> tuple[tuple[str, str], list[Branch]]:
    return job[0], explanation(*job)


def main() -> None:
    from tests.benchmarks import diagnosis_library

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="of the study by the same seed")
    parser.add_argument("--seed", type=int, default=FRESH)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    library = Library.load(diagnosis_library.SHIPPED)
    names = (*GIVEN, *askable(library, GIVEN))
    tests = [test for test in library.tests if test.id in names]
    owner = np.repeat([test.id for test in tests], [len(test.loads) for test in tests])
    own = [asked(test) for test in tests]
    twos = list(combinations([name for name in EFFECTS if name not in FORCED], 2))
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(options.workers, get_context("spawn")) as pool:
        pairs = dict(pool.map(explained, [(two, own) for two in twos]))
    rows = rows_of(rows_file(options.folder, options.seed))
    errors = reading(own)
    for kind in ("pair", "large pair"):
        draws = list(judgeable((one for one in plan(options.seed) if one.kind == kind), library, 0.0))
        read_ = [read(draw, tests, library) for draw in draws]
        data, odds = np.array([row for row, _ in read_]), np.array([by for _, by in read_])
        truth = np.array([twos.index(draw.hidden) for draw in draws])
        print(f"{kind}: {len(draws)} draws", flush=True)
        more = [rows[draw.key]["asked"]["best"]["tests"] for draw in draws]
        for what, known in (("three tests", [()] * len(draws)), ("asked-for", more),
                            (f"all {len(tests)} tests", [names] * len(draws))):
            shares = by_each(pairs, data, odds, errors, owner, [frozenset((*GIVEN, *one)) for one in known])
            print(f"  {what}: {said(shares, truth)}", flush=True)


if __name__ == "__main__":
    main()
