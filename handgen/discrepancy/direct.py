"""Checks that need no test of a finger: data sheet against law, balance against model, stability, own
weight."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from handgen.bending.model import BendModel, Choice
from handgen.discrepancy.convention import OTHER, stress
from handgen.materials import library, stability
from handgen.materials.sets import ParameterSet, Reading
from handgen.measurements.model import Measurements, Weighed
from handgen.parameters.model import Hand

OFF = 1.25
"""Ratio of a law's stress and the bulletin's from which it is flagged: batches scatter by 10 to 20 %."""
LIGHT = 0.05
"""Share of a weighed mass that a model may be off."""
POSED = 0.99
"""Probability that a part hung as its test says: own weight acts on all that nothing carries."""
USED = 1.5
"""Nominal strain up to which a law must be a possible material."""
HANGING = ("palm_down", "palm_up")
"""Orientations in which own weight bends a finger."""
SMALL = 0.1
"""Nominal strain at which two laws that agree at 100 % are compared."""


@dataclass(frozen=True)
class Finding:
    """What a direct check found wrong."""

    check: Literal["datasheet", "mass", "stability", "weight"]
    subject: str
    effect: str | None
    """Effect of the catalogue that it points to."""
    message: str
    probability: float | None = None
    """That the effect is missing, where the check itself shows it; None: the check only points to it."""

    def __str__(self) -> str:
        return f"{self.check}: {self.effect or self.subject}: {self.message}"


def materials(hand: Hand) -> dict[str, str]:
    """Body -> its material."""
    return {"exoskeleton": (hand.printing.hand if hand.palm else hand.printing.finger).material,
            "actuator": hand.casting.silicone.name}


def findings(model: BendModel, hand: Hand, measurements: Measurements) -> list[Finding]:
    """All that is wrong with the materials that `hand` is made of, and with what was weighed."""
    bodies = materials(hand)
    found: list[Finding] = list(_weightless(model, measurements))
    for body, material in bodies.items():
        if (choice := model.materials.get(material)) is not None:
            found += _of_set(material, choice)
            found += [finding for one in measurements.weighed if body in one.what
                      for finding in _mass(one, material, choice)]
    return found


def _weightless(model: BendModel, measurements: Measurements) -> Iterator[Finding]:
    """Own weight that a model leaves out where nothing carries the part."""
    for part, share in model.own_weight.model_dump().items():
        tests = [test.id for test in measurements.tests if test.part == part and test.orientation in HANGING]
        if share < 1.0 - LIGHT and tests:
            yield Finding("weight", part, "own_weight", (
                f"{model.name} lets {100 * share:.0f} % of the {part}'s own weight act; nothing carried it "
                f"in "
                + ", ".join(tests)), POSED)


def _of_set(material: str, choice: Choice) -> Iterator[Finding]:
    known = library.library().materials
    readings = known[material].readings if material in known else ()
    yield from _datasheet(material, choice, readings)
    law = choice.parameters.build()
    steady = stability.stable_up_to(law, USED)
    if steady < USED:
        yield Finding("stability", choice.name, "uniaxial_only_law", (
            f"{choice.name} is no possible material beyond {100 * steady:.0f} % strain: "
            f"{stability.failures(law, USED)[0]}"))


def _datasheet(material: str, choice: Choice, readings: tuple[Reading, ...]) -> Iterator[Finding]:
    """The set itself, and what it was tuned from: a tuning hides what it started with."""
    if not readings:
        return
    line = list(_lineage(choice))
    for name, parameters in line:
        wrong = _misread(name, parameters, readings)
        if wrong is None:
            continue
        if parameters is not line[0][1]:
            wrong += _inherited(choice, parameters, readings)
        yield Finding("datasheet", material, "wrong_convention", wrong)
        return
    for reading in readings:
        ratio = stress(choice.parameters.build(), reading) / reading.megapascals
        if not 1 / OFF < ratio < OFF:
            yield Finding("datasheet", material, None, (
                f"{choice.name} gives {ratio:.2f} times the bulletin's {_said(reading)}"
                + (f"; it was tuned from {choice.parameters.tuned_from}, on tests of a finger: it may hide "
                   "something that is missing" if choice.parameters.tuned_from else "")))


def _lineage(choice: Choice) -> Iterator[tuple[str, ParameterSet]]:
    """The set, then what it was tuned from, and so on."""
    name, found = choice.name, choice.parameters
    seen = set()
    while found is not None and name not in seen:
        yield name, found
        seen.add(name)
        name = found.tuned_from
        found = library.library().sets.get(name) if name else None


def _misread(name: str, parameters: ParameterSet, readings: tuple[Reading, ...]) -> str | None:
    """Why the set's constants belong to the other of Ogden's conventions; None if they do not."""
    if parameters.convention is None:
        return None
    other = OTHER[parameters.convention]
    for reading in readings:
        own = stress(parameters.build(), reading)
        read = stress(parameters.build(other), reading)
        if abs(_log(own, reading)) > np.log(OFF) and abs(_log(read, reading)) < np.log(OFF):
            return (f"{name}, read in {parameters.convention}, gives {1e3 * own:.1f} kPa where the bulletin "
                    f"says {_said(reading)}: {own / reading.megapascals:.1f} times as much; read in {other} "
                    f"{1e3 * read:.1f} kPa. Its constants belong to the other convention")
    return None


def _inherited(choice: Choice, parent: ParameterSet, readings: tuple[Reading, ...]) -> str:
    """What a tuning that started from a misread set made of it."""
    law, meant = choice.parameters.build(), parent.build(OTHER[parent.convention])
    reading = max(readings, key=lambda one: one.strain)
    small = Reading(strain=SMALL, stress=1.0, unit="MPa", source=reading.source)
    there = stress(law, reading) / reading.megapascals - 1
    return (f". {choice.name} was tuned from it in the same convention: {100 * there:+.0f} % at "
            f"{100 * reading.strain:.0f} % strain, but {stress(law, small) / stress(meant, small):.1f} "
            f"times as "
            f"stiff at {100 * SMALL:.0f} % as those constants are in their own")


def _log(value: float, reading: Reading) -> float:
    return float(np.log(value / reading.megapascals)) if value > 0 else np.inf


def _said(reading: Reading) -> str:
    what = "as modulus" if reading.strain == 0.0 else f"at {100 * reading.strain:.0f} % strain"
    stress = reading.megapascals
    return f"{stress:.3g} MPa {what}" if stress >= 1.0 else f"{1e3 * stress:.1f} kPa {what}"


def _mass(weighed: Weighed, material: str, choice: Choice) -> Iterator[Finding]:
    """What the model makes of a part that was weighed."""
    density = choice.density
    if weighed.volume is None or density is None:
        return
    modelled = 1e9 * density * weighed.volume
    if abs(modelled / weighed.mass - 1) > LIGHT:
        light = modelled > weighed.mass
        yield Finding("mass", weighed.what, "print_porosity" if light else None, (
            f"{weighed.what} weighs {weighed.mass:g} g; {material} of {1e12 * density:.0f} kg/m3 in its "
            f"volume "
            f"of {weighed.volume:g} cm3 would be {modelled:.0f} g"))
