"""Isotropic laws in principal axes: what an energy W(J^-2/3 C) answers to given squared stretches.

With x_a the eigenvalues of C, its squared stretches, and y_a = J^-2/3 x_a, the second Piola stress and its
derivative have the axes of C:

    S = sum S_a N_a N_a,  S_a = 2 dW/dx_a
    2 dS/dC = sum D_ab N_a N_a x N_b N_b + sum (a < b) Q_ab (N_a N_b + N_b N_a) x (N_a N_b + N_b N_a)
    D_ab = 2 dS_a/dx_b,  Q_ab = (S_a - S_b) / (x_a - x_b)

(R. W. Ogden, Non-linear elastic deformations, 1984, section 6.1.4). A law is a function of y; it gives its
slopes y dW/dy and their derivatives with respect to log y, and needs no tensor.

All points of an element are worked out side by side (`handgen.simulation.lanes`).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from handgen.simulation.lanes import (
    AXES,
    CURVE,
    ENERGY,
    KERNEL,
    METRIC,
    MODULI,
    SHEAR,
    SLOPE,
    SQUARED,
    STRESS,
    VOLUME,
    L,
    put,
    thirds,
    three,
)

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
    t = 2 * across / (abs(apart) + np.sqrt(apart * apart + 4 * across * across) + 1e-300)
    t = t if apart >= 0.0 else -t
    cos = 1.0 / np.sqrt(t * t + 1.0)
    return t * across, cos, t * cos


@njit(**KERNEL)
def _beside(w):
    """How many of the matrices are not diagonal yet."""
    count = 0
    for g in range(L):
        p, q, r = three(w, SQUARED, g)
        pq, pr, qr = three(w, METRIC + 3 * L, g)
        count += pq * pq + pr * pr + qr * qr > ROUNDED * (p * p + q * q + r * r)
    return count


@njit(**KERNEL)
def principal(w):
    """Squared stretches and principal axes of the metrics, whose rows beside the diagonal are used up.

    Jacobi's rotations: as exact where eigenvalues meet as elsewhere, which closed forms are not.
    """
    for g in range(L):
        for i in range(3):
            w[SQUARED + i * L + g] = w[METRIC + i * L + g]
        for i in range(9):
            w[AXES + i * L + g] = 0.0 if i % 4 else 1.0
    for _ in range(SWEEPS):
        if not _beside(w):
            break
        for g in range(L):
            p, q, r = three(w, SQUARED, g)
            pq, pr, qr = three(w, METRIC + 3 * L, g)
            a0, a1, a2 = thirds(w, AXES, g)
            b0, b1, b2 = thirds(w, AXES + L, g)
            c0, c1, c2 = thirds(w, AXES + 2 * L, g)
            more, cos, sin = _rotation(p, q, pq)
            p, q, pr, qr = p - more, q + more, cos * pr - sin * qr, sin * pr + cos * qr
            a0, b0 = cos * a0 - sin * b0, sin * a0 + cos * b0
            a1, b1 = cos * a1 - sin * b1, sin * a1 + cos * b1
            a2, b2 = cos * a2 - sin * b2, sin * a2 + cos * b2
            more, cos, sin = _rotation(p, r, pr)
            p, r, pq, qr = p - more, r + more, -sin * qr, cos * qr
            a0, c0 = cos * a0 - sin * c0, sin * a0 + cos * c0
            a1, c1 = cos * a1 - sin * c1, sin * a1 + cos * c1
            a2, c2 = cos * a2 - sin * c2, sin * a2 + cos * c2
            more, cos, sin = _rotation(q, r, qr)
            q, r, pq, pr = q - more, r + more, cos * pq, sin * pq
            b0, c0 = cos * b0 - sin * c0, sin * b0 + cos * c0
            b1, c1 = cos * b1 - sin * c1, sin * b1 + cos * c1
            b2, c2 = cos * b2 - sin * c2, sin * b2 + cos * c2
            put(w, SQUARED, g, p, q, r)
            put(w, METRIC + 3 * L, g, pq, pr, 0.0)
            put(w, AXES, g, a0, b0, c0)
            put(w, AXES + 3 * L, g, a1, b1, c1)
            put(w, AXES + 6 * L, g, a2, b2, c2)


@njit(**KERNEL)
def _polynomial(c, w):
    """W with constants `c`, and its slopes; y_a stand where S_a go."""
    c10, c20, c30, c01 = c[0], c[1], c[2], c[3]
    for g in range(L):
        y0, y1, y2 = three(w, STRESS, g)
        i1, i2 = y0 + y1 + y2, y0 * y1 + y1 * y2 + y2 * y0
        k = i1 - 3.0
        w1, w11 = c10 + k * (2 * c20 + 3 * c30 * k), 2 * c20 + 6 * c30 * k
        s0, s1, s2 = y0 * (w1 + c01 * (i1 - y0)), y1 * (w1 + c01 * (i1 - y1)), y2 * (w1 + c01 * (i1 - y2))
        w[ENERGY + g] = k * (c10 + k * (c20 + k * c30)) + c01 * (i2 - 3.0)
        put(w, SLOPE, g, s0, s1, s2)
        put(w, CURVE, g, s0 + y0 * y0 * w11, s1 + y1 * y1 * w11, s2 + y2 * y2 * w11)
        put(w, CURVE + 3 * L, g, y0 * y1 * (w11 + c01), y1 * y2 * (w11 + c01), y2 * y0 * (w11 + c01))


@njit(**KERNEL)
def _ogden(c, w):
    """The same for sum of mu_k / alpha_k (l1^alpha_k + ...), c = mu_1, alpha_1, mu_2, alpha_2, ..."""
    w[ENERGY:ENERGY + L] = 0.0
    w[SLOPE:SLOPE + 3 * L] = 0.0
    w[CURVE:CURVE + 6 * L] = 0.0
    for k in range(len(c) // 2):
        mu, alpha = c[2 * k], c[2 * k + 1]
        for a in range(3):
            for g in range(L):
                power = w[STRESS + a * L + g] ** (alpha / 2)
                w[ENERGY + g] += mu / alpha * (power - 1.0)
                w[SLOPE + a * L + g] += mu / 2 * power
                w[CURVE + a * L + g] += mu * alpha / 4 * power


@njit(**KERNEL)
def _shear(x, y, s, t, own, other, between):
    """Q of two axes of squared stretches x and y, with S and D."""
    apart = x - y
    return (s - t) / apart if abs(apart) > NEAR * (x + y) else (own + other) / 4 - between / 2


@njit(**KERNEL)
def respond(form, constants, w):
    """W, S, Q and D from squared stretches and J."""
    for g in range(L):
        scale = w[VOLUME + g] ** (-2.0 / 3.0)
        for a in range(3):
            w[STRESS + a * L + g] = scale * w[SQUARED + a * L + g]
    if form == POLYNOMIAL:
        _polynomial(constants, w)
    else:
        _ogden(constants, w)
    for g in range(L):
        s0, s1, s2 = three(w, SLOPE, g)
        c00, c11, c22 = three(w, CURVE, g)
        c01, c12, c20 = three(w, CURVE + 3 * L, g)
        x0, x1, x2 = three(w, SQUARED, g)
        # d log y_b / d log x_c = 1 (b = c) - 1/3: what is isochoric has no mean.
        mean = (s0 + s1 + s2) / 3
        m0, m1, m2 = (c00 + c01 + c20) / 3, (c01 + c11 + c12) / 3, (c20 + c12 + c22) / 3
        whole = (m0 + m1 + m2) / 3
        o0, o1, o2 = 2 / x0, 2 / x1, 2 / x2
        s0, s1, s2 = o0 * (s0 - mean), o1 * (s1 - mean), o2 * (s2 - mean)
        d00 = o0 * (o0 * (c00 - 2 * m0 + whole) - s0)
        d11 = o1 * (o1 * (c11 - 2 * m1 + whole) - s1)
        d22 = o2 * (o2 * (c22 - 2 * m2 + whole) - s2)
        d01, d12 = o0 * o1 * (c01 - m0 - m1 + whole), o1 * o2 * (c12 - m1 - m2 + whole)
        d20 = o2 * o0 * (c20 - m2 - m0 + whole)
        put(w, STRESS, g, s0, s1, s2)
        put(w, MODULI, g, d00, d11, d22)
        put(w, MODULI + 3 * L, g, d01, d12, d20)
        put(w, SHEAR, g, _shear(x0, x1, s0, s1, d00, d11, d01), _shear(x1, x2, s1, s2, d11, d22, d12),
            _shear(x2, x0, s2, s0, d22, d00, d20))
