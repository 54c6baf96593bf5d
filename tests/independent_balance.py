"""A state's balance judged anew: out-of-balance forces from differences of an energy written in numpy alone.

Nothing of the kernels is used: energies are those of the library's laws at the elements' points, of the
thread's edges, the chamber and the pairs of contact, differentiated by moving each entry of F and each node
to and fro. Of the project: the mesh (what is a node, an element, an edge of the thread, a point of contact)
and the profile. Bones are taken from where their nodes went.

Friction depends on the way, which a state does not tell: what balances with some friction no larger than mu
times each point's normal force is in balance (`Balance.unbalanced`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handgen.simulation import contact
from handgen.simulation.case import Case
from handgen.simulation.exoskeleton import CORNERS_AND_EDGES, NEVER
from handgen.simulation.system import System

STEP, FINE = 1e-4, 1e-6
"""mm, of differences of fourth order: of solids and air; of threads and contact, stiff with kinks."""
SHORT = 1e-6
"""N left out of balance, above which the best friction is sought exactly."""
DIFFERENCE = ((-2, 1 / 12), (-1, -8 / 12), (1, 8 / 12), (2, -1 / 12))
GAUSS = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]) / 3**0.5


@dataclass
class Balance:
    """Forces, N: of the free nodes (n, 3), of each bone (b, 3: along x, along z, moment about its pivot)."""

    nodes: np.ndarray
    bones: np.ndarray
    acting: float
    """The largest acting force on a node, N."""
    least: float
    """Least Jacobian in any point."""

    @property
    def unbalanced(self) -> float:
        """Largest force out of balance over the largest acting one; moments as forces at 10 mm."""
        bones = np.abs(self.bones[1:] / [1.0, 1.0, 10.0]).max(initial=0.0)
        return float(max(np.abs(self.nodes).max(), bones) / self.acting)


class Judge:
    """Judges states of `case`; made once, its meshes are reused."""

    def __init__(self, case: Case):
        self.case, self.system = case, System(case)
        s = self.system
        self.bodies = []
        if s.actuator:
            self.bodies.append((s.actuator.grid.cells, case.silicone, True))
        if s.exoskeleton:
            cells = s.exoskeleton.grid.cells + s.first
            carried = s.body[cells]
            rigid = (carried == carried[:, :1]).all(axis=1) & (carried[:, 0] != NEVER)
            self.bodies.append((cells[~rigid], case.tpu, False))
        self.least = np.inf

    def _solid(self, cells, substance, mean, x, force) -> np.ndarray:
        """Add a body's forces at places x; returns its nodes' masses (m, n).

        Stress by differences of W, and the rate of J by differences of J, along each entry of F.
        """
        slopes, local = _slopes(cells.shape[1]), _shapes(cells.shape[1])
        jacobian = np.einsum("mni,gnj->mgij", self.system.drawn[cells], slopes)
        weight = np.linalg.det(jacobian)
        gradient = np.einsum("gnj,mgjk->mgnk", slopes, np.linalg.inv(jacobian))
        f = np.einsum("mni,mgnk->mgik", x[cells], gradient)
        j = np.linalg.det(f)
        self.least = min(self.least, float(j.min()))

        def energy(f):
            squared = np.linalg.eigvalsh(np.swapaxes(f, -1, -2) @ f)
            return substance.law.response(squared / np.cbrt(squared.prod(axis=-1, keepdims=True))).value

        stress, rate = np.zeros_like(f), np.zeros_like(f)
        for at in np.ndindex(3, 3):
            for steps, share in DIFFERENCE:
                moved = f.copy()
                moved[..., *at] += steps * STEP
                stress[..., *at] += share / STEP * energy(moved)
                rate[..., *at] += share / STEP * np.linalg.det(moved)
        grown = j - 1
        if mean:
            grown = np.broadcast_to(((weight * grown).sum(axis=1) / weight.sum(axis=1))[:, None], j.shape)
        stress += substance.bulk * grown[..., None, None] * rate
        np.add.at(force, cells, np.einsum("mg,mgik,mgnk->mni", weight, stress, gradient))
        return substance.density * np.einsum("mg,gn->mn", weight, local)

    # Energies of pieces: of one edge, face, point, by where its nodes are

    def _edge(self):
        """Energy of the thread's edges by their ends' places (k, 2, 3)."""
        s, w = self.system, self.case.winding
        drawn = s.drawn[s.actuator.threads]
        length = np.linalg.norm(drawn[:, 1] - drawn[:, 0], axis=1)
        stiff = w.young * np.pi / 4 * w.diameter**2 * s.actuator.thread_span / w.pitch

        def energy(x):
            from handgen.simulation import fibre

            strain = np.linalg.norm(x[:, 1] - x[:, 0], axis=1) / length - 1
            # The rounded knee between 0 and -KNEE: its stiffness falls linearly from 1 to the share.
            share, knee = w.compressive, fibre.KNEE
            slack = np.clip(-strain, 0, knee)
            bent = strain**2 / 2 - (1 - share) * slack**3 / (6 * knee)
            beyond = np.clip(-strain - knee, 0, None)
            bent -= (1 - share) * (beyond**2 / 2 + beyond * knee / 2)
            return stiff * length * bent

        return energy

    def _face(self, pressure):
        """Energy of air at faces by their corners' places (f, 4, 3): both triangulations' mean."""

        def energy(x):
            total = 0.0
            for a, b, c in ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)):
                total = total + np.linalg.det(x[:, (a, b, c)]) / 12
            return -pressure * total

        return energy

    # The balance

    def judge(self, positions: dict[str, np.ndarray], pressure: float, tip_load: float = 0.0,
              rubbing: np.ndarray | None = None) -> Balance:
        """Balance of bodies at `positions` (State.positions) under own weight, `pressure` MPa, `tip_load` N.

        `rubbing`: normal forces, N, of all pairs that friction may rest on; by default those that act now.
        """
        s, case = self.system, self.case
        x = np.vstack([positions[name] for name in ("actuator", "exoskeleton") if name in positions])
        self.least = np.inf
        force, acting = np.zeros_like(x), [1e-3]
        masses = np.zeros(len(x))
        for cells, substance, mean in self.bodies:
            np.add.at(masses, cells, self._solid(cells, substance, mean, x, force))
        pull = masses[:, None] * np.array(case.gravity)
        force -= pull
        acting.append(np.abs(pull[s.body == NEVER]).max(initial=0.0))
        if s.actuator:
            if case.winding:
                _add(force, x, s.actuator.threads, self._edge(), FINE)
            blown = np.zeros_like(x)
            _add(blown, x, s.actuator.chamber, self._face(pressure))
            force += blown
            acting.append(np.abs(blown).max())
        bones = np.zeros((0 if s.bones is None else len(s.bones.start), 3))
        rubs = []
        if s.bones is not None:
            frames = self._frames(x)
            if s.actuator:
                rubs = self._touch(x, frames, force, bones, rubbing)
            self._load(x, frames, force, bones, tip_load)
        nodes = np.where(s.node_dofs >= 0, force, 0.0)
        if rubs and case.contact.friction:
            self._rub(rubs, nodes, bones)
        return Balance(nodes, bones, max(*acting, tip_load / 2), self.least)

    def _frames(self, x) -> list[tuple[np.ndarray, float]]:
        """(place (x, z) of its pivot, flexion) of every bone, from its nodes.

        Raises:
            ValueError: they did not move as one.
        """
        s, found = self.system, []
        for b, pivot in enumerate(s.bones.pivot):
            mine = s.body == b
            flat, now = s.straight[mine][:, [0, 2]] - [pivot, 0.0], x[mine][:, [0, 2]]
            (u, w), (p, q) = (flat - flat.mean(axis=0)).T, (now - now.mean(axis=0)).T
            angle = np.arctan2((w * p - u * q).sum(), (u * p + w * q).sum())
            turn = _turn(angle)
            place = now.mean(axis=0) - turn @ flat.mean(axis=0)
            if np.abs(flat @ turn.T + place - now).max() > 1e-8:
                raise ValueError(f"bone {b} is not rigid")
            found.append((place, angle))
        return found

    def _touch(self, x, frames, force, bones, rubbing) -> list:
        """Add what contact does; returns (node pair, shares, bone, place, direction of the axis, normal N) of
        every pair that touches in a bore."""
        s, case = self.system, self.case
        finger, rubs = case.finger, []
        low, high = s.bones.start.copy(), s.bones.end
        low[0] = -np.inf
        rest = (s.actuator.grid.nodes[s.pair_nodes] * s.pair_shares[..., None]).sum(axis=1)
        point = (x[s.pair_nodes] * s.pair_shares[..., None]).sum(axis=1)
        for b, (place, angle) in enumerate(frames):
            mine = np.flatnonzero(s.pair_bodies == b)
            if not len(mine):
                continue
            back = _turn(angle).T
            kinds, area = s.pair_kinds[mine], s.pair_areas[mine]

            def seen(p, back=back, place=place, b=b):
                along, up = (p[:, [0, 2]] - place) @ back.T, p[:, 1]
                return np.stack([s.bones.pivot[b] + along[:, 0], up, along[:, 1]], -1)

            def gap(p, b=b, kinds=kinds, seen=seen):
                at = seen(p)
                rims = np.stack([low[b] + contact.RIM - at[:, 0], at[:, 0] - high[b] + contact.RIM])
                bore = finger.bore(at[:, 0]) + (np.clip(rims, 0, None) ** 2).sum(axis=0) / (2 * contact.RIM)
                radial = bore - np.hypot(at[:, 1], at[:, 2]) / s.actuator.swell
                return np.where(kinds == contact.FACE, high[b] - at[:, 0], radial)

            def energy(p, area=area, mine=mine, seen=seen, gap=gap):
                if case.contact.bonded:
                    return contact.PENALTY * area / 2 * ((seen(p) - rest[mine]) ** 2).sum(axis=1)
                deep, soft = np.clip(-gap(p), 0, None), contact.SOFT
                return contact.PENALTY * area * np.where(
                    deep < 2 * soft, deep**3 / (12 * soft), (deep - soft) ** 2 / 2 + soft**2 / 6)

            pushed = np.stack([_slope(energy, point[mine], axis, FINE) for axis in range(3)], -1)
            np.add.at(force, s.pair_nodes[mine], pushed[:, None] * s.pair_shares[mine][..., None])
            arm = point[mine][:, [0, 2]] - place
            bones[b] -= _resultant(pushed, arm)
            deep = np.clip(-gap(point[mine]), 0, None)
            normal = contact.PENALTY * area * np.where(
                deep < 2 * contact.SOFT, deep**2 / (4 * contact.SOFT), deep - contact.SOFT)
            normal = normal if rubbing is None else rubbing[mine]
            axis = np.array([np.cos(angle), 0.0, -np.sin(angle)])
            for i in np.flatnonzero((normal > 0) & (kinds == contact.BORE)):
                e = mine[i]
                rubs.append((s.pair_nodes[e], s.pair_shares[e], b, arm[i], axis, normal[i]))
        return rubs

    def _load(self, x, frames, force, bones, tip_load) -> None:
        """Add to the bones what their nodes feel, own weight beyond the elements, the weight on the tip."""
        s, case = self.system, self.case
        gravity = np.array(case.gravity)
        along = gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0.0, -1.0])
        for b, (place, angle) in enumerate(frames):
            mine = s.body == b
            bones[b] += _resultant(force[mine], x[mine][:, [0, 2]] - place)
            dead = [(s.exoskeleton.mass_points[b],
                     s.exoskeleton.volumes[b] * case.tpu.density * gravity)]
            if b == len(frames) - 1:
                dead.append((np.array([case.finger.length, 0.0, 0.0]), tip_load / 2 * along))
            for at, pull in dead:
                arm = _turn(angle) @ (at[[0, 2]] - [s.bones.pivot[b], 0.0])
                bones[b] -= _resultant(pull[None], arm[None])

    def _rub(self, rubs, nodes, bones) -> None:
        """Add the friction, within mu times the normal forces, that balances nodes and bones best."""
        from scipy.optimize import lsq_linear

        s, scale = self.system, np.array([1.0, 1.0, 0.1])
        touched = np.unique([r[0] for r in rubs])
        row = {n: 3 * i for i, n in enumerate(touched)}
        ways = np.zeros((3 * len(touched) + 3 * len(bones), len(rubs)))
        for k, (pair, shares, b, arm, axis, _) in enumerate(rubs):
            for n, share in zip(pair, shares, strict=True):
                ways[row[n]:row[n] + 3, k] += share * np.where(s.node_dofs[n] >= 0, axis, 0.0)
            first = 3 * len(touched) + 3 * b
            if b:
                ways[first:first + 3, k] -= scale * _resultant(axis[None], arm[None])
        moving = np.vstack([0 * scale, bones[1:] * scale])
        right = np.concatenate([nodes[touched].ravel(), moving.ravel()])
        most = self.case.contact.friction * np.array([r[-1] for r in rubs])
        bounds = -most - 1e-12, most + 1e-12
        left = right + ways @ lsq_linear(ways, -right, bounds, tol=1e-14, max_iter=200).x
        if np.abs(left).max() > SHORT:
            # From inside, the search may stop short of the least: the exact one, ten times slower, decides.
            left = right + ways @ lsq_linear(ways, -right, bounds, method="bvls", tol=1e-14).x
        nodes[touched] = left[:3 * len(touched)].reshape(-1, 3)
        bones[1:] = left[3 * len(touched):].reshape(-1, 3)[1:] / scale


def _turn(angle: float) -> np.ndarray:
    """(x, z) turned by a flexion."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _resultant(force: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Force along x and z and moment (flexion positive) of forces (n, 3) at arms (n, 2)."""
    return np.array([force[:, 0].sum(), force[:, 2].sum(),
                     (force[:, 0] * arm[:, 1] - force[:, 2] * arm[:, 0]).sum()])


