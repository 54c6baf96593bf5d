"""The free actuator as the body of revolution that it is: `--solver revolution`.

Without own weight, on its axis and held all around, an actuator stays round, and half of its section says
everything. What turns round the axis stretches with its radius: F is the section's own gradient and, across,
r / R. A node therefore has a second self, which stands at (0, r, 0), moves as the first one's radius does and
has the gradient N / R across: so F = sum x_a grad N_a holds as in any solid, and `element.assemble` need not
know. Likewise a ring of thread is an edge from the axis to that second self. Everything is that of half the
body, a turn of pi, as in the solid model; so are the element (Q1P0), the laws, the thread and the solver.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from itertools import pairwise

import numpy as np
from numba import njit

from handgen.simulation import fibre
from handgen.simulation.block import Block, Crew, assemble_blocks, extrapolate_blocks, kernel_law
from handgen.simulation.case import Case, Curve, Grid
from handgen.simulation.element import scatter
from handgen.simulation.loads import Load
from handgen.simulation.mesh import actuator_mesh, layers
from handgen.simulation.section import section
from handgen.simulation.solid import follow
from handgen.simulation.sparse import Pattern

NO_FRAMES, NO_CURVES = np.zeros((0, 3, 3)), np.zeros((0, 3))
"""No bone carries any node."""


def simulate(case: Case, progress: Callable[[str], None] | None = None) -> Curve:
    """Blow up the free actuator of `case` from no pressure through all of its points.

    Raises:
        ValueError: what does not stay round about its axis, a law that the kernels do not know, or a
            factoriser that there is not.
        ImportError: the factoriser's package is missing.
    """
    if case.part != "actuator" or case.extended or any(case.gravity):
        raise ValueError("a body of revolution is a free actuator on its axis, without own weight; it does "
                         f"not know {', '.join(case.extended) or 'own weight or an exoskeleton'}")
    return follow(case, lambda threads: Revolution(case, threads), progress)


class Revolution:
    """`case` as one system of equations for `solve.Solver`, as `system.System` is that of the solid model.

    Unknowns are displacements along the axis and away from it; `positions` are those of the solid's mesh.
    """

    bones = base = exoskeleton = None
    pair_nodes = turns = np.zeros(0, int)
    grip = 0.0

    def __init__(self, case: Case, threads: int = 1):
        self.case, self.crew = case, Crew(threads)
        self.section = section(case.actuator, case.winding, case.held, case.refine)
        self.actuator = actuator_mesh(case.actuator, case.winding, case.held, case.refine)
        self.drawn = self.unstrained = self.actuator.grid.nodes
        self.first = len(self.drawn)
        self._number()
        self._lay_out()
        self._wind()
        self.loads = self  # pressure alone
        self.inertia = self._inertia()

    def _number(self) -> None:
        """Unknowns: rows of `dofs` are nodes, their second selves and, last, the one place on the axis."""
        x, radius = self.section.nodes.T
        free = x > self.case.held
        kept = np.stack([free, free & (radius > 0.0)], -1)
        self._own = np.full(kept.shape, -1)
        self._own[kept] = np.arange(kept.sum())
        self.size, self._count = int(kept.sum()), len(kept)
        none, zero = np.full(len(kept), -1), np.zeros(len(kept))
        self.dofs = np.vstack([np.stack([self._own[:, 0], none, self._own[:, 1]], -1),
                               np.stack([none, self._own[:, 1], none], -1), [[-1, -1, -1]]])
        self._straight = np.vstack([np.stack([x, zero, radius], -1), np.stack([zero, radius, zero], -1),
                                    [[0.0, 0.0, 0.0]]])

    def _lay_out(self) -> None:
        """Elements, rings of thread and the chamber's lines, and where their matrices' entries go."""
        s, silicone = self.section, self.case.silicone
        cells = np.hstack([s.cells, s.cells + self._count])
        self._rings = np.stack([np.full(len(s.wound), 2 * self._count), s.wound + self._count], -1)
        solid, rings = self.dofs[cells].reshape(-1, 24), self.dofs[self._rings].reshape(-1, 6)
        lines = self._own[s.chamber].reshape(-1, 4)
        self.pattern = Pattern([solid, rings, lines], self.size)
        form, constants = kernel_law(silicone.law)
        self._block = Block(cells, *s.points(), form, constants, silicone.bulk, True,
                            np.zeros(len(cells), bool), solid, self.pattern.places[0])
        self._ring_group, self._line_group = zip((rings, lines), self.pattern.places[1:], strict=True)

    def _wind(self) -> None:
        """The rings' length, stiffness and tension, as of edges from the axis."""
        w, s = self.case.winding, self.section
        self._radius, self.tension = s.nodes[s.wound, 1], np.zeros(len(s.wound))
        wire = w.young * np.pi * w.diameter**2 / 4 / w.pitch if w else 0.0
        self._stiffness, self._compressive = np.pi * s.span * wire, w.compressive if w else 0.0

    def _inertia(self) -> np.ndarray:
        """(n,) what artificial time drags on each unknown: the elements' volumes, evenly, over their mean."""
        volume = np.zeros(self._count)
        np.add.at(volume, self.section.cells, self._block.weight.sum(axis=1, keepdims=True) / 4)
        kept = self._own >= 0
        return np.broadcast_to(volume[:, None], kept.shape)[kept] / volume.mean()

    # Places

    @property
    def grids(self) -> dict[str, Grid]:
        return {"actuator": self.actuator.grid}

    def positions(self, q: np.ndarray) -> np.ndarray:
        """(N, 3) nodes of the solid's mesh, mm, moved as the section is where they lie."""
        from scipy.interpolate import RegularGridInterpolator

        s = self.section
        moved = np.where(self._own >= 0, q[self._own], 0.0)
        lattice = np.where(s.number[:, :, None] >= 0, moved[s.number], 0.0)
        along, out = RegularGridInterpolator((s.x, s.depth), lattice)(self._seen).T
        radius = np.hypot(self.drawn[:, 1], self.drawn[:, 2])
        grown = 1.0 + self.actuator.swell * np.divide(out, radius, out=np.zeros_like(out), where=radius > 0)
        return np.stack([self.drawn[:, 0] + along, *(self.drawn[:, 1:] * grown[:, None]).T], -1)

    @cached_property
    def _seen(self) -> np.ndarray:
        """(N, 2) station, mm, and row (`Section.depth`) at which the nodes of the solid's mesh lie."""
        x = np.maximum(self.drawn[:, 0], self.case.held)
        radius = np.hypot(self.drawn[:, 1], self.drawn[:, 2]) / self.actuator.swell
        rows = np.insert(layers(self.case.actuator, self.case.winding, x), 0, 0.0, axis=1).T
        return np.stack([x, sum(np.clip((radius - a) / (b - a), 0, 1) for a, b in pairwise(rows))], -1)

    # Equilibrium

    def assemble(self, q: np.ndarray, load: Load, *, exact: bool):
        """(energy, force, matrix values, least J) as `system.System.assemble` gives them."""
        x = self._placed = self._straight + self._moved(q)
        force, matrix = np.zeros(self.size), np.zeros(self.pattern.entries)
        energy, least = assemble_blocks([self._block], self.crew, x, NO_FRAMES, NO_CURVES, load.lost, exact,
                                        force, matrix)
        if least <= 0.0:
            return np.inf, force, matrix, least
        energy += fibre.add_threads(x, self._rings, self._radius, self._stiffness, self._compressive,
                                    self.tension, exact, *self._ring_group, force, matrix)
        self._inner = force.copy()
        energy += add_pressure(x, self.section.chamber, load.pressure, *self._line_group, force, matrix)
        return energy, force, matrix, least

    def reload(self, q: np.ndarray, load: Load) -> np.ndarray:
        """Force out of balance, N, under another load at `q`, where the system was assembled last."""
        return self._inner + self._blown(self._placed, load.pressure)

    def _blown(self, x: np.ndarray, pressure: float) -> np.ndarray:
        force = np.zeros(self.size)
        add_pressure(x, self.section.chamber, pressure, *self._line_group, force,
                     np.zeros(self.pattern.entries))
        return force

    def _moved(self, step: np.ndarray) -> np.ndarray:
        """(2 n + 1, 3) what nodes and second selves do in a `step`."""
        return np.where(self.dofs >= 0, step[self.dofs], 0.0)

    def extrapolate(self, q: np.ndarray, step: np.ndarray) -> None:
        """Set the stresses that Newton extrapolates to those after `step`, as the solid model does."""
        moved = self._moved(step)
        extrapolate_blocks([self._block], self.crew, moved)
        fibre.extrapolate_threads(self._placed, moved, self._rings, self._radius, self._stiffness,
                                  self._compressive, self.tension)

    def coupling(self) -> None:
        """Nothing rubs."""

    def accept(self, q: np.ndarray) -> None:
        """Nothing slides."""

    def largest(self, load: Load) -> float:
        """The largest force that acts on an unknown under `load`, N."""
        return self._broadest * load.pressure

    @cached_property
    def _broadest(self) -> float:
        """mm2, through which pressure acts on an unknown at most."""
        return float(np.abs(self._blown(self._straight, 1.0)).max())


