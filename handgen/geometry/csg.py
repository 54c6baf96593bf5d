"""A part as data: a tree of a few primitives, read by two independent kernels.

`mesh_kernel` evaluates a tree with manifold3d (the mesh that is printed), `brep_kernel` with
CadQuery/OCCT (the STEP file). Because both read the same tree, their volumes check one another,
and because a tree is plain data its hash (`Shape.key`) names the part: a build reuses a file only
when nothing that shapes it has changed.

Lengths in mm, angles in degrees. Curves are straight lines and cubic Beziers only: a cubic
polynomial R(x) is a Bezier exactly, and a quarter circle is one to 0.03 % of its radius.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import accumulate, pairwise

Point2 = tuple[float, float]
Point3 = tuple[float, float, float]
QUARTER_ARC = 4.0 / 3.0 * (math.sqrt(2.0) - 1.0)
"""Handle length of the cubic Bezier nearest to a quarter circle of radius 1."""


@dataclass(frozen=True)
class Path:
    """A closed plane curve: a start point and segments back to it.

    A segment is an end point ((u, v),) or two handles and an end point (c1, c2, (u, v)).
    The last segment need not return to the start: it is closed with a straight line.
    """

    start: Point2
    segments: tuple[tuple[Point2, ...], ...]

    @classmethod
    def polygon(cls, points: Iterable[Point2]) -> Path:
        first, *rest = [(float(u), float(v)) for u, v in points]
        return cls(first, tuple((p,) for p in rest))

    def line(self, *points: Point2) -> Path:
        return Path(self.start, self.segments + tuple((p,) for p in points))

    def cubic(self, c1: Point2, c2: Point2, end: Point2) -> Path:
        return Path(self.start, (*self.segments, (c1, c2, end)))

    def quarter(self, corner: Point2, end: Point2) -> Path:
        """A quarter ellipse from the present end to `end`, its tangents meeting in `corner`."""
        a = self.end
        handles = [
            (p[0] + QUARTER_ARC * (corner[0] - p[0]), p[1] + QUARTER_ARC * (corner[1] - p[1]))
            for p in (a, end)
        ]
        return self.cubic(handles[0], handles[1], end)

    @property
    def end(self) -> Point2:
        return self.segments[-1][-1] if self.segments else self.start


class Shape:
    """A node of the tree. Combine with +, - and &; place with `moved`, `turned`, `mirrored`."""

    @property
    def key(self) -> str:
        """sha256 of the tree, equal for equal geometry and stable between runs."""
        return digest(self)

    def __add__(self, other: Shape) -> Shape:
        return Union((self, other))

    def __sub__(self, other: Shape) -> Shape:
        return Difference(self, (other,))

    def __and__(self, other: Shape) -> Shape:
        return Intersection((self, other))

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Shape:
        return Placed(self, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (x, y, z))

    def turned(self, axis: str, degrees: float) -> Shape:
        """Rotate about a coordinate axis through the origin, right-hand rule."""
        return Placed(self, rotation(axis, degrees), (0.0, 0.0, 0.0))

    def placed(self, rotation: Sequence[Sequence[float]], origin: Sequence[float]) -> Shape:
        """Rigid placement: p -> rotation @ p + origin (columns of rotation are the new axes)."""
        rows = tuple(tuple(float(v) for v in row) for row in rotation)
        return Placed(self, rows, tuple(float(v) for v in origin))

    def mirrored(self, axis: str) -> Shape:
        """Mirror in the plane through the origin that is normal to `axis`."""
        return Mirrored(self, axis)


def rotation(axis: str, degrees: float) -> tuple[Point3, Point3, Point3]:
    """Rotation matrix (rows) about coordinate axis "x", "y" or "z", right-hand rule, degrees.

    Rounded, so that a right angle carries planes exactly into planes: faces that meet stay closed.
    """
    c, s = (round(f(math.radians(degrees)), 15) for f in (math.cos, math.sin))
    return {
        "x": ((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)),
        "y": ((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)),
        "z": ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)),
    }[axis]


@dataclass(frozen=True)
class Revolve(Shape):
    """`path` in (x, radius), radius >= 0, turned fully about the x axis."""

    path: Path


@dataclass(frozen=True)
class Extrude(Shape):
    """`path` in (x, y), extruded from z = 0 to `height`."""

    path: Path
    height: float


@dataclass(frozen=True)
class Section:
    """A closed path drawn in the plane that `rotation` and `origin` place (as in `Placed`)."""

    path: Path
    rotation: tuple[Point3, Point3, Point3]
    origin: Point3


@dataclass(frozen=True)
class Loft(Shape):
    """A skin through sections whose paths have the same segments, capped at both ends.

    `smooth` runs the skin through the sections without edges, on cubic splines over `stations`;
    such sections are drawn in cubics only, each running on smoothly into the next.
    """

    sections: tuple[Section, ...]
    smooth: bool = False

    @property
    def stations(self) -> tuple[float, ...]:
        """Where the sections lie along the line through their origins, mm from the first."""
        steps = (math.dist(a.origin, b.origin) for a, b in pairwise(self.sections))
        return tuple(accumulate(steps, initial=0.0))


@dataclass(frozen=True)
class Text(Shape):
    """Lettering, centred on the origin of the xy plane, extruded from z = 0 to `height`.

    `size` is the height of a capital letter. DejaVu Sans Bold, as it ships with matplotlib, so
    that every machine embosses the same shapes.
    """

    text: str
    size: float
    height: float


@dataclass(frozen=True)
class Field(Shape):
    """A blended skin: the zero level of a signed distance field, sampled on a grid.

    `recipe` is a frozen dataclass with `sample(pitch) -> (values, origin)`: values (nx, ny, nz)
    in mm, negative inside; origin (3,) of the first sample. Only the mesh kernel can read it; a
    part that uses it gives the B-rep kernel an unblended tree of its own.
    """

    recipe: object
    pitch: float


@dataclass(frozen=True)
class Placed(Shape):
    """p -> rotation @ p + origin; a proper rotation, because OCCT garbles a reflected one."""

    shape: Shape
    rotation: tuple[Point3, Point3, Point3]
    origin: Point3

    def __post_init__(self):
        (a, b, c), (d, e, f), (g, h, i) = self.rotation
        if abs(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) - 1.0) > 1e-9:
            raise ValueError(f"not a rotation: {self.rotation}")


@dataclass(frozen=True)
class Mirrored(Shape):
    shape: Shape
    axis: str


@dataclass(frozen=True)
class Union(Shape):
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Difference(Shape):
    base: Shape
    tools: tuple[Shape, ...]


@dataclass(frozen=True)
class Intersection(Shape):
    shapes: tuple[Shape, ...]


def box(low: Sequence[float], high: Sequence[float]) -> Shape:
    """Axis-aligned box between two corners, mm."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    outline = Path.polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    return Extrude(outline, float(z1 - z0)).moved(z=float(z0))


