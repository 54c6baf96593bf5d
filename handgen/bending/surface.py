"""Boundaries of a solver's hexahedra as triangles: for STL files and pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handgen.simulation.case import Grid

CORNERS = np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
"""Faces of a hexahedron in VTK's order, outward."""
EDGES = {(0, 1): 8, (1, 2): 9, (2, 3): 10, (3, 0): 11, (4, 5): 12, (5, 6): 13, (6, 7): 14, (7, 4): 15,
         (0, 4): 16, (1, 5): 17, (2, 6): 18, (3, 7): 19}
"""Node in the middle of an edge of a hexahedron of 20 nodes."""
LINEAR = np.array([(0, 1, 2), (0, 2, 3)])
QUADRATIC = np.array([(0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)])
"""Triangles of a face of 4 nodes, and of one of 8: corners, then the middles of the edges after each."""
IN_PLANE = 1e-9
"""mm; nodes nearer to y = 0 as drawn lie in the plane of symmetry."""


@dataclass(frozen=True)
class Surface:
    """Outward triangles over a mesh's nodes."""

    triangles: np.ndarray
    """(t, 3) nodes."""
    owner: np.ndarray
    """(t,) the cell that each belongs to."""
    cut: np.ndarray
    """(t,) whether it lies in the plane of symmetry."""


def surface(grid: Grid) -> Surface:
    """The boundary of half a body."""
    corners = grid.cells[:, CORNERS].reshape(-1, 4)
    _, which, count = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True)
    outside = count[which.ravel()] == 1
    owner = np.repeat(np.arange(len(grid.cells)), len(CORNERS))[outside]
    faces, split = corners[outside], LINEAR
    if grid.cells.shape[1] == 20:
        middles = np.array([[_middle(face[k], face[(k + 1) % 4]) for k in range(4)] for face in CORNERS])
        faces, split = np.hstack([faces, grid.cells[:, middles].reshape(-1, 4)[outside]]), QUADRATIC
    flat = np.abs(grid.nodes[:, 1]) < IN_PLANE
    return Surface(faces[:, split].reshape(-1, 3), np.repeat(owner, len(split)),
                   np.repeat(flat[faces].all(axis=1), len(split)))


def whole(grid: Grid, found: Surface, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(vertices (v, 3), triangles (t, 3)) of both halves, joined in the plane of symmetry."""
    flat = np.abs(grid.nodes[:, 1]) < IN_PLANE
    mirror = np.arange(len(flat))
    mirror[~flat] = len(flat) + np.arange((~flat).sum())
    mine = found.triangles[~found.cut]
    vertices = np.vstack([positions, positions[~flat] * (1.0, -1.0, 1.0)])
    triangles = np.vstack([mine, mirror[mine][:, ::-1]])
    used, triangles = np.unique(triangles, return_inverse=True)
    return vertices[used], triangles.reshape(-1, 3)


def _middle(a: int, b: int) -> int:
    return EDGES.get((int(a), int(b))) or EDGES[int(b), int(a)]
