"""Evaluate a part's tree with CadQuery/OCCT: the exact boundary representation for STEP."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

from handgen.geometry import csg
from handgen.geometry.lettering import outlines

SMOOTH = 1e-6
"""Tolerance of smooth lofts, mm."""

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
            return _skin(shape) if smooth else _ruled(sections)
        case csg.Placed(inner, rotation, origin):
            return _evaluate(inner).moved(_location(rotation, origin))
        case csg.Mirrored(inner, axis):
            plane = {"x": "YZ", "y": "XZ", "z": "XY"}[axis]
            return _evaluate(inner).mirror(plane)
        case csg.Union(shapes):
            return _boolean("Fuse", shapes[0], shapes[1:])
        case csg.Difference(base, tools):
            return _boolean("Cut", base, tools)
        case csg.Intersection((first, *others)):
            return _boolean("Common", first, (csg.Intersection(tuple(others)),) if others else ())
        case _:
            raise TypeError(f"no B-rep for a {type(shape).__name__}")


def forget() -> None:
    """Let go of all solids that `evaluate` remembers."""
    _evaluate.cache_clear()


def _boolean(kind: str, first: csg.Shape, others: tuple[csg.Shape, ...]) -> Shape:
    """OCCT's Fuse, Cut or Common, told to tell faces apart by oriented boxes (a tenth faster).

    On one thread, because a build keeps every processor busy with a part of its own.
    """
    import cadquery
    from OCP import BRepAlgoAPI
    from OCP.TopTools import TopTools_ListOfShape

    if not others:
        return _evaluate(first)
    operation = getattr(BRepAlgoAPI, f"BRepAlgoAPI_{kind}")()
    arguments, tools = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(_evaluate(first).wrapped)
    for other in others:
        tools.Append(_evaluate(other).wrapped)
    operation.SetArguments(arguments)
    operation.SetTools(tools)
    operation.SetUseOBB(True)
    operation.Build()
    return cadquery.Shape.cast(operation.Shape())


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


def _ruled(sections: tuple[csg.Section, ...]) -> Shape:
    from cadquery import Solid

    return Solid.makeLoft(
        [_wire(s.path).moved(_location(s.rotation, s.origin)) for s in sections], ruled=True)


def _skin(loft: csg.Loft) -> Shape:
    """A smooth loft as one B-spline surface and two plane caps.

    The poles of the sections are interpolated along the loft; OCCT's own lofting fits a surface
    to every piece of the outline instead, in four times as many faces that cost every boolean.
    """
    import numpy as np
    from cadquery import Edge, Face, Shell, Solid, Wire
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_Sewing
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt
    from OCP.TColgp import TColgp_Array2OfPnt
    from scipy.interpolate import make_interp_spline

    poles = np.array([
        np.c_[_poles(s.path), np.zeros(3 * len(s.path.segments) + 1)] @ np.array(s.rotation).T + s.origin
        for s in loft.sections])
    degree = min(3, len(poles) - 1)
    along = make_interp_spline(loft.stations, poles, k=degree)
    columns = along.c.transpose(1, 0, 2)
    net = TColgp_Array2OfPnt(1, columns.shape[0], 1, columns.shape[1])
    for i, column in enumerate(columns, start=1):
        for j, pole in enumerate(column.tolist(), start=1):
            net.SetValue(i, j, gp_Pnt(*pole))
    pieces = len(loft.sections[0].path.segments)
    around = _knots(np.arange(pieces + 1.0), np.r_[4, np.full(pieces - 1, 3), 4])
    down = _knots(*np.unique(along.t, return_counts=True))
    surface = Geom_BSplineSurface(net, around[0], down[0], around[1], down[1], 3, degree)
    for inner in range(2, pieces + 1):
        # Where pieces run on smoothly, as they must, one surface can say so.
        surface.RemoveUKnot(inner, 2, SMOOTH)

    sewing = BRepBuilderAPI_Sewing(SMOOTH)
    sewing.Add(BRepBuilderAPI_MakeFace(surface, SMOOTH).Face())
    for v in (along.t[0], along.t[-1]):
        rim = Edge(BRepBuilderAPI_MakeEdge(surface.VIso(float(v))).Edge())
        sewing.Add(Face.makeFromWires(Wire.assembleEdges([rim])).wrapped)
    sewing.Perform()
    solid = Solid.makeSolid(Shell(sewing.SewedShape()))
    return solid.fix()


def _poles(path: csg.Path):
    """Bezier poles (3 n + 1, 2) of a closed path of n cubics, the first repeated as the last.

    Raises:
        ValueError: the path has straight pieces or is left open.
    """
    import numpy as np

    if any(len(segment) == 1 for segment in path.segments) or path.end != path.start:
        raise ValueError("a smooth loft needs closed sections of cubics only")
    return np.array([path.start, *(point for segment in path.segments for point in segment)])


def _knots(values, counts):
    """OCCT's arrays of knots and their multiplicities."""
    from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal

    knots = TColStd_Array1OfReal(1, len(values))
    times = TColStd_Array1OfInteger(1, len(values))
    for i, (value, count) in enumerate(zip(values, counts, strict=True), start=1):
        knots.SetValue(i, float(value))
        times.SetValue(i, int(count))
    return knots, times


def _location(rotation, origin):
    from cadquery import Location
    from OCP.gp import gp_Trsf

    move = gp_Trsf()
    rows = zip(rotation, origin, strict=True)
    move.SetValues(*(float(v) for row, shift in rows for v in (*row, shift)))
    return Location(move)
