"""Which way the parts go when a scene is taken apart: as a maker would pull them, clear of one another."""

from __future__ import annotations

import numpy as np

from handgen.geometry.assembly import Seated
from handgen.geometry.part import Part
from handgen.parameters.model import OPPOSITION, Hand

BEYOND = {"collar": 20.0, "plug": 42.0}
"""How far beyond the fingertip the seals go, mm; the actuator goes behind them."""
ACTUATOR = 65.0
LIFT = 2.5
"""Way of the opposition's actuators in diameters of theirs."""
ASIDE = {"core_large": (0.0, 50.0, 0.0), "core_small": (0.0, 80.0, 0.0), "suspender": (-40.0, 0.0, 0.0),
         "mould_base": (35.0, 0.0, 0.0), "plug": (-95.0, 0.0, 0.0), "collar": (-70.0, 0.0, 0.0)}
"""Ways of the tooling in the actuator's frame, mm."""
HALVES = 75.0
"""Way of a mould's half, mm, to the side on which it lies."""
FINGER = (0.0, -50.0, 0.0)


def in_hand(hand: Hand, seated: Seated) -> np.ndarray:
    """In the hand's frame: actuators leave along their fingers, those of the opposition on the palm side."""
    kind, *_, last = seated.name.split("/")
    if kind == "exoskeleton":
        return np.zeros(3)
    name = last if kind == "actuators" else seated.name.split("/")[1]
    if name in OPPOSITION:
        lift = LIFT * getattr(hand.actuators, name).base_outer_diameter + BEYOND.get(last, ACTUATOR / 2)
        return np.array([0.0, 0.0, -lift])
    way = getattr(hand.fingers, name).outer_length + BEYOND.get(last, ACTUATOR)
    return way * np.array(seated.rotation)[:, 0] * (1.0, -1.0 if seated.mirrored else 1.0, 1.0)


def in_mould(part: Part, box: tuple) -> np.ndarray:
    """In the actuator's frame; a mould's half goes to the side on which it lies."""
    kind, *_, last = part.name.split("/")
    if kind == "exoskeleton":
        return np.array(FINGER)
    if last in ("mould_a", "mould_b"):
        middle = np.mean(box, axis=0)
        side = np.argmax(np.abs(middle[1:]))
        way = np.zeros(3)
        way[1 + side] = np.copysign(HALVES, middle[1 + side])
        return way
    return np.array(ASIDE.get(last, (0.0, 0.0, 0.0)))
