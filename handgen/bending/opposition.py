"""The thumb's opposition against pressure: two actuators push against the palmar sheet (a section model).

Balance, energy and their derivation: `handgen.mechanics.hinge`, the same that the rule
`thumb.palm-stiffness` judges by, with the substances of the bend's model instead of the rule's limits. Its
sections are measured on the hand's mesh; the silicone is neo-Hookean through its law at a usual stretch.
Own weight, sockets that yield and whatever else touches the thumb are not in it. Held against tetrahedra of
large rotation (`tests/reference_thumb.py`, sheets of 2 and 4 mm, 20 to 115 kPa): within 2 % up to 45 degrees,
beyond that too far, by 3 % at 61 and 6 % at 72 degrees.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from handgen.materials.law import Law
from handgen.materials.states import PLANAR, nominal_stress
from handgen.mechanics.hinge import Pusher, balance
from handgen.simulation.case import Curve, State

PART = "opposition"
SOLVER = "section"
MOST_STRETCH, MOST_ANGLE = 1.45, math.radians(75.0)
"""Of the actuators on average, and of the thumb: as far as tetrahedra have confirmed the model."""
USUAL_STRETCH = 1.25
"""Of the actuators at which the neo-Hookean law of the section model meets the silicone's own."""
UNKNOWNS = 3
NO_WEIGHT = "opposition: angle of the thumb's hinge by a section model; own weight is not in it"


@dataclass(frozen=True)
class HingeCase:
    """The hinge under a row of pressures; stands where a `Case` does."""

    sheet: tuple[tuple[float, float, float], ...]
    """Flexibility of what joins thumb and palm (`mechanics.hinge.flexibility`)."""
    pushers: tuple[Pusher, ...]
    young: float
    """Of the sheet at small strain, MPa."""
    mu: float
    """Shear modulus of the neo-Hookean silicone, MPa."""
    pressures: tuple[float, ...]
    """MPa, ascending."""
    part: str = PART
    tip_loads: tuple[float, ...] = (0.0,)
    obstacle: None = None
    refine: int = 0


def secant_modulus(law: Law) -> float:
    """Shear modulus, MPa, of the neo-Hookean law that is as stiff as `law` at USUAL_STRETCH, circles held."""
    s = USUAL_STRETCH
    return float(nominal_stress(law, PLANAR, np.array(s))) / (s - s**-3)


def simulate(case: HingeCase, progress: Callable[[str], None] | None = None) -> Curve:
    """The opposition angle at every pressure; beyond the model's range a point does not converge."""
    say = progress or (lambda line: None)
    begun = time.perf_counter()
    states: list[State] = []
    reached, stopped, q = 0.0, "", None
    for pressure in case.pressures:
        if not stopped:
            try:
                q = balance(np.array(case.sheet), case.pushers, pressure, case.young, case.mu, q)
                stopped = _beyond(case, q)
            except ArithmeticError as error:
                stopped = str(error)
        if stopped:
            states.append(State(pressure, 0.0, False, note=stopped))
            continue
        states.append(_state(case, q, pressure))
        reached = pressure
        say(f"{1e3 * pressure:g} kPa: opposition {math.degrees(q[1]):.1f} degrees")
    return Curve(tuple(states), {}, reached, (), UNKNOWNS, 0, time.perf_counter() - begun, stopped)


def _state(case: HingeCase, q: np.ndarray, pressure: float) -> State:
    growth = np.array([q[0] + q[2] * p.at for p in case.pushers])
    length = np.array([p.free_length for p in case.pushers])
    outside = np.array([p.outside for p in case.pushers])
    # Every section turns alike: the wall's outer fibre on the dorsal side stretches most.
    stretch = 1.0 + (growth + math.hypot(q[1], q[2]) * outside) / length
    return State(pressure, 0.0, True, bend_angle=float(q[1]), elongation=float(growth.mean()),
                 max_stretch=float(stretch.max()), stretch={"actuator": stretch})


def _beyond(case: HingeCase, q: np.ndarray) -> str:
    """Why `q` lies outside the model's range; empty where it does not."""
    stretch = max(1.0 + (q[0] + q[2] * p.at) / p.free_length for p in case.pushers)
    if stretch > MOST_STRETCH:
        return f"the actuators stretch beyond the {MOST_STRETCH:g} that the section model is confirmed for"
    if q[1] > MOST_ANGLE:
        return (f"the thumb turns beyond the {math.degrees(MOST_ANGLE):g} degrees that the section model is "
                "confirmed for")
    return ""
