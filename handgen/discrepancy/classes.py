"""Effects that no test at hand can tell apart are one class."""

from __future__ import annotations

from collections.abc import Sequence

from handgen.discrepancy.score import Scores

ALIKE = 2.0
"""Deviations, all points together: explanations nearer than this no data of this quality tell apart."""


def alike(scores: Scores, first: str, second: str) -> bool:
    """Whether the best predictions of two hypotheses are the same, as far as these data can tell."""
    problem = scores.problem
    rows = problem.scored
    a, b = scores[first], scores[second]
    whiten = problem.whitener(a.ids)
    apart = whiten((a.centre - b.centre)[rows])
    return float(apart @ apart) < ALIKE**2


def class_of(scores: Scores, leader: str, among: Sequence[str]) -> tuple[str, ...]:
    """`leader` and those `among` that predict the same."""
    return (leader, *(name for name in among if name != leader and alike(scores, leader, name)))


def classes(scores: Scores, among: Sequence[str]) -> list[tuple[str, ...]]:
    """`among` parted into classes that predict the same, each led by its most probable explanation."""
    left, found = list(among), []
    while left:
        found.append(class_of(scores, left[0], left))
        left = [name for name in left if name not in found[-1]]
    return found
