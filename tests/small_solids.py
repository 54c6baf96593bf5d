"""Simple bodies for the element's tests: a mapped block of hexahedra, held and pushed, solved by Newton.

All that computes forces is the project's own (`element.assemble`, `sparse.Pattern`, `cavity`, `shapes`);
meshes, supports and Newton are not (it too extrapolates stresses). Units mm, N, MPa.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from handgen.materials.law import Law, law, ogden_law
from handgen.simulation import cavity, element, shapes
from handgen.simulation.block import kernel_law
from handgen.simulation.lanes import KEPT, LANES, STRESSES
from handgen.simulation.sparse import Pattern

LAWS = {
    "neo_hookean": law("neo_hookean", {"c10": 0.3}),
    "mooney_rivlin": law("mooney_rivlin", {"c10": 0.21, "c01": 0.525}),
    "yeoh": law("yeoh", {"c10": 0.3, "c20": -0.02, "c30": 0.004}),
    "ogden": ogden_law([0.4, 0.01, -0.2], [1.3, 5.0, -2.5], "mu/alpha"),
}
"""One of each kind that the kernels know; moduli near 1 MPa, constants of both signs."""
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""Of VTK's hexahedron; its edges' middles are nodes 8 to 19."""


def block(counts: tuple[int, int, int], nodes: int, place: Callable[[np.ndarray], np.ndarray] | None = None):
    """(nodes (n, 3), cells (m, 8 or 20), their unit places (n, 3)) of the unit cube carried by `place`."""
    corner = np.array(CORNERS)
    local = 2 * corner
    if nodes == 20:
        local = np.vstack([local, [corner[a] + corner[b] for a, b in EDGES]])
    size = 2 * np.array(counts) + 1
    i, j, k = (2 * np.arange(c) for c in counts)
    first = np.stack(np.meshgrid(i, j, k, indexing="ij"), -1).reshape(-1, 1, 3)
    number = np.ravel_multi_index(tuple(np.moveaxis(first + local, -1, 0)), size)
    used, cells = np.unique(number, return_inverse=True)
    unit = np.stack(np.unravel_index(used, size), -1) / (size - 1.0)
    return (unit if place is None else place(unit)), np.ascontiguousarray(cells.reshape(number.shape)), unit


