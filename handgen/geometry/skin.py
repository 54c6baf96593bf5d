"""The hand's skin: a few round primitives, smoothly united into one signed distance field.

Distances in mm, negative inside. Near its surface every primitive is a true distance to a few per
cent, so that a blend has the radius it is given and a wall can be checked by reading the field.
Plain data, read by `csg.Field`: equal primitives hash equal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handgen.geometry.csg import Loft, Path, Point3, Section

Rows = tuple[Point3, Point3, Point3]
FIT = 2.0
"""Grid on which `fitted_loft` finds a section's middle, mm; it finds the edge to an eighth of it."""
RING = 12
"""Points around a section of `fitted_loft`."""
SAMPLES = 65536
"""Points evaluated at once by `Skin.distance`; keeps its temporaries small."""


@dataclass(frozen=True)
class Cone:
    """A ball that rolls from `start` to `end` while its radius goes from `r0` to `r1`."""

    start: Point3
    end: Point3
    r0: float
    r1: float

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        a, b = np.array(self.start), np.array(self.end)
        return np.minimum(a - self.r0, b - self.r1), np.maximum(a + self.r0, b + self.r1)

    def distance(self, x, y, z):
        axis = np.subtract(self.end, self.start)
        dx, dy, dz = (c - o for c, o in zip((x, y, z), _singles(self.start), strict=True))
        ux, uy, uz = _singles(axis / (axis @ axis))
        t = np.clip(dx * ux + dy * uy + dz * uz, 0, 1)
        ax, ay, az = _singles(axis)
        away = np.sqrt((dx - t * ax) ** 2 + (dy - t * ay) ** 2 + (dz - t * az) ** 2)
        return away - (np.float32(self.r0) + t * np.float32(self.r1 - self.r0))


@dataclass(frozen=True)
class Ellipsoid:
    """Semi-axes along the columns of `rotation`."""

    rotation: Rows
    origin: Point3
    semi_axes: Point3

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        reach = np.linalg.norm(np.array(self.rotation) * np.array(self.semi_axes), axis=1)
        return np.array(self.origin) - reach, np.array(self.origin) + reach

    def distance(self, x, y, z):
        u, v, w = _local(self.rotation, self.origin, x, y, z)
        a, b, c = _singles(self.semi_axes)
        u, v, w = u / a, v / b, w / c
        level = np.sqrt(u * u + v * v + w * w)
        slope = np.sqrt((u / a) ** 2 + (v / b) ** 2 + (w / c) ** 2)
        return level * (level - 1) / np.maximum(slope, np.float32(1e-6))


@dataclass(frozen=True)
class Block:
    """A box between two corners in its own frame, all its edges rounded."""

    rotation: Rows
    origin: Point3
    low: Point3
    high: Point3
    radius: float

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        rows = np.array(self.rotation)
        middle = rows @ (np.add(self.low, self.high) / 2) + np.array(self.origin)
        reach = np.abs(rows) @ (np.subtract(self.high, self.low) / 2)
        return middle - reach, middle + reach

    def distance(self, x, y, z):
        local = _local(self.rotation, self.origin, x, y, z)
        middle = _singles(np.add(self.low, self.high) / 2)
        half = _singles(np.subtract(self.high, self.low) / 2 - self.radius)
        q = [abs(c - m) - h for c, m, h in zip(local, middle, half, strict=True)]
        outside = np.sqrt(sum(np.maximum(c, 0) ** 2 for c in q))
        return outside + np.minimum(np.maximum(np.maximum(*q[:2]), q[2]), 0) - np.float32(self.radius)


