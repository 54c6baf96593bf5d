"""An actuator whose core, and the thread wound around it, lie off the middle of its wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handgen.geometry.profile import ActuatorProfile
from handgen.simulation.case import Grid
from handgen.simulation.mesh import ActuatorMesh


def shifted(mesh: ActuatorMesh, profile: ActuatorProfile, depth: float, offset: float) -> ActuatorMesh:
    """`mesh` with all up to the thread moved by `offset` mm dorsally, what lies outside it less and less.

    `depth`: how far the thread lies outside the large core. The outside, which the mould gives, stays.
    """
    nodes = mesh.grid.nodes.copy()
    x, radius = nodes[:, 0], np.hypot(nodes[:, 1], nodes[:, 2]) / mesh.swell
    thread, outside = profile.large_core(x) + depth, profile.outer(x)
    nodes[:, 2] += offset * np.clip((outside - radius) / (outside - thread), 0.0, 1.0)
    return replace(mesh, grid=Grid(nodes, mesh.grid.cells))
