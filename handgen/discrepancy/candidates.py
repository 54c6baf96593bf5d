"""Tests that a lab with these set-ups could do next: another reading, another way up, the way back, a second
instrument."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from handgen.measurements.model import Test

SAME = ("part", "orientation", "path", "obstacle")
SIGMAS = {"tip_drop": 0.5, "elongation": 0.25, "bend_angle": 1.0, "tip_force": 0.01, "chamber_pressure": 0.3,
          "force_angle": 2.0}
"""Of the mean of three repeats, as the source's scatter: mm, mm; a protractor on a photograph, deg; a
balance, N; a manometer, kPa; the force's direction on a photograph, deg."""
HOLD = (0.0, 60.0, 300.0, 900.0, 1800.0)
"""s at which a held load is read."""
PREFIX = "ask-"


def candidates(tests: Sequence[Test]) -> list[Test]:
    """What is not among `tests` yet, the cheapest first."""
    done = {_key(test) for test in tests}
    found: dict[tuple, Test] = {}
    for test in tests:
        for one in _around(test):
            key = _key(one)
            if key not in done and key not in found:
                found[key] = one
    return list(found.values())


def _around(test: Test) -> Iterator[Test]:
    """Tests on the set-up of `test`."""
    if test.path != "loading":
        return
    if test.obstacle is not None:
        if test.observable.quantity == "tip_force":
            yield _like(test, "force_angle", "deg")
    elif test.part == "assembly":
        yield _like(test, "bend_angle", "deg")
        yield _like(test, "tip_drop", "mm", orientation="palm_up")
        yield _like(test, "tip_drop", "mm", path="unloading", loads=test.load.values[::-1])
        yield _like(test, "tip_drop", "mm", path="hold", loads=[_middle(test)] * len(HOLD), times=list(HOLD))
    elif test.part == "exoskeleton":
        yield _like(test, "tip_drop", "mm", orientation="palm_up")
    else:
        yield _like(test, "bend_angle", "deg")
        yield _like(test, "chamber_pressure", "kPa")
        yield _like(test, "elongation", "mm", path="unloading", loads=test.load.values[::-1])
        yield _like(
            test, "elongation", "mm", path="hold", loads=[_middle(test)] * len(HOLD), times=list(HOLD)
        )


def _middle(test: Test) -> float:
    return test.load.values[len(test.load.values) // 2]


def _like(
    test: Test,
    quantity: str,
    unit: str,
    *,
    orientation: str | None = None,
    path: str = "loading",
    loads: Sequence[float] | None = None,
    times: list[float] | None = None,
) -> Test:
    orientation = orientation or test.orientation
    loads = list(loads or test.load.values)
    changes: dict[str, Any] = {
        "id": f"{PREFIX}{test.part}-{quantity}-{orientation}-{path}".replace("_", "-"),
        "title": "",
        "note": "",
        "simulated": [],
        "orientation": orientation,
        "path": path,
        "load": test.load.model_copy(update={"values": loads}),
        "times": times,
        "observable": test.observable.model_copy(update={"quantity": quantity, "unit": unit}),
        "repeats": [[None] * len(loads)],
        "held_out": False,
        "fit_up_to": None,
    }
    return test.model_copy(update=changes)


def _key(test: Test) -> tuple:
    return (*(getattr(test, name) for name in SAME), test.observable.quantity)


def words(test: Test) -> str:
    """One line for people."""
    quantity = {
        "tip_drop": "the tip's drop",
        "elongation": "the actuator's elongation",
        "bend_angle": "the angle of the fingertip",
        "tip_force": "the fingertip's force",
        "chamber_pressure": "a manometer at the inlet",
        "force_angle": "the direction of the fingertip's force, on a photograph from the side,",
    }
    what = {
        "assembly": "finger with its actuator",
        "exoskeleton": "bare exoskeleton",
        "actuator": "free actuator",
    }
    loads = sorted(set(test.load.values))
    span = f"at {loads[0]:g}" if len(loads) == 1 else f"{test.load.values[0]:g} to {test.load.values[-1]:g}"
    return (
        f"read {quantity[test.observable.quantity]} of the {what[test.part]}, "
        f"{test.orientation.replace('_', ' ')}, "
        f"{test.path}, {span} {test.load.unit}"
    )
