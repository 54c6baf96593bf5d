"""What acts on a finger: pressure, own weight, a weight that hangs on the tip.

A dead force g per mass on points that a bone carries needs their mass m and first moments only: with (u, w)
their places in the bone's straight frame from its pivot, and the bone turned by a,

    g . sum m x = m g . (origin + d) + gx (c U + s W) + gz (-s U + c W),  U, W = sum m u, sum m w
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from handgen.simulation import cavity, shapes
from handgen.simulation.exoskeleton import NEVER

if TYPE_CHECKING:
    from handgen.simulation.system import System


@dataclass(frozen=True)
class Load:
    """What acts: share of own weight, pressure MPa, tip load N; share of the silicone's stiffness lost, and
    of what the finger strains its actuator by (`handgen.simulation.cast`)."""

    weight: float = 0.0
    pressure: float = 0.0
    tip: float = 0.0
    lost: float = 0.0
    fit: float = 0.0

    def towards(self, other: Load, share: float) -> Load:
        return Load(*(float(a + share * (b - a)) for a, b in zip(self.parts, other.parts, strict=True)))

    @property
    def parts(self) -> tuple[float, float, float, float, float]:
        return self.weight, self.pressure, self.tip, self.lost, self.fit


class Loads:
    """Loads of `system`, which is laid out; masses in tonne."""

    def __init__(self, system: System):
        s = self.system = system
        self.gravity = np.array(s.case.gravity)
        self.masses = _masses(s)
        """(N,) of nodes: deformable elements', evenly to their points' shape."""
        self.loose = np.where(s.body == NEVER, self.masses, 0.0)
        """The same of nodes that no bone carries."""
        free = s.node_dofs >= 0
        self.dofs, self.dof_axes = s.node_dofs[free], np.nonzero(free)[1]
        self.dof_masses = (self.masses[:, None] * np.ones(3))[free]
        count = len(s.bones.start) if s.bones is not None else 0
        self.moments = np.array([self._moments(*self._centres(b), b) for b in range(count)]).reshape(-1, 3)
        """(b, 3) of every bone, its nodes included: mass, U, W."""
        self.heaviest = self._heaviest()
        self.largest_face = self._largest_face()
        self.inertia = self._inertia()

    def largest(self, load: Load) -> float:
        """The largest force that acts on an unknown under `load`, N."""
        weight = load.weight * self.heaviest * float(np.linalg.norm(self.gravity))
        return max(self.largest_face * load.pressure, weight, load.tip / 2)

    def _largest_face(self) -> float:
        """mm2, of the chamber's."""
        if not len(self.system.faces):
            return 0.0
        corners = self.system.drawn[self.system.faces]
        diagonals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        return float(np.linalg.norm(diagonals, axis=1).max() / 2)

    def _heaviest(self) -> float:
        s = self.system
        heavy = self.masses[s.body == NEVER]
        if s.exoskeleton:
            heavy = np.append(heavy, s.exoskeleton.volumes * s.case.tpu.density)
        return float(heavy.max())

    def _inertia(self) -> np.ndarray:
        """(n,) what artificial time drags on each unknown: masses over their mean, bones' turns by arm."""
        s = self.system
        mean = self.masses[self.masses > 0].mean()
        found = np.zeros(s.size)
        found[self.dofs] = np.maximum(self.dof_masses, 0.1 * mean) / mean
        for b in range(1, len(self.moments)):
            places, masses = self._centres(b)
            arms = ((places - [s.bones.pivot[b], 0, 0]) ** 2).sum(axis=1)
            found[s.body_dofs[b]] = np.array([masses.sum(), masses.sum(), (masses * arms).sum()]) / mean
        if s.base:
            found[s.base.dof] = found[s.turns[:-1]].sum()
        return found

    def _centres(self, b: int) -> tuple[np.ndarray, np.ndarray]:
        """(straight points, masses) of bone b: its rigid part and its nodes in deformable elements."""
        # Corners of 20-node elements have masses below zero: all count, or the bone is too heavy.
        s = self.system
        mine, e = (s.body == b) & (self.masses != 0), s.exoskeleton
        points = np.vstack([s.straight[mine], e.mass_points[b:b + 1]])
        return points, np.append(self.masses[mine], e.volumes[b] * s.case.tpu.density)

    def _moments(self, places: np.ndarray, masses: np.ndarray, b: int) -> tuple[float, float, float]:
        return masses.sum(), masses @ (places[:, 0] - self.system.bones.pivot[b]), masses @ places[:, 2]

    def add(self, x: np.ndarray, q: np.ndarray, load: Load, force: np.ndarray, matrix: np.ndarray) -> float:
        """Add forces and tangent of `load` at the nodes' places `x`; returns the energy."""
        s, energy = self.system, 0.0
        if load.pressure and len(s.faces):
            energy += cavity.add_pressure(x, s.faces, load.pressure, *s.groups["faces"], force, matrix)
        if s.base:
            energy += s.base.spring(q, force, matrix, s.pattern.diagonal)
        if load.weight and self.gravity.any():
            acting = load.weight * self.gravity
            if s.base:
                s.base.add_weight(x, self.loose, acting, q, s.groups["base_nodes"][1], force, matrix,
                                  s.pattern.diagonal)
            pull = s.base.seen(acting, q) if s.base else acting
            energy -= float(pull @ (self.loose @ x))
            force[self.dofs] -= self.dof_masses * pull[self.dof_axes]
            for b, moments in enumerate(self.moments):
                energy += self._pull(b, moments, acting, q, force, matrix)
        if load.tip and s.bones is not None:
            down = np.array([0.0, 0.0, -1.0])
            along = self.gravity / np.linalg.norm(self.gravity) if self.gravity.any() else down
            b = len(s.bones.start) - 1
            tip = self._moments(np.array([[s.case.finger.length, 0.0, 0.0]]), np.array([0.5]), b)
            energy += self._pull(b, tip, load.tip * along, q, force, matrix)
        return energy

    def _pull(self, b: int, moments, acceleration: np.ndarray, q: np.ndarray, force, matrix) -> float:
        """Add a dead force, `acceleration` times masses of these `moments`, that bone `b` carries."""
        s, (mass, mu, mw) = self.system, moments
        dx, dz, turn = s.bone_states(q)[b]
        a = s.bones.angle[b] + turn
        along, up = np.cos(a) * mu + np.sin(a) * mw, -np.sin(a) * mu + np.cos(a) * mw
        x, z = s.bones.origin[b] + (dx, dz)
        at = np.array([mass * x + along, 0.0, mass * z + up])
        if s.base:
            s.base.add_pull(b, mass, at, np.array([up, 0.0, -along]), acceleration, q,
                            s.groups["base_bones"][1], force, matrix, s.pattern.diagonal)
            acceleration = s.base.seen(acceleration, q)
        dofs, (gx, _, gz) = s.body_dofs[b], acceleration
        if dofs[0] >= 0:
            force[dofs] -= (mass * gx, mass * gz, gx * up - gz * along)
            matrix[s.pattern.diagonal[dofs[2]]] += gx * along + gz * up
        return -float(acceleration @ at)


def _masses(system: System) -> np.ndarray:
    found = np.zeros(len(system.drawn))
    for mesh, first, substance in ((system.actuator, 0, system.case.silicone),
                                   (system.exoskeleton, system.first, system.case.tpu)):
        if mesh is None:
            continue
        cells = mesh.grid.cells + first
        carried = system.body[cells]
        rigid = (carried == carried[:, :1]).all(axis=1) & (carried[:, 0] != NEVER)
        cells = cells[~rigid]
        _, volume = shapes.gradients(system.drawn, cells)
        np.add.at(found, cells, substance.density * volume @ shapes.values(cells.shape[1]))
    return found
