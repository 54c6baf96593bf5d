"""A bend's shapes as files: states for ParaView, and the deformed finger as STL.

A state holds the half of the finger that was solved (y >= 0): ParaView's Reflect shows the other. The STL
holds both halves.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from handgen.bending.surface import surface, whole
from handgen.export import stl
from handgen.simulation.case import Curve, State

if TYPE_CHECKING:
    from handgen.geometry.mesh_kernel import Triangles

OVERLAP = 1e-4
"""Growth of a piece before it is united with what it touches: about a micrometre."""


def shaped(curve: Curve) -> list[State]:
    """The converged states that come with their nodes."""
    return [state for state in curve.states if state.converged and state.positions]


def write_states(curve: Curve, folder: Path, labels: Sequence[str]) -> None:
    """`states/<label>.vtu` of every state that has its shape, and `states.pvd` over the load.

    Nodes as drawn with `displacement`, mm (Warp By Vector shows the shape); on the cells `stretch`, the
    largest principal one, and `body`, the place of its name in the file's field `bodies`. Time is the load:
    kPa, or N where only a weight acts.
    """
    found = shaped(curve)
    if not found:
        return
    (folder / "states").mkdir(parents=True)
    rows = []
    for state, label in zip(found, labels, strict=True):
        file = f"states/{label}.vtu"
        _unstructured(curve, state).save(folder / file, binary=True)
        time = 1e3 * state.pressure or state.tip_load
        rows.append(f'<DataSet timestep="{time:.9g}" part="0" file={quoteattr(file)}/>')
    (folder / "states.pvd").write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
        + "\n".join(rows) + "\n</Collection>\n</VTKFile>\n", encoding="utf-8")


def write_stl(curve: Curve, path: Path) -> None:
    """The finger in its last shape, both halves, every body one closed surface, mm."""
    from handgen.geometry.mesh_kernel import Triangles

    state = shaped(curve)[-1]
    vertices, faces, first = [], [], 0
    for body, positions in state.positions.items():
        grid = curve.grids[body]
        found = _closed(*whole(grid, surface(grid), positions))
        vertices.append(found.vertices)
        faces.append(found.faces + first)
        first += len(found.vertices)
    path.write_bytes(stl.to_bytes(Triangles(np.vstack(vertices), np.vstack(faces))))


def _closed(vertices: np.ndarray, triangles: np.ndarray) -> Triangles:
    """One closed body: meshes may be drawn in pieces that only touch, which no slicer joins.

    Every piece grows about its middle by OVERLAP before they are united. What is then still apart is kept so.
    """
    from manifold3d import Manifold, Mesh64, OpType

    from handgen.geometry.mesh_kernel import Triangles
    from handgen.geometry.mesh_kernel import triangles as as_triangles

    solid = Manifold(Mesh64(np.ascontiguousarray(vertices, float),
                            np.ascontiguousarray(triangles, np.uint64)))
    pieces = []
    for piece in solid.decompose():
        middle = np.mean(np.reshape(piece.bounding_box(), (2, 3)), axis=0)
        pieces.append(piece.translate(-middle).scale((1.0 + OVERLAP,) * 3).translate(middle))
    try:
        return as_triangles(Manifold.batch_boolean(pieces, OpType.Add))
    except ValueError:
        return Triangles(np.asarray(vertices, np.float32), triangles)


def _unstructured(curve: Curve, state: State):
    """All bodies of `state` as one VTK grid."""
    import pyvista

    points, displaced, cells, kinds, stretch, body, first = [], [], [], [], [], [], 0
    for number, (name, positions) in enumerate(state.positions.items()):
        grid = curve.grids[name]
        count, nodes = grid.cells.shape
        points.append(grid.nodes)
        displaced.append(positions - grid.nodes)
        cells.append(np.hstack([np.full((count, 1), nodes), grid.cells + first]).ravel())
        kinds.append(np.full(count, grid.cell_type, np.uint8))
        stretch.append(state.stretch.get(name, np.full(count, np.nan)))
        body.append(np.full(count, number, np.uint8))
        first += len(grid.nodes)
    found = pyvista.UnstructuredGrid(np.concatenate(cells), np.concatenate(kinds), np.vstack(points))
    found.point_data["displacement"] = np.vstack(displaced)
    found.cell_data["stretch"] = np.concatenate(stretch)
    found.cell_data["body"] = np.concatenate(body)
    found.field_data["bodies"] = list(state.positions)
    return found
