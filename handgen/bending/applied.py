"""Effects of a model at work: on the hand, the model, the case, what the chamber sees and what is read."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from pydantic import ValidationError

from handgen.bending.model import BendModel
from handgen.effects import Course, Switched
from handgen.errors import Problem
from handgen.parameters import explain, fault, relations
from handgen.parameters.load import Loaded
from handgen.parameters.model import Hand
from handgen.simulation.case import Case, Curve

T = TypeVar("T")
READ = {"tip_drop": 1.0, "elongation": 1.0, "bend_angle": math.degrees(1.0), "tip_force": 1.0}
"""Values of a state that a lab reads, in its units."""


@dataclass(frozen=True)
class Applied:
    """The effects that are on, and where they stand."""

    switched: tuple[Switched, ...]
    file: str
    problems: list[Problem]
    """What hinders them goes here."""

    def hand(self, loaded: Loaded, finger: str) -> Loaded:
        """`loaded` as it really is; `finger` must still be one that can be made."""
        hand: Hand = self._each(loaded.hand, lambda one, now: one.effect.on_hand(now, one.parameters))
        if hand is loaded.hand:
            return loaded
        found: list[fault.Fault] = []
        try:
            hand = Hand.model_validate(hand.model_dump(by_alias=True))
        except ValidationError as error:
            found = list(explain.faults(Hand, error))
        if not found and (mine := hand.fingers.present().get(finger)):
            found = list(relations.curl(mine, ("fingers", finger)))
        self.problems.extend(
            Problem(self.file, "effects", one.value, f"{fault.text(one.path)} {one.message}", one.allowed)
            for one in found)
        return replace(loaded, hand=hand)

    def model(self, model: BendModel) -> BendModel:
        return self._each(model, lambda one, now: one.effect.on_model(now, one.parameters))

    def chamber(self, gauge: Sequence[float]) -> list[float]:
        """kPa that the chamber really sees where the gauge says `gauge`."""
        return self._each(list(gauge), lambda one, now: list(one.effect.on_pressures(now, one.parameters)))

    def case(self, case: Case, course: Course) -> Case:
        """`case`, whose chamber sees what `course` says."""
        if case.part != "exoskeleton":
            case = replace(case, softening=self._softening(course))
        return self._each(case, lambda one, now: one.effect.on_case(now, one.parameters))

    def _softening(self, course: Course) -> tuple[float, ...]:
        """Share of the silicone's stiffness that all effects together take at every reading; empty: none."""
        left = [1.0] * len(course.pressures)
        for one in self.switched:
            lost = one.effect.on_course(course, one.parameters)
            left = [a * (1.0 - b) for a, b in zip(left, lost, strict=True)]
        return tuple(1.0 - share for share in left) if any(share != 1.0 for share in left) else ()

    def _each(self, given: T, change: Callable[[Switched, T], T]) -> T:
        """`given`, changed by one effect after the other; one that cannot becomes a problem."""
        for i, one in enumerate(self.switched):
            try:
                given = change(one, given)
            except ValueError as error:
                self.problems.append(Problem(self.file, f"effects[{i}]", one.effect.id, str(error)))
        return given


def read(curve: Curve, case: Case, switched: Sequence[Switched], gauge: Sequence[float]) -> Curve:
    """`curve` of `case` as it is read: pressures as the `gauge` (MPa) says them, and readings off the finger.

    Pressures in words (where a curve stopped) stay those of the chamber.
    """
    if not switched:
        return curve
    bare = case.part == "exoskeleton"
    said = [state.pressure for state in curve.states] if bare else gauge
    states = [replace(state, pressure=pressure) for state, pressure in zip(curve.states, said, strict=True)]
    loads = [state.tip_load if bare else 1e3 * state.pressure for state in states]
    for name, unit in READ.items():
        values = [unit * getattr(s, name) if s.converged and getattr(s, name) is not None else None
                  for s in states]
        for effect, parameters in switched:
            values = effect.on_reading(name, loads, values, parameters)
        states = [state if value is None else replace(state, **{name: value / unit})
                  for state, value in zip(states, values, strict=True)]
    if bare:
        return replace(curve, states=tuple(states))
    order = np.argsort(case.pressures, kind="stable")
    chamber, shown = np.array(case.pressures)[order], np.array(gauge)[order]
    return replace(curve, states=tuple(states),
                   folds=tuple(float(np.interp(fold, chamber, shown)) for fold in curve.folds),
                   reached=max((s.pressure for s in states if s.converged), default=0.0))
