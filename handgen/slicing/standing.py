"""A part as it stands on the printer: turned so that its `up` points up, about the origin, on z = 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from handgen.geometry.mesh_kernel import Triangles

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def standing(mesh: Triangles, up: Sequence[float], bed: Sequence[float]) -> Triangles:
    """The mesh turned; a quarter further about the vertical where only so it fits `bed` (x, y in mm)."""
    from handgen.geometry.mesh_kernel import Triangles

    vertices = np.asarray(mesh.vertices, float) @ upright(up).T
    size = np.ptp(vertices, axis=0)
    if (size[0] > bed[0] or size[1] > bed[1]) and size[0] <= bed[1] and size[1] <= bed[0]:
        vertices = vertices @ QUARTER.T
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return Triangles(vertices - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]], mesh.faces)


def upright(up: Sequence[float]) -> np.ndarray:
    """The shortest rotation, 3 x 3, that carries `up` to z; upside down: half a turn about x."""
    axis = np.asarray(up, float) / np.linalg.norm(up)
    if axis[2] < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = axis
    # Rodrigues' formula for the rotation about up x z.
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    return np.eye(3) + cross + cross @ cross / (1 + z)
