"""Solid elements: energy, out-of-balance force and tangent of nearly incompressible hyperelastic bodies.

Two elements share one kernel. Hexahedra of 8 nodes with one mean dilatation an element (Q1P0: J. C. Simo,
R. L. Taylor, K. S. Pister, Comput. Methods Appl. Mech. Eng. 51 (1985) 177-208) for the silicone; those of 20
nodes with 2 x 2 x 2 points (O. C. Zienkiewicz, R. L. Taylor, J. M. Too, Int. J. Numer. Methods Eng. 3 (1971)
275-290), which neither lock in thin bent strips nor in volume, for the printed exoskeleton.

    energy = sum of points w W(F) + volumetric part,  W isochoric: W(J^-2/3 C)
    Q1P0:  V0 K/2 (V/V0 - 1)^2 of each element;  else  w K/2 (J - 1)^2 of each point

Everything is written in the deformation gradient F: first Piola stress P = dW/dF, moduli A = d2W/dFdF
(9 x 9); K_ab = sum w grad N_a . A . grad N_b. Voigt never appears.

Mixed integration points (D. Magisano, L. Leonetti, G. Garcea, Int. J. Numer. Methods Eng. 109 (2017)
1237-1262; 111 (2017) 1003-1030): Newton treats the second Piola stress S of every point, and the pressure of
every element, as unknowns of their own. Condensed, all that changes is the stress in the tangent's geometric
part: not S(F) of the present iterate but its linear extrapolation from the one before (`extrapolate`). The
rotation of a step then makes no false stress and the steps may be ten times as long; solution and residual
stay the same.
"""

from __future__ import annotations

import numpy as np
from numba import njit

CONTRACTED = {"contract"}
"""Products and sums in one instruction; nothing else may be taken for granted."""
SWEEPS = 12
"""Of Jacobi's rotations at most; four do for what is nearly diagonal."""
POLYNOMIAL, OGDEN = 0, 1
"""Forms of laws: c10 (I1 - 3) + c20 (I1 - 3)^2 + c30 (I1 - 3)^3 + c01 (I2 - 3); powers of stretches."""


@njit(cache=True)
def inverse_transposed(f, h):
    """Write F^-T into `h`; returns J."""
    for i in range(3):
        for j in range(3):
            a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
            h[i, j] = f[a, c] * f[b, d] - f[a, d] * f[b, c]
    det = f[0, 0] * h[0, 0] + f[0, 1] * h[0, 1] + f[0, 2] * h[0, 2]
    for i in range(3):
        for j in range(3):
            h[i, j] /= det
    return det


@njit(cache=True, fastmath=CONTRACTED)
def polynomial(f, h, det, c, p, a):
    """W, P and A of the polynomial law with constants `c`; writes `p` (3, 3) and `a` (9, 9).

    With s = J^-2/3 and G = d(s I1)/dF = s (2 F - 2/3 I1 H), H = F^-T:
    P = W1 G, A = W1 dG/dF + W11 G x G; dG/dF has only dyads of F and H, and the transposed one of H.
    """
    c10, c20, c30, c01 = c[0], c[1], c[2], c[3]
    scale = det ** (-2.0 / 3.0)
    i1 = 0.0
    for i in range(3):
        for j in range(3):
            i1 += f[i, j] * f[i, j]
    k = scale * i1 - 3.0
    w1 = c10 + k * (2 * c20 + 3 * c30 * k)
    w11 = 2 * c20 + 6 * c30 * k
    g = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            g[i, j] = scale * (2 * f[i, j] - 2.0 / 3.0 * i1 * h[i, j])
            p[i, j] = w1 * g[i, j]
    t = w1 * scale
    for i in range(3):
        for j in range(3):
            row, ff, hh, gg = 3 * i + j, f[i, j], h[i, j], w11 * g[i, j]
            for m in range(3):
                across = 2.0 / 3.0 * i1 * t * h[m, j]
                for n in range(3):
                    a[row, 3 * m + n] = (-4.0 / 3.0 * t * ff * h[m, n] + across * h[i, n] + gg * g[m, n]
                                         + t * hh * (4.0 / 9.0 * i1 * h[m, n] - 4.0 / 3.0 * f[m, n]))
            a[row, row] += 2.0 * t
    energy = k * (c10 + k * (c20 + k * c30))
    if c01 != 0.0:
        energy += _second_invariant(f, h, i1, scale, c01, p, a)
    return energy


