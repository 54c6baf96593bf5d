"""The thread: rings of straight edges whose stiffness is that of the turns they stand for.

A turn of pitch s climbs by atan(s / (2 pi r)), 2 to 3 degrees here: its rings are drawn flat, which also
keeps the half model's symmetry. An edge of length L stands for span / s turns:

    energy = c E A span/s L/2 (l/L - 1)^2,  c = 1 under tension, a small share under compression

A thread pulls; bedded in silicone it buckles when it is pushed. Stiff both ways, rings of edges would
buckle as rings. The knee is rounded over KNEE of strain so that Newton does not rattle on it; a thread on a
bedding of k N/mm per mm holds even longer, up to sqrt(k / (pi E)) of strain (S. P. Timoshenko, J. M. Gere,
Theory of Elastic Stability, 1961, section 2.10), some 3e-3 with the silicone's modulus for k. It shows only
where no pressure pulls: with a knee that is sharp a free actuator hangs 0.6 of 12 mm lower by its own weight.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from handgen.simulation.element import scatter

KNEE = 4e-4
"""Compressive strain over which the stiffness falls to that of a pushed thread."""


@njit(cache=True)
def pull(strain, share):
    """(energy, force, stiffness) per unit of stiffness at `strain`."""
    lost = 1.0 - share
    if strain >= 0.0:
        return 0.5 * strain**2, strain, 1.0
    if strain > -KNEE:
        return (strain**2 * (0.5 + lost * strain / (6 * KNEE)), strain * (1 + lost * strain / (2 * KNEE)),
                1 + lost * strain / KNEE)
    beyond, at = strain + KNEE, -KNEE * (1 - lost / 2)
    return KNEE**2 * (0.5 - lost / 6) + beyond * (at + share * beyond / 2), at + share * beyond, share


@njit(cache=True)
def add_threads(x, ends, length, stiffness, share, tension, exact, dofs, place, force, matrix):
    """Add all edges' forces and tangent; returns their energy.

    ends (k, 2) nodes; length (k,) mm; stiffness (k,) N; tension (k,) N the extrapolated one, which the
    geometric stiffness takes unless `exact`.
    """
    fe, ke, n = np.empty((2, 3)), np.empty((6, 6)), np.empty(3)
    energy = 0.0
    for e in range(len(ends)):
        size = 0.0
        for i in range(3):
            n[i] = x[ends[e, 1], i] - x[ends[e, 0], i]
            size += n[i] * n[i]
        size = np.sqrt(size)
        n /= size
        w, pulled, stiff = pull(size / length[e] - 1.0, share)
        energy += stiffness[e] * length[e] * w
        now = stiffness[e] * pulled
        along, across = stiffness[e] * stiff / length[e], (now if exact else tension[e]) / size
        for i in range(3):
            fe[0, i], fe[1, i] = -now * n[i], now * n[i]
            for j in range(3):
                k = (along - across) * n[i] * n[j] + (across if i == j else 0.0)
                ke[i, j] = ke[3 + i, 3 + j] = k
                ke[3 + i, j] = ke[i, 3 + j] = -k
        scatter(dofs[e], place[e], fe, ke, force, matrix)
    return energy


@njit(cache=True)
def extrapolate_threads(x, step, ends, length, stiffness, share, tension):
    """Write the tension after the nodes' `step`, to first order."""
    for e in range(len(ends)):
        size, grown = 0.0, 0.0
        for i in range(3):
            d = x[ends[e, 1], i] - x[ends[e, 0], i]
            size += d * d
            grown += d * (step[ends[e, 1], i] - step[ends[e, 0], i])
        size = np.sqrt(size)
        _, pulled, stiff = pull(size / length[e] - 1.0, share)
        tension[e] = stiffness[e] * (pulled + stiff * grown / size / length[e])
