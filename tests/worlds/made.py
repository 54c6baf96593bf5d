"""Fingers as they come out of printer and mould, and gauges and rulers as a lab has them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tests.worlds.effects import stressed
from tests.worlds.finger import Finger, calibrated
from tests.worlds.world import Moment, State, World

SHAPE = 0.10
"""Geometry and stiffness lie within so much of what was drawn."""
GAUGE = 3.5
"""Of the pressure gauge, kPa, one standard deviation (MPX4250AP, over its range)."""
REFERENCE = 0.5
"""Of where a ruler's zero lies, mm, one standard deviation."""


def made(rng: np.random.Generator, tolerance: float = 1.0) -> Finger:
    """The finger near the solid model's with everything within `tolerance` times its tolerance.

    Widths, thicknesses, slots and moduli within 10 %; the length 1 %; places of joints 1 mm; rest angle 2
    degrees.
    """
    drawn = calibrated()

    def near(share: float = SHAPE) -> float:
        """A factor: triangular, most often near 1, never farther off than the tolerance."""
        return 1.0 + tolerance * share * rng.triangular(-1.0, 0.0, 1.0)

    print_modulus, pour_modulus, wall = near(), near(), near()
    bore, core, size = near(0.05), near(0.05), near(0.01)
    slots = tuple(s * near() for s in drawn.slots)
    return replace(
        drawn,
        length=drawn.length * size, bore=drawn.bore * size,
        joints=tuple(size * j + tolerance * rng.triangular(-1, 0, 1) for j in drawn.joints),
        slots=slots,
        curls=tuple(c + tolerance * math.radians(2.0) * rng.triangular(-1, 0, 1) / (1 + 2 * (i > 0))
                    for i, c in enumerate(drawn.curls)),
        strip=drawn.strip * print_modulus * near(), first=drawn.first * near(0.05), bone=drawn.bone * near(),
        arm=drawn.arm * bore, offset=drawn.offset * bore, tip_radius=drawn.tip_radius * near(0.02),
        area=drawn.area * core**2, beam=drawn.beam * pour_modulus * wall,
        wall=stressed(drawn, pour_modulus * wall / core**2), active=drawn.active * size * near(0.02),
        shell_mass=drawn.shell_mass * near(), tube_mass=drawn.tube_mass * near(),
        tip_mass=drawn.tip_mass * near())


def lab(rng: np.random.Generator, tolerance: float = 1.0) -> World:
    """A finger as it was made in a lab that has a gauge and a ruler."""
    off = tolerance * GAUGE * float(np.clip(rng.standard_normal(), -2.5, 2.5))
    zeros = {part: tolerance * REFERENCE * rng.standard_normal() for part in ("exoskeleton", "assembly")}

    def gauge(kilopascals: float, moment: Moment) -> float:
        return max(kilopascals + off, 0.0) if kilopascals > 0.0 else 0.0

    def ruler(value: float, moment: Moment, state: State) -> float:
        return value + zeros[moment.test.part] if moment.test.quantity == "tip_drop" else value

    return World(made(rng, tolerance)).then(chamber=gauge, read=ruler)
