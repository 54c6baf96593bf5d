"""Probabilities -> what is said: none, named, pair, ambiguous, outside. It names what it could defend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from handgen.discrepancy.classes import classes
from handgen.discrepancy.hypothesis import Hypothesis
from handgen.discrepancy.library import NONE
from handgen.discrepancy.score import Scores
from handgen.discrepancy.untold import untold

Word = Literal["none", "named", "pair", "ambiguous", "outside"]
SURE = 0.9
"""Probability from which an explanation is named."""
RATHER = 0.5
"""Probability from which it is said that nothing is missing, or something unknown."""
COVERED = 0.9
"""Probability that the set of an ambiguous verdict holds together."""
MISFIT = 0.02
"""Chance of so bad a fit below which an explanation is vetoed."""
HOPELESS = 1e-4
"""Probability below which one effect alone is given up and a second one named beside it, as where it is
refuted."""


@dataclass(frozen=True)
class Verdict:
    """What the data allow to say."""

    word: Word
    effects: tuple[str, ...]
    """What it rests on: one, two (more beside what a direct check shows), or the effects of an ambiguous set;
    empty for none and outside."""
    best: Hypothesis
    """The explanation that is shown: the named one, else the most probable."""
    probability: float
    """Of what is said."""
    candidates: tuple[str, ...]
    """The smallest set of explanations that holds COVERED."""
    classes: tuple[tuple[str, ...], ...]
    """The same set, explanations that predict the same readings taken together, the most probable first."""
    vetoed: bool
    """The most probable explanation does not fit."""
    known: tuple[str, ...] = ()
    """Effects that a direct check shows to be missing, and that the readings do not deny."""
    untold: tuple[str, ...] = ()
    """Effects of one class that would else be named by the first: only a test of another kind parts them."""
    more: float = 0.0
    """Probability that something is missing beside what is named."""
    or_both: tuple[str, ...] = ()
    """The likelier effect of a pair alone, and the pair, where the pair is sure but that one alone is not
    refuted: a test has to tell."""

    @property
    def alike(self) -> tuple[str, ...]:
        """Explanations that these tests cannot tell from the best, itself among them."""
        return next((one for one in self.classes if self.best.id in one), (self.best.id,))


def verdict(scores: Scores) -> Verdict:
    """The verdict on `scores`."""
    library = scores.problem.library
    known = tuple(library.on) if all(scores.present(name) >= SURE for name in library.on) else ()
    found = _named(scores, known)
    if found.word not in ("named", "pair"):
        return found
    return replace(found, more=sum(h.probability for h in scores.hypotheses if h.more_than(found.effects)))


def _named(scores: Scores, known: tuple[str, ...]) -> Verdict:
    """What the readings say, and what a direct check shows."""
    library, found = scores.problem.library, _of_readings(scores, known)
    if known and found.word != "pair" and scores[library.called()].p_value >= MISFIT:
        # A direct check names it, and it fits: whatever else may be missing.
        alone = scores[library.called()]
        return replace(found, word="named", effects=known, best=alone, vetoed=False,
                       probability=min(scores.present(name) for name in known))
    return found


def _of_readings(scores: Scores, known: tuple[str, ...]) -> Verdict:
    """What the readings say, beside the effects that are `known` to be missing."""
    best = scores.hypotheses[0]
    beside = tuple(name for name in best.ids if name not in known)
    held = covering(scores)
    vetoed = best.p_value < MISFIT and not best.outside
    parted = tuple(classes(scores, held))

    def said(word: Word, effects: tuple[str, ...], probability: float, shown: Hypothesis = best) -> Verdict:
        return Verdict(word, effects, shown, probability, held, parted, vetoed, known)

    outside = sum(h.probability for h in scores.hypotheses if h.outside)
    if vetoed or (best.outside and outside >= RATHER):
        return said("outside", (), outside)
    if best.id == NONE and best.probability >= RATHER:
        return said("none", (), best.probability)
    if best.outside or not beside:
        return said("ambiguous", _effects(scores, held), _sum(scores, held))
    both = len(beside) == 2 and best.probability >= SURE and not best.cut
    if both and not _one_may_do(scores, known, beside):
        return _parted(said("pair", best.ids, best.probability), scores)
    # One effect may be certain where it is open whether another one is there as well
    sure = [name for name in beside if scores.present(name) >= SURE
            and _nameable(_alone(scores, known, name))]
    found = said("ambiguous", _effects(scores, held), _sum(scores, held))
    if sure:
        one = _likeliest_alone(scores, known, sure)
        (name,) = set(one.ids) - set(known)
        found = _parted(said("pair" if known else "named", one.ids, scores.present(name), one), scores)
    either = (_likeliest_alone(scores, known, sure or beside).id, best.id) if both else ()
    return replace(found, or_both=either)


def _parted(named: Verdict, scores: Scores) -> Verdict:
    """`named`, or a class where one of its effects cannot be told from others by any test that was done."""
    for name in named.effects:
        if others := untold(scores, name):
            ids = (name, *others)
            held = tuple(dict.fromkeys((*ids, *named.candidates)))
            rest = [tuple(one for one in group if one not in ids) for group in named.classes]
            return replace(named, word="ambiguous", effects=tuple(dict.fromkeys((*named.effects, *ids))),
                           candidates=held, untold=ids, classes=(ids, *(group for group in rest if group)))
    return named


def _one_may_do(scores: Scores, known: tuple[str, ...], pair: tuple[str, ...]) -> bool:
    """Whether one of a pair's effects alone is not quite refuted: the other may but mend its law."""
    alone = [_alone(scores, known, name) for name in pair]
    return any(not one.refuted and one.probability >= HOPELESS for one in alone)


def _alone(scores: Scores, known: tuple[str, ...], name: str) -> Hypothesis:
    """One effect and no other beside those that are known."""
    return scores["+".join((*known, name))]


def _nameable(one: Hypothesis) -> bool:
    """Whether it fits, at a size short of what could be simulated: else a rival may have been cut off there
    as well, and how probable it is among those that are left says little."""
    return one.p_value >= MISFIT and not one.cut


def _likeliest_alone(scores: Scores, known: tuple[str, ...], names: Sequence[str]) -> Hypothesis:
    return max((_alone(scores, known, name) for name in names), key=lambda h: h.probability)


def covering(scores: Scores, share: float = COVERED) -> tuple[str, ...]:
    """The fewest explanations that hold `share` of the probability, the most probable first."""
    found, total = [], 0.0
    for hypothesis in scores.hypotheses:
        found.append(hypothesis.id)
        total += hypothesis.probability
        if total >= share:
            break
    return tuple(found)


def _effects(scores: Scores, held: tuple[str, ...]) -> tuple[str, ...]:
    """What the explanations `held` are made of, the most probable first."""
    names = dict.fromkeys(name for one in held for name in scores[one].ids)
    return tuple(sorted(names, key=scores.present, reverse=True))


def _sum(scores: Scores, held: tuple[str, ...]) -> float:
    return sum(scores[one].probability for one in held)
