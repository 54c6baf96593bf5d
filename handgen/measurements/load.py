"""A measurements file -> validated tests with the hand they were made on, or every one of its errors."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from handgen.errors import InputError, Problem
from handgen.measurements.model import SCHEMA, UNITS, Measurements, Test
from handgen.parameters.fault import Fault, nearest
from handgen.parameters.load import Loaded, load
from handgen.parameters.single import load_single

OBSERVABLE = {
    "assembly": ("tip_drop", "bend_angle", "elongation", "tip_force", "force_angle"),
    "exoskeleton": ("tip_drop", "bend_angle", "tip_force"),
    "actuator": ("elongation", "bend_angle", "chamber_pressure"),
}
"""What can be read off each part."""
LOADS = {"assembly": ("pressure",), "exoskeleton": ("tip_load",), "actuator": ("pressure",)}
"""What each part can be loaded with, reading by reading."""


@dataclass(frozen=True)
class Measured:
    """Measurements and the hand that they were made on."""

    measurements: Measurements
    file: Path
    hand: Loaded

    def test(self, name: str) -> Test:
        """The test of this id.

        Raises:
            KeyError: there is none.
        """
        return {test.id: test for test in self.measurements.tests}[name]


def load_measurements(file: str | os.PathLike) -> Measured:
    """Read the measurements `file` and the hand it names.

    Raises:
        InputError: every error of the file, and of the hand's.
    """
    found = load_single(file, Measurements, SCHEMA, relate=_relations)
    path = Path(file)
    try:
        hand = load(path.parent / found.hand)
    except InputError as error:
        raise InputError([Problem(str(file), "hand", found.hand, "is no hand that can be used"),
                          *error.problems]) from None
    bendable = {name for test in found.tests for name in _fingers(hand, test)}
    if wrong := [test for test in found.tests if found.finger not in _fingers(hand, test)]:
        raise InputError([Problem(
            str(file), "finger", found.finger, f"the hand {hand.hand.name} has none for {wrong[0].id}",
            "one of " + ", ".join(sorted(bendable)), nearest(found.finger, bendable))])
    return Measured(found, path, hand)


def _fingers(hand: Loaded, test: Test) -> list[str]:
    parts = hand.hand.actuators if test.part == "actuator" else hand.hand.fingers
    return list(parts.present())


def _relations(found: Measurements) -> list[Fault]:
    """What is wrong between fields that are right by themselves."""
    faults = []
    for i, test in enumerate(found.tests):
        before = {other.id for other in found.tests[:i]}
        if test.id in before:
            faults.append(Fault(("tests", i, "id"), "is the id of an earlier test", test.id))
        for path, *rest in itertools.chain(_quantities(test), _order(test), _moments(test), _rows(test),
                                             _others(test)):
            faults.append(Fault(("tests", i, *path), *rest))
    return faults


def _quantities(test: Test) -> Iterator[tuple]:
    """(key path in the test, message, value, allowed): loads, observables and units that do not belong."""
    for key, part, valid in (("load", test.load, LOADS[test.part]),
                             ("observable", test.observable, OBSERVABLE[test.part])):
        if part.quantity not in valid:
            yield ((key, "quantity"), f"is nothing of a test of the {test.part}", part.quantity,
                   "one of " + ", ".join(valid))
        if part.unit != UNITS[part.quantity]:
            yield (key, "unit"), f"is no unit of {part.quantity}", part.unit, UNITS[part.quantity]
    force = test.observable.quantity in ("tip_force", "force_angle")
    if force and test.obstacle is None:
        yield ("obstacle",), "a fingertip force needs the plane it acts on", None, "a distance in mm"
    if test.obstacle is not None and test.part == "actuator":
        yield ("obstacle",), "an actuator on its own meets no plane", test.obstacle, "null"


def _order(test: Test) -> Iterator[tuple]:
    """Loads that do not rise on the way up or fall on the way down."""
    sign = {"loading": 1, "unloading": -1}.get(test.path, 0)
    for k, (a, b) in enumerate(itertools.pairwise(test.load.values), start=1):
        if sign and sign * (b - a) <= 0:
            word = "rise" if sign > 0 else "fall"
            yield ("load", "values", k), f"does not {word}: it follows {a:g}", b, f"{test.path} {word}s"


def _moments(test: Test) -> Iterator[tuple]:
    """Times that are too few or too many, or do not pass."""
    if test.times is None:
        return
    if len(test.times) != len(test.load.values):
        yield (("times",), f"has {len(test.times)} times", len(test.times),
               f"{len(test.load.values)}, one a load")
    for k, (a, b) in enumerate(itertools.pairwise(test.times), start=1):
        if b <= a:
            yield ("times", k), f"does not come later: it follows {a:g}", b, "s, rising"


def _rows(test: Test) -> Iterator[tuple]:
    """Repeats that do not fit the loads."""
    wanted = len(test.load.values)
    for k, row in enumerate(test.repeats):
        if len(row) != wanted:
            yield (("repeats", k), f"has {len(row)} readings", len(row),
                   f"{wanted}, one a load; null where one is missing")
    if all(reading is None for row in test.repeats for reading in row):
        yield ("repeats",), "holds no reading at all", None, "at least one number"


def _others(test: Test) -> Iterator[tuple]:
    for k, other in enumerate(test.simulated):
        if len(other.loads) != len(other.values):
            yield (("simulated", k, "values"), f"has {len(other.values)} values", len(other.values),
                   f"{len(other.loads)}, one a load")
