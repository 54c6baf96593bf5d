"""The finger as one system of equations: bodies, unknowns, energy, out-of-balance force and tangent.

Unknowns: three displacements of every free node (two in the plane of symmetry) and three of every rigid
bone (dx, dz, flexion). Everything but friction is the derivative of one energy, so the tangent is symmetric,
and positive definite where the state is stable; what friction takes from that is given apart (`coupling`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handgen.simulation import contact, fibre, shapes
from handgen.simulation.base import Base, add_turned_plane
from handgen.simulation.block import Block, Crew, assemble_blocks, extrapolate_blocks, kernel_law
from handgen.simulation.case import Case, Grid, Substance
from handgen.simulation.cast import free_of_stress
from handgen.simulation.closing import Closing
from handgen.simulation.exoskeleton import NEVER, ExoskeletonMesh, exoskeleton_mesh, palmar
from handgen.simulation.loads import Load, Loads
from handgen.simulation.mesh import ActuatorMesh, actuator_mesh
from handgen.simulation.offcentre import shifted
from handgen.simulation.sparse import Pattern

PLANE = 1e-9
"""mm; nodes nearer to y = 0 lie in the plane of symmetry."""
REACH_BACK, REACH_ON = 8.0, 0.8
"""How far a node of the actuator may slide: mm towards the root; towards the tip as a share of the free
length behind it (a mean stretch of 1.8). A node is paired with the bones within reach only: from a bone
farther on, which a curled finger brings back to it, the node is seen outside, not in the bore."""


class System:
    """`case` discretised. Nodes of the actuator come first, then those of the exoskeleton."""

    def __init__(self, case: Case, threads: int = 1):
        self.case = case
        self.crew = Crew(threads)
        self.actuator: ActuatorMesh | None = None
        self.exoskeleton: ExoskeletonMesh | None = None
        if case.part != "exoskeleton":
            self.actuator = actuator_mesh(case.actuator, case.winding, case.held, case.refine)
            if case.offset:
                depth = case.winding.depth if case.winding else 0.0
                self.actuator = shifted(self.actuator, case.actuator, depth, case.offset)
        if case.part != "actuator":
            self.exoskeleton = exoskeleton_mesh(case.finger, case.fillet, case.refine, case.root_angle)
        self.first = len(self.actuator.grid.nodes) if self.actuator else 0
        self._number()
        gives = self.exoskeleton is not None and case.base_compliance > 0.0
        self.base = Base(self, case.base_compliance) if gives else None
        closes = self.exoskeleton is not None and case.edges_left > 0.0
        self.closing = Closing(case, self.bones) if closes else None
        self.blocks = self._blocks()
        self._pairs()
        self._lay_out()
        self.loads = Loads(self)
        self.inertia = self.loads.inertia

    # Nodes and unknowns

    @property
    def grids(self) -> dict[str, Grid]:
        """Meshes as drawn: in a finger with a rest curl the actuator lies curled too (`cast`)."""
        found = {}
        if self.actuator:
            nodes = self.actuator.grid.nodes
            if self.exoskeleton:
                nodes = free_of_stress(self.case, nodes, 0.0)
            found["actuator"] = Grid(nodes, self.actuator.grid.cells)
        if self.exoskeleton:
            found["exoskeleton"] = self.exoskeleton.grid
        return found

    def _number(self) -> None:
        self.drawn = np.vstack([grid.nodes for grid in self.grids.values()])
        self.unstrained, self._fit = self.drawn, 0.0
        self.body = np.full(len(self.drawn), NEVER)
        held = np.zeros(len(self.drawn), bool)
        self.bones = None
        count = 0
        if self.actuator:
            held[:self.first] = self.actuator.grid.nodes[:, 0] <= self.case.held + PLANE
        if self.exoskeleton:
            self.bones = self.exoskeleton.bones
            self.body[self.first:] = self.exoskeleton.body
            count = len(self.bones.start)
        free = (self.body == NEVER) & ~held
        kept = np.zeros((len(self.drawn), 3), bool)
        kept[free] = True
        kept[np.abs(self.drawn[:, 1]) < PLANE, 1] = False
        self.node_dofs = np.full(kept.shape, -1)
        self.node_dofs[kept] = np.arange(kept.sum())
        self.size = int(kept.sum())
        self.body_dofs = np.full((max(count, 1), 3), -1)
        if count:
            self.body_dofs[1:] = self.size + np.arange(3 * (count - 1)).reshape(-1, 3)
            self.size += 3 * (count - 1)
        self.turns = self.body_dofs[1:, 2]
        carried = self.body != NEVER
        self.dofs = self.node_dofs.copy()
        self.dofs[carried] = self.body_dofs[self.body[carried]]
        self.straight = np.zeros((len(self.drawn), 3))
        self.carried = np.flatnonzero(carried)
        self.carried_by = self.body[self.carried]
        self._slopes = np.tile(np.eye(3), (len(self.drawn), 1, 1))
        self._curves = np.zeros((len(self.drawn), 3))
        if self.exoskeleton:
            self.straight[self.first:] = self.exoskeleton.straight
            self.arms = self.straight[self.carried][:, [0, 2]]
            self.arms[:, 0] -= self.bones.pivot[self.carried_by]
            self._slopes[self.carried] = 0.0
            self._slopes[self.carried, 0, 0] = self._slopes[self.carried, 2, 1] = 1.0

    def bone_states(self, q: np.ndarray) -> np.ndarray:
        """(b, 3) dx, dz, flexion of every bone."""
        return np.where(self.body_dofs >= 0, q[self.body_dofs], 0.0)

    def positions(self, q: np.ndarray) -> np.ndarray:
        """(N, 3) nodes, mm."""
        x = self.drawn + np.where(self.node_dofs >= 0, q[self.node_dofs], 0.0)
        if self.bones is not None:
            self._place(x, self.bone_states(q))
        return x

    def _place(self, x: np.ndarray, states: np.ndarray) -> None:
        """Write the places of the nodes that bones carry, the bones' `states` (b, 3)."""
        nodes, of, arm = self.carried, self.carried_by, self.arms
        turn = self.bones.angle + states[:, 2]
        c, s = np.cos(turn)[of], np.sin(turn)[of]
        at = (self.bones.origin + states[:, :2])[of]
        x[nodes, 0] = at[:, 0] + c * arm[:, 0] + s * arm[:, 1]
        x[nodes, 2] = at[:, 1] - s * arm[:, 0] + c * arm[:, 1]

    def _frames(self, x: np.ndarray, q: np.ndarray):
        """(slopes (N, 3, 3), curves (N, 3)) of carried nodes with respect to their bone's unknowns."""
        if self.bones is not None:
            nodes, of = self.carried, self.carried_by
            at = (self.bones.origin + self.bone_states(q)[:, :2])[of]
            along, up = x[nodes, 0] - at[:, 0], x[nodes, 2] - at[:, 1]
            self._slopes[nodes, 0, 2], self._slopes[nodes, 2, 2] = up, -along
            self._curves[nodes, 0], self._curves[nodes, 2] = -along, -up
        return self._slopes, self._curves

    # Elements

    def _blocks(self) -> list[Block]:
        found = []
        if self.actuator:
            found.append(self._block(self.actuator.grid.cells, 0, self.case.silicone, mean=True))
        if self.exoskeleton:
            found.append(self._block(self.exoskeleton.grid.cells, self.first, self.case.tpu, mean=False))
        return found

    def _block(self, cells: np.ndarray, first: int, substance: Substance, *, mean: bool) -> Block:
        cells = cells + first
        cells = cells[(self.dofs[cells] >= 0).any(axis=(1, 2))]
        rigid = (self.body[cells] == self.body[cells][:, :1]).all(axis=1) & (self.body[cells[:, 0]] != NEVER)
        cells = np.ascontiguousarray(cells[~rigid])
        dn, weight = shapes.gradients(self.drawn, cells)
        form, constants = kernel_law(substance.law)
        return Block(cells, dn, weight, form, constants, substance.bulk, mean,
                     (self.body[cells] != NEVER).any(axis=1))

    def _pairs(self) -> None:
        """Pairs of contact: actuator and bones; and the points of the bones that may meet the plane."""
        found = [(np.zeros((0, 2), int), np.zeros((0, 2)), np.zeros(0, int), np.zeros(0, int), np.zeros(0))]
        if self.actuator and self.exoskeleton:
            a, bones = self.actuator, self.bones
            x = (a.grid.nodes[a.outside, 0] * a.outside_share).sum(axis=1)
            movable = (self.node_dofs[a.outside] >= 0).any(axis=(1, 2))
            ahead, back = (0.0, 0.0) if self.case.contact.bonded else (
                REACH_ON * np.maximum(x - self.case.held, 0.0), REACH_BACK)
            for b in range(len(bones.start)):
                near = movable & (x + ahead >= bones.start[b]) & (x - back <= bones.end[b])
                found.append((a.outside[near], a.outside_share[near], np.full(near.sum(), b),
                              np.full(near.sum(), contact.BORE), a.outside_area[near]))
            alone = np.array([1.0, 0.0]) * np.ones((len(a.face), 1))
            found.append((np.stack([a.face, a.face], -1), alone, np.full(len(a.face), len(bones.start) - 1),
                          np.full(len(a.face), contact.FACE), a.face_area))
        self.pair_nodes, self.pair_shares, self.pair_bodies, self.pair_kinds, self.pair_areas = (
            np.concatenate(v) for v in zip(*found, strict=True))
        self.anchors = np.full(len(self.pair_nodes), np.nan)
        self.normal = np.zeros(len(self.pair_nodes))
        self.pressed = np.zeros(len(self.pair_nodes))
        self.dragged = np.zeros(len(self.pair_nodes))
        self.pair_stiffness = np.zeros(len(self.pair_nodes))
        self.lever, self.press = np.zeros((2, len(self.pair_nodes), 9))
        self.grip = 0.0
        self.plane_points, self.plane_bodies, self.plane_areas = (
            (np.zeros((0, 3)), np.zeros(0, int), np.zeros(0)) if self.case.obstacle is None
            or self.bones is None else palmar(self.case.finger, self.bones))

    def _lay_out(self) -> None:
        """Unknowns of all elements and where their matrices' entries go."""
        groups = [self.dofs[b.cells].reshape(len(b.cells), -1) for b in self.blocks]
        a = self.actuator
        ends = a.threads if a else np.zeros((0, 2), int)
        faces = a.chamber if a else np.zeros((0, 4), int)
        moving = (self.dofs[ends] >= 0).any(axis=(1, 2))
        self.threads = np.ascontiguousarray(ends[moving])
        self.faces = np.ascontiguousarray(faces[(self.dofs[faces] >= 0).any(axis=(1, 2))])
        self._wind(moving)
        pairs = np.hstack([self.dofs[self.pair_nodes].reshape(-1, 6), self.body_dofs[self.pair_bodies]])
        named = {"threads": self.dofs[self.threads].reshape(-1, 6),
                 "faces": self.dofs[self.faces].reshape(-1, 12), "pairs": pairs,
                 "plane": self.body_dofs[self.plane_bodies], "bones": self.body_dofs}
        if self.base:
            named |= self.base.groups(self.plane_bodies)
        if self.closing:
            named["closing"] = self.closing.groups(self.body_dofs)
        self.pattern = Pattern([*groups, *named.values()], self.size)
        for block, dofs, place in zip(self.blocks, groups, self.pattern.places, strict=False):
            block.dofs, block.place = dofs, place
        self.groups = dict(zip(named, zip(named.values(), self.pattern.places[len(groups):], strict=True),
                               strict=True))

    def _wind(self, moving: np.ndarray) -> None:
        w = self.case.winding
        self.thread_length = np.linalg.norm(self.drawn[self.threads[:, 1]] - self.drawn[self.threads[:, 0]],
                                            axis=1)
        self.thread_stiffness = np.zeros(0)
        self.compressive = 0.0
        if w is not None and self.actuator:
            turns = self.actuator.thread_span[moving] / w.pitch
            radius = np.linalg.norm(self.actuator.grid.nodes[self.threads[:, 0], 1:], axis=1)
            give = 4 / (w.young * np.pi * w.diameter**2) + w.bulge / (w.pitch * radius**2)
            self.thread_stiffness = turns / give
            self.compressive = w.compressive
        self.tension = np.zeros(len(self.threads))

    def _strain(self, share: float) -> None:
        """Let `share` of rest curl and tight bore strain the actuator."""
        self._fit, self.unstrained = share, self.drawn.copy()
        self.unstrained[:self.first] = free_of_stress(self.case, self.actuator.grid.nodes, share)
        for block in self.blocks:
            if block.mean:
                block.dn, block.weight = shapes.gradients(self.unstrained, block.cells)

    # Equilibrium

    def assemble(self, q: np.ndarray, load: Load, *, exact: bool):
        """(energy, force, matrix values, least J): energy mJ, force N internal less external.

        `exact`: with the stresses of this very state in the geometric stiffness, not the extrapolated ones.
        """
        if load.fit != self._fit:
            self._strain(load.fit)
        x = self.positions(q)
        frames, curves = self._frames(x, q)
        self._placed = x, frames
        force, matrix = np.zeros(self.size), np.zeros(self.pattern.entries)
        energy, least = assemble_blocks(
            self.blocks, self.crew, x, frames, curves, load.lost, exact, force, matrix)
        if least <= 0.0:
            return np.inf, force, matrix, least
        if len(self.threads):
            energy += fibre.add_threads(
                x, self.threads, self.thread_length, self.thread_stiffness, self.compressive, self.tension,
                exact, *self.groups["threads"], force, matrix)
        self._inner = (load.lost, load.fit), force.copy()
        energy += self._touch(x, q, exact, force, matrix)
        energy += self.loads.add(x, q, load, force, matrix)
        return energy, force, matrix, least

    def reload(self, q: np.ndarray, load: Load) -> np.ndarray:
        """Force out of balance, N, under another load at `q`, where the system was assembled last."""
        shared, inner = self._inner
        if shared != (load.lost, load.fit):
            return self.assemble(q, load, exact=True)[1]
        force, unused = inner.copy(), np.zeros(self.pattern.entries)
        self._touch(self._placed[0], q, True, force, unused)
        self.loads.add(self._placed[0], q, load, force, unused)
        return force

    def _touch(self, x: np.ndarray, q: np.ndarray, exact: bool, force, matrix) -> float:
        """Add what bodies that meet do to one another; returns the energy of it."""
        energy = 0.0
        if self.case.contact.bonded and len(self.pair_nodes):
            energy += contact.add_bonds(
                x, *self._points, self.pair_areas,
                (self.actuator.grid.nodes[self.pair_nodes] * self.pair_shares[:, :, None]).sum(axis=1),
                *self._bone_arrays[2:], self.bone_states(q),
                *self.groups["pairs"], force, matrix)
        elif len(self.pair_nodes):
            energy += contact.add_contact(
                x, *self.touching(q), self.case.contact.friction, self.anchors, self.normal, self.pressed,
                self.dragged, self.pair_stiffness, self.lever, self.press, exact, self.grip,
                *self.groups["pairs"], force, matrix)
        if len(self.plane_points):
            level = -self.case.finger.outer(0.0) - self.case.obstacle
            what = (self.plane_points, self.plane_bodies, self.plane_areas, level, *self._bone_arrays[2:],
                    self.bone_states(q))
            part, self.pushed = (
                add_turned_plane(*what, self.base.angle(q), *self.groups["base_plane"], force, matrix)
                if self.base else contact.add_plane(*what, *self.groups["plane"], force, matrix))
            energy += part
        if self.closing:
            energy += self.closing.add(self.bone_states(q), *self.groups["closing"], force, matrix)
        return energy

    @property
    def placed(self) -> np.ndarray:
        """(N, 3) nodes where the system was assembled last, mm."""
        return self._placed[0]

    def moved(self, step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What nodes (N, 3) and bones (b, 3) do in a `step` from there, to first order."""
        own = np.where(self.dofs >= 0, step[self.dofs], 0.0)
        return (np.einsum("nij,nj->ni", self._placed[1], own),
                np.where(self.body_dofs >= 0, step[self.body_dofs], 0.0))

    def touching(self, q: np.ndarray) -> tuple:
        """What contact's pairs are and where the bones stand, as the kernels take it."""
        return (*self._points, self.pair_kinds, self.pair_areas, self.actuator.swell, self._pieces,
                *self._bone_arrays, self.bone_states(q))

    @property
    def _points(self):
        """What contact's pairs consist of: nodes and shares of the points, and bones."""
        return self.pair_nodes, self.pair_shares, self.pair_bodies

    @property
    def _pieces(self) -> np.ndarray:
        play = self.case.contact.clearance + (1.0 - self._fit) * self.case.tight
        return np.array([(p.x0, p.x1, p.y0 + play, p.y1 + play, p.m0, p.m1)
                         for p in self.case.finger.bore.pieces])

    @property
    def _bone_arrays(self):
        b = self.bones
        low, high = b.start.copy(), b.end.copy()
        low[0] = -np.inf
        high[-1] = b.end[-1]
        return low, high, b.pivot, b.origin, b.angle

    def extrapolate(self, q: np.ndarray, step: np.ndarray) -> None:
        """Set the stresses that Newton extrapolates to those after `step` from `q`, to first order.

        The system must have been assembled at `q` last: laws are not evaluated again.
        """
        x, (moved, turned) = self.placed, self.moved(step)

        extrapolate_blocks(self.blocks, self.crew, moved)
        if len(self.threads):
            fibre.extrapolate_threads(x, moved, self.threads, self.thread_length, self.thread_stiffness,
                                      self.compressive, self.tension)
        if len(self.pair_nodes) and not self.case.contact.bonded:
            contact.extrapolate_contact(
                x, moved, turned, *self.touching(q), self.anchors, self.pair_stiffness, self.pressed,
                self.dragged)

    def coupling(self) -> Callable[[np.ndarray], np.ndarray] | None:
        """How friction, N, changes after a step because normal forces do, to first order, from where
        `assemble` was last: not symmetric, and no part of its matrix. None where nothing rubs."""
        at = np.flatnonzero(self.lever.any(axis=1))
        if not len(at):
            return None
        dofs, lever, press = self.groups["pairs"][0][at], self.lever[at], self.press[at]
        dofs = np.where(dofs < 0, self.size, dofs)

        def follow(step: np.ndarray) -> np.ndarray:
            pressed = (press * np.append(step, 0.0)[dofs]).sum(axis=1)
            return np.bincount(dofs.ravel(), (lever * pressed[:, None]).ravel(), self.size + 1)[:-1]

        return follow

    def accept(self, q: np.ndarray) -> None:
        """Friction's bonds follow an accepted state."""
        if len(self.pair_nodes) and self.case.contact.friction > 0:
            contact.drag(self.positions(q), *self._points, self.pair_kinds, self.normal,
                         *self._bone_arrays[2:], self.bone_states(q), self.anchors)
