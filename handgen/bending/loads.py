"""What acts on a finger, as a command line or a notebook says it: pressures, weights, orientation, plane."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from handgen.bending.opposition import PART as OPPOSITION
from handgen.errors import Problem
from handgen.parameters.fault import nearest
from handgen.simulation.case import STANDARD_GRAVITY

COMMAND_LINE = "command line"
"""Where a wrong argument is reported, from a notebook too."""
LOADING, UNLOADING = "loading", "unloading"
Numbers = str | Iterable[float | str] | float | None
"""`0:100:10`, `0,20,40`, or a list."""

PRESSURES = "0:100:10"
HIGHEST = 150.0
"""kPa; half as much again as the source ever applied, and no law is fitted to what silicone does beyond."""
HEAVIEST = 5.0
"""N; nine times the source's largest weight."""
BEYOND = {"kPa": "is above the range that any silicone here is known for",
          "N": "is more than a finger holds"}
"""Why a number beyond these is refused."""
FARTHEST = 200.0
"""mm; beyond every finger's reach."""
POINTS = 1001
"""Most points of one curve."""

LOOSE = {"actuator": "an actuator on its own", OPPOSITION: "the section model of the thumb's hinge"}
"""Parts on which pressure alone acts."""
WEIGHTLESS = "weightless"
OFF_AXIS = "own weight takes an actuator off its axis, on which the solver revolution keeps it"
ORIENTATIONS = {
    "palm_down": (0.0, 0.0, -STANDARD_GRAVITY),
    "palm_up": (0.0, 0.0, STANDARD_GRAVITY),
    "sideways": (0.0, 0.0, 0.0),
    WEIGHTLESS: (0.0, 0.0, 0.0),
}
"""Gravity that acts in the plane of bending, mm/s2."""
SIDEWAYS = (
    "sideways: own weight acts across the plane of bending and is not in the model, which is one of half a"
    " finger; to first order it moves the finger sideways only; what is given is the bend within the plane")


class Faults(list[Problem]):
    """What is wrong with the arguments."""

    def say(self, option: str, value: object, message: str, allowed: str | None = None,
            suggestion: str | None = None) -> None:
        if isinstance(value, float) and not math.isfinite(value):
            value = str(value)
        self.append(Problem(COMMAND_LINE, option, value, message, allowed, suggestion))


def pressures(given: Numbers, part: str, faults: Faults, path: str = LOADING) -> tuple[float, ...]:
    """Those that are within range, kPa; a bare exoskeleton has none."""
    option = "--pressures"
    if part == "exoskeleton":
        if given is not None:
            faults.say(option, _shown(given), "a bare exoskeleton holds no pressure",
                       "leave it out; --tip-loads bends it")
        return (0.0,)
    found = _numbers(PRESSURES if given is None else given, option, faults)
    _in_order(found, option, "kPa", HIGHEST, faults, path)
    return tuple(number for number in found if 0.0 <= number <= HIGHEST)


def tip_loads(given: Numbers, part: str, orientation: str, faults: Faults,
              path: str = LOADING) -> tuple[float, ...]:
    """Weights that hang on the fingertip, N: many for a bare exoskeleton, else at most one."""
    option = "--tip-loads"
    if given is None:
        return (0.0,)
    found = _numbers(given, option, faults)
    _in_order(found, option, "N", HEAVIEST, faults, path)
    if part in LOOSE:
        faults.say(option, _shown(given), f"{LOOSE[part]} carries no weight",
                   "leave it out, or --part exoskeleton or assembly")
    elif part == "assembly" and len(found) > 1:
        faults.say(option, _shown(given), "an assembly bends under one weight at a time", "one weight, N")
    if orientation == "sideways" and any(found):
        faults.say(option, _shown(given), "on a hand that lies sideways it pulls across the plane of bending",
                   "--orientation palm_down, palm_up or weightless")
    return tuple(found)