def straightened(x: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Nodes with those in the middle of an edge moved half-way between its ends."""
    x = x.copy()
    for middle, (a, b) in enumerate(EDGES[:cells.shape[1] - 8], start=8):
        x[cells[:, middle]] = (x[cells[:, a]] + x[cells[:, b]]) / 2
    return x


def crooked(counts: tuple[int, int, int], nodes: int):
    """(nodes, cells, unit places) of a block of distorted elements with straight edges."""
    x, cells, unit = block(counts, nodes, distorted)
    return straightened(x, cells), cells, unit


def distorted(unit: np.ndarray, size=(2.0, 1.5, 1.0), by: float = 0.06) -> np.ndarray:
    """A box whose inner nodes lie off the grid, smoothly, so that no two elements are alike."""
    off = np.sin(np.pi * unit).prod(axis=1)[:, None] * np.cos(7 * unit[:, [1, 2, 0]] + [0, 1, 2])
    return (unit + by * off) * size


@dataclass
class Body:
    """Elements of one material; every node has three unknowns, some of them prescribed."""

    nodes: np.ndarray
    cells: np.ndarray
    law: Law
    bulk: float
    faces: np.ndarray = field(default_factory=lambda: np.zeros((0, 4), int))
    """(f, 4) of a chamber, their normals out of the air."""

    def __post_init__(self):
        self.mean = self.cells.shape[1] == 8
        self.dn, self.weight = shapes.gradients(self.nodes, self.cells)
        self.form, self.constants = kernel_law(self.law)
        dofs = np.arange(self.nodes.size).reshape(-1, 3)
        self.dofs = [dofs[self.cells].reshape(len(self.cells), -1), dofs[self.faces].reshape(-1, 12)]
        self.pattern = Pattern(self.dofs, self.nodes.size)
        m, n = len(self.cells), len(self.nodes)
        self.stress, self.pressure = np.zeros((m, STRESSES)), np.zeros((m, LANES))
        self.kept = np.zeros((m, KEPT))
        self.swell = np.zeros((m, 3 * self.cells.shape[1] + 1))
        self.free_of_bodies = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(m, bool)

    def assemble(self, x: np.ndarray, air: float = 0.0, exact: bool = True):
        """(energy, force (n, 3), stiffness as a sparse matrix) at places `x`; `air` MPa in the chamber."""
        from scipy.sparse import csc_matrix, tril

        force, values = np.zeros(self.nodes.size), np.zeros(self.pattern.entries)
        frames, curves, framed = self.free_of_bodies
        energy, least = element.assemble(
            x, self.cells, self.dn, self.weight, self.form, self.constants, self.bulk, self.mean, self.stress,
            self.pressure, exact, self.kept, self.swell, self.dofs[0], self.pattern.places[0],
            frames, curves, framed, force, values)
        assert least > 0, "an element is turned inside out"
        if air:
            energy += cavity.add_pressure(
                x, self.faces, air, self.dofs[1], self.pattern.places[1], force, values)
        p = self.pattern
        lower = csc_matrix((values, (p.rows, p.columns)), shape=(p.size, p.size))
        return energy, force.reshape(-1, 3), (lower + tril(lower, -1).T).tocsc()

    def extrapolate(self, x: np.ndarray, step: np.ndarray) -> None:
        self.assemble(x)
        element.extrapolate(step, self.cells, self.dn, self.weight, self.bulk, self.mean, self.kept,
                            self.swell, self.stress, self.pressure)

    def solve(self, fixed: np.ndarray, place: Callable[[float], np.ndarray] | None = None, air: float = 0.0,
              steps: int = 4) -> tuple[np.ndarray, np.ndarray]:
        """(places, forces (n, 3) that hold the `fixed` (n, 3) ones) in balance.

        place(share): where the fixed ones are (n, 3), `share` 0 to 1; they stay by default.
        """
        from scipy.sparse.linalg import splu

        x, free = self.nodes.copy(), ~fixed.ravel()
        for share in np.linspace(0, 1, steps + 1)[1:]:
            target = self.nodes if place is None else place(share)
            move = np.where(fixed, target - x, 0.0).ravel()
            self.extrapolate(x, np.zeros_like(x))
            for _ in range(30):
                _, force, stiff = self.assemble(x, share * air, exact=False)
                step = move.copy()
                factor = splu(stiff[free][:, free], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=1e-3,
                              options={"SymmetricMode": True})
                step[free] = -factor.solve((force.ravel() + stiff @ move)[free])
                self.extrapolate(x, step.reshape(-1, 3))
                x, move = x + step.reshape(-1, 3), np.zeros_like(move)
                if np.abs(step).max() < 1e-11 * np.ptp(self.nodes):
                    break
            else:
                raise ArithmeticError("no balance")
        return x, self.assemble(x, air)[1]


WEIGHTS = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
"""Central difference of fourth order: steps and their weights."""


def slope_error(assemble, q: np.ndarray, step: float, directions: int = 4) -> tuple[float, float]:
    """Largest relative error of (force, stiffness) against differences of (energy, force).

    assemble(q) -> (energy, force (n,), stiffness with @); along random directions of largest entry 1.
    """
    rng = np.random.default_rng(0)
    _, force, stiff = assemble(q)
    worst = np.zeros(2)
    for _ in range(directions):
        way = rng.uniform(-1, 1, size=q.shape)
        slope, rate = 0.0, np.zeros_like(q)
        for steps, weight in WEIGHTS.items():
            ahead = assemble(q + steps * step * way)
            slope, rate = slope + weight / step * ahead[0], rate + weight / step * ahead[1]
        exact = stiff @ way
        worst = np.maximum(worst, [abs(slope - force @ way) / np.linalg.norm(force) / np.linalg.norm(way),
                                   np.abs(rate - exact).max() / np.abs(exact).max()])
    return tuple(worst)