@dataclass(frozen=True)
class Slab:
    """The palm's body: superellipse sections (x, y, z, width, thickness) along x, rounded ends."""

    sections: tuple[tuple[float, float, float, float, float], ...]
    exponent: float
    radius: float

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        s = np.array(self.sections)
        half = s[:, 3:] / 2
        low, high = (s[:, 1:3] - half).min(0), (s[:, 1:3] + half).max(0)
        # The spline through the sections may overshoot them a little.
        over = 0.05 * (high - low)
        return np.r_[s[0, 0], low - over], np.r_[s[-1, 0], high + over]

    def at(self, x) -> np.ndarray:
        """(y, z, half width, half thickness) along the last axis at `x`: a Catmull-Rom spline."""
        s = np.array(self.sections)
        knots, rows = s[:, 0], s[:, 1:] * (1, 1, 0.5, 0.5)
        slopes = np.gradient(rows, knots, axis=0)
        x = np.clip(np.asarray(x, float), knots[0], knots[-1])
        i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
        h = (knots[i + 1] - knots[i])[..., None]
        t = (x - knots[i])[..., None] / h
        u = 1 - t
        return (rows[i] * (1 + 2 * t) * u * u + rows[i + 1] * (1 + 2 * u) * t * t
                + h * t * u * (slopes[i] * u - slopes[i + 1] * t))

    def distance(self, x, y, z):
        shape = np.shape(x)
        cy, cz, a, b = (c.reshape(shape).astype(np.float32) for c in np.moveaxis(self.at(x), -1, 0))
        n = self.exponent
        v, w = np.maximum(abs(y - cy) / a, 1e-4), np.maximum(abs(z - cz) / b, 1e-4)
        vn, wn = v ** np.float32(n - 1), w ** np.float32(n - 1)
        power = vn * v + wn * w
        level = power ** np.float32(1 / n)
        slope = np.sqrt((vn / a) ** 2 + (wn / b) ** 2) * level / power
        side = (level - 1) / slope
        # Deep inside the normalised level runs ahead of the distance: no point is farther than b.
        side = np.maximum(side, -np.minimum(a, b))
        r = np.float32(self.radius)
        first, last = np.float32(self.sections[0][0]), np.float32(self.sections[-1][0])
        along = np.maximum(first - x, x - last) + r
        side = side + r
        outside = np.sqrt(np.maximum(side, 0) ** 2 + np.maximum(along, 0) ** 2)
        return outside + np.minimum(np.maximum(side, along), 0) - r


@dataclass(frozen=True)
class Limb:
    """Primitives or limbs united with blends of their own radius; 0: plainly.

    A blend of two surfaces that run together swells by a quarter of its radius: what only
    continues or repeats another surface is united with it plainly.
    """

    parts: tuple
    blend: float = 0.0

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        lows, highs = zip(*(p.bounds() for p in self.parts), strict=True)
        return np.min(lows, 0) - self.blend, np.max(highs, 0) + self.blend

    def distance(self, x, y, z):
        first, *rest = (p.distance(x, y, z) for p in self.parts)
        for other in rest:
            first = _blended(first, other, self.blend)
        return first


@dataclass(frozen=True)
class Common:
    """What all of `parts` have in common."""

    parts: tuple

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        lows, highs = zip(*(p.bounds() for p in self.parts), strict=True)
        return np.max(lows, 0), np.min(highs, 0)

    def distance(self, x, y, z):
        first, *rest = (p.distance(x, y, z) for p in self.parts)
        for other in rest:
            first = np.maximum(first, other)
        return first