@njit(cache=True, fastmath=CONTRACTED)
def _second_invariant(f, h, i1, scale, c01, p, a):
    """Add c01 (I2 - 3): its energy is returned, its stress and moduli added to `p` and `a`."""
    b, c, g = np.zeros((3, 3)), np.zeros((3, 3)), np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                b[i, j] += f[i, k] * f[j, k]
                c[i, j] += f[k, i] * f[k, j]
    i2 = 0.5 * i1 * i1
    for i in range(3):
        for j in range(3):
            i2 -= 0.5 * c[i, j] * c[i, j]
            g[i, j] = 2 * (i1 * f[i, j] - f[i, 0] * c[0, j] - f[i, 1] * c[1, j] - f[i, 2] * c[2, j])
    s = c01 * scale * scale
    for i in range(3):
        for j in range(3):
            row = 3 * i + j
            p[i, j] += s * (g[i, j] - 4.0 / 3.0 * i2 * h[i, j])
            for m in range(3):
                for n in range(3):
                    a[row, 3 * m + n] += s * (
                        4 * f[i, j] * f[m, n] - 2 * f[i, n] * f[m, j] + 4.0 / 3.0 * i2 * h[i, n] * h[m, j]
                        - 4.0 / 3.0 * g[i, j] * h[m, n]
                        + h[i, j] * (16.0 / 9.0 * i2 * h[m, n] - 4.0 / 3.0 * g[m, n]))
            for n in range(3):
                a[row, 3 * i + n] -= 2 * s * c[n, j]
                a[row, 3 * n + j] -= 2 * s * b[i, n]
            a[row, row] += 2 * s * i1
    return s * i2 - 3.0 * c01


@njit(cache=True, fastmath=CONTRACTED)
def principal(c, x, axes):
    """Eigenvalues `x` (3,) and eigenvectors (columns of `axes`) of the symmetric `c` (3, 3), which is lost.

    Jacobi's rotations: as exact where eigenvalues meet as elsewhere, which closed forms are not, and for so
    small a matrix several times faster than LAPACK's call.
    """
    axes[:] = 0.0
    for i in range(3):
        axes[i, i] = 1.0
    for _ in range(SWEEPS):
        off = c[0, 1] ** 2 + c[0, 2] ** 2 + c[1, 2] ** 2
        if off <= 1e-32 * (c[0, 0] ** 2 + c[1, 1] ** 2 + c[2, 2] ** 2):
            break
        for i in range(2):
            for j in range(i + 1, 3):
                if c[i, j] == 0.0:
                    continue
                t = (c[j, j] - c[i, i]) / (2.0 * c[i, j])
                t = (1.0 if t >= 0.0 else -1.0) / (abs(t) + np.sqrt(t * t + 1.0))
                cos = 1.0 / np.sqrt(t * t + 1.0)
                sin, k = t * cos, 3 - i - j
                c[i, i], c[j, j] = c[i, i] - t * c[i, j], c[j, j] + t * c[i, j]
                c[i, j] = c[j, i] = 0.0
                u, v = c[i, k], c[j, k]
                c[i, k] = c[k, i] = cos * u - sin * v
                c[j, k] = c[k, j] = sin * u + cos * v
                for m in range(3):
                    u, v = axes[m, i], axes[m, j]
                    axes[m, i], axes[m, j] = cos * u - sin * v, sin * u + cos * v
    for i in range(3):
        x[i] = c[i, i]


