"""Half of the section of a free actuator by a plane through its axis, as quadrilaterals.

Rows of nodes from the axis through the chamber's wall and the thread to the outside, in the places of the
real profile: a body of revolution needs no polygons. Elements end where the thread does, and are short there.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from handgen.geometry.profile import ActuatorProfile
from handgen.simulation.case import Winding
from handgen.simulation.mesh import graded, layers

ROWS = (3, 3, 2)
"""Elements across the closed tip's core, the wall inside the thread and the wall outside it."""
END_EDGE, TIP_EDGE = 0.5, 0.33
"""Length along the axis, mm, of elements at the ends of the chamber and of the thread, and in the closed tip:
there, as through the wall, the strain varies most. By all of them a free actuator's elongation is a fifth of
a percent less than NGSolve's finest (`python -m tests.benchmarks.bend_reference speed`)."""
ROUNDED = 1e-9
"""mm."""
CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)


@dataclass(frozen=True)
class Section:
    """Stations and rows form a lattice, whose nodes are numbered station by station."""

    x: np.ndarray
    """(s,) stations, mm."""
    depth: np.ndarray
    """(r,) rows: 0 the axis, 1 the chamber's wall, 2 the thread, 3 the outside."""
    number: np.ndarray
    """(s, r) of the lattice's nodes; -1 in the chamber."""
    nodes: np.ndarray
    """(n, 2) places x and radius, mm."""
    cells: np.ndarray
    """(m, 4) corners, counterclockwise."""
    chamber: np.ndarray
    """(f, 2) lines along the chamber's wall and its end, from the base to the axis."""
    wound: np.ndarray
    """(k,) nodes on the thread, and ..."""
    span: np.ndarray
    """(k,) ... the length along the axis, mm, that each stands for."""

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """(dn (m, 4, 3, 8), volume (m, 4) mm3) of the elements' 2 x 2 points, turned by half a circle.

        Gradients of the nodes along x and away from the axis, then those across of their second selves
        (`handgen.simulation.revolution`).
        """
        one = 1 + CORNERS[:, None, :] / np.sqrt(3.0) * CORNERS
        values, slopes = one.prod(axis=2) / 4, CORNERS * one[:, :, ::-1] / 4
        local = np.einsum("gni,mnj->mgij", slopes, self.nodes[self.cells])
        radius = self.nodes[self.cells, 1] @ values.T
        dn = np.zeros((len(self.cells), 4, 3, 8))
        dn[:, :, ::2, :4] = np.einsum("mgij,gnj->mgin", np.linalg.inv(local), slopes)
        dn[:, :, 1, 4:] = values / radius[:, :, None]
        return dn, np.pi * radius * np.linalg.det(local)


def section(profile: ActuatorProfile, winding: Winding | None, held: float, refine: int) -> Section:
    """The section beyond x = `held`, mm; `refine` halves the edges so many times."""
    fine, chamber = 2**refine, profile.small_core_end
    ends = np.unique(np.clip([held, *((winding.start, winding.end) if winding else ()), chamber],
                             held, chamber))
    hollow = np.concatenate([[held], *(graded(a, b, fine, END_EDGE)[1:] for a, b in pairwise(ends))])
    tip = fine * max(1, round((profile.length - chamber) / TIP_EDGE))
    x = np.concatenate([hollow, _even(chamber, profile.length, tip)])
    cap, wall, thread = len(hollow) - 1, fine * ROWS[0], fine * (ROWS[0] + ROWS[1])
    depth = np.concatenate([[0.0], *(_even(n, n + 1.0, fine * count) for n, count in enumerate(ROWS))])
    radii = np.insert(layers(profile, winding, x), 0, 0.0, axis=1)
    radius = np.stack([np.interp(depth, np.arange(4), row) for row in radii])
    i, j = np.indices(radius.shape)
    there = (j >= wall) | (i >= cap)
    number = np.where(there, np.cumsum(there).reshape(there.shape) - 1, -1)
    i, j = (index[:-1, :-1][there[:-1, :-1]] for index in (i, j))
    cells = np.stack([number[i + a, j + b] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], -1)
    edge = np.concatenate([number[:cap, wall], number[cap, wall::-1]])
    return Section(x, depth, number, np.stack([x[:, None] + 0 * radius, radius], -1)[there], cells,
                   np.stack([edge[:-1], edge[1:]], -1), *_wound(x, number[:, thread], winding))


def _wound(x: np.ndarray, row: np.ndarray, winding: Winding | None) -> tuple[np.ndarray, np.ndarray]:
    """Nodes between the first and the last turn, with half of the wound elements beside them."""
    span = np.zeros(len(x))
    if winding is not None:
        wound = (x[:-1] > winding.start - ROUNDED) & (x[1:] < winding.end + ROUNDED)
        half = np.where(wound, np.diff(x), 0.0) / 2
        span[:-1] += half
        span[1:] += half
    there = span > 0
    return row[there], span[there]


def _even(start: float, end: float, count: int) -> np.ndarray:
    """`count` stations after `start`, the last of them `end`."""
    return np.linspace(start, end, count + 1)[1:]