@njit(cache=True)
def add_pressure(x, lines, pressure, dofs, place, force, matrix):
    """Add the forces of `pressure`, MPa, on `lines` (f, 2) turned by half a circle, and their tangent;
    returns -p V, V that of the frusta beneath. dofs (f, 4): along and away from the axis, by node."""
    fe, ke = np.zeros((2, 3)), np.zeros((4, 4))
    push = fe.reshape(6)
    total, p = 0.0, np.pi * pressure / 6
    for e in range(len(lines)):
        a, b = x[lines[e, 0], 2], x[lines[e, 1], 2]
        dx, da, db, area = x[lines[e, 1], 0] - x[lines[e, 0], 0], 2 * a + b, 2 * b + a, a * a + a * b + b * b
        total += area * dx
        push[0], push[1], push[2], push[3] = p * area, -p * dx * da, -p * area, -p * dx * db
        ke[0, 1] = ke[1, 0] = p * da
        ke[0, 3] = ke[3, 0] = p * db
        ke[2, 1] = ke[1, 2] = -p * da
        ke[2, 3] = ke[3, 2] = -p * db
        ke[1, 1] = ke[3, 3] = -2 * p * dx
        ke[1, 3] = ke[3, 1] = -p * dx
        scatter(dofs[e], place[e], fe, ke, force, matrix)
    return -p * total
