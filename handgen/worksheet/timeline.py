"""The castings of a day: who does what when, so that the last actuator leaves its mould as early as possible.

One pair of hands winds, assembles, mixes, pours and opens, one thing at a time. An actuator's mould is taken
from its assembly to its second opening; no more than `moulds` are taken at once. A mix fills as many moulds
as can be poured within its pot life, counted from when A meets B. All times in minutes.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, floor

from handgen.errors import InputError, Problem
from handgen.parameters.process import Casting

WIND, ASSEMBLE, MIX, POUR, CURE, OPEN, DEMOULD = (
    "wind", "assemble", "mix", "pour", "cure", "open", "demould")
HANDS = (WIND, ASSEMBLE, MIX, POUR, OPEN, DEMOULD)
"""What takes somebody's hands; a cure takes none."""
ROUNDING = 1e-6


@dataclass(frozen=True)
class Durations:
    """How long each thing takes; `wind` by actuator."""

    wind: dict[str, float]
    assemble: float
    mix: float
    """Mixing and settling."""
    pour: float
    """One mould."""
    pot_life: float
    cure: float
    open: float
    """After the first cure, the mould closed again around the small core."""
    demould: float
    """After the second cure."""

    @property
    def batch(self) -> int:
        """Moulds that one mix fills."""
        return floor((self.pot_life - self.mix) / self.pour + ROUNDING)

    @classmethod
    def of(cls, casting: Casting, turns: dict[str, float]) -> Durations:
        """Of a parameter file; `turns` of thread by actuator."""
        return cls(
            wind={name: count / casting.winding_rate for name, count in turns.items()},
            assemble=casting.assembly_time, mix=casting.mixing_time + casting.settling_time,
            pour=casting.pour_time, pot_life=casting.silicone.pot_life,
            cure=60 * casting.silicone.cure_time, open=casting.opening_time + casting.assembly_time,
            demould=casting.opening_time)


@dataclass(frozen=True)
class Step:
    """`layer` is 1 or 2: outer or inner layer; 0 where the step belongs to neither."""

    what: str
    start: float
    end: float
    actuators: tuple[str, ...]
    layer: int = 0


@dataclass(frozen=True)
class Timeline:
    """Steps in order of their starts; no schedule whatever ends before `bound`."""

    steps: tuple[Step, ...]
    moulds: int
    bound: float

    @property
    def end(self) -> float:
        """When the last actuator leaves its mould."""
        return max(step.end for step in self.steps)

    @property
    def gap(self) -> float:
        """Share by which it could at most be shorter: 0 is proven optimal."""
        return self.end / self.bound - 1

    @cached_property
    def mixes(self) -> list[tuple[Step, list[Step]]]:
        """Every mix with the pours that it fills."""
        found: list[tuple[Step, list[Step]]] = []
        for step in self.steps:
            if step.what == MIX:
                found.append((step, []))
            elif step.what == POUR:
                found[-1][1].append(step)
        return found


def plan(durations: Durations, moulds: int) -> Timeline:
    """The shortest schedule found, with a bound that proves how short any could be.

    Simple rules of thumb (what to do first, how many moulds to wait for before a mix) are all tried; see
    `lower_bound` for what they are held against. A mix is poured at once: where a pot life is as long as a
    cure, letting it stand can save time on paper, and only the bound counts on that.

    Raises:
        InputError: no actuators, no mould, or a mix that cannot fill one mould within its pot life.
    """
    _check(durations, moulds)
    bound = lower_bound(durations, moulds)
    best: tuple[Step, ...] = ()
    end = float("inf")
    most = min(durations.batch, moulds, len(durations.wind))
    for order in _orders(durations.wind):
        for preference in itertools.permutations((POUR, OPEN, ASSEMBLE, WIND)):
            for wait in range(1, most + 1):
                steps = _Shop(durations, moulds, order, (DEMOULD, *preference), wait).run(end)
                if steps and steps[-1].end < end - ROUNDING:
                    best, end = steps, max(step.end for step in steps)
            if end <= bound + ROUNDING:
                break
    return Timeline(tuple(sorted(best, key=lambda s: (s.start, s.end))), moulds, bound)


def lower_bound(durations: Durations, moulds: int) -> float:
    """No schedule is shorter. The larger of two bounds:

    moulds: of `moulds` moulds one is taken at least ceil(n / moulds) times, each time for an assembly, two
    pours, two cures, an opening, a demoulding, and for a mix wherever that could not be made before and still
    be poured in time; and nothing is poured before something is wound and mixed.

    hands: before the last of the first pours, one pair of hands has wound and assembled all n, poured the
    n - 1 others and mixed for them; that last one then still has both its cures before it.
    """
    d, count = durations, len(durations.wind)
    early, late = (d.mix if d.mix + work + d.pour > d.pot_life + ROUNDING else 0.0
                   for work in (d.assemble, d.open))
    second = d.pour + d.cure + d.open + late + d.pour + d.cure + d.demould
    taken = d.assemble + early + second
    by_moulds = min(d.wind.values()) + (d.mix - early) + ceil(count / moulds) * taken
    by_hands = (sum(d.wind.values()) + count * d.assemble + ceil(count / d.batch) * d.mix
                + (count - 1) * d.pour + second)
    return max(by_moulds, by_hands)


