"""A clamp that gives: one more unknown, the flexion theta by which the whole finger turns about its root.

Everything else is written in the finger's own frame, which turns: there the lab's gravity, the tip's weight
and the obstacle turn the other way. A point (x, z) of the finger stands in the lab at

    X = c x + s z,  Z = -s x + c z,  c, s = cos, sin theta

so that a dead force g does the work g . X = (c gx - s gz) x + (s gx + c gz) z. The spring's energy,
theta^2 / (4 compliance), is that of half the finger, as everything here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from handgen.simulation.contact import PENALTY, SOFT, onset
from handgen.simulation.element import scatter

if TYPE_CHECKING:
    from handgen.simulation.system import System


class Base:
    """The turning root of `system`, whose unknown becomes its last one; `compliance` rad/(N mm)."""

    def __init__(self, system: System, compliance: float):
        self.compliance = compliance
        self.dof = system.size
        system.size += 1
        system.turns = np.append(system.turns, self.dof)
        self.free = (system.node_dofs >= 0) & np.array([True, False, True])
        """(N, 3) displacements in the plane of bending of nodes that no bone carries."""
        self.body_dofs = system.body_dofs
        self.nodes = system.node_dofs[self.free]

    def groups(self, plane_bodies: np.ndarray) -> dict[str, np.ndarray]:
        """Unknowns that the turn couples with: free nodes', bones', those of the plane's points."""
        turn = np.full((max(len(self.nodes), len(plane_bodies), len(self.body_dofs)), 1), self.dof)
        return {
            "base_nodes": np.hstack([self.nodes[:, None], turn[:len(self.nodes)]]),
            "base_bones": np.hstack([self.body_dofs, turn[:len(self.body_dofs)]]),
            "base_plane": np.hstack([self.body_dofs[plane_bodies], turn[:len(plane_bodies)]]),
        }

    def angle(self, q: np.ndarray) -> float:
        """Flexion of the root, rad."""
        return float(q[self.dof])

    def carried(self, x: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Places (n, 3) of the finger's frame, in the lab."""
        c, s = np.cos(q[self.dof]), np.sin(q[self.dof])
        return np.stack([c * x[:, 0] + s * x[:, 2], x[:, 1], -s * x[:, 0] + c * x[:, 2]], -1)

    def seen(self, dead: np.ndarray, q: np.ndarray) -> np.ndarray:
        """A force of the lab in the finger's frame."""
        c, s = np.cos(q[self.dof]), np.sin(q[self.dof])
        return np.array([c * dead[0] - s * dead[2], dead[1], s * dead[0] + c * dead[2]])

    def slope(self, dead: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Derivative of `seen` with the turn; the second one is -`seen`."""
        c, s = np.cos(q[self.dof]), np.sin(q[self.dof])
        return np.array([-s * dead[0] - c * dead[2], 0.0, c * dead[0] - s * dead[2]])

    def spring(self, q: np.ndarray, force: np.ndarray, matrix: np.ndarray, diagonal: np.ndarray) -> float:
        """Add the clamp's moment and stiffness; returns its energy."""
        half = 0.5 / self.compliance
        force[self.dof] += half * q[self.dof]
        matrix[diagonal[self.dof]] += half
        return 0.5 * half * q[self.dof] ** 2

    def add_weight(self, x: np.ndarray, masses: np.ndarray, dead: np.ndarray, q: np.ndarray,
                   place: np.ndarray, force: np.ndarray, matrix: np.ndarray, diagonal: np.ndarray) -> None:
        """Add what the turn does to the weight of nodes that no bone carries; `masses` (N,), 0 elsewhere."""
        turned, now = self.slope(dead, q), self.seen(dead, q)
        force[self.dof] -= float((masses[:, None] * turned * x).sum())
        matrix[diagonal[self.dof]] += float((masses[:, None] * now * x).sum())
        np.subtract.at(matrix, place[:, 1, 0], (masses[:, None] * turned)[self.free])

    def add_pull(self, body: int, mass: float, at: np.ndarray, arm: np.ndarray, dead: np.ndarray,
                 q: np.ndarray, place: np.ndarray, force: np.ndarray, matrix: np.ndarray,
                 diagonal: np.ndarray) -> None:
        """The same of points that bone `body` carries: their `mass`, the sums `at` (3,) of masses times
        places and `arm` (3,) of masses times slopes with the bone's turn."""
        turned, now = self.slope(dead, q), self.seen(dead, q)
        force[self.dof] -= float(turned @ at)
        matrix[diagonal[self.dof]] += float(now @ at)
        for i, value in enumerate((mass * turned[0], mass * turned[2], float(turned @ arm))):
            if (where := place[body, 3, i]) >= 0:
                matrix[where] -= value


@njit(cache=True)
def add_turned_plane(points, bodies, area, level, pivot, origin, angle, states, theta, dofs, place, force,
                     matrix):
    """`contact.add_plane` seen from a finger whose root is turned by `theta`: one unknown more a point."""
    fe, ke, step = np.empty((2, 3)), np.zeros((4, 4)), np.empty(4)
    energy, pushed = 0.0, 0.0
    ct, st = np.cos(theta), np.sin(theta)
    for e in range(len(points)):
        b = bodies[e]
        a = angle[b] + states[b, 2]
        c, n = np.cos(a), np.sin(a)
        u, w = points[e, 0] - pivot[b], points[e, 2]
        x = origin[b, 0] + states[b, 0] + c * u + n * w
        z = origin[b, 1] + states[b, 1] - n * u + c * w
        height = -st * x + ct * z
        value, w1, w2 = onset(height - level, PENALTY * area[e], SOFT)
        if w2 == 0.0:
            continue
        energy += value
        pushed -= w1
        both = a + theta
        step[0], step[1] = -st, ct
        step[2] = -np.cos(both) * u - np.sin(both) * w
        step[3] = -ct * x - st * z
        twice = np.sin(both) * u - np.cos(both) * w
        for i in range(4):
            fe[i // 3, i % 3] = w1 * step[i]
            for j in range(4):
                ke[i, j] = w2 * step[i] * step[j]
        ke[2, 2] += w1 * twice
        ke[3, 3] -= w1 * height
        for i, more in ((0, -ct), (1, -st), (2, twice)):
            ke[3, i] += w1 * more
            ke[i, 3] += w1 * more
        scatter(dofs[e], place[e], fe, ke, force, matrix)
    return energy, pushed
