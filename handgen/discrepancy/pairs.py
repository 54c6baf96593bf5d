"""Two effects at once: their responses added, and what both do together beyond that where it was simulated.

A softer wall under more pressure goes further than the sum, a finger that is bent already less far. The
interplay is simulated at one size of both effects and goes with the product of how much of its shift at that
size each has: exact to second order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from handgen.discrepancy.dense import COARSE, Dense, dense
from handgen.discrepancy.gaussian import Whitener, log_sum
from handgen.discrepancy.hypothesis import Draft, estimates
from handgen.discrepancy.library import Library, Response
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
        more = Together.of(library, a, b, first, second, problem.scored)
        excess = None if more is None else _whitened(whiteners, more.excess[problem.scored])
        posterior = _posterior(whiteners, white[key], moved[key, a], moved[key, b], more, excess)
        posterior += first.log_weights[:, None] + second.log_weights[None, :]
        i, j = np.unravel_index(int(posterior.argmax()), posterior.shape)
        parameters = {
            a: estimates(library.responses[a].parameters, first.values, _rows(posterior)),
            b: estimates(library.responses[b].parameters, second.values, _rows(posterior.T))}
        centre = first.predictions[i] + second.predictions[j] - library.baseline
        if more is not None:
            centre = centre + more.first[i] * more.second[j] * more.excess
        result.append(Draft(library.called(a, b), (a, b), log_sum(posterior.ravel()), parameters, centre,
                            len(parameters[a]) + len(parameters[b]), problem,
                            tuple(name for name, last in ((a, first.last[i]), (b, second.last[j])) if last)))
    return result


@dataclass(frozen=True)
class Together:
    """The interplay of two effects at all of their values."""

    excess: np.ndarray
    """(n,) where it was simulated; 0 where that found no balance."""
    first: np.ndarray
    """Of each value of the first effect: its shift as a share of that which the interplay belongs to."""
    second: np.ndarray

    @classmethod
    def of(cls, library: Library, a: str, b: str, first: Dense, second: Dense,
           scored: np.ndarray) -> Together | None:
        """None where none was simulated, or where it is unknown at a point that is `scored`."""
        found = library.interplays.get((a, b))
        if found is None or not np.isfinite(found.at(scored).excess).all():
            return None
        return cls(np.nan_to_num(found.excess), *(
            _shares(dense.predictions[:, scored] - library.baseline[scored], shift)
            for dense, shift in zip((first, second), found.at(scored).shifts, strict=True)))


def _shares(shifts: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """(m,) of each of `shifts`, its part along `whole`, whose own is 1."""
    size = float(whole @ whole)
    return shifts @ whole / size if size > 0 else np.zeros(len(shifts))


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
               second: Sequence[np.ndarray], more: Together | None,
               excess: Sequence[np.ndarray] | None) -> np.ndarray:
    """log of the likelihood at every two values, summed over the scales of the structural error."""
    terms = []
    for i, (whiten, share) in enumerate(zip(whiteners, SCALE_WEIGHTS, strict=True)):
        left, b = white[i] - first[i], second[i]
        squares = (left**2).sum(axis=1)[:, None] + (b**2).sum(axis=1)[None, :] - 2 * left @ b.T
        if more is not None:
            by = np.outer(more.first, more.second)
            squares += by**2 * (excess[i] @ excess[i]) - 2 * by * (
                (left @ excess[i])[:, None] - (b @ excess[i])[None, :])
        terms.append(whiten.log_norm - squares / 2 + np.log(share))
    return np.logaddexp(np.logaddexp(terms[0], terms[1]), terms[2])


def _rows(posterior: np.ndarray) -> np.ndarray:
    most = posterior.max(axis=1)
    return most + np.log(np.exp(posterior - most[:, None]).sum(axis=1))
