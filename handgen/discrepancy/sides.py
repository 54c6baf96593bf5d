"""An effect of either sign, of which the readings tell the size but not the sign.

A core that lies off the middle shortens the free actuator by as much towards either side: only a few
millimetres of the finger's drop tell which, or a look at the actuator.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from handgen.discrepancy.ask import Proposal, next_test
from handgen.discrepancy.candidates import SIGMAS
from handgen.discrepancy.library import Library, Response
from handgen.discrepancy.problem import Problem
from handgen.discrepancy.score import score_problem
from handgen.discrepancy.verdict import Verdict
from handgen.effects import Parameter, catalogue


def signed(effect: str) -> Parameter | None:
    """The size of an effect of either sign; None of others, and of those with more parameters."""
    known = catalogue().get(effect)
    if known is None or len(known.parameters) != 1:
        return None
    (size,) = known.parameters
    return size if size.low < size.null < size.high else None


def either_way(said: Verdict) -> dict[str, float]:
    """Named effects of which the 99 % interval lies on both sides of no effect at all -> that size.

    Wider than what is reported of a size, for a mould is mended by the side: of 53 windings of which the 95 %
    interval lay on one side 8 were on the other (`tests.benchmarks.diagnosis`, seeds from 250000): the few
    millimetres of the finger that tell it another law moves as well. None while another test has to tell
    whether there is one effect, or two.
    """
    if said.word not in ("named", "pair") or said.or_both:
        return {}
    sizes = {name: size for name in said.effects if (size := signed(name)) is not None}
    return {name: size.null for name, size in sizes.items()
            if any(one.wide[0] < size.null < one.wide[1] for one in said.best.parameters.get(name, ()))}


def which_way(problem: Problem, ways: Mapping[str, float], tests: Sequence[str]) -> Proposal | None:
    """The best of `tests`, not done yet, to tell on which side the first of `ways` is, see `either_way`."""
    effect, null = next(iter(ways.items()))
    library, sides = parted(problem.library, effect, null)
    scores = score_problem(replace(problem, library=library), pairs=False, process=False)
    found = next_test(scores, tests, SIGMAS, or_both=sides)
    return found and replace(found, separates=(effect,))


def parted(library: Library, effect: str, null: float) -> tuple[Library, tuple[str, str]]:
    """(`library` with no effect but this one, as two: up to `null` and from there on; their explanations)."""
    response = library.responses[effect]
    axis = response.axes[0]
    halves = {f"{effect} {word}": _part(response, mine)
              for word, mine in (("below", axis <= null), ("above", axis >= null))}
    below, above = (library.called(half) for half in halves)
    return replace(library, responses=halves, prior_odds={}), (below, above)


def _part(response: Response, mine: np.ndarray) -> Response:
    (density,) = response.densities
    return replace(response, axes=(response.axes[0][mine],), predictions=response.predictions[mine],
                   densities=(density if density.ndim == 2 else density[mine],))
