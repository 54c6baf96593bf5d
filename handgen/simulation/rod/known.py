"""What the rod was calibrated to: coefficients, the range they come from, and how far off it was."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from handgen.simulation.rod.chain import Chain

FILE = Path(__file__).with_name("known.json")
MARGIN = 1e-9


@dataclass(frozen=True)
class Known:
    """The contents of `known.json`."""

    coefficients: Mapping[str, float]
    range: Mapping[str, Sequence[float]]
    """Measure (see `measures`) -> its least and largest."""
    share: float
    """Half-width of the error as a share of the bend."""
    least: float
    """And what it is at least, rad."""
    outside: float
    """How many times as wide it is said to be beyond the range."""

    def beyond(self, chain: Chain, turns: np.ndarray, stretch: np.ndarray, pressure: float) -> list[str]:
        """Where a state lies outside the range, in words."""
        told = []
        found = {**measures(chain), **state_measures(chain, turns, stretch, pressure)}
        for name, (low, high) in found.items():
            least, most = self.range[name]
            if low < least - MARGIN or high > most + MARGIN:
                worst = low if low < least - MARGIN else high
                told.append(f"outside the rod's calibration: {name} {worst:.3g} ({least:.3g} to {most:.3g})")
        return told

    def error(self, bend: float, beyond: bool) -> float:
        """How far off a bend may be, rad: nine in ten are nearer."""
        return (self.share * abs(bend) + self.least) * (self.outside if beyond else 1.0)


def measures(chain: Chain) -> dict[str, tuple[float, float]]:
    """(least, largest) of what a finger is like, over its joints: numbers without unit, or degrees."""
    case = chain.case
    each = {
        "slot length over bore radius": chain.slot / chain.bore,
        "palmar arc, deg": np.degrees(chain.arc),
        "wall over bore radius": chain.wall / chain.bore,
        "rest angle, deg": np.degrees(chain.rest),
        "silicone's share of the thread's circle": (chain.wall_area / chain.pressed)[chain.at],
        "play over bore radius": (chain.bore - chain.outside) / chain.bore,
        "exoskeleton's over silicone's modulus": np.array(
            [case.tpu.law.shear_modulus / case.silicone.law.shear_modulus]),
        "friction": np.array([case.contact.friction]),
        "joints": np.array([float(chain.joints)]),
    }
    return {name: (float(np.min(v)), float(np.max(v))) for name, v in each.items()}


def state_measures(chain: Chain, turns: np.ndarray, stretch: np.ndarray,
                   pressure: float) -> dict[str, tuple[float, float]]:
    """The same of a state: `turns` of the joints with rest, rad."""
    strength = pressure / chain.case.silicone.law.shear_modulus
    return {"joint's angle, deg": (math.degrees(turns.min()), math.degrees(turns.max())),
            "actuator's stretch": (1.0, float(stretch.max())),
            "pressure over silicone's modulus": (0.0, strength)}


@cache
def known() -> Known:
    """As fitted."""
    return Known(**json.loads(FILE.read_text(encoding="utf-8"))["rod"])