def _slope(energy, x: np.ndarray, axis: int, step: float, node: int | None = None) -> np.ndarray:
    """d energy (m,) / d coordinate `axis` of `node` of every piece; x (m, 3), or (m, n, 3) with a node."""
    total, at = 0.0, (slice(None), axis) if node is None else (slice(None), node, axis)
    for steps, weight in DIFFERENCE:
        moved = x.copy()
        moved[at] += steps * step
        total = total + weight / step * energy(moved)
    return total


def _add(force: np.ndarray, x: np.ndarray, pieces: np.ndarray, energy, step: float = STEP) -> None:
    """Add the forces of an energy of pieces (m, n) to those of their nodes."""
    places = x[pieces]
    for node in range(pieces.shape[1]):
        for axis in range(3):
            np.add.at(force[:, axis], pieces[:, node], _slope(energy, places, axis, step, node))


def _shapes(count: int, points: np.ndarray = GAUSS) -> np.ndarray:
    """(g, n) shape functions, as products that vanish at all other nodes."""
    own = np.array(CORNERS_AND_EDGES[:count], float) - 1
    found = np.empty((len(points), count))
    for n, (a, b, c) in enumerate(own):
        x, y, z = points.T
        if count == 8:
            found[:, n] = (1 + a * x) * (1 + b * y) * (1 + c * z) / 8
        elif 0 not in (a, b, c):
            found[:, n] = (1 + a * x) * (1 + b * y) * (1 + c * z) * (a * x + b * y + c * z - 2) / 8
        else:
            factors = [1 - p * p if o == 0 else 1 + o * p for o, p in zip((a, b, c), (x, y, z), strict=True)]
            found[:, n] = np.prod(factors, axis=0) / 4
    return found


def _slopes(count: int) -> np.ndarray:
    """(g, n, 3) their derivatives by differences, exact for polynomials of second degree in each letter."""
    h = 0.25
    return np.stack([(_shapes(count, GAUSS + h * e) - _shapes(count, GAUSS - h * e)) / (2 * h)
                     for e in np.eye(3)], -1)
