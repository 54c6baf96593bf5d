"""Table B.1 row by row, read back from the G-code of a part: what was asked and what the printer is told."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from handgen.slicing.gcode import ADHESION, INFILL, INNER, OUTER, SOLID, SUPPORT, Toolpath
from handgen.slicing.profile import Profile

TOLERANCE = {"layer height": 0.0015, "nozzle size": 0.01, "printing speed": 0.05, "flow": 1.0,
             "infill density": 1.0}
"""Of a number from the asked one, in the row's unit: G-code is rounded to um."""
FULL = 5.0
"""Per cent by which full infill may fill more or less than the part: where lines meet, they overlap."""
DIAGONALS = math.pi / 4, 3 * math.pi / 4
"""Directions of both slicers' grids and lines, rad."""
DIAGONAL = math.radians(1.0)
"""How far a line may lie from them."""
MOSTLY = 0.8
"""Share of the infill's length that lies on the diagonals in a grid or lines, and does not if concentric."""
SEVERAL = 4
"""Lines of infill in a layer below which nothing is said of their pattern."""
WALLED = 0.1
"""Share of the layers from which a number of walls counts."""
BRIM_LOOPS = 3
"""Loops on the first layer from which a skirt is a brim."""
SAMPLED = 24
"""Layers on which distances between lines are measured."""


@dataclass(frozen=True)
class Row:
    """`equal` is None where a part has nothing that the row speaks of."""

    row: str
    unit: str
    asked: Any
    found: Any
    equal: bool | None

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def compare(profile: Profile, path: Toolpath, volume: float) -> list[Row]:
    """Every row of the profile's column of Table B.1 against a part's G-code.

    `volume` is the part's, mm3: full infill is told by how much of it is filled.
    """
    asked, read = profile.process, _Reading(profile, path)
    return [
        _single("nozzle temperature", "degC", asked.nozzle_temperature, path.nozzle),
        _number("nozzle size", "mm", asked.nozzle_size, read.line_width()),
        _number("printing speed", "mm/s", asked.speed, read.speed()),
        _same("infill pattern", asked.infill_pattern, read.pattern()),
        read.density_row(volume),
        _number("layer height", "mm", asked.layer_height, read.layer_height()),
        _same("adhesion", profile.adhesion, read.adhesion()),
        _number("flow", "%", asked.flow, read.flow()),
        _support(profile.support, read.supported()),
        _same("retraction", asked.retraction, read.retracts()),
        _single("heated bed", "degC", asked.heated_bed, path.bed),
        _walls(asked.walls, read.walls()),
    ]


def _number(row: str, unit: str, asked: float, found: float | None) -> Row:
    equal = None if found is None else bool(abs(found - asked) <= TOLERANCE[row])
    return Row(row, unit, asked, None if found is None else round(float(found), 4), equal)


def _same(row: str, asked: Any, found: Any) -> Row:
    return Row(row, "", asked, found, None if found is None else found == asked)


def _single(row: str, unit: str, asked: float | None, found: frozenset[float]) -> Row:
    """The only temperature that is ever commanded, or none at all."""
    values = sorted(found)
    return Row(row, unit, asked, values[0] if len(values) == 1 else values or None,
               values == ([] if asked is None else [asked]))


def _support(asked: str, found: bool) -> Row:
    """A part may need none of the support that it is allowed."""
    return Row("support", "", asked, "some" if found else "none", not found if asked == "none" else True)


def _walls(asked: int, found: int | None) -> Row:
    """Where a part is thin, fewer have room: that says nothing."""
    return Row("walls", "", asked, found, None if found is None or found < asked else found == asked)