@njit(cache=True, fastmath=CONTRACTED)
def ogden(f, h, det, c, p, a):
    """The same for sum of mu_k / alpha_k (l1^alpha_k + ...), c = mu_1, alpha_1, mu_2, alpha_2, ...

    In principal axes of C, with x_a the squared stretches and y_a = J^-2/3 x_a:
    S = sum 2 dW/dx_a N_a N_a and dS/dC from its derivatives and difference quotients. With L_a = F N_a N_a
    and M_ab = F N_a N_b + F N_b N_a: A = 1 x S + sum 2 dS_a/dx_b L_a x L_b
    + sum (a < b) (S_a - S_b) / (x_a - x_b) M_ab x M_ab.
    """
    room = np.zeros((13, 9))  # one allocation: they cost as much as the arithmetic
    metric, axes, moved, rate = (room[0].reshape(3, 3), room[1].reshape(3, 3), room[2].reshape(3, 3),
                                 room[3].reshape(3, 3))  # moved: columns F N_a; rate: d stress_a / d x_b
    own, with_rate, shear = room[4:7], room[7:10], room[10]
    x, first, second, stress = room[11, :3], room[12, :3], room[12, 3:6], room[12, 6:]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                metric[i, j] += f[k, i] * f[k, j]
    principal(metric, x, axes)
    scale = det ** (-2.0 / 3.0)
    energy = 0.0
    for q in range(len(c) // 2):
        mu, alpha = c[2 * q], c[2 * q + 1]
        for k in range(3):
            power = (scale * x[k]) ** (alpha / 2)
            energy += mu / alpha * (power - 1.0)
            first[k] += mu / 2 * power  # y dw/dy
            second[k] += mu * alpha / 4 * power  # y d(y dw/dy)/dy
    mean, mean2 = (first[0] + first[1] + first[2]) / 3, (second[0] + second[1] + second[2]) / 9
    for k in range(3):
        stress[k] = 2 * (first[k] - mean) / x[k]
        for m in range(3):
            rate[k, m] = 2 * (mean2 - (second[k] + second[m]) / 3) / (x[k] * x[m])
        rate[k, k] += 2 * second[k] / x[k] ** 2 - stress[k] / x[k]
    for i in range(3):
        for k in range(3):
            for j in range(3):
                moved[i, k] += f[i, j] * axes[j, k]
    for k in range(3):
        for i in range(3):
            for j in range(3):
                own[k, 3 * i + j] = moved[i, k] * axes[j, k]
    p[:] = 0.0
    a[:] = 0.0
    for k in range(3):
        for n in range(9):
            p[n // 3, n % 3] += stress[k] * own[k, n]
            for m in range(3):
                with_rate[k, n] += 2 * rate[k, m] * own[m, n]
        for i in range(3):
            for j in range(3):
                for n in range(3):
                    a[3 * i + j, 3 * i + n] += stress[k] * axes[j, k] * axes[n, k]
        for row in range(9):
            for column in range(9):
                a[row, column] += own[k, row] * with_rate[k, column]
        m = (k + 1) % 3
        apart = x[k] - x[m]
        if abs(apart) > 1e-6 * (x[k] + x[m]):
            quotient = (stress[k] - stress[m]) / apart
        else:
            quotient = (rate[k, k] + rate[m, m]) / 2 - rate[k, m]
        for i in range(3):
            for j in range(3):
                shear[3 * i + j] = moved[i, k] * axes[j, m] + moved[i, m] * axes[j, k]
        for row in range(9):
            for column in range(9):
                a[row, column] += quotient * shear[row] * shear[column]
    return energy


@njit(cache=True)
def law_at(form, f, h, det, c, p, a):
    if form == POLYNOMIAL:
        return polynomial(f, h, det, c, p, a)
    return ogden(f, h, det, c, p, a)


@njit(cache=True)
def gradient_at(x, cell, dn, f):
    """F = sum of x_a grad N_a."""
    f[:] = 0.0
    for n in range(len(cell)):
        for i in range(3):
            for j in range(3):
                f[i, j] += x[cell[n], i] * dn[n, j]


@njit(cache=True)
def _volume(x, cell, dn, weight, f, h, slopes):
    """Volume of an element and its derivative (n, 3) with respect to its nodes; least J."""
    volume, least = 0.0, np.inf
    slopes[:] = 0.0
    for g in range(len(weight)):
        gradient_at(x, cell, dn[g], f)
        det = inverse_transposed(f, h)
        least = min(least, det)
        volume += weight[g] * det
        for n in range(len(cell)):
            for i in range(3):
                slopes[n, i] += weight[g] * det * (
                    h[i, 0] * dn[g, n, 0] + h[i, 1] * dn[g, n, 1] + h[i, 2] * dn[g, n, 2])
    return volume, least


@njit(cache=True)
def _second_piola(f, h, p, s):
    """S = F^-1 P."""
    for i in range(3):
        for j in range(3):
            s[i, j] = h[0, i] * p[0, j] + h[1, i] * p[1, j] + h[2, i] * p[2, j]


@njit(cache=True, fastmath=CONTRACTED)
def _add_pressure(h, det, pressure, a):
    """A += pressure d2J/dFdF."""
    factor = pressure * det
    for i in range(3):
        for j in range(3):
            own = factor * h[i, j]
            for m in range(3):
                across = factor * h[m, j]
                for n in range(3):
                    a[3 * i + j, 3 * m + n] += own * h[m, n] - across * h[i, n]


@njit(cache=True, fastmath=CONTRACTED)
def add_stiffness(a, dn, w, across, moved, kc):
    """Add w grad N . A . grad N of one point to `kc` (3 n, 3 n), whose rows go by component, then by node.

    So ordered, every innermost loop runs over neighbouring nodes' numbers, which the compiler turns into
    vector instructions. `across` (3, n) and `moved` (9, 3 n) are room to work in.
    """
    nodes = len(dn)
    for j in range(3):
        for n in range(nodes):
            across[j, n] = dn[n, j]
    for row in range(9):
        for i in range(3):
            a0, a1, a2 = w * a[row, 3 * i], w * a[row, 3 * i + 1], w * a[row, 3 * i + 2]
            for n in range(nodes):
                moved[row, i * nodes + n] = a0 * across[0, n] + a1 * across[1, n] + a2 * across[2, n]
    for i in range(3):
        for n in range(nodes):
            d0, d1, d2 = across[0, n], across[1, n], across[2, n]
            for column in range(3 * nodes):
                kc[i * nodes + n, column] += (d0 * moved[3 * i, column] + d1 * moved[3 * i + 1, column]
                                              + d2 * moved[3 * i + 2, column])


@njit(cache=True, nogil=True)
def assemble(x, cells, dn, weight, form, constants, bulk, mean, stress, pressure, exact, first, moduli,
             dofs, place, frames, curves, framed, force, matrix):
    """Add internal forces and tangent of all elements; returns (energy, least J).

    x (N, 3) nodes, mm; dn (m, g, n, 3) gradients and weight (m, g) volumes of the points; `mean`: Q1P0;
    stress (m, g, 3, 3), isochoric, and pressure (m, g), of Q1P0 the first of a row: the extrapolated ones,
    not used where `exact`. Writes `first` (m, g, 3, 3) and `moduli` (m, g, 9, 9), isochoric, from which
    `extrapolate` goes on.
    Nodes that belong to a rigid body: frames (N, 3, 3) their slopes with respect to its three unknowns,
    curves (N, 3) the second derivative with respect to its rotation; `framed` (m,): has such nodes.
    dofs (m, 3 n) unknowns, -1 for none; place (m, 3 n, 3 n) where in `matrix` an entry goes, -1 nowhere.
    A J <= 0 anywhere: nothing more is added, its value is returned.
    """
    count, points, nodes, _ = dn.shape
    f, h, p, a, s = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((9, 9)), np.empty((3, 3))
    slopes, fe, ke = np.empty((nodes, 3)), np.empty((nodes, 3)), np.empty((3 * nodes, 3 * nodes))
    across, moved, kc = np.empty((3, nodes)), np.empty((9, 3 * nodes)), np.empty((3 * nodes, 3 * nodes))
    along = np.empty(3 * nodes)
    turning, known = np.empty((nodes, 3)), np.empty((3, 3))
    energy, least = 0.0, np.inf
    for e in range(count):
        cell = cells[e]
        level, acting, v0 = 0.0, 0.0, 0.0
        if mean:
            volume, low = _volume(x, cell, dn[e], weight[e], f, h, slopes)
            least = min(least, low)
            if low <= 0.0:
                return np.inf, low
            v0 = weight[e].sum()
            level = bulk * (volume / v0 - 1.0)
            acting = level if exact else pressure[e, 0]
            energy += 0.5 * v0 * bulk * (volume / v0 - 1.0) ** 2
        fe[:] = 0.0
        kc[:] = 0.0
        turning[:] = 0.0
        for g in range(points):
            gradient_at(x, cell, dn[e, g], f)
            det = inverse_transposed(f, h)
            if det <= 0.0:
                return np.inf, det
            least = min(least, det)
            w = weight[e, g]
            energy += w * law_at(form, f, h, det, constants, p, a)
            first[e, g] = p
            moduli[e, g] = a
            if not exact:
                _second_piola(f, h, p, s)
                for j in range(3):
                    for n in range(3):
                        more = stress[e, g, j, n] - s[j, n]
                        for i in range(3):
                            a[3 * i + j, 3 * i + n] += more
            if not mean:
                energy += w * 0.5 * bulk * (det - 1.0) ** 2
                level = bulk * (det - 1.0)
                acting = level if exact else pressure[e, g]
                for i in range(3):
                    for j in range(3):
                        p[i, j] += level * det * h[i, j]
                        for m in range(3):
                            for n in range(3):
                                a[3 * i + j, 3 * m + n] += bulk * det * det * h[i, j] * h[m, n]
            _add_pressure(h, det, acting, a)
            for n in range(nodes):
                for i in range(3):
                    fe[n, i] += w * (p[i, 0] * dn[e, g, n, 0] + p[i, 1] * dn[e, g, n, 1]
                                     + p[i, 2] * dn[e, g, n, 2])
            if framed[e]:
                known = p if exact else f @ stress[e, g] + acting * det * h
                for n in range(nodes):
                    for i in range(3):
                        turning[n, i] += w * (known[i, 0] * dn[e, g, n, 0] + known[i, 1] * dn[e, g, n, 1]
                                              + known[i, 2] * dn[e, g, n, 2])
            add_stiffness(a, dn[e, g], w, across, moved, kc)
        if mean:
            for n in range(nodes):
                for i in range(3):
                    fe[n, i] += level * slopes[n, i]
                    along[i * nodes + n] = slopes[n, i]
            for row in range(3 * nodes):
                factor = bulk / v0 * along[row]
                for column in range(3 * nodes):
                    kc[row, column] += factor * along[column]
        for n in range(nodes):
            for i in range(3):
                for m in range(nodes):
                    for j in range(3):
                        ke[3 * n + i, 3 * m + j] = kc[i * nodes + n, j * nodes + m]
        if framed[e]:
            to_bodies(cell, frames, curves, turning, fe, ke)
        scatter(dofs[e], place[e], fe, ke, force, matrix)
    return energy, least


@njit(cache=True)
def to_bodies(cell, frames, curves, turning, fe, ke):
    """Forces and stiffness of nodes that rigid bodies carry, in those bodies' unknowns.

    `turning` (n, 3): the forces that the bones' rotation turns, of the stresses of the geometric part.
    """
    nodes = len(cell)
    block, turned = np.empty((3, 3)), np.empty(3)
    for n in range(nodes):
        for m in range(nodes):
            t, u = frames[cell[n]], frames[cell[m]]
            for i in range(3):
                for j in range(3):
                    total = 0.0
                    for k in range(3):
                        for o in range(3):
                            total += t[k, i] * ke[3 * n + k, 3 * m + o] * u[o, j]
                    block[i, j] = total
            for i in range(3):
                for j in range(3):
                    ke[3 * n + i, 3 * m + j] = block[i, j]
    for n in range(nodes):
        curve, t = curves[cell[n]], frames[cell[n]]
        ke[3 * n + 2, 3 * n + 2] += (turning[n, 0] * curve[0] + turning[n, 1] * curve[1]
                                     + turning[n, 2] * curve[2])
        for i in range(3):
            turned[i] = t[0, i] * fe[n, 0] + t[1, i] * fe[n, 1] + t[2, i] * fe[n, 2]
        for i in range(3):
            fe[n, i] = turned[i]


@njit(cache=True)
def scatter(dofs, place, fe, ke, force, matrix):
    """Add an element's forces (n, 3) and stiffness (3 n, 3 n) to the system's."""
    size = len(dofs)
    for i in range(size):
        if dofs[i] < 0:
            continue
        force[dofs[i]] += fe[i // 3, i % 3]
        for j in range(size):
            where = place[i, j]
            if where >= 0:
                matrix[where] += ke[i, j]


@njit(cache=True, nogil=True)
def extrapolate(x, step, cells, dn, weight, bulk, mean, first, moduli, stress, pressure):
    """Write stress and pressure after the nodes' `step` (N, 3) from `x`, to first order.

    `first` and `moduli` are those of `x`: it is where `assemble` was last.
    """
    count, points, nodes, _ = dn.shape
    f, h, s = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    df, dp, slopes = np.empty((3, 3)), np.empty((3, 3)), np.empty((nodes, 3))
    for e in range(count):
        cell = cells[e]
        if mean:
            volume, _ = _volume(x, cell, dn[e], weight[e], f, h, slopes)
            grown = 0.0
            for n in range(nodes):
                for i in range(3):
                    grown += slopes[n, i] * step[cell[n], i]
            pressure[e, 0] = bulk * ((volume + grown) / weight[e].sum() - 1.0)
        for g in range(points):
            gradient_at(x, cell, dn[e, g], f)
            gradient_at(step, cell, dn[e, g], df)
            det = inverse_transposed(f, h)
            p, a = first[e, g], moduli[e, g]
            if not mean:
                grown = 0.0
                for i in range(3):
                    for j in range(3):
                        grown += h[i, j] * df[i, j]
                pressure[e, g] = bulk * (det * (1.0 + grown) - 1.0)
            _second_piola(f, h, p, s)
            for i in range(3):
                for j in range(3):
                    total = 0.0
                    for m in range(3):
                        total -= df[i, m] * s[m, j]
                        for n in range(3):
                            total += a[3 * i + j, 3 * m + n] * df[m, n]
                    dp[i, j] = total
            for i in range(3):
                for j in range(3):
                    stress[e, g, i, j] = s[i, j] + (h[0, i] * dp[0, j] + h[1, i] * dp[1, j]
                                                    + h[2, i] * dp[2, j])


@njit(cache=True)
def largest_stretch(x, cells, dn):
    """(m,) largest principal stretch at the elements' middles: `dn` (m, 1, n, 3) gradients there."""
    found, f = np.empty(len(cells)), np.empty((3, 3))
    for e in range(len(cells)):
        gradient_at(x, cells[e], dn[e, 0], f)
        found[e] = np.sqrt(np.linalg.eigvalsh(f.T @ f)[2])
    return found
