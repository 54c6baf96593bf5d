"""Something that no effect of the catalogue explains: a Gaussian process on the residual of each kind."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from handgen.discrepancy.gaussian import log_sum
from handgen.discrepancy.problem import SCALE_WEIGHTS, SCALES, Problem

AMPLITUDES = (0.05, 0.12, 0.3)
"""Of the process, as shares of the largest prediction of its kind; less is what a mesh and fingers within
tolerance leave open anyway, and no finding."""
LENGTHS = (0.35, 1.0)
"""Over which it changes, as shares of the largest load."""
ABSENT = 0.5
"""Prior probability that a kind of test is not touched."""
MOST_KINDS = 4
"""Beyond, all kinds have one amplitude in common: there would be too many combinations."""


def kernels(problem: Problem, rows: np.ndarray, columns: np.ndarray, length: float) -> list[np.ndarray]:
    """Of each kind of test: covariance of the process with amplitude 1 between points of the library.

    What is read directly is no part of it: a process is a lack of the simulation.
    """
    library = problem.library
    kinds = np.array(["" if test.direct else test.kind for test in library.tests])[library.owner]
    found = []
    for kind in dict.fromkeys(kinds[problem.scored]):
        if not kind:
            continue
        mine = kinds == kind
        reach = float(library.loads[mine].max()) or 1.0
        size = float(np.nanmax(np.abs(library.baseline[mine]))) or 1.0
        distance = (library.loads[rows][:, None] - library.loads[columns][None, :]) / (length * reach)
        both = mine[rows][:, None] & mine[columns][None, :]
        found.append(np.where(both, size**2 * np.exp(-distance**2 / 2), 0.0))
    return found


def combinations(count: int) -> list[tuple[tuple[float, ...], float]]:
    """(amplitude of each kind, prior log weight); at least one kind is touched."""
    single = {0.0: ABSENT, **dict.fromkeys(AMPLITUDES, (1 - ABSENT) / len(AMPLITUDES))}
    if count > MOST_KINDS:
        return [((a,) * count, -np.log(len(AMPLITUDES))) for a in AMPLITUDES]
    rows = [(row, float(np.log([single[a] for a in row]).sum()))
            for row in itertools.product(single, repeat=count) if any(row)]
    norm = log_sum(np.array([weight for _, weight in rows]))
    return [(row, weight - norm) for row, weight in rows]


def log_evidence(problem: Problem, baseline: np.ndarray,
                 ids: Sequence[str] = ()) -> tuple[float, np.ndarray]:
    """(log evidence, learned residual at all points of the library) of a process on data - `baseline`, which
    has the effects `ids` on.

    The residual is the mean over everything that the process leaves open. It is no physics.
    """
    rows = problem.scored
    residual = problem.data - baseline[rows]
    everywhere = np.arange(problem.library.size)
    terms, parts = [], []
    for length in LENGTHS:
        near = np.array(kernels(problem, rows, rows, length))
        far = np.array(kernels(problem, everywhere, rows, length))
        squares, weights = (np.array(x) for x in zip(*combinations(len(near)), strict=True))
        squares = squares**2
        added = np.tensordot(squares, near, axes=1)
        for scale, share in zip(SCALES, SCALE_WEIGHTS, strict=True):
            densities, weighted = _densities(problem.covariance(scale, ids) + added, residual)
            terms.append(densities + weights + np.log(share / len(LENGTHS)))
            parts.append((squares, weighted, far))
    total = log_sum(np.concatenate(terms))
    learned = np.zeros(len(everywhere))
    for term, (squares, weighted, far) in zip(terms, parts, strict=True):
        shares = np.exp(term - total)
        learned += np.einsum("c,ck,knm,cm->n", shares, squares, far, weighted, optimize=True)
    return total, learned


def _densities(covariances: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each of (c, s, s) covariances: the log density of `residual`, and C^-1 `residual`."""
    weighted = np.linalg.solve(covariances, residual[:, None])[..., 0]
    determinants = np.linalg.slogdet(covariances)[1]
    return -(determinants + weighted @ residual + len(residual) * np.log(2 * np.pi)) / 2, weighted
