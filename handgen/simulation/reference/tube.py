"""The actuator as a structured mesh: hexahedra of the wall, prisms around the axis of the closed tip.

It is drawn as a prism with a regular polygon as section, whose layers have radii 1 (chamber), 2 (thread)
and 3 (outside); the elements' quadratic maps then carry it to the profile's circles and tapers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from handgen.geometry.profile import ActuatorProfile
from handgen.simulation.reference.drawing import MIDDLE, Drawing

NAME = "actuator"
HELD, CHAMBER, WOUND, OUTSIDE, FACE = "held", "chamber", "inner thread", "outside", "face"
"""Surfaces: the section at the plug's end, the chamber's wall, the thread's, the side, the tip's disc."""


@dataclass(frozen=True)
class Division:
    """How many elements: along chamber and tip, through the wall inside and outside the thread, around half
    the circle, across the tip's core."""

    along: int = 30
    tip: int = 2
    inside: int = 1
    outside: int = 1
    around: int = 5
    core: int = 2

    def finer(self, refine: int) -> Division:
        n = 2**refine
        return Division(n * self.along, n * self.tip, n * self.inside, n * self.outside, n * self.around,
                        n * self.core)


def drawing(profile: ActuatorProfile, held: float, division: Division) -> Drawing:
    """The polygonal prism of the half (y >= 0) beyond x = `held`, mm."""
    return _Prism(profile, held, division).drawing()


class _Prism:
    def __init__(self, profile: ActuatorProfile, held: float, division: Division):
        self.d = d = division
        self.x = np.concatenate([np.linspace(held, profile.small_core_end, d.along + 1),
                                 np.linspace(profile.small_core_end, profile.length, d.tip + 1)[1:]])
        self.radius = np.concatenate([np.linspace(0, 1, d.core + 1), np.linspace(1, 2, d.inside + 1)[1:],
                                      np.linspace(2, 3, d.outside + 1)[1:]])

    def at(self, i: int, j: int, k: int) -> int:
        """Node of station i, layer j, place k around; on the axis all places are one."""
        return (i * len(self.radius) + j) * (self.d.around + 1) + (k if j else 0)

    def section(self, i: int, j: int, k: int) -> tuple[int, ...]:
        """Corners of a field in the section at station i: four, or three at the axis."""
        return _apart(self.at(i, j, k), self.at(i, j + 1, k), self.at(i, j + 1, k + 1), self.at(i, j, k + 1))

    def drawing(self) -> Drawing:
        d, stations, layers = self.d, len(self.x) - 1, len(self.radius) - 1
        angle = np.linspace(0.0, math.pi, d.around + 1)
        y, z = np.sin(angle), -np.cos(angle)
        y[-1] = 0.0
        nodes = np.stack(np.broadcast_arrays(
            self.x[:, None, None], self.radius[:, None] * y, self.radius[:, None] * z), -1)
        fields = [(i, j, k) for i in range(stations) for j in range(d.core if i < d.along else 0, layers)
                  for k in range(d.around)]
        solids = [(*self.section(i, j, k), *self.section(i + 1, j, k)) for i, j, k in fields]
        ends = {HELD: [self.section(0, j, k)[::-1] for i, j, k in fields if i == 0],
                FACE: [self.section(stations, j, k) for i, j, k in fields if i == stations - 1],
                CHAMBER: [self.section(i, j, k)[::-1] for i, j, k in fields if i == d.along and j < d.core],
                MIDDLE: [_apart(self.at(i, j, n), self.at(i + 1, j, n), self.at(i + 1, j + 1, n),
                                self.at(i, j + 1, n))
                         for i, j, k in fields if k == 0 for n in (0, d.around)]}
        ends[CHAMBER] += [face[::-1] for face in self._side(d.core, d.along)]
        sides = {WOUND: self._side(d.core + d.inside, stations), OUTSIDE: self._side(layers, stations)}
        return Drawing(NAME, nodes.reshape(-1, 3), solids, {**ends, **sides})

    def _side(self, j: int, stations: int) -> list[tuple[int, ...]]:
        """Faces around layer j, their normals away from the axis."""
        return [(self.at(i, j, k), self.at(i, j, k + 1), self.at(i + 1, j, k + 1), self.at(i + 1, j, k))
                for i in range(stations) for k in range(self.d.around)]


def _apart(*corners: int) -> tuple[int, ...]:
    """Corners without those that the axis makes one."""
    return tuple(dict.fromkeys(corners))


def placed(profile: ActuatorProfile, depth: float, around: int, points: np.ndarray) -> np.ndarray:
    """Where points (n, 3) of the polygonal prism lie, mm; the thread `depth` outside the large core."""
    x, y, z = points.T
    step = math.pi / around
    angle = np.arctan2(y, -z)
    sector = step * (np.floor(angle / step) + 0.5)
    off = angle - sector
    polygon = np.hypot(y, z) * np.cos(off) / math.cos(step / 2)
    turned = sector + step / 2 * np.tan(off) / math.tan(step / 2)
    layers = np.stack([0 * x, profile.small_core(x), profile.large_core(x) + depth, profile.outer(x)])
    below = np.clip(np.floor(polygon).astype(int), 0, len(layers) - 2)
    each = np.arange(len(x))
    radius = layers[below, each] + (polygon - below) * (layers[below + 1, each] - layers[below, each])
    return np.stack([x, radius * np.sin(turned), -radius * np.cos(turned)], -1)