@dataclass(frozen=True)
class Skin:
    """The smooth union of `limbs`, in their order, with blends of radius `blend`.

    `openings` are cut out of it, their rims rounded by blends of radius `rim`.
    """

    limbs: tuple
    blend: float
    openings: tuple = ()
    rim: float = 0.0

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        lows, highs = zip(*(p.bounds() for p in self.limbs), strict=True)
        return np.min(lows, 0) - self.blend, np.max(highs, 0) + self.blend

    def sample(self, pitch: float) -> tuple[np.ndarray, np.ndarray]:
        """(values (nx, ny, nz), origin (3,)) on a grid of `pitch` mm that encloses the skin.

        A limb is evaluated only where it can matter: in its own box, widened by the blend.
        """
        low, high = self.bounds()
        counts = np.ceil((high - low) / pitch).astype(int) + 1
        axes = [(o + pitch * np.arange(n)).astype(np.float32)
                for o, n in zip(low, counts, strict=True)]
        values = np.full(counts, 2 * self.blend, np.float32)
        for limb in self.limbs:
            a, b = limb.bounds()
            window = tuple(
                slice(*np.searchsorted(axis, (lo - self.blend, hi + self.blend)))
                for axis, lo, hi in zip(axes, a, b, strict=True))
            x, y, z = (axis[w] for axis, w in zip(axes, window, strict=True))
            near = limb.distance(x[:, None, None], y[:, None], z)
            values[window] = _blended(values[window], near, self.blend)
        for opening in self.openings:
            a, b = opening.bounds()
            window = tuple(
                slice(*np.searchsorted(axis, (lo - self.rim, hi + self.rim)))
                for axis, lo, hi in zip(axes, a, b, strict=True))
            x, y, z = (axis[w] for axis, w in zip(axes, window, strict=True))
            near = opening.distance(x[:, None, None], y[:, None], z)
            values[window] = -_blended(-values[window], near, self.rim)
        return values, low

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distances (n,) of points (n, 3), mm."""
        out = np.full(len(points), 2 * self.blend, np.float32)
        for start in range(0, len(points), SAMPLES):
            chunk = slice(start, start + SAMPLES)
            x, y, z = np.asarray(points[chunk], np.float32).T
            for limb in self.limbs:
                out[chunk] = _blended(out[chunk], limb.distance(x, y, z), self.blend)
            for opening in self.openings:
                out[chunk] = -_blended(-out[chunk], opening.distance(x, y, z), self.rim)
        return out


def fitted_loft(skin: Limb, rotation: Rows, origin: Point3, stations: Sequence[float]) -> Loft:
    """A plain solid for the B-rep: a loft through sections of `skin`.

    The sections are normal to the first column of `rotation`, at `stations` mm from `origin`;
    each is a smooth ring around the middle of what the skin encloses there.
    """
    rows, o = np.array(rotation), np.array(origin)
    plane = tuple(map(tuple, rows[:, [1, 2, 0]].tolist()))
    low, high = skin.bounds()
    reach = float(np.linalg.norm(high - low)) / 2
    middle = rows.T @ ((low + high) / 2 - o)
    angle = np.linspace(0.0, 2 * math.pi, RING, endpoint=False)
    circle = np.c_[np.cos(angle), np.sin(angle)]
    far = np.arange(0.0, reach, FIT / 4)
    coarse = np.stack(np.meshgrid(*(np.arange(-reach, reach, FIT),) * 2), -1).reshape(-1, 2) + middle[1:]

    def distances(u, points):
        flat = points.reshape(-1, 2)
        x, y, z = (np.c_[np.full(len(flat), u), flat] @ rows.T + o).astype(np.float32).T
        return skin.distance(x, y, z).reshape(points.shape[:-1])

    sections = []
    for u in stations:
        away = distances(u, coarse)
        enclosed = coarse[away < 0]
        centre, spread = enclosed.mean(axis=0), enclosed.std(axis=0)
        # Rays at even steps around the ellipse that is as flat as the section.
        ray = circle * spread / np.linalg.norm(circle * spread, axis=1, keepdims=True)
        inside = distances(u, centre + far[:, None, None] * ray) < 0
        edge = far[len(far) - 1 - np.argmax(inside[::-1], axis=0)] + FIT / 8
        ring = edge[:, None] * ray
        # Few points cut corners: as much again is given all round, so that the areas agree.
        area = FIT**2 * np.clip(0.5 - away / FIT, 0.0, 1.0).sum()
        path = _closed_spline(ring * math.sqrt(area / _enclosed(ring)))
        at = rows @ np.r_[u, centre] + o
        sections.append(Section(path, plane, tuple(at.tolist())))
    return Loft(tuple(sections), smooth=True)


def _enclosed(ring: np.ndarray) -> float:
    """Area inside the closed spline through `ring`, mm2."""
    handle = (np.roll(ring, -1, axis=0) - np.roll(ring, 1, axis=0)) / 2
    end, end_handle = np.roll(ring, -1, axis=0), np.roll(handle, -1, axis=0)
    t = np.arange(0.0, 1.0, 0.125)[:, None, None]
    u = 1 - t
    points = (ring * (1 + 2 * t) * u * u + end * (1 + 2 * u) * t * t
              + t * u * (handle * u - end_handle * t)).swapaxes(0, 1).reshape(-1, 2)
    x, y = points.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _closed_spline(points: np.ndarray) -> Path:
    """A closed curve of cubics through points (n, 2): Catmull and Rom's."""
    handle = (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)) / 6
    ends = np.roll(points, -1, axis=0)
    path = Path(tuple(points[0].tolist()), ())
    for p, q, m, n in zip(points, ends, handle, np.roll(handle, -1, axis=0), strict=True):
        path = path.cubic(*(tuple(c.tolist()) for c in (p + m, q - n, q)))
    return path


def _blended(a, b, radius: float):
    """Polynomial smooth minimum: exactly the smaller where they differ by `radius` or more."""
    if radius <= 0.0:
        return np.minimum(a, b)
    h = np.maximum(np.float32(radius) - abs(a - b), 0)
    return np.minimum(a, b) - h * h * np.float32(0.25 / radius)


def _singles(values):
    return tuple(np.float32(v) for v in values)


def _local(rotation: Rows, origin: Point3, x, y, z):
    """Coordinates along the columns of `rotation`, from `origin`."""
    dx, dy, dz = (c - o for c, o in zip((x, y, z), _singles(origin), strict=True))
    return [dx * p + dy * q + dz * r for p, q, r in (_singles(c) for c in np.transpose(rotation))]
