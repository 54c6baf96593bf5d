"""Evaluate a part's tree with CadQuery/OCCT: the exact boundary representation for STEP."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

from handgen.geometry import csg
from handgen.geometry.lettering import outlines

if TYPE_CHECKING:
    from cadquery import Edge, Shape, Wire


def evaluate(shape: csg.Shape) -> Shape:
    """The CadQuery solid of `shape`, in mm.

    Raises:
        ValueError: OCCT returned nothing, or a solid that it calls invalid itself.
    """
    from OCP.Standard import Standard_Failure

    try:
        result = _evaluate(shape)
    except Standard_Failure as error:
        raise ValueError(f"OCCT gave up on a {type(shape).__name__}: {error}") from error
    if not result.Solids() or not result.isValid():
        raise ValueError(f"OCCT gave no valid solid for a {type(shape).__name__}")
    solids = result.Solids()
    return solids[0] if len(solids) == 1 else result


@functools.lru_cache(maxsize=256)
def _evaluate(shape: csg.Shape) -> Shape:
    """Remembered, because the hand holds the same slotted fingers that are exported singly."""
    from cadquery import Solid, Vector

    match shape:
        case csg.Revolve(path):
            wire = _wire(path)
            return Solid.revolve(wire, [], 360.0, Vector(0, 0, 0), Vector(1, 0, 0))
        case csg.Extrude(path, height):
            return Solid.extrudeLinear(_wire(path), [], Vector(0, 0, height))
        case csg.Text(text, size, height):
            return _text(text, size, height)
        case csg.Loft(sections, smooth):
            return _loft(sections, smooth)
        case csg.Placed(inner, rotation, origin):
            return _evaluate(inner).moved(_location(rotation, origin))
        case csg.Mirrored(inner, axis):
            plane = {"x": "YZ", "y": "XZ", "z": "XY"}[axis]
            return _evaluate(inner).mirror(plane)
        case csg.Union(shapes):
            first, *rest = [_evaluate(s) for s in shapes]
            return first.fuse(*rest) if rest else first
        case csg.Difference(base, tools):
            return _evaluate(base).cut(*[_evaluate(t) for t in tools])
        case csg.Intersection(shapes):
            first, *rest = [_evaluate(s) for s in shapes]
            for other in rest:
                first = first.intersect(other)
            return first
        case _:
            raise TypeError(f"no B-rep for a {type(shape).__name__}")


def _wire(path: csg.Path) -> Wire:
    from cadquery import Vector, Wire

    edges, at = [], Vector(*path.start, 0)
    for segment in (*path.segments, (path.start,)):
        points = [at, *(Vector(*p, 0) for p in segment)]
        if (points[-1] - at).Length < 1e-7:
            continue
        edges.append(_edge(points))
        at = points[-1]
    return Wire.assembleEdges(edges)


def _edge(points) -> Edge:
    """A line, a true circular arc where the cubic stands for a quarter of one, or a Bezier curve."""
    from cadquery import Edge

    if len(points) == 2:
        return Edge.makeLine(*points)
    start, c1, c2, end = points
    out, back = (c1 - start) / csg.QUARTER_ARC, (c2 - end) / csg.QUARTER_ARC
    if abs(out.dot(back)) < 1e-9 and abs(out.Length - back.Length) < 1e-9 \
            and (start + out - end - back).Length < 1e-9:
        centre = start - back
        middle = centre + (start + end - centre * 2) / math.sqrt(2.0)
        return Edge.makeThreePointArc(start, middle, end)
    return Edge.makeBezier(points)


def _text(text: str, size: float, height: float) -> Shape:
    from cadquery import Compound, Solid, Vector, Wire

    def ring(points):
        return Wire.makePolygon([Vector(x, y, 0) for x, y in points], close=True)

    up = Vector(0, 0, height)
    return Compound.makeCompound(
        [Solid.extrudeLinear(ring(outer), [ring(h) for h in holes], up)
         for outer, holes in outlines(text, size)]
    )


def _loft(sections, smooth: bool) -> Shape:
    from cadquery import Solid

    wires = [_wire(s.path).moved(_location(s.rotation, s.origin)) for s in sections]
    return Solid.makeLoft(wires, ruled=not smooth)


def _location(rotation, origin):
    from cadquery import Location
    from OCP.gp import gp_Trsf

    move = gp_Trsf()
    rows = zip(rotation, origin, strict=True)
    move.SetValues(*(float(v) for row, shift in rows for v in (*row, shift)))
    return Location(move)
