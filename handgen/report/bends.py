"""The hand under pressure: the palm, and every finger that was bent, in all its states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from handgen.bending import cache, request, solve, solvers
from handgen.bending.result import Bend
from handgen.bending.states import shaped
from handgen.bending.surface import surface, whole
from handgen.builder.survey import Survey
from handgen.errors import InputError
from handgen.geometry.finger import COLOUR as SKIN
from handgen.geometry.palm import finger_placement, first_slot
from handgen.parameters.model import Hand
from handgen.report import meshes, scenes

CLEAR = 0.8
"""mm around a finger within which the palm's picture ends: the webs stay, the bent finger takes its place."""
SHARP = 40.0
"""deg: a solver's elements turn by more around a bore than the facets of a print."""
UNSOLVED = "not solved yet"
LEAST = 1.0
"""Stretch at the lower end of the colours."""


def bend(survey: Survey, fingers: list[str], known: bool, progress: Callable[[str], None]
         ) -> tuple[dict[str, Bend], dict[str, str]]:
    """Bend the fingers 0 to 100 kPa, palm down: (finger -> bend, finger -> why there is none).

    `known`: only those that were solved before.

    Raises:
        EngineError: the solver cannot be loaded or failed.
    """
    found, missing = {}, {}
    for name in fingers:
        try:
            asked = request(survey.loaded, finger=name)
        except InputError as error:
            missing[name] = "; ".join(problem.message for problem in error.problems)
            continue
        if known and cache.read(cache.key(asked.case, solvers.solver(asked.solver))) is None:
            missing[name] = UNSOLVED
            continue
        progress(f"bending {name}")
        found[name] = solve(asked)
    return found, missing


def scene(stage: scenes.Stage, bent: Mapping[str, Bend]) -> dict[str, Any] | None:
    """The scene of all bent fingers on the palm; None where none has a shape.

    A moving node has `states`: for every point that was solved the place of its vertices, and `stretch`, a
    byte for each vertex, from LEAST to the scene's `most`.
    """
    shaped_ = {name: found for name, found in bent.items() if shaped(found.curve)}
    if not shaped_:
        return None
    most = max(float(stretch.max()) for found in shaped_.values() for state in shaped(found.curve)
               for stretch in state.stretch.values())
    nodes = [_still(stage, list(shaped_))] if stage.hand.palm else []
    for name, found in shaped_.items():
        nodes += [_moving(stage, name, found, body, most) for body in found.curve.grids]
    return {"name": "bend", "title": "Under pressure", "nodes": nodes, "markers": [],
            "stretch": [LEAST, round(most, 3)]}


def _still(stage: scenes.Stage, fingers: list[str]) -> dict[str, Any]:
    """The hand without the fingers that move."""
    survey = stage.survey
    node = scenes.Node(survey.parts[scenes.HAND].part, stage.add(palm(survey, fingers)), scenes.IDENTITY,
                       np.zeros(3)).row()
    return node | {"states": []}


def palm(survey: Survey, fingers: list[str]) -> meshes.Drawn:
    """The hand's mesh without the `fingers` beyond their first joints."""
    from manifold3d import Error, Manifold, Mesh

    hand = survey.loaded.hand
    vertices, faces = meshes.welded(survey.parts[scenes.HAND].stl)
    solid = Manifold(Mesh(vertices.astype(np.float32), faces.astype(np.uint32)))
    if solid.status() != Error.NoError:
        return meshes.smooth(vertices, faces)
    for name in fingers:
        points, _ = meshes.welded(survey.parts[f"exoskeleton/{name}"].stl)
        beyond = points[points[:, 0] > first_slot(getattr(hand.fingers, name)) - CLEAR].astype(float)
        around = np.vstack([beyond + np.array([0.0, y, z]) for y in (-CLEAR, CLEAR) for z in (-CLEAR, CLEAR)])
        solid -= Manifold.hull_points(placed(hand, name, around))
    # What a hull missed of a finger, by a rounding, would stand in the air.
    rest = max(solid.decompose(), key=lambda body: body.volume())
    mesh = rest.simplify(meshes.COARSE).to_mesh()
    return meshes.smooth(mesh.vert_properties[:, :3], mesh.tri_verts.astype(int))


def placed(hand: Hand, name: str, points: np.ndarray) -> np.ndarray:
    """Points (..., 3) of a finger's own frame in the hand's; a finger without palm keeps its frame."""
    if not hand.palm:
        return points
    rotation, origin = finger_placement(hand, name)
    found = points @ np.array(rotation).T + origin
    return found * (1.0, -1.0, 1.0) if hand.side == "left" else found


def _moving(stage: scenes.Stage, name: str, found: Bend, body: str, most: float) -> dict[str, Any]:
    """A body of a bent finger: its mesh at rest, and where its vertices are in every state."""
    curve, grid = found.curve, found.curve.grids[body]
    outside = surface(grid)
    states = shaped(curve)
    shapes = [whole(grid, outside, state.positions[body]) for state in states]
    drawn = meshes.smooth(placed(stage.hand, name, shapes[0][0]), _wound(stage.hand, shapes[0][1]), SHARP)
    positions = placed(stage.hand, name, np.array([points[drawn.origin] for points, _ in shapes]))
    stretch = np.array([_at_vertices(grid, outside, state.stretch[body])[drawn.origin] for state in states])
    byte = np.clip(255 * (stretch - LEAST) / max(most - LEAST, 1e-9), 0, 255).astype(np.uint8)
    part = "exoskeleton" if body == "exoskeleton" else "actuators"
    tint = SKIN if body == "exoskeleton" else stage.survey.parts[f"actuators/{name}"].part.colour
    return {
        "name": f"{part}/{name}", "material": found.request.materials[body], "role": body,
        "colour": scenes.colour(tint), "mesh": stage.add(drawn), "shown": True,
        "matrix": scenes.IDENTITY.ravel().tolist(), "apart": [0.0, 0.0, 0.0], "finger": name,
        "states": [round(1e3 * state.pressure, 9) for state in states],
        "moves": stage.buffer.add_points(positions), "stretch": stage.buffer.add(byte),
    }


def _wound(hand: Hand, triangles: np.ndarray) -> np.ndarray:
    """Outward after `placed`: a mirror turns triangles inside out."""
    return triangles[:, ::-1] if hand.palm and hand.side == "left" else triangles


def _at_vertices(grid, outside, stretch: np.ndarray) -> np.ndarray:
    """The cells' stretch at the vertices of both halves, in the order of `whole`."""
    total, count = np.zeros(len(grid.nodes)), np.zeros(len(grid.nodes))
    for corner in outside.triangles.T:
        np.add.at(total, corner, stretch[outside.owner])
        np.add.at(count, corner, 1.0)
    mean = total / np.maximum(count, 1.0)
    # `whole` mirrors positions; a scalar goes the same way as a coordinate that no mirror changes.
    carried, _ = whole(grid, outside, np.c_[mean, np.zeros(len(mean)), mean])
    return carried[:, 0]
