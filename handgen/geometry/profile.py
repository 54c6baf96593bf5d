"""THE truth about a finger along its axis: R(x), r(x), the actuator's layers, the joints.

CAD, mesher and bend simulation all read these curves and nothing else. x runs from the root
plane to the fingertip, mm. Every curve is piecewise cubic, so that it is a chain of Bezier
segments exactly and both CAD kernels and the simulation see the same finger.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from handgen.geometry.csg import Path
from handgen.parameters import derive
from handgen.parameters.finger import Actuator, Finger, Joint, Layers


@dataclass(frozen=True)
class Piece:
    """One cubic on [x0, x1] with values y0, y1 and slopes m0, m1 at its ends."""

    x0: float
    x1: float
    y0: float
    y1: float
    m0: float
    m1: float


@dataclass(frozen=True)
class Curve:
    """A radius along x, piecewise cubic and continuous (it may have kinks)."""

    pieces: tuple[Piece, ...]

    @classmethod
    def monotone(cls, length: float, start: float, end: float, stations) -> Curve:
        """From `start` at 0 to `end` at `length` through `stations` (`derive.monotone`)."""
        return cls(tuple(Piece(*piece) for piece in derive.monotone(length, start, end, stations)))

    @property
    def end(self) -> float:
        return self.pieces[-1].x1

    @cached_property
    def _numbers(self) -> derive.Pieces:
        return tuple((p.x0, p.x1, p.y0, p.y1, p.m0, p.m1) for p in self.pieces)

    @cached_property
    def _rows(self) -> np.ndarray:
        return np.array(self._numbers)

    def __call__(self, x):
        """Radius at x (scalar or array); beyond its ends the curve keeps its end value."""
        if isinstance(x, float | int):
            return float(derive.value_at(self._numbers, x))
        rows = self._rows
        x = np.clip(np.asarray(x, float), rows[0, 0], rows[-1, 1])
        x0, x1, y0, y1, m0, m1 = rows[np.searchsorted(rows[1:, 0], x, side="right")].T
        h = x1 - x0
        t = ((x.T - x0) / h)
        u = 1 - t
        value = (y0 * (1 + 2 * t) + h * m0 * t) * u * u + (y1 * (1 + 2 * u) - h * m1 * u) * t * t
        return value.T if value.ndim else float(value)

    def slope(self, x: float) -> float:
        """dR/dx at x (right-sided at a kink)."""
        for p in reversed(self.pieces):
            if x >= p.x0:
                break
        h = p.x1 - p.x0
        t = min(max((x - p.x0) / h, 0.0), 1.0)
        u = 1 - t
        return 6 * t * u * (p.y1 - p.y0) / h + p.m0 * u * (1 - 3 * t) + p.m1 * t * (3 * t - 2)

    def affine(self, scale: float, shift: float) -> Curve:
        """scale * R(x) + shift."""
        return Curve(tuple(
            Piece(p.x0, p.x1, scale * p.y0 + shift, scale * p.y1 + shift, scale * p.m0, scale * p.m1)
            for p in self.pieces
        ))

    def between(self, start: float, end: float) -> Curve:
        """The same curve on [start, end]."""
        pieces = []
        for p in self.pieces:
            a, b = max(p.x0, start), min(p.x1, end)
            if b - a > 1e-9:
                # Inside a piece the one-sided slopes are the cubic's own.
                inner = Curve((p,))
                pieces.append(Piece(a, b, inner(a), inner(b), inner.slope(a), inner.slope(b)))
        return Curve(tuple(pieces))

    def joined(self, other: Curve) -> Curve:
        return Curve(self.pieces + other.pieces)

    def crossing(self, level: float) -> float | None:
        """Where a non-increasing curve falls below `level`, mm; None if it never does."""
        return _crossing(self._numbers, level)

    def append_to(self, path: Path) -> Path:
        """Extend `path`, which ends at this curve's start, along the curve in (x, radius)."""
        for p in self.pieces:
            h = (p.x1 - p.x0) / 3.0
            path = path.cubic((p.x0 + h, p.y0 + h * p.m0), (p.x1 - h, p.y1 - h * p.m1), (p.x1, p.y1))
        return path

    def append_reversed_to(self, path: Path) -> Path:
        """Extend `path`, which ends at this curve's end, back to the curve's start."""
        for p in reversed(self.pieces):
            h = (p.x1 - p.x0) / 3.0
            path = path.cubic((p.x1 - h, p.y1 - h * p.m1), (p.x0 + h, p.y0 + h * p.m0), (p.x0, p.y0))
        return path


@lru_cache(maxsize=64)
def _crossing(pieces: derive.Pieces, level: float) -> float | None:
    """Kept: every rule asks each of a hand's actuators."""
    if pieces[-1][3] >= level:
        return None
    low, high = pieces[0][0], pieces[-1][1]
    if derive.value_at(pieces, low) < level:
        return low
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if derive.value_at(pieces, middle) >= level else (low, middle)
    return 0.5 * (low + high)


