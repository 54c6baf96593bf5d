"""Stress and tangent of a law at a right Cauchy-Green tensor: what a finite-element kernel computes.

The plain statement, vectorised over points, for verifying a kernel and for studies; a kernel may fuse the
same products. Laws of the invariants need C alone; separable ones an eigen-decomposition, in whose axes
the tangent has 6 + 3 different entries: 4 W_ab, and twice the quotients on the shear terms.
Formulas: G. A. Holzapfel, Nonlinear Solid Mechanics (Wiley 2000), sections 6.4 to 6.6.
"""

from __future__ import annotations

import numpy as np

from handgen.materials.law import PAIRS, Law

IDENTITY = np.eye(3)


def symmetric_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(a_ik b_jl + a_il b_jk)/2, shape (..., 3, 3, 3, 3)."""
    return (np.einsum("...ik,...jl->...ijkl", a, b) + np.einsum("...il,...jk->...ijkl", a, b)) / 2


def outer(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a_ij b_kl, shape (..., 3, 3, 3, 3)."""
    return np.einsum("...ij,...kl->...ijkl", a, b)


def plain(law: Law, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """W, S = 2 dW/dC and 4 d2W/dC2 of the strain energy as it is written, MPa, at `c`, shape (..., 3, 3).

    S counts up to a pressure only: a law says nothing about volume; see `isochoric`.
    """
    return _by_invariants(law, c) if law.energy.FORM == "invariants" else _by_directions(law, c)


def isochoric(law: Law, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """W, second Piola-Kirchhoff stress, its tangent dS/dE, MPa, of W(J^(-2/3) C); `c`: shape (..., 3, 3).

    The deviatoric half of a nearly incompressible material: a volumetric energy U(J) is added by the kernel.
    """
    shrink = np.linalg.det(c) ** (-1 / 3)
    inverse = np.linalg.inv(c)
    value, own, rate = plain(law, shrink[..., None, None] * c)
    own = shrink[..., None, None] * own
    rate = shrink[..., None, None, None, None] ** 2 * rate
    trace = np.einsum("...ij,...ij->...", own, c)
    stress = own - trace[..., None, None] / 3 * inverse
    project = symmetric_product(IDENTITY, IDENTITY) - outer(inverse, c) / 3
    tangent = np.einsum("...ijmn,...mnpq,...klpq->...ijkl", project, rate, project)
    volume = symmetric_product(inverse, inverse) - outer(inverse, inverse) / 3
    tangent = tangent + 2 / 3 * trace[..., None, None, None, None] * volume
    tangent = tangent - 2 / 3 * (outer(inverse, stress) + outer(stress, inverse))
    return value, stress, tangent


def _by_invariants(law: Law, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    i1 = np.trace(c, axis1=-2, axis2=-1)
    i2 = (i1**2 - np.einsum("...ij,...ij->...", c, c)) / 2
    w1, w2 = law.energy.first(i1, i2, *law.constants)
    w11, w12, w22 = (w[..., None, None, None, None] for w in law.energy.second(i1, i2, *law.constants))
    b = i1[..., None, None] * IDENTITY - c  # dI2/dC
    stress = 2 * (w1[..., None, None] * IDENTITY + w2[..., None, None] * b)
    one = np.broadcast_to(IDENTITY, c.shape)
    tangent = w11 * outer(one, one) + w12 * (outer(one, b) + outer(b, one)) + w22 * outer(b, b)
    second_of_i2 = outer(one, one) - symmetric_product(one, one)
    tangent = tangent + w2[..., None, None, None, None] * second_of_i2
    return law.energy.value(i1, i2, *law.constants), stress, 4 * tangent


def _by_directions(law: Law, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    x, axes = np.linalg.eigh(c)
    response = law.response(x)
    local = np.zeros((*x.shape[:-1], 3, 3, 3, 3))
    for a in range(3):
        for b in range(3):
            local[..., a, a, b, b] = 4 * response.second[..., a, b]
    for k, (a, b) in enumerate(PAIRS):
        for i, j in ((a, b), (b, a)):
            local[..., i, j, i, j] = local[..., i, j, j, i] = 2 * response.quotient[..., k]
    stress = np.einsum("...ia,...a,...ja->...ij", axes, 2 * response.first, axes)
    tangent = np.einsum(
        "...ia,...jb,...kc,...ld,...abcd->...ijkl", axes, axes, axes, axes, local, optimize=True
    )
    return response.value, stress, tangent
