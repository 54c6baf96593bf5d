"""What the points of an element answer to its deformation, side by side (`handgen.simulation.lanes`).

Principal axes, the geometric part's stress, the tangent, and what becomes of the stresses in a step; the
formulas stand in `handgen.simulation.element`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from handgen.simulation.lanes import (
    ACTING,
    AXES,
    CURVE,
    GRADIENT,
    HELD,
    KERNEL,
    METRIC,
    MODULI,
    MOVED,
    PRESSURE,
    SHEAR,
    SLOPE,
    SQUARED,
    STRESS,
    TANGENT,
    TOTAL,
    VOLUME,
    L,
    put,
    thirds,
    three,
)
from handgen.simulation.principal import principal


@njit(**KERNEL)
def along_axes(w, to):
    """Write F N to the rows from `to` on."""
    for i in range(3):
        for g in range(L):
            f0, f1, f2 = three(w, GRADIENT + 3 * i * L, g)
            a0, a1, a2 = thirds(w, AXES, g)
            b0, b1, b2 = thirds(w, AXES + L, g)
            c0, c1, c2 = thirds(w, AXES + 2 * L, g)
            put(w, to + 3 * i * L, g, f0 * a0 + f1 * a1 + f2 * a2, f0 * b0 + f1 * b1 + f2 * b2,
                f0 * c0 + f1 * c1 + f2 * c2)


@njit(**KERNEL)
def to_axes(w):
    """Write C = F^T F, its principal axes and squared stretches, and F N."""
    for g in range(L):
        a0, a1, a2 = thirds(w, GRADIENT, g)
        b0, b1, b2 = thirds(w, GRADIENT + L, g)
        c0, c1, c2 = thirds(w, GRADIENT + 2 * L, g)
        put(w, METRIC, g, a0 * a0 + a1 * a1 + a2 * a2, b0 * b0 + b1 * b1 + b2 * b2,
            c0 * c0 + c1 * c1 + c2 * c2)
        put(w, METRIC + 3 * L, g, a0 * b0 + a1 * b1 + a2 * b2, a0 * c0 + a1 * c1 + a2 * c2,
            b0 * c0 + b1 * c1 + b2 * c2)
    principal(w)
    along_axes(w, MOVED)


@njit(**KERNEL)
def press(w, bulk):
    """Write the stresses together with those of the pressure K (J - 1)."""
    for g in range(L):
        pressed = bulk * (w[VOLUME + g] - 1.0) * w[VOLUME + g]
        s0, s1, s2 = three(w, STRESS, g)
        x0, x1, x2 = three(w, SQUARED, g)
        put(w, TOTAL, g, s0 + pressed / x0, s1 + pressed / x1, s2 + pressed / x2)


@njit(**KERNEL)
def _times(s, t, n0, n1, n2):
    """A symmetric matrix of diagonal `s` and (01, 02, 12) `t`, times a vector."""
    return (s[0] * n0 + t[0] * n1 + t[1] * n2, t[0] * n0 + s[1] * n1 + t[2] * n2,
            t[1] * n0 + t[2] * n1 + s[2] * n2)


@njit(**KERNEL)
def hold(w, exact):
    """Write T along the axes: of the acting stresses, or of the state's own if `exact`, and of the acting
    pressure."""
    for g in range(L):
        t00, t11, t22 = three(w, STRESS, g)
        t01, t12, t20 = 0.0, 0.0, 0.0
        if not exact:
            s, t = three(w, ACTING, g), three(w, ACTING + 3 * L, g)
            a0, a1, a2 = thirds(w, AXES, g)
            b0, b1, b2 = thirds(w, AXES + L, g)
            c0, c1, c2 = thirds(w, AXES + 2 * L, g)
            p0, p1, p2 = _times(s, t, a0, a1, a2)
            q0, q1, q2 = _times(s, t, b0, b1, b2)
            r0, r1, r2 = _times(s, t, c0, c1, c2)
            t00, t01, t20 = (a0 * p0 + a1 * p1 + a2 * p2, b0 * p0 + b1 * p1 + b2 * p2,
                             a0 * r0 + a1 * r1 + a2 * r2)
            t11, t12, t22 = (b0 * q0 + b1 * q1 + b2 * q2, c0 * q0 + c1 * q1 + c2 * q2,
                             c0 * r0 + c1 * r1 + c2 * r2)
        pressed = w[PRESSURE + g] * w[VOLUME + g]
        x0, x1, x2 = three(w, SQUARED, g)
        put(w, HELD, g, t00 + pressed / x0, t11 + pressed / x1, t22 + pressed / x2)
        put(w, HELD + 3 * L, g, t01, t12, t20)


@njit(**KERNEL)
def tangent(w, bulk):
    """Write A (9, 9), rows 3 i + a, where i is no less than k; `bulk`: K where J makes the pressure, or 0."""
    for g in range(L):
        pressed = w[PRESSURE + g] * w[VOLUME + g]
        stiff = pressed + bulk * w[VOLUME + g] * w[VOLUME + g]
        own = stiff - 2 * pressed
        x0, x1, x2 = three(w, SQUARED, g)
        i0, i1, i2 = 1 / x0, 1 / x1, 1 / x2
        q01, q12, q20 = three(w, SHEAR, g)
        d00, d11, d22 = three(w, MODULI, g)
        d01, d12, d20 = three(w, MODULI + 3 * L, g)
        put(w, SLOPE, g, q01 - pressed * i0 * i1, q12 - pressed * i1 * i2, q20 - pressed * i2 * i0)
        put(w, CURVE, g, d00 + own * i0 * i0, d11 + own * i1 * i1, d22 + own * i2 * i2)
        put(w, CURVE + 3 * L, g, d01 + stiff * i0 * i1, d12 + stiff * i1 * i2, d20 + stiff * i2 * i0)
    for i in range(3):
        for k in range(i + 1):
            _tangent_of(w, MOVED + 3 * i * L, MOVED + 3 * k * L, 1.0 if i == k else 0.0,
                        TANGENT + (27 * i + 3 * k) * L)


@njit(**KERNEL)
def _tangent_of(w, one, other, same, to):
    """Write A's block of two components, whose rows of F N begin at `one` and `other`, from `to` on; `same`:
    1 if the two are one, else 0."""
    for g in range(L):
        m0, m1, m2 = three(w, one, g)
        n0, n1, n2 = three(w, other, g)
        q01, q12, q20 = three(w, SLOPE, g)
        d00, d11, d22 = three(w, CURVE, g)
        d01, d12, d20 = three(w, CURVE + 3 * L, g)
        t00, t11, t22 = three(w, HELD, g)
        t01, t12, t20 = three(w, HELD + 3 * L, g)
        put(w, to, g, same * t00 + d00 * m0 * n0 + q01 * m1 * n1 + q20 * m2 * n2,
            same * t01 + d01 * m0 * n1 + q01 * m1 * n0, same * t20 + d20 * m0 * n2 + q20 * m2 * n0)
        put(w, to + 9 * L, g, same * t01 + d01 * m1 * n0 + q01 * m0 * n1,
            same * t11 + q01 * m0 * n0 + d11 * m1 * n1 + q12 * m2 * n2,
            same * t12 + d12 * m1 * n2 + q12 * m2 * n1)
        put(w, to + 18 * L, g, same * t20 + d20 * m2 * n0 + q20 * m0 * n2,
            same * t12 + d12 * m2 * n1 + q12 * m1 * n2,
            same * t22 + q20 * m0 * n0 + q12 * m1 * n1 + d22 * m2 * n2)


@njit(**KERNEL)
def strain(w, bulk):
    """Write the acting stresses and K (J - 1) after a step dF, to first order; dF N stands where A does."""
    for g in range(L):
        a0, a1, a2 = thirds(w, MOVED, g)
        b0, b1, b2 = thirds(w, MOVED + L, g)
        c0, c1, c2 = thirds(w, MOVED + 2 * L, g)
        d0, d1, d2 = thirds(w, TANGENT, g)
        e0, e1, e2 = thirds(w, TANGENT + L, g)
        f0, f1, f2 = thirds(w, TANGENT + 2 * L, g)
        # sym(F^T dF) along the axes, twice that beside the diagonal
        e00, e11, e22 = a0 * d0 + a1 * d1 + a2 * d2, b0 * e0 + b1 * e1 + b2 * e2, c0 * f0 + c1 * f1 + c2 * f2
        e01 = a0 * e0 + a1 * e1 + a2 * e2 + b0 * d0 + b1 * d1 + b2 * d2
        e12 = b0 * f0 + b1 * f1 + b2 * f2 + c0 * e0 + c1 * e1 + c2 * e2
        e20 = c0 * d0 + c1 * d1 + c2 * d2 + a0 * f0 + a1 * f1 + a2 * f2
        x0, x1, x2 = three(w, SQUARED, g)
        grown = e00 / x0 + e11 / x1 + e22 / x2
        w[PRESSURE + g] = bulk * (np.sqrt(x0 * x1 * x2) * (1.0 + grown) - 1.0)
        s0, s1, s2 = three(w, STRESS, g)
        q01, q12, q20 = three(w, SHEAR, g)
        d00, d11, d22 = three(w, MODULI, g)
        d01, d12, d20 = three(w, MODULI + 3 * L, g)
        put(w, HELD, g, s0 + d00 * e00 + d01 * e11 + d20 * e22, s1 + d01 * e00 + d11 * e11 + d12 * e22,
            s2 + d20 * e00 + d12 * e11 + d22 * e22)
        put(w, HELD + 3 * L, g, q01 * e01, q12 * e12, q20 * e20)
    _from_axes(w)


@njit(**KERNEL)
def _from_axes(w):
    """Write N T N^T of what HELD holds as the acting stresses."""
    for g in range(L):
        t00, t11, t22 = three(w, HELD, g)
        t01, t12, t20 = three(w, HELD + 3 * L, g)
        s, t = (t00, t11, t22), (t01, t20, t12)
        a0, b0, c0 = three(w, AXES, g)
        a1, b1, c1 = three(w, AXES + 3 * L, g)
        a2, b2, c2 = three(w, AXES + 6 * L, g)
        p0, q0, r0 = _times(s, t, a0, b0, c0)
        p1, q1, r1 = _times(s, t, a1, b1, c1)
        p2, q2, r2 = _times(s, t, a2, b2, c2)
        put(w, ACTING, g, p0 * a0 + q0 * b0 + r0 * c0, p1 * a1 + q1 * b1 + r1 * c1,
            p2 * a2 + q2 * b2 + r2 * c2)
        put(w, ACTING + 3 * L, g, p0 * a1 + q0 * b1 + r0 * c1, p0 * a2 + q0 * b2 + r0 * c2,
            p1 * a2 + q1 * b2 + r1 * c2)