class _Reading:
    """What a toolpath says of the settings behind it."""

    def __init__(self, profile: Profile, path: Toolpath):
        self.profile, self.path = profile, path
        self.height = profile.process.layer_height
        walls = path.of(OUTER)
        if not walls.any():
            walls = path.of(OUTER, INNER, SOLID, INFILL)
        self.first = float(path.z[walls].min()) if walls.any() else float(path.heights[0])
        """Height of the part's own first layer."""

    def layer_height(self) -> float | None:
        """Between one layer of walls and the next, where all agree; else the farthest off."""
        steps = np.diff(np.unique(self.path.z[self.path.of(OUTER)]))
        steps = steps[steps < 1.5 * self.height]
        return None if not len(steps) else float(steps[np.abs(steps - self.height).argmax()])

    def flow(self) -> float | None:
        """Per cent of what a line as wide as the nozzle holds: the median over the walls' length."""
        walls = self.path.of(OUTER, INNER) & (self.path.length > 0.2)
        if not walls.any():
            return None
        full = self.height * self.profile.process.nozzle_size
        area = self.path.filament[walls] * self.profile.filament_area / self.path.length[walls]
        return 100 * float(_median(area, self.path.length[walls])) / full

    def line_width(self) -> float | None:
        """From the distance of an inner wall to the outer wall beside it."""
        found = [gap for layer in self._sample(OUTER, INNER) for gap in self._gaps(layer)]
        return None if len(found) < 5 else _mode(np.array(found), 0.002)

    def _gaps(self, layer: int) -> np.ndarray:
        from shapely import STRtree, linestrings, points

        here = self.path.layer == layer
        outer, inner = (np.flatnonzero(here & self.path.of(kind)) for kind in (OUTER, INNER))
        lines = STRtree(linestrings(np.stack([self.path.start[outer], self.path.end[outer]], axis=1)))
        middle = points((self.path.start[inner] + self.path.end[inner]) / 2)
        _, gaps = lines.query_nearest(middle, return_distance=True, all_matches=False)
        return gaps[gaps < 1.5 * self.profile.process.nozzle_size]

    def speed(self) -> float | None:
        """The speed of most of what is drawn in layers that need no slowing down; any faster line counts."""
        path, least = self.path, self.profile.process.minimum_layer_time
        seconds = np.bincount(path.layer, path.length / path.feed, len(path.heights))
        calm = seconds[path.layer] > 2 * least
        if not calm.any():
            return float(path.feed.max())
        usual = _mode(path.feed[calm], 0.01, path.length[calm])
        return max(float(path.feed.max()), usual) if path.feed.max() > usual + 0.05 else usual

    def pattern(self) -> str | None:
        """Told by the directions of the infill's lines, in layers that hold several."""
        path = self.path
        lines = (path.of(INFILL, SOLID) if self._full() else path.of(INFILL)) & (path.length > 1)
        counts = np.bincount(path.layer[lines], minlength=len(path.heights))
        lines &= counts[path.layer] >= SEVERAL
        if not lines.any():
            return None
        rising, falling = (lines & self._along(direction) for direction in DIAGONALS)
        if path.length[rising | falling].sum() < MOSTLY * path.length[lines].sum():
            return "concentric"
        both = np.intersect1d(path.layer[rising], path.layer[falling])
        return "grid" if 2 * len(both) > len(np.unique(path.layer[lines])) else "lines"

    def _along(self, direction: float) -> np.ndarray:
        """Which lines lie along a direction, rad."""
        step = self.path.end - self.path.start
        off = (np.arctan2(step[:, 1], step[:, 0]) - direction + math.pi / 2) % math.pi - math.pi / 2
        return np.abs(off) < DIAGONAL

    def density_row(self, volume: float) -> Row:
        """Full infill: the share of the part that is filled; else from the distance of its parallel lines."""
        asked = self.profile.process.infill_density
        if not self._full():
            return _number("infill density", "%", asked, self._spaced())
        drawn = ~self.path.of(SUPPORT, ADHESION)
        filled = float(self.path.filament[drawn].sum()) * self.profile.filament_area
        share = 1e4 * filled / self.profile.process.flow / volume
        return Row("infill density", "%", asked, round(share, 2), abs(share - asked) <= FULL)

    def _spaced(self) -> float | None:
        """Width of a line over the distance to the next, in every direction."""
        lines = self.path.of(INFILL) & (self.path.length > 1)
        gaps = []
        for direction in DIAGONALS:
            normal = np.array([-math.sin(direction), math.cos(direction)])
            along = lines & self._along(direction)
            for layer in np.unique(self.path.layer[along]):
                offsets = np.unique((self.path.start[along & (self.path.layer == layer)] @ normal).round(1))
                steps = np.diff(offsets)
                gaps += steps[steps > 2 * self.profile.process.nozzle_size].tolist()
        if len(gaps) < 5:
            return None
        ways = 2 if self.profile.process.infill_pattern == "grid" else 1
        return 100 * ways * self.profile.process.nozzle_size / _mode(np.array(gaps), 0.1)

    def adhesion(self) -> str:
        """raft: support under the part's first layer; brim or skirt: by its loops on the first layer."""
        path = self.path
        below = path.of(SUPPORT) & (path.z < self.first - 0.01)
        if below.any() and self.first > 1.9 * self.height:
            return "raft"
        around = path.of(ADHESION) & (path.z < self.first + 0.01)
        if not around.any():
            return "none"
        return "brim" if path.length[around].sum() > BRIM_LOOPS * self._girth() else "skirt"

    def _girth(self) -> float:
        """Around the box of the first layer, mm."""
        first = np.abs(self.path.z - self.first) < 0.01
        corners = self.path.end[first & ~self.path.of(ADHESION)]
        return float(2 * (corners.max(axis=0) - corners.min(axis=0)).sum())

    def supported(self) -> bool:
        """Whether support stands beside or above the part's first layer."""
        return bool((self.path.of(SUPPORT) & (self.path.z > self.first + 0.01)).any()) or (
            self.adhesion() != "raft" and bool(self.path.of(SUPPORT).any()))

    def retracts(self) -> bool:
        """More than the one retraction with which a file may begin and end."""
        return len(self.path.retractions) > 2

    def walls(self) -> int | None:
        """Lines around an outline: the most loops of walls per loop of outer walls, but for rare layers."""
        sample = self._sample(OUTER, INNER)
        found = [n for layer in sample if (n := self._nested(layer)) is not None]
        common = [n for n in set(found) if found.count(n) >= WALLED * len(sample)]
        return max(common) if common else None

    def _nested(self, layer: int) -> int | None:
        here = self.path.layer == layer
        loops = [_loops(self.path, here & self.path.of(kind)) for kind in (OUTER, INNER)]
        return None if not loops[0] or loops[1] % loops[0] else 1 + loops[1] // loops[0]

    def _sample(self, *kinds: int) -> list[int]:
        """Layers, spread evenly, that hold lines of all these kinds."""
        layers = [np.unique(self.path.layer[self.path.of(kind)]) for kind in kinds]
        common = layers[0]
        for more in layers[1:]:
            common = np.intersect1d(common, more)
        chosen = np.linspace(0, len(common) - 1, min(SAMPLED, len(common))).round().astype(int)
        return common[chosen].tolist() if len(common) else []

    def _full(self) -> bool:
        return self.profile.process.infill_density >= 100


def _loops(path: Toolpath, lines: np.ndarray) -> int:
    """How many unbroken strokes these lines make."""
    places = np.flatnonzero(lines)
    if not len(places):
        return 0
    joined = np.hypot(*(path.start[places[1:]] - path.end[places[:-1]]).T) < 1e-6
    return 1 + int((~joined).sum())


def _median(values: np.ndarray, weights: np.ndarray) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return values[order][np.searchsorted(total, total[-1] / 2)]


def _mode(values: np.ndarray, width: float, weights: np.ndarray | None = None) -> float:
    """The middle of the fullest bin of `width`, refined by what lies in and beside it."""
    bins = np.floor(values / width).astype(int)
    low = bins.min()
    counts = np.bincount(bins - low, weights)
    best = low + int(counts.argmax())
    near = np.abs(bins - best) <= 1
    return float(np.average(values[near], weights=None if weights is None else weights[near]))