def _check(durations: Durations, moulds: int) -> None:
    d, problems = durations, []
    if not d.wind:
        problems.append(Problem("worksheet", "actuators", None, "there is nothing to cast"))
    if moulds < 1:
        problems.append(Problem("worksheet", "casting.mould_sets", moulds, "no mould to pour", "at least 1"))
    times = {"wind": min(d.wind.values(), default=0), "assemble": d.assemble, "mix": d.mix, "pour": d.pour,
             "pot_life": d.pot_life, "cure": d.cure, "open": d.open, "demould": d.demould}
    problems += [Problem("worksheet", name, value, "no time is negative, and pouring takes some", "minutes")
                 for name, value in times.items()
                 if not value >= 0 or value == float("inf") or (name == "pour" and value == 0)]
    if not problems and d.batch < 1:
        problems.append(Problem("worksheet", "casting.silicone.pot_life", d.pot_life,
                                "is over before the first mould is full", f"at least {d.mix + d.pour:g} min"))
    if problems:
        raise InputError(problems)


def _orders(wind: dict[str, float]) -> Iterable[list[str]]:
    """Quick ones first, or slow ones first."""
    yield sorted(wind, key=lambda name: wind[name])
    yield sorted(wind, key=lambda name: -wind[name])


@dataclass
class _Shop:
    """One run of the rules: at every moment the hands do the first thing of `preference` that can be done."""

    d: Durations
    moulds: int
    order: list[str]
    preference: Sequence[str]
    wait: int
    """Moulds that must stand ready for a mix, while others could still join them."""
    now: float = 0.0
    free: int = 0
    steps: list[Step] = field(default_factory=list)
    ready: list[tuple[str, int]] = field(default_factory=list)
    """Closed moulds, with the layer that they wait for."""
    curing: list[tuple[float, str, int]] = field(default_factory=list)

    def run(self, limit: float) -> tuple[Step, ...]:
        """All steps; none if it takes longer than `limit`."""
        self.free = self.moulds
        unwound, wound = list(self.order), []
        while unwound or wound or self.ready or self.curing:
            for action in self.preference:
                if self._does(action, unwound, wound):
                    break
            else:
                # Nothing to do before the next cure is over.
                self.now = max(self.now, min(end for end, _, _ in self.curing))
            if self.now > limit:
                return ()
        return tuple(self.steps)

    def _does(self, action: str, unwound: list[str], wound: list[str]) -> bool:
        if action == WIND and unwound:
            self._work(WIND, self.d.wind[unwound[0]], unwound[0])
            wound.append(unwound.pop(0))
        elif action == ASSEMBLE and wound and self.free:
            self._work(ASSEMBLE, self.d.assemble, wound[0], 1)
            self.free -= 1
            self.ready.append((wound.pop(0), 1))
        elif action == OPEN and (name := self._cured(1)):
            self._work(OPEN, self.d.open, name, 1)
            self.ready.append((name, 2))
        elif action == DEMOULD and (name := self._cured(2)):
            self._work(DEMOULD, self.d.demould, name, 2)
            self.free += 1
        elif action == POUR and self._enough(unwound, wound):
            self._mix()
        else:
            return False
        return True

    def _enough(self, unwound: list[str], wound: list[str]) -> bool:
        """Whether a mix is worth while: enough moulds, or none that could join soon."""
        if not self.ready:
            return False
        joining = (self.free and (unwound or wound)) or any(
            end <= self.now + ROUNDING and layer == 1 for end, _, layer in self.curing)
        return len(self.ready) >= self.wait or not joining

    def _mix(self) -> None:
        filled = self.ready[:self.d.batch]
        del self.ready[:self.d.batch]
        self._work(MIX, self.d.mix, *(name for name, _ in filled))
        for name, layer in filled:
            self._work(POUR, self.d.pour, name, layer)
            self.steps.append(Step(CURE, self.now, self.now + self.d.cure, (name,), layer))
            self.curing.append((self.now + self.d.cure, name, layer))

    def _cured(self, layer: int) -> str | None:
        """The first that is cured and waits to be opened."""
        done = sorted(c for c in self.curing if c[2] == layer and c[0] <= self.now + ROUNDING)
        if not done:
            return None
        self.curing.remove(done[0])
        return done[0][1]

    def _work(self, what: str, time: float, *who: str | int) -> None:
        layer = who[-1] if who and isinstance(who[-1], int) else 0
        names = tuple(name for name in who if isinstance(name, str))
        self.steps.append(Step(what, self.now, self.now + time, names, layer))
        self.now += time
