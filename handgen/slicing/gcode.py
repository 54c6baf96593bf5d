"""What a G-code file tells a printer to do: every line that is drawn, every temperature, every retraction.

Reads the dialect that PrusaSlicer and CuraEngine share (absolute or relative, straight lines, `;TYPE:`
comments); nothing is taken from the settings that slicers list at the end.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from handgen.errors import EngineError

KINDS = ("outer wall", "inner wall", "infill", "solid infill", "support", "adhesion", "other")
OUTER, INNER, INFILL, SOLID, SUPPORT, ADHESION, OTHER = range(len(KINDS))
TYPES = {
    # PrusaSlicer
    "External perimeter": OUTER, "Perimeter": INNER, "Internal infill": INFILL, "Solid infill": SOLID,
    "Top solid infill": SOLID, "Support material": SUPPORT, "Support material interface": SUPPORT,
    "Skirt/Brim": ADHESION, "Skirt": ADHESION, "Overhang perimeter": OTHER, "Bridge infill": OTHER,
    "Gap fill": OTHER, "Custom": OTHER,
    # CuraEngine
    "WALL-OUTER": OUTER, "WALL-INNER": INNER, "FILL": INFILL, "SKIN": SOLID, "SUPPORT": SUPPORT,
    "SUPPORT-INTERFACE": SUPPORT, "SKIRT": ADHESION,
}
"""What the slicers call the lines, and which of KINDS they are; bridges and gaps have widths of their own."""
ROUND = 4
"""Decimals of a height, mm, by which lines belong to one layer."""


@dataclass
class Toolpath:
    """Every drawn line of a file; lengths in mm, feeds in mm/s, temperatures in degC."""

    kind: np.ndarray
    start: np.ndarray
    end: np.ndarray
    z: np.ndarray
    filament: np.ndarray
    """Length of filament pushed through."""
    feed: np.ndarray
    retractions: np.ndarray
    """Lengths of filament drawn back."""
    pushed: float
    """Length of filament that leaves the file for good."""
    nozzle: frozenset[float]
    bed: frozenset[float]

    @cached_property
    def length(self) -> np.ndarray:
        return np.hypot(*(self.end - self.start).T)

    @cached_property
    def heights(self) -> np.ndarray:
        """Every height at which something is drawn, rising."""
        return np.unique(self.z)

    @cached_property
    def layer(self) -> np.ndarray:
        """Index of each line into `heights`."""
        return np.searchsorted(self.heights, self.z)

    def of(self, *kinds: int) -> np.ndarray:
        """Which lines are of these kinds."""
        return np.isin(self.kind, kinds)


@dataclass
class _Head:
    """The print head as it reads along."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    e: float = 0.0
    feed: float = 0.0
    relative: bool = False
    e_relative: bool = False
    kind: int = OTHER
    pushed: float = 0.0
    lines: dict[str, array] = field(default_factory=lambda: {
        key: array("d") for key in ("kind", "x0", "y0", "x1", "y1", "z", "e", "feed")})
    retractions: array = field(default_factory=lambda: array("d"))
    nozzle: set[float] = field(default_factory=set)
    bed: set[float] = field(default_factory=set)


def read(path: Path) -> Toolpath:
    """The toolpath in a file.

    Raises:
        EngineError: the file draws nothing, or holds a kind of line that is not known.
    """
    head = _Head()
    with open(path, encoding="utf-8", errors="replace") as file:
        _follow(head, file, path)
    found = {key: np.frombuffer(values) if values else np.zeros(0) for key, values in head.lines.items()}
    if not len(found["e"]):
        raise EngineError(f"{path.name} draws nothing")
    return Toolpath(
        found["kind"].astype(np.int8), np.c_[found["x0"], found["y0"]], np.c_[found["x1"], found["y1"]],
        found["z"].round(ROUND), found["e"], found["feed"] / 60, np.array(head.retractions), head.pushed,
        frozenset(head.nozzle), frozenset(head.bed))


def _follow(head: _Head, lines: Iterable[str], path: Path) -> None:
    for line in lines:
        if line.startswith(("G1 ", "G0 ")):
            _move(head, line)
        elif line.startswith(";TYPE:"):
            name = line[6:].strip()
            if name not in TYPES:
                raise EngineError(f"{path.name} holds lines of the unknown type {name!r}")
            head.kind = TYPES[name]
        elif line[:1] in "GM":
            _command(head, line)


def _move(head: _Head, line: str) -> None:
    x, y, e = head.x, head.y, None
    for word in line.split(";", 1)[0].split()[1:]:
        letter, value = word[0], float(word[1:])
        if letter == "X":
            x = value + head.x * head.relative
        elif letter == "Y":
            y = value + head.y * head.relative
        elif letter == "E":
            e = value
        elif letter == "F":
            head.feed = value
        elif letter == "Z":
            head.z = value + head.z * head.relative
    if e is not None:
        step = e if head.e_relative else e - head.e
        head.e += step
        head.pushed += step
        if step > 0 and (x != head.x or y != head.y):
            for key, value in (("kind", head.kind), ("x0", head.x), ("y0", head.y), ("x1", x), ("y1", y),
                               ("z", head.z), ("e", step), ("feed", head.feed)):
                head.lines[key].append(value)
        elif step < 0:
            head.retractions.append(-step)
    head.x, head.y = x, y


def _command(head: _Head, line: str) -> None:
    words = line.split(";", 1)[0].split()
    if not words:
        return
    values = {word[0]: float(word[1:]) for word in words[1:] if word[1:].replace(".", "").isdigit()}
    if words[0] in ("M104", "M109") and values.get("S"):
        head.nozzle.add(values["S"])
    elif words[0] in ("M140", "M190") and values.get("S"):
        head.bed.add(values["S"])
    elif words[0] == "G92" and "E" in values:
        head.e = values["E"]
    elif words[0] in ("G90", "G91"):
        head.relative = head.e_relative = words[0] == "G91"
    elif words[0] in ("M82", "M83"):
        head.e_relative = words[0] == "M83"
