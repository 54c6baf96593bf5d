"""Solid elements: energy, out-of-balance force and tangent of nearly incompressible hyperelastic bodies.

Two elements share one kernel. Hexahedra of 8 nodes with one mean dilatation an element (Q1P0: J. C. Simo,
R. L. Taylor, K. S. Pister, Comput. Methods Appl. Mech. Eng. 51 (1985) 177-208) for the silicone; those of 20
nodes with 2 x 2 x 2 points (O. C. Zienkiewicz, R. L. Taylor, J. M. Too, Int. J. Numer. Methods Eng. 3 (1971)
275-290), which neither lock in thin bent strips nor in volume, for the printed exoskeleton.

    energy = sum of points w W(F) + volumetric part,  W isochoric: W(J^-2/3 C)
    Q1P0:  V0 K/2 (V/V0 - 1)^2 of each element;  else  w K/2 (J - 1)^2 of each point

Every point is worked out in its own principal axes N_a (`principal.respond`): with m_a = F N_a and gradients
G_a = N_a . grad, force and tangent are

    f_i = sum w m_ia S_a G_a,  K_ik = sum w G_a A_iakb G_b
    A_iakb = delta_ik T_ab + D_ab m_ia m_kb + Q_ab m_ib m_ka (a != b), and for a = b + sum Q_ac m_ic m_kc

where T is the stress of the geometric part. A pressure p = K (J - 1) adds p J / x_a to S_a and T_aa,
p J / (x_a x_b) (1 - 2 delta_ab) to D_ab and -p J / (x_a x_b) to Q_ab.

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

from handgen.simulation.lanes import (
    ACTING,
    AXES,
    ENERGY,
    GRADIENT,
    HELD,
    KEPT,
    KERNEL,
    LANES,
    MOVED,
    PRESSURE,
    SQUARED,
    STRESS,
    STRESSES,
    TANGENT,
    TOTAL,
    VOLUME,
    L,
    room,
    thirds,
    three,
)
from handgen.simulation.points import along_axes, hold, press, strain, tangent, to_axes
from handgen.simulation.principal import respond


@njit(**KERNEL)
def gradient_at(x, cell, dn, f):
    """Write F = sum of x_a grad N_a; returns J."""
    f[:] = 0.0
    for n in range(len(cell)):
        for i in range(3):
            for j in range(3):
                f[i, j] += x[cell[n], i] * dn[j, n]
    return (f[0, 0] * (f[1, 1] * f[2, 2] - f[1, 2] * f[2, 1])
            + f[0, 1] * (f[1, 2] * f[2, 0] - f[1, 0] * f[2, 2])
            + f[0, 2] * (f[1, 0] * f[2, 1] - f[1, 1] * f[2, 0]))


@njit(**KERNEL)
def _gradients(x, cell, dn, f, w):
    """Write F and J of an element's points; returns the least J, and stops where it is not positive."""
    least = np.inf
    for g in range(len(dn)):
        w[VOLUME + g] = det = gradient_at(x, cell, dn[g], f)
        least = min(least, det)
        if det <= 0.0:
            return least
        for i in range(9):
            w[GRADIENT + i * L + g] = f[i // 3, i % 3]
    return least


@njit(**KERNEL)
def _turn(w, dn, turned):
    """Write `turned` (g, 3, n): the gradients `dn` along the axes."""
    for g in range(len(dn)):
        for a in range(3):
            n0, n1, n2 = thirds(w, AXES + a * L, g)
            for n in range(dn.shape[2]):
                turned[g, a, n] = n0 * dn[g, 0, n] + n1 * dn[g, 1, n] + n2 * dn[g, 2, n]


@njit(**KERNEL)
def _add_force(w, rows, turned, weight, fe):
    """Add w F N stress G of all points to `fe` (3, n); the stress along the axes stands from `rows` on."""
    for g in range(len(turned)):
        t0, t1, t2 = three(w, rows, g)
        for i in range(3):
            m0, m1, m2 = three(w, MOVED + 3 * i * L, g)
            s0, s1, s2 = weight[g] * m0 * t0, weight[g] * m1 * t1, weight[g] * m2 * t2
            for n in range(turned.shape[2]):
                fe[i, n] += s0 * turned[g, 0, n] + s1 * turned[g, 1, n] + s2 * turned[g, 2, n]


@njit(**KERNEL)
def _add_turning(w, turned, weight, turning):
    """Add w F T G of all points to `turning` (3, n)."""
    for g in range(len(turned)):
        t00, t11, t22 = three(w, HELD, g)
        t01, t12, t20 = three(w, HELD + 3 * L, g)
        for i in range(3):
            m0, m1, m2 = three(w, MOVED + 3 * i * L, g)
            f0 = weight[g] * (m0 * t00 + m1 * t01 + m2 * t20)
            f1 = weight[g] * (m0 * t01 + m1 * t11 + m2 * t12)
            f2 = weight[g] * (m0 * t20 + m1 * t12 + m2 * t22)
            for n in range(turned.shape[2]):
                turning[i, n] += f0 * turned[g, 0, n] + f1 * turned[g, 1, n] + f2 * turned[g, 2, n]


@njit(**KERNEL)
def _add_stiffness(a, turned, weight, across, kc):
    """Add w G . A . G of all points to `kc` (3 n, 3 n), whose rows go by component, then by node: those
    blocks of it whose row's component is no less than the column's.

    a (9, 9, LANES), turned (3 g, n), weight (g,); across (3 g, 3 n): room to work in. So ordered, every
    innermost loop runs over neighbouring nodes' numbers, which the compiler turns into vector instructions.
    """
    points, nodes = len(weight), turned.shape[1]
    for i in range(3):
        for g in range(points):
            w, first = weight[g], 3 * g
            for j in range(3):
                for k in range(i + 1):
                    row = 3 * i + j
                    a0, a1, a2 = w * a[row, 3 * k, g], w * a[row, 3 * k + 1, g], w * a[row, 3 * k + 2, g]
                    for n in range(nodes):
                        across[first + j, k * nodes + n] = (
                            a0 * turned[first, n] + a1 * turned[first + 1, n] + a2 * turned[first + 2, n])
        for n in range(nodes):
            own = kc[i * nodes + n]
            for g in range(0, 3 * points, 6):
                d0, d1, d2 = turned[g, n], turned[g + 1, n], turned[g + 2, n]
                d3, d4, d5 = turned[g + 3, n], turned[g + 4, n], turned[g + 5, n]
                for column in range((i + 1) * nodes):
                    own[column] += d0 * across[g, column] + d1 * across[g + 1, column] + (
                        d2 * across[g + 2, column] + d3 * across[g + 3, column]
                        + d4 * across[g + 4, column] + d5 * across[g + 5, column])


@njit(nogil=True, **KERNEL)
def assemble(x, cells, dn, weight, form, constants, bulk, mean, stress, pressure, exact, kept, swell,
             dofs, place, frames, curves, framed, force, matrix):
    """Add internal forces and tangent of all elements; returns (energy, least J).

    x (N, 3) nodes, mm; dn (m, g, 3, n) gradients and weight (m, g) volumes of an even number of points, LANES
    at most; `mean`: Q1P0; stress (m, STRESSES), isochoric, and pressure (m, LANES), of Q1P0 the first of a
    row: the extrapolated ones, not used where `exact`. Writes what `extrapolate` goes on from: kept (m, KEPT)
    of the points, and of Q1P0 swell (m, 3 n + 1), the derivative of the volume with respect to the nodes, by
    component, and V.
    Nodes that belong to a rigid body: frames (N, 3, 3) their slopes with respect to its three unknowns,
    curves (N, 3) the second derivative with respect to its rotation; `framed` (m,): has such nodes.
    dofs (m, 3 n) unknowns, -1 for none; place (m, 3 n, 3 n) where in `matrix` an entry goes, -1 nowhere.
    A J <= 0 anywhere: nothing more is added, its value is returned.
    """
    count, points, _, nodes = dn.shape
    w, f, turned = room(), np.empty((3, 3)), np.empty((points, 3, nodes))
    fe, turning, across = np.empty((3, nodes)), np.empty((3, nodes)), np.empty((3 * points, 3 * nodes))
    kc, ke = np.empty((3 * nodes, 3 * nodes)), np.empty((3 * nodes, 3 * nodes))
    moduli = w[TANGENT:].reshape(9, 9, LANES)
    energy, least = 0.0, np.inf
    for e in range(count):
        least = min(least, _gradients(x, cells[e], dn[e], f, w))
        if least <= 0.0:
            return np.inf, least
        to_axes(w)
        respond(form, constants, w)
        kept[e] = w[:KEPT]
        _turn(w, dn[e], turned)
        fe[:] = 0.0
        kc[:] = 0.0
        turning[:] = 0.0
        for g in range(points):
            energy += weight[e, g] * w[ENERGY + g]
        if mean:
            more, level = _add_volume(w, weight[e], turned, bulk, swell[e], fe, kc)
            energy += more
            _add_force(w, STRESS, turned, weight[e], fe)
            w[PRESSURE:PRESSURE + L] = level if exact else pressure[e, 0]
        else:
            for g in range(points):
                energy += weight[e, g] * 0.5 * bulk * (w[VOLUME + g] - 1.0) ** 2
            press(w, bulk)
            _add_force(w, TOTAL, turned, weight[e], fe)
            for g in range(L):
                w[PRESSURE + g] = bulk * (w[VOLUME + g] - 1.0) if exact else pressure[e, g]
        if not exact:
            w[ACTING:ACTING + STRESSES] = stress[e]
        hold(w, exact)
        if framed[e]:
            _add_turning(w, turned, weight[e], turning)
        tangent(w, 0.0 if mean else bulk)
        _add_stiffness(moduli, turned.reshape(3 * points, nodes), weight[e], across, kc)
        _by_nodes(kc, ke)
        if framed[e]:
            to_bodies(cells[e], frames, curves, turning, fe, ke)
        scatter(dofs[e], place[e], fe.T, ke, force, matrix)
    return energy, least


@njit(**KERNEL)
def _add_volume(w, weight, turned, bulk, swell, fe, kc):
    """Add force and stiffness of Q1P0's volumetric energy but for what its pressure adds to the moduli.

    Writes `swell`; returns (energy, pressure).
    """
    nodes = turned.shape[2]
    flat = swell[:-1]
    swollen = flat.reshape(3, nodes)
    swollen[:] = 0.0
    for a in range(3):
        for g in range(L):
            w[TOTAL + a * L + g] = w[VOLUME + g] / w[SQUARED + a * L + g]
    _add_force(w, TOTAL, turned, weight, swollen)
    volume, v0 = 0.0, 0.0
    for g in range(len(weight)):
        v0 += weight[g]
        volume += weight[g] * w[VOLUME + g]
    swell[-1] = volume
    level = bulk * (volume / v0 - 1.0)
    for i in range(3):
        for n in range(nodes):
            fe[i, n] += level * swollen[i, n]
            factor = bulk / v0 * swollen[i, n]
            for column in range((i + 1) * nodes):
                kc[i * nodes + n, column] += factor * flat[column]
    return 0.5 * v0 * bulk * (volume / v0 - 1.0) ** 2, level


@njit(**KERNEL)
def _by_nodes(kc, ke):
    """`kc`, by components and its lower blocks only, as the whole `ke` by nodes."""
    nodes = len(kc) // 3
    for i in range(3):
        for n in range(nodes):
            for j in range(i + 1):
                for m in range(nodes):
                    ke[3 * n + i, 3 * m + j] = ke[3 * m + j, 3 * n + i] = kc[i * nodes + n, j * nodes + m]


@njit(**KERNEL)
def to_bodies(cell, frames, curves, turning, fe, ke):
    """Forces (3, n) and stiffness of nodes that rigid bodies carry, in those bodies' unknowns.

    `turning` (3, n): the forces that the bones' rotation turns, of the stresses of the geometric part.
    """
    nodes = len(cell)
    turned = np.empty(3)
    for n in range(nodes):
        t = frames[cell[n]]
        for m in range(3 * nodes):
            a, b, c = ke[3 * n, m], ke[3 * n + 1, m], ke[3 * n + 2, m]
            for i in range(3):
                ke[3 * n + i, m] = t[0, i] * a + t[1, i] * b + t[2, i] * c
    for m in range(nodes):
        t = frames[cell[m]]
        for n in range(3 * nodes):
            a, b, c = ke[n, 3 * m], ke[n, 3 * m + 1], ke[n, 3 * m + 2]
            for i in range(3):
                ke[n, 3 * m + i] = a * t[0, i] + b * t[1, i] + c * t[2, i]
    for n in range(nodes):
        curve, t = curves[cell[n]], frames[cell[n]]
        ke[3 * n + 2, 3 * n + 2] += (turning[0, n] * curve[0] + turning[1, n] * curve[1]
                                     + turning[2, n] * curve[2])
        for i in range(3):
            turned[i] = t[0, i] * fe[0, n] + t[1, i] * fe[1, n] + t[2, i] * fe[2, n]
        for i in range(3):
            fe[i, n] = turned[i]


@njit(**KERNEL)
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


@njit(nogil=True, **KERNEL)
def extrapolate(step, cells, dn, weight, bulk, mean, kept, swell, stress, pressure):
    """Write stress and pressure after the nodes' `step` (N, 3), to first order, from where `assemble` was
    last, which `kept` and `swell` hold."""
    nodes, w, df = dn.shape[3], room(), np.empty((3, 3))
    for e in range(len(cells)):
        w[:KEPT] = kept[e]
        for g in range(dn.shape[1]):
            gradient_at(step, cells[e], dn[e, g], df)
            for i in range(9):
                w[GRADIENT + i * L + g] = df[i // 3, i % 3]
        along_axes(w, TANGENT)
        strain(w, bulk)
        stress[e] = w[ACTING:ACTING + STRESSES]
        if not mean:
            pressure[e] = w[PRESSURE:PRESSURE + L]
            continue
        volume = swell[e, -1]
        for i in range(3):
            for n in range(nodes):
                volume += swell[e, i * nodes + n] * step[cells[e, n], i]
        pressure[e, 0] = bulk * (volume / weight[e].sum() - 1.0)


@njit(**KERNEL)
def largest_stretch(x, cells, dn):
    """(m,) largest principal stretch at the elements' middles: `dn` (m, 1, 3, n) gradients there."""
    found, f = np.empty(len(cells)), np.empty((3, 3))
    for e in range(len(cells)):
        gradient_at(x, cells[e], dn[e, 0], f)
        found[e] = np.sqrt(np.linalg.eigvalsh(f.T @ f)[2])
    return found
