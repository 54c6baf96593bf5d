"""What to print with which profile, and how long it takes by the slicers, where `handgen slice` was run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

from handgen.geometry import csg
from handgen.geometry.casting import Setup
from handgen.geometry.part import Part
from handgen.parameters.model import Hand
from handgen.slicing import known
from handgen.slicing.profile import HAND, Profile, column, profile
from handgen.slicing.slice import printed

LETTERS = {"mould_a": "a", "mould_b": "b", "mould_base": "c", "core_large": "d", "core_small": "e",
           "suspender": "f", "plug": "g", "collar": "h"}
"""Of Figure 4.7."""
FIRST = "prusaslicer"
"""Whose mass counts where both slicers were run."""


@dataclass(frozen=True)
class Print:
    """One part to print."""

    part: Part
    number: str
    embossed: bool
    profile: Profile
    slices: dict[str, dict[str, Any]]
    """Slicer -> its row of slices.json, where that is of this part and these settings."""
    needed: bool
    """Single fingers are for trials, where there is a whole hand."""

    @property
    def slice(self) -> dict[str, Any] | None:
        return self.slices.get(FIRST) or next(iter(self.slices.values()), None)


def prints(hand: Hand, folder: Path) -> list[Print]:
    """All printed parts; what was sliced into `folder` for other parameters is passed over."""
    rows, listed = known.rows(hand, folder), printed(hand)
    found = []
    for name, part in listed.items():
        slices = {row["slicer"]: row for row in rows if row["part"] == name}
        texts = list(embossed(part.shape))
        number = texts[0] if texts else _number(hand, part)
        used = profile(hand.printing, column(part.role, name), part.role)
        needed = used.column != "finger" or HAND not in listed
        found.append(Print(part, number, bool(texts), used, slices, needed))
    return found


def embossed(value: object) -> Iterator[str]:
    """Every text that stands on a part, read from its shape."""
    if isinstance(value, csg.Text):
        yield value.text
    elif isinstance(value, tuple):
        for item in value:
            yield from embossed(item)
    elif is_dataclass(value):
        for one in fields(value):
            yield from embossed(getattr(value, one.name))


def total(chosen: list[Print]) -> tuple[float, float, int]:
    """(s, g, parts that were not sliced) of some prints."""
    rows = [one.slice for one in chosen]
    known = [row for row in rows if row]
    return (sum(row["print_time_s"] for row in known), sum(row["filament_g"] for row in known),
            len(rows) - len(known))


def least_hours(volume: float, of: Profile) -> float:
    """Hours that a nozzle needs for `volume` mm3, all filled and never travelling."""
    process = of.process
    return volume / process.rate * (process.infill_density / 100) / 3600


def _number(hand: Hand, part: Part) -> str:
    """By the scheme of what is embossed, for parts too small for letters."""
    if part.name == HAND or part.role not in LETTERS:
        return part.name.rsplit("/", 1)[-1]
    return Setup(hand, part.name.split("/")[1]).code + LETTERS[part.role]
