"""The points of an element side by side, LANES of them.

All numbers of an element lie in one flat room, a row of LANES numbers for each quantity, and loops run along
the rows. As the distances between rows are known, the compiler turns such a loop into vector instructions: an
element's points together cost little more than one of them alone.
"""

from __future__ import annotations

from itertools import accumulate

import numpy as np
from numba import njit

KERNEL = {"cache": True, "fastmath": {"contract"}, "error_model": "numpy"}
"""How the kernels are compiled: products and sums in one instruction, nothing else taken for granted; a
division by zero gives what IEEE says, where Python's check before every division would cost a third."""
L = LANES = 8
"""Where an element has fewer points, the other lanes idle."""
(AXES, MOVED, STRESS, SQUARED, SHEAR, MODULI, GRADIENT, VOLUME, ENERGY, METRIC, SLOPE, CURVE, ACTING, HELD,
 TOTAL, PRESSURE, TANGENT, ROOM) = (LANES * rows for rows in accumulate(
     (9, 9, 3, 3, 3, 6, 9, 1, 1, 6, 3, 6, 6, 6, 3, 1, 81), initial=0))
"""Where the rows of a room begin:

AXES N_ia and MOVED (F N)_ia, 3 i + a; STRESS S_a; SQUARED x_a; SHEAR Q of the pairs 01, 12 and 20; MODULI D
of 00, 11, 22, 01, 12 and 20; GRADIENT F_ij, 3 i + j; VOLUME J; ENERGY W; METRIC C of 00, 11, 22, 01, 02, 12;
of a law SLOPE and its derivatives CURVE, as D; ACTING: the stresses that Newton extrapolates, in the body's
own axes, as C; HELD: T, as D; TOTAL: S_a and the pressure's share; PRESSURE: the acting one; TANGENT: A.
"""
KEPT = GRADIENT
"""Numbers at the beginning of a room that are kept: all that `element.extrapolate` needs."""
STRESSES = 6 * LANES
"""Numbers of an element's ACTING stresses."""


@njit(**KERNEL)
def room():
    """Room for one element's points; those that idle are at rest."""
    w = np.zeros(ROOM)
    for g in range(L):
        w[GRADIENT + g] = w[GRADIENT + 4 * L + g] = w[GRADIENT + 8 * L + g] = w[VOLUME + g] = 1.0
    return w


@njit(**KERNEL)
def three(w, row, g):
    """What stands in lane g of `row` and the two after it."""
    return w[row + g], w[row + L + g], w[row + 2 * L + g]


@njit(**KERNEL)
def put(w, row, g, a, b, c):
    """Write lane g of `row` and the two after it."""
    w[row + g], w[row + L + g], w[row + 2 * L + g] = a, b, c


@njit(**KERNEL)
def thirds(w, row, g):
    """What stands in lane g of `row` and the third and the sixth after it: a column of a matrix."""
    return w[row + g], w[row + 3 * L + g], w[row + 6 * L + g]
