"""Effects that only a kind of test tells apart that was not done: none of them is named without the other.

Silicone that has given way before its first reading is soft silicone to every test that only goes up; which
of both is more probable there is no more than what was believed before. Only where one of them fits at no
size that is physical, alone or beside another effect, do the readings tell by themselves.
"""

from __future__ import annotations

import numpy as np

from handgen.discrepancy.score import Scores
from handgen.effects import catalogue

SEEN = 1e-6
"""mm, deg, N: an effect that moves no reading by as much cannot be mistaken for another."""


def untold(scores: Scores, effect: str) -> tuple[str, ...]:
    """Effects of the library that nothing read so far can tell from `effect`."""
    library, rows = scores.problem.library, scores.problem.scored
    read = [library.tests[i] for i in set(library.owner[rows])]
    done = {test.path for test in read} | {test.quantity for test in read}
    return tuple(other for other, response in library.responses.items()
                 if (means := telling(effect, other)) and not means & done
                 and (np.abs(response.predictions[..., rows] - library.baseline[rows]) > SEEN).any()
                 and not all(h.refuted for h in scores.hypotheses if other in h.ids and effect not in h.ids))


def telling(first: str, second: str) -> set[str]:
    """Paths and observables of a test that tell two effects apart; empty where any may."""
    known = catalogue()
    return {path for one, two in ((first, second), (second, first)) if one in known
            for path in known[one].told_by.get(two, ())}