@dataclass(frozen=True)
class FingerProfile:
    """Outside R(x) and bore r(x) of a finger, its rounded tip, its joints and its rest curl."""

    finger: Finger

    @cached_property
    def outer(self) -> Curve:
        """Outside radius from the root to the end of the bore; the rounded tip lies beyond."""
        f = self.finger
        return Curve.monotone(
            f.inner_length, f.base_outer_diameter / 2, f.tip_outer_diameter / 2, f.taper)

    @cached_property
    def bore(self) -> Curve:
        f = self.finger
        return Curve.monotone(
            f.inner_length, f.base_bore_diameter / 2, f.tip_bore_diameter / 2, f.taper)

    @property
    def length(self) -> float:
        return self.finger.outer_length

    def outer_radius(self, x):
        """R(x), scalar or array, mm: the taper, then a half-ellipsoid as rounded tip."""
        f = self.finger
        x = np.asarray(x, float)
        dome = np.clip((x - f.inner_length) / (f.outer_length - f.inner_length), 0.0, 1.0)
        radius = self.outer(x) * np.sqrt(1.0 - dome**2)
        return radius if radius.ndim else float(radius)

    def bore_radius(self, x):
        """r(x), scalar or array, mm: 0 beyond the end of the bore."""
        radius = np.where(np.asarray(x) <= self.finger.inner_length, self.bore(x), 0.0)
        return radius if radius.ndim else float(radius)

    def fillet(self, joint: Joint, wanted: float) -> float:
        """Radius in a slot's corners: at most a quarter of the slot or of its open arc.

        Between the corners the strip of a joint with a rest angle must find room for its bend.
        """
        middle = self.bore_radius(joint.position)
        open_arc = math.radians(360.0 - joint.palmar_arc) * middle
        bent = max(0.0, derive.palmar_fold(self.finger, joint) - derive.LEAST_FOLD) / 2.0
        return min(wanted, joint.slot_length / 4.0, open_arc / 8.0, bent)


@dataclass(frozen=True)
class ActuatorProfile:
    """An actuator's radii from its base (x = 0) to its tip, layer by layer (Table A.2).

    Where the layers leave less than `minimum_core` for the small core, the whole stack is
    thinned in proportion, from there to the tip: the chamber still reaches every joint, and
    nothing changes where the source's layers do fit.
    """

    actuator: Actuator
    layers: Layers
    minimum_core: float
    stations: tuple
    tip_fill: float = 0.0
    """Silicone added at the tip from inside, mm; 0 where the tip is cast with the layers."""

    @property
    def length(self) -> float:
        return self.actuator.outer_length

    @cached_property
    def outer(self) -> Curve:
        """Outside radius = the mould's cavity, from 0 to `length`."""
        a = self.actuator
        return Curve.monotone(
            a.outer_length, a.base_outer_diameter / 2, a.tip_outer_diameter / 2, self.stations)

    @cached_property
    def thinned_from(self) -> float | None:
        """x from which the layers are thinner than asked; None where they all fit."""
        return self.outer.crossing(self.minimum_core / 2 + self.layers.stack)

    def _inside(self, depth: float) -> Curve:
        """The surface that lies `depth` (of the asked stack) inside the outer one."""
        asked = self.outer.affine(1.0, -depth)
        if self.thinned_from is None:
            return asked
        share = depth / self.layers.stack
        thinned = self.outer.affine(1.0 - share, share * self.minimum_core / 2)
        start = self.thinned_from
        beyond = thinned.between(start, self.length)
        return asked.between(0.0, start).joined(beyond) if start > 0 else beyond

    @cached_property
    def thread(self) -> Curve:
        """Outside of the room drawn for the thread, inside of the external layer."""
        return self._inside(self.layers.external)

    @cached_property
    def large_core(self) -> Curve:
        """The large core's surface: the thread is wound on it; outside of the internal layer."""
        end = self.large_core_end
        return self._inside(self.layers.external + self.layers.thread).between(0.0, end)

    @cached_property
    def small_core(self) -> Curve:
        """The small core's surface: the air chamber."""
        return self._inside(self.layers.stack).between(0.0, self.small_core_end)

    @cached_property
    def casting_core(self) -> Curve:
        """The small core as it stands in the mould: longer than the chamber by what is filled."""
        return self._inside(self.layers.stack).between(0.0, self.small_core_end + self.tip_fill)

    @property
    def large_core_end(self) -> float:
        """Tip of the large core: the first pour wraps it in one thickness, tip included."""
        return self.length - min(
            self.layers.external + self.layers.thread, 0.75 * self.layers.tip)

    @property
    def small_core_end(self) -> float:
        """End of the air chamber = tip of the small core, unless the tip is filled afterwards."""
        return self.length - self.layers.tip
