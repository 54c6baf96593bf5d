"""Isotropic laws in principal axes: what an energy W(J^-2/3 C) answers to given squared stretches.

With x_a the eigenvalues of C, its squared stretches, and y_a = J^-2/3 x_a, the second Piola stress and its
derivative have the axes of C:

    S = sum S_a N_a N_a,  S_a = 2 dW/dx_a
    2 dS/dC = sum D_ab N_a N_a x N_b N_b + sum (a < b) Q_ab (N_a N_b + N_b N_a) x (N_a N_b + N_b N_a)
    D_ab = 2 dS_a/dx_b,  Q_ab = (S_a - S_b) / (x_a - x_b)

(R. W. Ogden, Non-linear elastic deformations, 1984, section 6.1.4). A law is a function of y; it gives its
slopes y dW/dy and their derivatives, and needs no tensor.
"""

from __future__ import annotations

import numpy as np
from numba import njit

KERNEL = {"cache": True, "fastmath": {"contract"}, "error_model": "numpy"}
"""How the kernels are compiled: products and sums in one instruction, nothing else taken for granted; a
division by zero gives what IEEE says, where Python's check before every division would cost a third."""
SWEEPS = 12
"""Of Jacobi's rotations at most; four do for what is nearly diagonal."""
ROUNDED = 1e-32
"""Squares of what is left beside the diagonal over those of it, from which on a matrix counts as diagonal."""
POLYNOMIAL, OGDEN = 0, 1
"""Forms of laws: c10 (I1 - 3) + c20 (I1 - 3)^2 + c30 (I1 - 3)^3 + c01 (I2 - 3); powers of stretches."""
NEAR = 1e-6
"""Eigenvalues closer than that, relative to their sum, count as equal in Q."""


@njit(**KERNEL)
def _rotation(p, q, across):
    """(change of p and q, cosine, sine) of Jacobi's rotation that takes `across` out of two axes."""
    apart = q - p
    t = (2 * across if apart >= 0.0 else -2 * across) / (
        abs(apart) + np.sqrt(apart * apart + 4 * across * across) + 1e-300)
    cos = 1.0 / np.sqrt(t * t + 1.0)
    return t * across, cos, t * cos


@njit(**KERNEL)
def _turn(axes, i, j, cos, sin):
    for m in range(3):
        u, v = axes[m, i], axes[m, j]
        axes[m, i], axes[m, j] = cos * u - sin * v, sin * u + cos * v


@njit(**KERNEL)
def principal(c, x, axes):
    """Eigenvalues `x` (3,) and eigenvectors (columns of `axes`) of the symmetric `c` (3, 3).

    Jacobi's rotations: as exact where eigenvalues meet as elsewhere, which closed forms are not, and for so
    small a matrix several times faster than LAPACK's call.
    """
    p, q, r = c[0, 0], c[1, 1], c[2, 2]
    pq, pr, qr = c[0, 1], c[0, 2], c[1, 2]
    axes[:] = 0.0
    axes[0, 0] = axes[1, 1] = axes[2, 2] = 1.0
    small = ROUNDED * (p * p + q * q + r * r)
    for _ in range(SWEEPS):
        if pq * pq + pr * pr + qr * qr <= small:
            break
        more, cos, sin = _rotation(p, q, pq)
        p, q, pq, pr, qr = p - more, q + more, 0.0, cos * pr - sin * qr, sin * pr + cos * qr
        _turn(axes, 0, 1, cos, sin)
        more, cos, sin = _rotation(p, r, pr)
        p, r, pr, pq, qr = p - more, r + more, 0.0, cos * pq - sin * qr, sin * pq + cos * qr
        _turn(axes, 0, 2, cos, sin)
        more, cos, sin = _rotation(q, r, qr)
        q, r, qr, pq, pr = q - more, r + more, 0.0, cos * pq - sin * pr, sin * pq + cos * pr
        _turn(axes, 1, 2, cos, sin)
    x[0], x[1], x[2] = p, q, r


@njit(**KERNEL)
def _polynomial(c, y, slope, curve):
    """W with constants `c`; writes y_a dW/dy_a and the derivatives of that with respect to log y_b."""
    c10, c20, c30, c01 = c[0], c[1], c[2], c[3]
    i1 = y[0] + y[1] + y[2]
    k = i1 - 3.0
    w1, w11 = c10 + k * (2 * c20 + 3 * c30 * k), 2 * c20 + 6 * c30 * k
    for a in range(3):
        slope[a] = y[a] * (w1 + c01 * (i1 - y[a]))
        for b in range(3):
            curve[a, b] = y[a] * y[b] * (w11 + c01)
        curve[a, a] = slope[a] + y[a] * y[a] * w11
    i2 = y[0] * y[1] + y[1] * y[2] + y[2] * y[0]
    return k * (c10 + k * (c20 + k * c30)) + c01 * (i2 - 3.0)


@njit(**KERNEL)
def _ogden(c, y, slope, curve):
    """The same for sum of mu_k / alpha_k (l1^alpha_k + ...), c = mu_1, alpha_1, mu_2, alpha_2, ..."""
    energy = 0.0
    slope[:] = 0.0
    curve[:] = 0.0
    for k in range(len(c) // 2):
        mu, alpha = c[2 * k], c[2 * k + 1]
        for a in range(3):
            power = y[a] ** (alpha / 2)
            energy += mu / alpha * (power - 1.0)
            slope[a] += mu / 2 * power
            curve[a, a] += mu * alpha / 4 * power
    return energy


@njit(**KERNEL)
def respond(form, constants, x, det, s, q, d, room):
    """W of squared stretches `x` and J `det`; writes S (3,), Q of the pairs 01, 12, 20 (3,) and D (3, 3).

    room (5, 3): to work in.
    """
    y, slope, curve = room[0], room[1], room[2:]
    scale = det ** (-2.0 / 3.0)
    for a in range(3):
        y[a] = scale * x[a]
    if form == POLYNOMIAL:
        energy = _polynomial(constants, y, slope, curve)
    else:
        energy = _ogden(constants, y, slope, curve)
    # d log y_b / d log x_c = 1 (b = c) - 1/3: what is isochoric has no mean.
    mean, whole = (slope[0] + slope[1] + slope[2]) / 3, 0.0
    for a in range(3):
        y[a] = (curve[a, 0] + curve[a, 1] + curve[a, 2]) / 3
        whole += y[a] / 3
    for a in range(3):
        over = 2 / x[a]
        s[a] = over * (slope[a] - mean)
        for b in range(a):
            d[a, b] = d[b, a] = over * (curve[a, b] - y[a] - y[b] + whole) * (2 / x[b])
        d[a, a] = over * (over * (curve[a, a] - 2 * y[a] + whole) - s[a])
    for a in range(3):
        b = (a + 1) % 3
        apart = x[a] - x[b]
        if abs(apart) > NEAR * (x[a] + x[b]):
            q[a] = (s[a] - s[b]) / apart
        else:
            q[a] = (d[a, a] + d[b, b]) / 4 - d[a, b] / 2
    return energy
