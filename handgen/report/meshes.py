"""What the page draws of a part: its mesh with fewer triangles, smooth where it is round."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handgen.builder.jobs import welded
from handgen.export.preview import SHARP
from handgen.report.buffers import Buffer

COARSE = 0.03
"""mm by which the drawn surface may leave the printed one."""


@dataclass(frozen=True)
class Drawn:
    """Triangles for the screen: a vertex on a sharp edge stands once for each side."""

    points: np.ndarray
    """(n, 3) mm."""
    normals: np.ndarray
    """(n, 3) unit vectors."""
    faces: np.ndarray
    """(m, 3)."""
    origin: np.ndarray
    """(n,) the vertex of the mesh it was made of."""

    def packed(self, buffer: Buffer) -> dict[str, Any]:
        return {"points": buffer.add_points(self.points),
                "normals": buffer.add(np.rint(127 * self.normals).astype(np.int8)),
                "faces": buffer.add(_short(self.faces))}


def of_stl(path: Path) -> Drawn:
    """A closed part, coarsened."""
    return smooth(*coarse(*welded(path)))


def coarse(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same surface within COARSE; a mesh that is not closed stays as it is."""
    from manifold3d import Error, Manifold, Mesh

    solid = Manifold(Mesh(vertices.astype(np.float32), faces.astype(np.uint32)))
    if solid.status() != Error.NoError:
        return vertices, faces
    mesh = solid.simplify(COARSE).to_mesh()
    return mesh.vert_properties[:, :3].astype(float), mesh.tri_verts.astype(int)


def smooth(vertices: np.ndarray, faces: np.ndarray, sharp: float = SHARP) -> Drawn:
    """With normals that break where the surface turns by more than `sharp`, deg."""
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(np.asarray(vertices, float), faces)
    mesh.point_data["origin"] = np.arange(len(vertices))
    mesh = mesh.compute_normals(cell_normals=False, split_vertices=True, feature_angle=sharp,
                                consistent_normals=False, auto_orient_normals=False)
    return Drawn(np.asarray(mesh.points, float), np.asarray(mesh.point_data["Normals"], float),
                 mesh.regular_faces, np.asarray(mesh.point_data["origin"]))


def _short(faces: np.ndarray) -> np.ndarray:
    return faces.astype(np.uint16 if faces.max() < 1 << 16 else np.uint32)
