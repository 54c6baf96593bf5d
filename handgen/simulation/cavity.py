"""Pressure as the energy -p V of the enclosed volume: it follows the wall, and its tangent is symmetric.

V = sum over the chamber's faces of x . (x,s x x,t) / 3, for four-sided faces the mean of their two ways of
being split in triangles. The origin lies in the plane of the chamber's open end, and so does the plane of
symmetry: neither adds to the sum, and the faces alone give the volume.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from handgen.simulation.element import scatter

SPLITS = ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))


@njit(cache=True)
def add_pressure(x, faces, pressure, dofs, place, force, matrix):
    """Add the forces of `pressure`, MPa, on `faces` (f, 4), and their tangent; returns -p V."""
    fe, ke = np.empty((4, 3)), np.empty((12, 12))
    total = 0.0
    for e in range(len(faces)):
        fe[:] = 0.0
        ke[:] = 0.0
        for split in SPLITS:
            for turn in range(3):
                a, b, c = split[turn], split[(turn + 1) % 3], split[(turn + 2) % 3]
                p, q, r = x[faces[e, a]], x[faces[e, b]], x[faces[e, c]]
                for i in range(3):
                    j, k = (i + 1) % 3, (i + 2) % 3
                    normal = (q[j] * r[k] - q[k] * r[j]) / 12.0
                    fe[a, i] -= pressure * normal
                    if turn == 0:
                        total += p[i] * normal
                    # d2V / da_i db_j = e_ijk c_k / 12, and its mirror image.
                    ke[3 * a + i, 3 * b + j] -= pressure * r[k] / 12.0
                    ke[3 * b + j, 3 * a + i] -= pressure * r[k] / 12.0
                    ke[3 * a + i, 3 * b + k] += pressure * r[j] / 12.0
                    ke[3 * b + k, 3 * a + i] += pressure * r[j] / 12.0
        scatter(dofs[e], place[e], fe, ke, force, matrix)
    return -pressure * total


@njit(cache=True)
def volume(x, faces):
    """Volume enclosed by the half, mm3."""
    total = 0.0
    for e in range(len(faces)):
        for split in SPLITS:
            p, q, r = x[faces[e, split[0]]], x[faces[e, split[1]]], x[faces[e, split[2]]]
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                total += p[i] * (q[j] * r[k] - q[k] * r[j]) / 12.0
    return total