def cylinder(radius: float, x0: float, x1: float) -> Shape:
    """Cylinder on the x axis from x0 to x1, mm. `turned("y", -90)` points it along +z."""
    return Revolve(Path.polygon([(x0, 0.0), (x1, 0.0), (x1, radius), (x0, radius)]))


def cone(radius0: float, radius1: float, x0: float, x1: float) -> Shape:
    """Truncated cone on the x axis, radius0 at x0 and radius1 at x1, mm."""
    return Revolve(Path.polygon([(x0, 0.0), (x1, 0.0), (x1, radius1), (x0, radius0)]))


def digest(value: object) -> str:
    """sha256 of plain nested data (dataclasses, tuples, numbers, strings); 12 digits of a float."""
    return hashlib.sha256(_canonical(value).encode()).hexdigest()


def _canonical(value: object) -> str:
    if is_dataclass(value):
        inner = ",".join(_canonical(getattr(value, f.name)) for f in fields(value))
        return f"{type(value).__name__}({inner})"
    if isinstance(value, (tuple, list)):
        return "(" + ",".join(map(_canonical, value)) + ")"
    if isinstance(value, float):
        return format(value + 0.0, ".12g")
    if isinstance(value, (str, int, bool)) or value is None:
        return repr(value)
    raise TypeError(f"{type(value).__name__} cannot be part of a shape: {value!r}")
