"""The exoskeleton as tetrahedra: gmsh revolves the meridian, cuts the slots and meshes what is left."""

from __future__ import annotations

import math

import numpy as np

from handgen.geometry.csg import Path
from handgen.geometry.finger import MARGIN, tube
from handgen.geometry.profile import FingerProfile
from handgen.parameters.finger import Joint
from handgen.simulation.reference.drawing import MIDDLE, Drawing

NAME = "exoskeleton"
ROOT, BORE, END, SKIN = "root", "bore", "end", "skin"
"""Surfaces: the root plane, what faces the actuator's side and its tip, all the rest."""
FINE, COARSE = 1.2, 4.0
"""Edges of elements in and beside a slot, and elsewhere, mm."""
BESIDE = 2.0
"""How far beside a slot the edges stay fine, mm."""
GRADING = 0.35
"""By how much an edge may grow with every mm from there."""
NEAR = 1e-6
QUADRATIC_TETRAHEDRON, QUADRATIC_TRIANGLE = 11, 9
"""gmsh's numbers."""
MIDDLES = ((0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3))
"""Ends of the edges whose middles are nodes 4 to 9 of gmsh's quadratic tetrahedron."""


def drawing(profile: FingerProfile, fillet: float, refine: int) -> tuple[Drawing, np.ndarray, np.ndarray]:
    """(the half finger y >= 0 with straight edges, middles of its edges (n, 3) mm, the same on its surface).

    `fillet`: wanted radius of the slots' corners, mm; `refine` halves the edges so many times.
    """
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        body = _revolved(occ, tube(profile))
        cutters = [_cutter(occ, profile, joint, fillet) for joint in profile.finger.joints]
        if cutters:
            occ.cut([body], cutters)
        occ.synchronize()
        gmsh.model.mesh.setSizeCallback(
            lambda dim, tag, x, y, z, size: _edge(profile, x) / 2**refine)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        gmsh.model.mesh.optimize("HighOrder")
        return _read(gmsh.model, profile)
    finally:
        gmsh.finalize()


def _edge(profile: FingerProfile, x: float) -> float:
    joints = profile.finger.joints
    away = min((abs(x - j.position) - j.slot_length / 2 - BESIDE for j in joints), default=math.inf)
    return min(COARSE, FINE + GRADING * max(0.0, away))


def _revolved(occ, meridian: Path) -> tuple[int, int]:
    """The half body of a meridian in (x, radius), drawn on the palmar side and turned half round."""

    def point(place) -> int:
        return occ.addPoint(place[0], 0.0, -place[1])

    first = last = point(meridian.start)
    curves = []
    for segment in meridian.segments:
        closing = math.dist(segment[-1], meridian.start) < NEAR
        handles, end = [point(p) for p in segment[:-1]], first if closing else point(segment[-1])
        curves.append(occ.addBezier([last, *handles, end]) if handles else occ.addLine(last, end))
        last = end
    if last != first:
        curves.append(occ.addLine(last, first))
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    turned = occ.revolve([(2, face)], 0, 0, 0, 1, 0, 0, math.pi)
    return next(entity for entity in turned if entity[0] == 3)


def _cutter(occ, profile: FingerProfile, joint: Joint, wanted: float) -> tuple[int, int]:
    """What a slot takes off the half finger: beyond the radial plane through the strip's edge.

    Its outline lies in x and the tangent there, its corners are rounded; it is drawn along the radius.
    """
    half, length = math.radians(joint.palmar_arc / 2), joint.slot_length
    start, radius = joint.position - length / 2, profile.fillet(joint, wanted)
    reach = profile.outer_radius(start) + MARGIN
    tangent = np.array([0.0, math.cos(half), math.sin(half)])
    outwards = np.array([0.0, math.sin(half), -math.cos(half)])

    def point(along: float, across: float) -> int:
        return occ.addPoint(*(np.array([start + along, 0, 0]) + across * tangent - reach * outwards))

    corners = [point(0, reach), point(0, radius), point(radius, 0), point(length - radius, 0),
               point(length, radius), point(length, reach)]
    if radius > 0:
        centres = point(radius, radius), point(length - radius, radius)
        rounds = {1: centres[0], 3: centres[1]}
    else:
        corners = [corners[0], corners[1], corners[3], corners[5]]
        rounds = {}
    curves = [occ.addCircleArc(a, rounds[i], b) if i in rounds else occ.addLine(a, b)
              for i, (a, b) in enumerate(zip(corners, [*corners[1:], corners[0]], strict=True))]
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    drawn = occ.extrude([(2, face)], *(2 * reach * outwards))
    return next(entity for entity in drawn if entity[0] == 3)


def _read(model, profile: FingerProfile) -> tuple[Drawing, np.ndarray, np.ndarray]:
    tags, coordinates, _ = model.mesh.getNodes()
    number = np.zeros(int(tags.max()) + 1, int)
    number[tags] = np.arange(len(tags))
    nodes = coordinates.reshape(-1, 3)
    _, cells = model.mesh.getElementsByType(QUADRATIC_TETRAHEDRON)
    cells = number[cells.reshape(-1, 10)]
    faces: dict[str, list[tuple[int, ...]]] = {name: [] for name in (ROOT, BORE, END, SKIN, MIDDLE)}
    for _, surface in model.getEntities(2):
        _, found = model.mesh.getElementsByType(QUADRATIC_TRIANGLE, surface)
        corners = number[found.reshape(-1, 6)][:, :3]
        faces[_name(nodes[corners], profile)] += [tuple(map(int, face)) for face in corners]
    ends = nodes[cells[:, MIDDLES]]
    body = Drawing(NAME, nodes, [tuple(map(int, c)) for c in cells[:, :4]], faces)
    return body, ends.mean(axis=2).reshape(-1, 3), nodes[cells[:, 4:]].reshape(-1, 3)


def _name(corners: np.ndarray, profile: FingerProfile) -> str:
    """The surface that triangles (n, 3, 3) of one face of the body belong to."""
    x, y, z = corners.reshape(-1, 3).T
    if np.abs(x).max() < NEAR:
        return ROOT
    if np.abs(y).max() < NEAR:
        return MIDDLE
    if np.abs(x - profile.finger.inner_length).max() < NEAR:
        return END
    return BORE if np.abs(np.hypot(y, z) - profile.bore(x)).max() < 1e-3 else SKIN
