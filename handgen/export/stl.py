"""Binary STL, mm: the file that is sliced."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from handgen.geometry.measure import HEADER, TRIANGLE

if TYPE_CHECKING:
    from handgen.geometry.mesh_kernel import Triangles

TITLE = b"binary STL of handgen, mm"


def to_bytes(mesh: Triangles) -> bytes:
    """The mesh as binary STL: a fixed header, then triangles in the mesh's order."""
    corners = np.asarray(mesh.vertices, np.float32)[mesh.faces]
    a, b, c = corners.astype(float).transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    record = np.zeros(len(corners), TRIANGLE)
    record["corners"] = corners
    record["normal"] = normals / np.where(lengths > 0.0, lengths, 1.0)
    return TITLE.ljust(HEADER, b" ") + len(record).to_bytes(4, "little") + record.tobytes()
