"""What a part is printed with, in no slicer's words: its column of Table B.1, its adhesion, its support."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from handgen.parameters.model import Hand
from handgen.parameters.process import ROLES, Printing, PrintProcess

HAND = "exoskeleton/hand"


@dataclass(frozen=True)
class Profile:
    """One print process with the adhesion and support of one kind of part."""

    column: str
    """`finger`, `hand` or `tooling`: the column of Table B.1."""
    process: PrintProcess
    adhesion: str
    support: str
    filament_diameter: float

    @property
    def name(self) -> str:
        """`hand`, `tooling-raft-support`: the column, then what differs from part to part within it."""
        if not (self.process.part_adhesion or self.process.part_support):
            return self.column
        marks = [self.adhesion] * (self.adhesion != "none") + ["support"] * (self.support != "none")
        return "-".join([self.column, *marks])

    @property
    def title(self) -> str:
        """For a slicer's list of presets."""
        return f"handgen {self.process.material} {self.name}"

    @property
    def solid_layers(self) -> int:
        """Solid layers below and above the infill."""
        return math.ceil(round(self.process.solid_thickness / self.process.layer_height, 6))

    @property
    def filament_area(self) -> float:
        """mm2."""
        return math.pi * self.filament_diameter**2 / 4

    def grams(self, length: float) -> float:
        """Mass, g, of `length` mm of filament."""
        return length * self.filament_area * self.process.density / 1000


def column(role: str, name: str) -> str | None:
    """The column of Table B.1 that prints a part; None: it is cast."""
    if role in ROLES["tooling"]:
        return "tooling"
    if role == "exoskeleton":
        return "hand" if name == HAND else "finger"
    return None


def profile(printing: Printing, of: str, role: str) -> Profile:
    """Of a part with `role` that column `of` prints."""
    process = getattr(printing, of)
    return Profile(of, process, process.part_adhesion.get(role, process.adhesion),
                   process.part_support.get(role, process.support), printing.filament_diameter)


def profiles(hand: Hand) -> list[Profile]:
    """Every profile that some part of a hand is printed with, each once."""
    pairs = ((of, role) for of, roles in ROLES.items() for role in roles)
    return unique(profile(hand.printing, of, role) for of, role in pairs)


def unique(found: Iterable[Profile]) -> list[Profile]:
    """Each profile once, in order of appearance."""
    return list({one.name: one for one in found}.values())