def obstacle(given: float | str | None, part: str, faults: Faults) -> float | None:
    """Distance of a rigid plane below the palm side, mm."""
    if given is None:
        return None
    option, allowed = "--obstacle", f"a distance above 0, at most {FARTHEST:g} mm"
    number = _number(given)
    if number is None:
        faults.say(option, given, "is no number", allowed)
    elif not 0.0 < number <= FARTHEST:
        faults.say(option, number, "is no place for a plane", allowed)
    if part in LOOSE:
        faults.say(option, given, f"{LOOSE[part]} meets no plane", "leave it out")
    return number


def orientation(given: str, part: str, faults: Faults) -> tuple[float, float, float]:
    """Gravity, mm/s2."""
    option = "--orientation"
    if given not in ORIENTATIONS:
        faults.say(option, given, "there is none of this name", "one of " + ", ".join(ORIENTATIONS),
                   nearest(given, ORIENTATIONS))
        return ORIENTATIONS[WEIGHTLESS]
    if part == OPPOSITION and given != WEIGHTLESS:
        faults.say(option, given, "own weight is not in the section model of the hinge",
                   f"leave it out, or {WEIGHTLESS}")
    return ORIENTATIONS[given]


def _numbers(given: Numbers, option: str, faults: Faults) -> list[float]:
    """The numbers in `given`; none, and a fault, where it cannot be read."""
    words = [given] if isinstance(given, (int, float)) else given
    words = words.split(",") if isinstance(words, str) else [w for word in words for w in _split(word)]
    if any(isinstance(word, str) and ":" in word for word in words):
        if len(words) == 1:
            return list(_range(words[0], option, faults))
        faults.say(option, _shown(given), "a range stands alone", "start:end:step, or a list")
        return []
    found = [_number(word) for word in words]
    for word, number in zip(words, found, strict=True):
        if number is None:
            faults.say(option, str(word), "is no number", "start:end:step, or a list such as 0,20,40")
    if not found:
        faults.say(option, _shown(given), "names no point", "start:end:step, or a list such as 0,20,40")
    if len(found) > POINTS:
        faults.say(option, len(found), "are too many points", f"at most {POINTS}")
        return []
    return [number for number in found if number is not None]


def _split(word: float | str) -> Sequence[float | str]:
    return word.split(",") if isinstance(word, str) else [word]


def _range(text: str, option: str, faults: Faults) -> Iterator[float]:
    """`0:100:10`, both ends included."""
    parts = [_number(part) for part in text.split(":")]
    if len(parts) != 3 or not all(part is not None and math.isfinite(part) for part in parts):
        faults.say(option, text, "is no range", "start:end:step, such as 0:100:10")
        return
    start, end, step = parts
    if step <= 0.0 or end < start:
        faults.say(option, text, "should rise", "start:end:step with end >= start and step > 0")
        return
    steps = (end - start) / step
    if steps >= POINTS:
        faults.say(option, text, f"has {steps + 1:.0f} points", f"at most {POINTS}")
    elif abs(steps - round(steps)) > 1e-9 * max(1.0, steps):
        faults.say(option, text, f"steps of {step:g} from {start:g} do not meet {end:g}",
                   f"an end such as {start + math.floor(steps) * step:g}")
    else:
        yield from (start + i * step for i in range(round(steps) + 1))


def _in_order(found: Sequence[float], option: str, unit: str, most: float, faults: Faults, path: str) -> None:
    """Finite, within 0 to `most`; while loading each larger than the one before, while unloading smaller."""
    before = -math.inf
    for number in found:
        if not math.isfinite(number):
            faults.say(option, number, "is not finite", f"0 to {most:g} {unit}")
            continue
        if not 0.0 <= number <= most:
            faults.say(option, number, "is negative" if number < 0 else BEYOND[unit], f"0 to {most:g} {unit}")
        if path == LOADING and number <= before:
            faults.say(option, number, f"does not rise: it follows {before:g}",
                       f"{unit} in rising order, each once")
        if path == UNLOADING and number >= before > -math.inf:
            faults.say(option, number, f"does not fall: it follows {before:g}",
                       f"{unit} in falling order, each once")
        before = number


def _number(word: Any) -> float | None:
    try:
        return float(word)
    except (TypeError, ValueError):
        return None


def _shown(given: Numbers) -> str:
    return str(given) if isinstance(given, (str, int, float)) else " ".join(map(str, given or ()))
