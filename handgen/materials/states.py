"""Homogeneous states of an incompressible material: nominal stress against stretch.

In each state the squared principal stretches are powers of one stretch, x_a = s^k_a, so energy and
derivatives along it follow from a law's response without a formula per law: work of one of the `m`
equal pulling directions gives P = (dW/ds)/m.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handgen.materials.law import Law


class State(NamedTuple):
    """x_a = s^powers_a; `pulled` directions carry the same nominal stress."""

    name: str
    powers: tuple[int, int, int]
    pulled: int


UNIAXIAL = State("uniaxial", (2, -1, -1), 1)
PLANAR = State("planar", (2, 0, -2), 1)
"""Pure shear: one direction held; the state of a thread-wrapped tube that lengthens."""
EQUIBIAXIAL = State("equibiaxial", (2, 2, -4), 2)
STATES = (UNIAXIAL, PLANAR, EQUIBIAXIAL)


def squared_stretches(state: State, stretch: np.ndarray) -> np.ndarray:
    """Squared principal stretches of `state`, shape (..., 3)."""
    return np.asarray(stretch)[..., None] ** np.array(state.powers, dtype=float)


def nominal_stress(law: Law, state: State, stretch: np.ndarray) -> np.ndarray:
    """Force per undeformed area in the pulled direction, MPa, at `stretch` (1 is unloaded)."""
    x = squared_stretches(state, stretch)
    k = np.array(state.powers)
    return (law.response(x).first * k * x).sum(-1) / (state.pulled * np.asarray(stretch))


def slope(law: Law, state: State, stretch: np.ndarray) -> np.ndarray:
    """d(nominal stress)/d(stretch), MPa; 3 G, 4 G and 6 G at stretch 1."""
    s = np.asarray(stretch)
    x = squared_stretches(state, s)
    k = np.array(state.powers)
    response = law.response(x)
    rate = k * x / s[..., None]
    bend = k * (k - 1) * x / s[..., None] ** 2
    along = np.einsum("...a,...ab,...b->...", rate, response.second, rate)
    return (along + (response.first * bend).sum(-1)) / state.pulled


def simple_shear_stress(law: Law, shear: np.ndarray) -> np.ndarray:
    """Shear stress, MPa, at the amount of shear gamma = s - 1/s of the principal stretch s.

    The energy is the planar one; d(gamma)/ds = 1 + 1/s^2 turns its derivative into the stress.
    """
    s = shear / 2 + np.sqrt(1 + np.square(shear) / 4)
    return nominal_stress(law, PLANAR, s) / (1 + s**-2.0)
