"""What every model leaves open: stiffness of both materials, the gauge's offset, where a ruler's zero is.

Physical priors, none of them flat: a material's batch and print, the gauge's data sheet, how well a lab lays
a ruler. The first two belong to the model (a re-tuned model file has them), the others to the measurement.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from handgen.effects.laws import softened
from handgen.measurements.model import Test
from handgen.simulation.case import Case

STIFFNESS = {"exoskeleton": 0.25, "actuator": 0.15}
"""Standard deviation of the logarithm. TPU: moduli of sets 1 to 3 of Table 5.5, print density; silicone:
batch and mixing, the bulletin's 12 psi against sets of the literature."""
STEP = 0.5
"""Of the finite differences, in standard deviations."""
GAUGE = 1.0
"""kPa, where a measurements file states no `sensor.pressure_sigma`."""
ZERO = {"tip_drop": 1.0, "elongation": 0.25, "bend_angle": 1.0, "tip_force": 0.01, "chamber_pressure": 0.5,
        "force_angle": 3.0}
"""Standard deviation of where a reading's zero lies: mm, mm, deg, N, kPa, deg. A manometer of class 0.6 over
100 kPa; a protractor on a photograph."""


@dataclass(frozen=True)
class Nuisance:
    """One of them. `target`: body of a stiffness, kind of reading of a zero, nothing of the gauge."""

    kind: Literal["stiffness", "gauge", "zero"]
    target: str
    sigma: float

    @property
    def name(self) -> str:
        return f"{self.kind} {self.target}".strip()

    def moves(self, test: Test) -> bool:
        """Whether it changes what `test` reads."""
        if self.kind == "gauge":
            return test.load.quantity == "pressure"
        if self.kind == "stiffness":
            return test.part in (self.target, "assembly")
        return self.target == f"{test.part} {test.observable.quantity}"

    def applied(self, case: Case, value: float) -> Case:
        """`case` with the nuisance at `value`; a zero changes no case, a vented chamber no gauge."""
        if self.kind == "gauge":
            moved = tuple(max(p + 1e-3 * value, 0.0) if p else 0.0 for p in case.pressures)
            return replace(case, pressures=moved)
        if self.kind == "stiffness":
            return stiffened(case, self.target, value)
        return case


def stiffened(case: Case, body: str, logarithm: float) -> Case:
    """`case` with all stresses of one body's material times exp(`logarithm`)."""
    import math

    name = "tpu" if body == "exoskeleton" else "silicone"
    substance = getattr(case, name)
    if substance is None or logarithm == 0.0:
        return case
    return replace(case, **{name: softened(substance, math.exp(logarithm))})


def nuisances(tests: list[Test]) -> list[Nuisance]:
    """All that move any of `tests`."""
    gauges = [test.sensor.pressure_sigma for test in tests if test.sensor.pressure_sigma is not None]
    kinds = dict.fromkeys((test.part, test.observable.quantity) for test in tests)
    found = [Nuisance("stiffness", body, sigma) for body, sigma in STIFFNESS.items()]
    found.append(Nuisance("gauge", "", max(gauges, default=GAUGE)))
    found += [Nuisance("zero", f"{part} {quantity}", ZERO[quantity]) for part, quantity in kinds]
    return [one for one in found if any(one.moves(test) for test in tests)]
