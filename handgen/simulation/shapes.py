"""Shape functions of the two elements and their gradients at the points of integration."""

from __future__ import annotations

from functools import cache

import numpy as np

from handgen.simulation.exoskeleton import CORNERS_AND_EDGES

POINT = 1.0 / np.sqrt(3.0)
GAUSS = np.array([(a, b, c) for a in (-POINT, POINT) for b in (-POINT, POINT) for c in (-POINT, POINT)])
"""2 x 2 x 2 points, each of weight 1."""


@cache
def nodes_of(count: int) -> np.ndarray:
    """(count, 3) places of the nodes in the element's own cube [-1, 1]^3, VTK's order."""
    return np.array(CORNERS_AND_EDGES[:count], float) - 1.0


def slopes(count: int, points: np.ndarray) -> np.ndarray:
    """(g, count, 3) derivatives of the shape functions at `points` (g, 3).

    8 nodes: trilinear. 20: serendipity, corners (1 + a)(1 + b)(1 + c)(a + b + c - 2)/8, edges
    (1 - a^2)(1 + b)(1 + c)/4, each letter a coordinate times the node's own.
    """
    own = nodes_of(count)
    p = points[:, None, :] * own  # letters; zero where a node lies in the middle of an edge
    one = 1.0 + p
    found = np.empty((len(points), count, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        if count == 8:
            found[:, :, i] = own[:, i] * one[:, :, j] * one[:, :, k] / 8
            continue
        corner = own[:, i] * one[:, :, j] * one[:, :, k] * (2 * p[:, :, i] + p[:, :, j] + p[:, :, k] - 1) / 8
        # Edges: the middle letter's factor is 1 - point^2, not 1 + letter.
        middle = -points[:, None, i] / 2 * one[:, :, j] * one[:, :, k]
        bubble = 1.0 - points[:, None, :] ** 2
        others = [np.where(own[:, n] == 0, bubble[:, :, n] * np.ones(count), one[:, :, n]) for n in (j, k)]
        side = own[:, i] * others[0] * others[1] / 4
        edge = np.where(own[:, i] == 0, middle, side)
        found[:, :, i] = np.where((own == 0).any(axis=1), edge, corner)
    return found


def values(count: int, points: np.ndarray = GAUSS) -> np.ndarray:
    """(g, count) shape functions at `points` (g, 3)."""
    own = nodes_of(count)
    one = 1.0 + points[:, None, :] * own
    if count == 8:
        return one.prod(axis=2) / 8
    corner = one.prod(axis=2) * ((points[:, None, :] * own).sum(axis=2) - 2) / 8
    bubble = 1.0 - points[:, None, :] ** 2
    edge = np.where(own == 0, bubble, one).prod(axis=2) / 4
    return np.where((own == 0).any(axis=1), edge, corner)


def gradients(nodes: np.ndarray, cells: np.ndarray, points: np.ndarray = GAUSS):
    """(dn (m, g, 3, n), volume (m, g)) of `cells` (m, n) at `points`, with respect to drawn places."""
    local = slopes(cells.shape[1], points)
    jacobian = np.einsum("mni,gnj->mgij", nodes[cells], local)
    volume = np.linalg.det(jacobian)
    dn = np.einsum("gnj,mgji->mgin", local, np.linalg.inv(jacobian))
    return np.ascontiguousarray(dn), volume
