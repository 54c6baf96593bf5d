"""Something that no effect of the catalogue explains: a Gaussian process on the residual.

Over the load, of each kind of test by itself, where the simulation lacks something. Or over what is read,
the same in all tests that read it, where the reading is off: a camera that looks from the side draws out what
lies far from its axis, in whichever test. A scale that is off is the simplest of these, and no name for the
others.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handgen.discrepancy.gaussian import log_sum
from handgen.discrepancy.problem import SCALE_WEIGHTS, SCALES, Problem

AMPLITUDES = (0.05, 0.12, 0.3)
"""Of the process, as shares of the largest prediction that it moves; less is what a mesh and fingers within
tolerance leave open anyway, and no finding."""
LENGTHS = (0.35, 1.0)
"""Over which it changes, as shares of the largest load, or reading."""
ABSENT = 0.5
"""Prior probability that a kind of test is not touched."""
MOST_KINDS = 4
"""Beyond, all kinds have one amplitude in common: there would be too many combinations."""
OF_READING = 0.1
"""Prior probability that it is the reading: as many of the catalogue's effects are, two of 18."""


def processes(problem: Problem, rows: np.ndarray, columns: np.ndarray,
              length: float) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Covariances with amplitude 1 between points of the library: (of each kind of test over the load, of
    each quantity that more than one kind reads over the reading).

    What is read directly is no part of it: a process is a lack of the simulation, or of the eye. A quantity
    that only one kind reads would be a process over the load once more.
    """
    library = problem.library
    kinds = np.array(["" if test.direct else test.kind for test in library.tests])
    scored = [library.tests[i] for i in set(library.owner[problem.scored])]
    read_of = {quantity: len({test.kind for test in scored if test.quantity == quantity})
               for quantity in {test.quantity for test in scored if not test.direct}}
    read = np.array([test.quantity if read_of.get(test.quantity, 0) > 1 else "" for test in library.tests])
    there = np.nan_to_num(library.baseline)
    return (_over(problem, kinds[library.owner], library.loads, rows, columns, length),
            _over(problem, read[library.owner], there, rows, columns, length))


def _over(problem: Problem, groups: np.ndarray, along: np.ndarray, rows: np.ndarray, columns: np.ndarray,
          length: float) -> list[np.ndarray]:
    """Of each of the `groups` (n,) of points that is scored, a process over `along` (n,)."""
    found = []
    for group in dict.fromkeys(groups[problem.scored]):
        if not group:
            continue
        mine = groups == group
        reach = float(np.abs(along[mine]).max()) or 1.0
        size = float(np.nanmax(np.abs(problem.library.baseline[mine]))) or 1.0
        distance = (along[rows][:, None] - along[columns][None, :]) / (length * reach)
        both = mine[rows][:, None] & mine[columns][None, :]
        found.append(np.where(both, size**2 * np.exp(-distance**2 / 2), 0.0))
    return found


def amplitudes(kinds: int, readings: int) -> list[tuple[tuple[float, ...], float]]:
    """(amplitude of each process, prior log weight): some of the kinds, or else one of the readings."""
    if not readings:
        return combinations(kinds)
    simulation = [((*row, *(0.0,) * readings), weight + float(np.log(1 - OF_READING)))
                  for row, weight in combinations(kinds)]
    alone = [tuple(a if i == kinds + which else 0.0 for i in range(kinds + readings))
             for which in range(readings) for a in AMPLITUDES]
    return simulation + [(row, float(np.log(OF_READING / len(alone)))) for row in alone]


def combinations(count: int) -> list[tuple[tuple[float, ...], float]]:
    """(amplitude of each kind, prior log weight); at least one kind is touched."""
    single = {0.0: ABSENT, **dict.fromkeys(AMPLITUDES, (1 - ABSENT) / len(AMPLITUDES))}
    if count > MOST_KINDS:
        return [((a,) * count, -np.log(len(AMPLITUDES))) for a in AMPLITUDES]
    rows = [(row, float(np.log([single[a] for a in row]).sum()))
            for row in itertools.product(single, repeat=count) if any(row)]
    norm = log_sum(np.array([weight for _, weight in rows]))
    return [(row, weight - norm) for row, weight in rows]


@dataclass(frozen=True)
class Weighed:
    """Processes of one length, at one scale of the structural error: c amplitudes of k processes."""

    logs: np.ndarray
    """(c,) how well each foresaw the data, with its prior."""
    squares: np.ndarray
    """(c, k) amplitudes squared."""
    of_reading: np.ndarray
    """(c,) whether it is the reading that is off."""
    mean: np.ndarray
    """(c, s) residual over its covariance."""


def _weighed(problem: Problem, baseline: np.ndarray, ids: Sequence[str], length: float) -> list[Weighed]:
    rows = problem.scored
    residual = problem.data - baseline[rows]
    of_kinds, readings = processes(problem, rows, rows, length)
    squares, weights = (np.array(x) for x in zip(*amplitudes(len(of_kinds), len(readings)), strict=True))
    squares = squares**2
    added = np.tensordot(squares, np.array(of_kinds + readings), axes=1)
    found = []
    for scale, share in zip(SCALES, SCALE_WEIGHTS, strict=True):
        densities, mean = _densities(problem.covariance(scale, ids) + added, residual)
        found.append(Weighed(densities + weights + np.log(share / len(LENGTHS)), squares,
                             squares[:, len(of_kinds):].any(axis=1), mean))
    return found


def log_evidence(problem: Problem, baseline: np.ndarray,
                 ids: Sequence[str] = ()) -> tuple[float, np.ndarray]:
    """(log evidence, learned residual at all points of the library) of a process on data - `baseline`, which
    has the effects `ids` on.

    The residual is the mean over everything that the process leaves open. It is no physics.
    """
    everywhere = np.arange(problem.library.size)
    found = {length: _weighed(problem, baseline, ids, length) for length in LENGTHS}
    total = log_sum(np.concatenate([one.logs for of_length in found.values() for one in of_length]))
    learned = np.zeros(len(everywhere))
    for length, of_length in found.items():
        far = np.array(list(itertools.chain(*processes(problem, everywhere, problem.scored, length))))
        for one in of_length:
            learned += np.einsum("c,ck,knm,cm->n", np.exp(one.logs - total), one.squares, far, one.mean,
                                 optimize=True)
    return total, learned


def share_of_reading(problem: Problem, baseline: np.ndarray) -> float:
    """If it is something unknown, the probability that it is in the reading, not in what the finger does."""
    found = [one for length in LENGTHS for one in _weighed(problem, baseline, (), length)]
    logs = np.concatenate([one.logs for one in found])
    return float(np.exp(logs - log_sum(logs))[np.concatenate([one.of_reading for one in found])].sum())


def _densities(covariances: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each of (c, s, s) covariances: the log density of `residual`, and C^-1 `residual`."""
    weighted = np.linalg.solve(covariances, residual[:, None])[..., 0]
    determinants = np.linalg.slogdet(covariances)[1]
    return -(determinants + weighted @ residual + len(residual) * np.log(2 * np.pi)) / 2, weighted
