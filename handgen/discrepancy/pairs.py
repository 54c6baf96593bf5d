"""Two effects at once: their responses added, which holds as far as one does not change the other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from handgen.discrepancy.dense import COARSE, Dense, dense
from handgen.discrepancy.gaussian import Whitener, log_sum
from handgen.discrepancy.hypothesis import Draft, estimates
from handgen.discrepancy.library import Response
from handgen.discrepancy.problem import SCALE_WEIGHTS, Problem


def drafts(problem: Problem, names: Sequence[str]) -> list[Draft]:
    """A draft of every pair of `names`."""
    library = problem.library
    coarse = {name: coarsened(library.responses[name]).on(problem.scored) for name in names}
    base = library.baseline[problem.scored]
    residual = problem.data - base
    moves = {name: found.predictions[:, problem.scored] - base for name, found in coarse.items()}
    white = {(): _whitened(problem.whiteners(), residual)}
    moved = {((), name): _whitened(problem.whiteners(), move) for name, move in moves.items()}
    result = []
    for a, b in combinations(names, 2):
        first, second = coarse[a], coarse[b]
        if not len(first.values) or not len(second.values):
            continue
        key, whiteners = problem.local((a, b)), problem.whiteners((a, b))
        if key not in white:
            white[key] = _whitened(whiteners, residual)
        for name in (a, b):
            if (key, name) not in moved:
                moved[key, name] = _whitened(whiteners, moves[name])
        posterior = _posterior(whiteners, white[key], moved[key, a], moved[key, b])
        posterior += first.log_weights[:, None] + second.log_weights[None, :]
        i, j = np.unravel_index(int(posterior.argmax()), posterior.shape)
        parameters = {
            a: estimates(library.responses[a].parameters, first.values, _rows(posterior)),
            b: estimates(library.responses[b].parameters, second.values, _rows(posterior.T))}
        centre = first.predictions[i] + second.predictions[j] - library.baseline
        result.append(Draft(f"{a}+{b}", (a, b), log_sum(posterior.ravel()), parameters, centre,
                            len(parameters[a]) + len(parameters[b]), problem))
    return result


def _whitened(whiteners: Sequence[Whitener], rows: np.ndarray) -> list[np.ndarray]:
    return [whiten(rows) for whiten in whiteners]


def coarsened(response: Response) -> Dense:
    """The response at as many values as a pair needs; kept on the response."""
    found = response.__dict__.get("_coarse")
    if found is None:
        found = dense(response.axes, response.densities, response.predictions, COARSE)
        response.__dict__["_coarse"] = found
    return found


def _posterior(whiteners: Sequence[Whitener], white: Sequence[np.ndarray], first: Sequence[np.ndarray],
               second: Sequence[np.ndarray]) -> np.ndarray:
    """log of the likelihood at every two values, summed over the scales of the structural error."""
    terms = []
    for whiten, w, a, b, share in zip(whiteners, white, first, second, SCALE_WEIGHTS, strict=True):
        left = w - a
        squares = (left**2).sum(axis=1)[:, None] + (b**2).sum(axis=1)[None, :] - 2 * left @ b.T
        terms.append(whiten.log_norm - squares / 2 + np.log(share))
    return np.logaddexp(np.logaddexp(terms[0], terms[1]), terms[2])


def _rows(posterior: np.ndarray) -> np.ndarray:
    most = posterior.max(axis=1)
    return most + np.log(np.exp(posterior - most[:, None]).sum(axis=1))
