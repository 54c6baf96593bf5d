"""What an effect is: a name, a sentence, parameters, and the few hooks by which it changes a simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from handgen.effects.course import Course
from handgen.effects.parameter import Parameter

if TYPE_CHECKING:
    from handgen.parameters.model import Hand
    from handgen.simulation.case import Case

Values = Mapping[str, float]
"""Parameters by name."""


class Effect:
    """A physical effect that a model may lack.

    A subclass states what follows and overrides only the hooks that it needs; each gets the effect's
    parameters as `p` and returns what it was given, changed. A hook may raise ValueError with the reason why
    this hand or model cannot have the effect. With every parameter at `null` all of them change nothing.
    """

    id: str
    name: str
    sentence: str
    """Names it; a format string over the parameters: "The gauge reads {offset:.1f} kPa too little"."""
    signature: str
    """Where it shows in the tests, and where it does not."""
    source: str
    """Section of the source thesis, or literature."""
    settle: str
    """The direct measurement that settles it."""
    settled_by: tuple[str, ...] = ()
    """Observables that are this measurement, where a test can be it."""
    parameters: tuple[Parameter, ...]
    told_by: Mapping[str, tuple[str, ...]] = MappingProxyType({})
    """Effects that show the same until a test goes a certain way (its `path`) or reads a certain thing:
    effect -> paths and observables that tell."""

    def on_hand(self, hand: Hand, p: Values) -> Hand:
        """The hand as it really is."""
        return hand

    def on_model(self, model: Any, p: Values) -> Any:
        """The model (`handgen.bending.model.BendModel`) as it should be."""
        return model

    def on_case(self, case: Case, p: Values) -> Case:
        """What the solver is given."""
        return case

    def on_pressures(self, kilopascals: Sequence[float], p: Values) -> Sequence[float]:
        """What the chamber really sees, kPa, where the gauge says `kilopascals`; never below 0."""
        return kilopascals

    def on_course(self, course: Course, p: Values) -> Sequence[float]:
        """Share of the silicone's stiffness that is lost at every reading."""
        return [0.0] * len(course.pressures)

    def on_reading(self, quantity: str, loads: Sequence[float], values: Sequence[float | None],
                   p: Values) -> Sequence[float | None]:
        """What is read (tip_drop mm, elongation mm, bend_angle deg, tip_force N, chamber_pressure kPa,
        force_angle deg) where `values` is true.

        None where a load was not reached.
        """
        return values

    # Over its parameters

    def null(self, p: Values) -> bool:
        """Whether `p` switch the effect off."""
        return all(p[one.name] == one.null for one in self.parameters)

    def filled(self, p: Values) -> dict[str, float]:
        """`p` with the usual value of every parameter that it leaves out, or else with none of it."""
        return {one.name: float(p.get(one.name, one.null if one.usual is None else one.usual))
                for one in self.parameters}

    def said(self, p: Values) -> str:
        """The sentence with its numbers."""
        return self.sentence.format(**self.filled(p))

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return {
            "id": self.id, "name": self.name, "sentence": self.sentence, "signature": self.signature,
            "source": self.source, "settle": self.settle,
            "parameters": [{
                "name": one.name, "unit": one.unit, "low": one.low, "high": one.high, "null": one.null,
                "usual": one.usual, "prior": {"kind": one.prior.kind, "numbers": list(one.prior.numbers)},
                "meaning": one.meaning} for one in self.parameters],
        }
