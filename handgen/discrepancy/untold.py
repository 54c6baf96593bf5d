"""Effects that only a kind of test tells apart that was not done: none of them is named without the other.

Silicone that has given way before its first reading is soft silicone to every test that only goes up, however
its law runs; which of both is more probable there is no more than what was believed before.
"""

from __future__ import annotations

from handgen.discrepancy.score import Scores
from handgen.effects import catalogue


def untold(scores: Scores, effect: str) -> tuple[str, ...]:
    """Effects of the library that nothing read so far can tell from `effect`."""
    library = scores.problem.library
    done = {library.tests[i].path for i in set(library.owner[scores.problem.scored])}
    return tuple(other for other in library.responses
                 if (paths := telling(effect, other)) and not paths & done)


def telling(first: str, second: str) -> set[str]:
    """Paths of a test that tell two effects apart; empty where any may."""
    known = catalogue()
    return {path for one, two in ((first, second), (second, first)) if one in known
            for path in known[one].told_by.get(two, ())}
