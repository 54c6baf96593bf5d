"""Sliding contact of the actuator with the bones' bores, and of the finger with a plane.

A bone is rigid, so its bore is known in closed form: a point at x, seen from the bone's frame at s, is
inside by the gap g = r(s_x) + rim(s_x) - |(s_y, s_z)|. Beyond its slot's edge the bore opens like a rim of
radius RIM, so that a point slides on and off without a jump; the tip's face meets the flat end of the last
bone's bore. The gap costs the energy area W(g) with a stiffness PENALTY and a rounded onset of width
SOFT; its Hessian is exact, in the point's three coordinates and the bone's three unknowns: the list of pairs,
and with it the matrix's pattern, never changes. Points lie between two nodes each (`mesh.ActuatorMesh`).

Newton, on the way to balance, knows forces better than gaps: the linear equations are in balance with the
extrapolated ones. The stiffness of a pair is therefore that of the chord from its gap to the gap that goes
with its extrapolated force (`met`); where the two meet, it is the tangent's.

Friction acts along the axis, by bonds (`friction`). As their normal force follows the gap, friction has no
energy and its tangent no symmetry: what is symmetric goes into the matrix, the rest is given apart (`lever`,
`press`).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from handgen.simulation.element import scatter
from handgen.simulation.friction import SLIP, bond, chord

PENALTY = 1.0
"""N/mm3: at 100 kPa a wall sinks in by 0.025 mm."""
SOFT = 0.1
"""mm; half the width of the rounded onset."""
RIM = 3.0
"""mm; radius over which a bore opens towards a slot."""
BORE, FACE = 0, 1


@njit(cache=True)
def onset(gap, stiffness, soft):
    """(W, W', W'') of the gap: nothing above 0, a cubic down to -2 soft, a parabola below it.

    Surfaces that just touch, as drawn, do not push one another.
    """
    gap += soft
    if gap >= soft:
        return 0.0, 0.0, 0.0
    if gap <= -soft:
        return stiffness * (gap * gap / 2 + soft * soft / 6), stiffness * gap, stiffness
    t = soft - gap
    return stiffness * t**3 / (12 * soft), -stiffness * t * t / (4 * soft), stiffness * t / (2 * soft)


@njit(cache=True)
def met(gap, stiffness, soft, force, exact):
    """(W, W', slope of the chord of `onset` from `gap` to where it pushes with `force`), or W'' if `exact`.

    Where forces are known better than gaps, the chord leads to the gap that goes with the force; along the
    tangent a parabola's root is reached by halves only.
    """
    w, w1, w2 = onset(gap, stiffness, soft)
    deep = force / stiffness + soft if force > stiffness * soft else 2 * np.sqrt(soft * force / stiffness)
    apart = -gap - deep
    return w, w1, w2 if exact or abs(apart) < 1e-8 else (-w1 - force) / apart


@njit(cache=True)
def radius_at(pieces, x):
    """(r, r', r'') of a piecewise cubic; level beyond its ends."""
    n = len(pieces)
    if x <= pieces[0, 0]:
        return pieces[0, 2], 0.0, 0.0
    if x >= pieces[n - 1, 1]:
        return pieces[n - 1, 3], 0.0, 0.0
    i = 0
    while x > pieces[i, 1]:
        i += 1
    h = pieces[i, 1] - pieces[i, 0]
    t = (x - pieces[i, 0]) / h
    y0, y1, m0, m1 = pieces[i, 2], pieces[i, 3], h * pieces[i, 4], h * pieces[i, 5]
    a, b = 2 * (y0 - y1) + m0 + m1, 3 * (y1 - y0) - 2 * m0 - m1
    return y0 + t * (m0 + t * (b + t * a)), (m0 + t * (2 * b + 3 * t * a)) / h, (2 * b + 6 * t * a) / h**2


@njit(cache=True)
def bore_at(pieces, x, low, high, rim):
    """(r, r', r'') of a bone's bore with its rims; low, high: the slots' edges beside it."""
    r, d, c = radius_at(pieces, x)
    before, after = low + rim - x, x - (high - rim)
    if before > 0.0:
        r, d, c = r + before * before / (2 * rim), d - before / rim, c + 1.0 / rim
    if after > 0.0:
        r, d, c = r + after * after / (2 * rim), d + after / rim, c + 1.0 / rim
    return r, d, c


@njit(cache=True)
def seen(x, pivot, origin, angle, state, s, slope):
    """Write the place `s` of a point in a bone's straight frame, and its slopes (3, 6) in the point's x, y,
    z and the bone's dx, dz, turn."""
    a = angle + state[2]
    c, n = np.cos(a), np.sin(a)
    u, w = x[0] - origin[0] - state[0], x[2] - origin[1] - state[1]
    s[0], s[1], s[2] = pivot + c * u - n * w, x[1], n * u + c * w
    slope[:] = 0.0
    slope[0, 0], slope[0, 2], slope[0, 3], slope[0, 4] = c, -n, -c, n
    slope[2, 0], slope[2, 2], slope[2, 3], slope[2, 4] = n, c, -n, -c
    slope[1, 1] = 1.0
    slope[0, 5], slope[2, 5] = -n * u - c * w, c * u - n * w


@njit(cache=True)
def add_turning(slope, gx, gz, k):
    """Add gx d2s_x + gz d2s_z to `k` (6, 6): only the bone's turn bends the way s depends on it.

    d/dturn of (s_x - pivot, s_z) is (-s_z, s_x - pivot), so second derivatives with the turn are the first
    ones of the other component.
    """
    for j in range(6):
        more = -gx * slope[2, j] + gz * slope[0, j]
        k[5, j] += more
        if j != 5:
            k[j, 5] += more


@njit(cache=True)
def between(x, nodes, share, point):
    """Write the place of a point that has its `share` (2,) in two `nodes`."""
    for i in range(3):
        point[i] = share[0] * x[nodes[0], i] + share[1] * x[nodes[1], i]


@njit(cache=True)
def rub(friction, now, bend, normal, rubs, slope, fe, ke):
    """Add the force of a bond of the share `now` and its symmetric tangent of slope `bend`; `rubs`: the
    normal force that the tangent takes."""
    stiff = friction * rubs * bend
    for i in range(6):
        fe[i // 3, i % 3] += friction * normal * now * slope[0, i]
        for j in range(6):
            ke[i, j] += stiff * slope[0, i] * slope[0, j]
    add_turning(slope, friction * rubs * now, 0.0, ke)


@njit(cache=True)
def scatter_pair(share, fe, ke, dofs, place, force, matrix):
    """Add a pair's forces (2, 3), on point and bone, and stiffness (6, 6) to its two nodes and its bone."""
    for a in range(9):
        if dofs[a] < 0:
            continue
        i = a % 3 if a < 6 else a - 3
        own = share[a // 3] if a < 6 else 1.0
        force[dofs[a]] += own * fe[i // 3, i % 3]
        for b in range(9):
            where = place[a, b]
            if where >= 0:
                other = share[b // 3] if b < 6 else 1.0
                matrix[where] += own * other * ke[i, b % 3 if b < 6 else b - 3]


@njit(cache=True)
def add_contact(x, nodes, shares, bodies, kinds, area, swell, pieces, low, high, pivot, origin, angle, states,
                friction, anchors, normal, pressed, dragged, stiff, lever, press, exact, grip, dofs, place,
                force, matrix):
    """Add all pairs' forces and tangent; returns the energy of the gaps.

    nodes, shares (k, 2), bodies, kinds, area (k,): pairs of a point and a bone, what of the bone it meets,
    mm2 for it; pieces: of the bore; low, high (b,): where each bone ends; anchors (k,) where friction's bonds
    are fixed, NaN: nowhere; pressed: the extrapolated normal forces, N, which the stiffness takes unless
    `exact`, as `dragged` are the bonds' extrapolated directions; grip, mm: surfaces count as so much closer
    than they are. Writes the normal forces `normal` (k,), N, their slopes `stiff` (k,), N/mm, with respect to
    the gap, and what the tangent lacks, being symmetric: friction that follows the normal force, the sum of
    lever x press of all pairs (k, 9): friction's force on the unknowns for a normal force of 1, and the
    normal force's derivative with respect to them.
    """
    s, slope, g, step, at = np.empty(3), np.empty((3, 6)), np.empty(3), np.empty(6), np.empty(3)
    fe, ke = np.empty((2, 3)), np.empty((6, 6))
    energy = 0.0
    for e in range(len(nodes)):
        b = bodies[e]
        normal[e] = 0.0
        lever[e] = 0.0
        press[e] = 0.0
        between(x, nodes[e], shares[e], at)
        seen(at, pivot[b], origin[b], angle[b], states[b], s, slope)
        ke[:] = 0.0
        fe[:] = 0.0
        touched = False
        if kinds[e] == FACE:
            gap = high[b] - s[0]
            w, w1, w2 = met(gap - grip, PENALTY * area[e], SOFT, pressed[e], exact)
            stiff[e] = w2
            if w2 > 0.0:
                touched = True
                energy += w
                for i in range(6):
                    fe[i // 3, i % 3] -= w1 * slope[0, i]
                    for j in range(6):
                        ke[i, j] += w2 * slope[0, i] * slope[0, j]
                add_turning(slope, -w1 if exact else pressed[e], 0.0, ke)
        else:
            rho = np.sqrt(s[1] * s[1] + s[2] * s[2]) / swell
            r, d, c = bore_at(pieces, s[0], low[b], high[b], RIM)
            gap = r - rho
            w, w1, w2 = met(gap - grip, PENALTY * area[e], SOFT, pressed[e], exact)
            stiff[e] = w2
            if w2 > 0.0:
                touched = True
                energy += w
                normal[e] = -w1
                q = rho * swell * swell
                g[0], g[1], g[2] = d, -s[1] / q, -s[2] / q
                for j in range(6):
                    step[j] = g[0] * slope[0, j] + g[1] * slope[1, j] + g[2] * slope[2, j]
                # A force extrapolated far beyond the gap's would make the tangent indefinite.
                bent = w1 if exact else -min(pressed[e], -w1)
                for i in range(6):
                    fe[i // 3, i % 3] += w1 * step[i]
                    for j in range(6):
                        ke[i, j] += w2 * step[i] * step[j] + bent * (
                            c * slope[0, i] * slope[0, j]
                            + (g[1] * slope[1, i] + g[2] * slope[2, i])
                            * (g[1] * slope[1, j] + g[2] * slope[2, j]) / rho
                            - (slope[1, i] * slope[1, j] + slope[2, i] * slope[2, j]) / q)
                add_turning(slope, bent * g[0], bent * g[2], ke)
            if touched and friction > 0.0 and not np.isnan(anchors[e]):
                way = s[0] - anchors[e]
                now, _ = bond(way)
                along, rubs = (now, normal[e]) if exact else (dragged[e], pressed[e])
                rub(friction, now, chord(way, now, along), normal[e], rubs, slope, fe, ke)
                for a in range(9):
                    i, own = (a % 3, shares[e, a // 3]) if a < 6 else (a - 3, 1.0)
                    lever[e, a] = own * friction * now * slope[0, i]
                    press[e, a] = -own * w2 * step[i]
        if touched:
            scatter_pair(shares[e], fe, ke, dofs[e], place[e], force, matrix)
    return energy


@njit(cache=True)
def add_bonds(x, nodes, shares, bodies, area, rest, pivot, origin, angle, states, dofs, place, force, matrix):
    """Springs of PENALTY that hold points to their places `rest` (k, 3) in the bones' straight frames."""
    s, slope, off, at = np.empty(3), np.empty((3, 6)), np.empty(3), np.empty(3)
    fe, ke = np.empty((2, 3)), np.empty((6, 6))
    energy = 0.0
    for e in range(len(nodes)):
        b, k = bodies[e], PENALTY * area[e]
        between(x, nodes[e], shares[e], at)
        seen(at, pivot[b], origin[b], angle[b], states[b], s, slope)
        fe[:] = 0.0
        ke[:] = 0.0
        for n in range(3):
            off[n] = s[n] - rest[e, n]
            energy += 0.5 * k * off[n] ** 2
            for i in range(6):
                fe[i // 3, i % 3] += k * off[n] * slope[n, i]
                for j in range(6):
                    ke[i, j] += k * slope[n, i] * slope[n, j]
        add_turning(slope, k * off[0], k * off[2], ke)
        scatter_pair(shares[e], fe, ke, dofs[e], place[e], force, matrix)
    return energy


@njit(cache=True)
def extrapolate_contact(x, moved, turned, nodes, shares, bodies, kinds, area, swell, pieces, low, high,
                        pivot, origin, angle, states, anchors, stiff, pressed, dragged):
    """Write the normal forces after the nodes' step `moved` (N, 3) and the bones' `turned` (b, 3), to first
    order, never below 0, and the directions of friction's bonds, -1 to 1."""
    s, slope, step, at = np.empty(3), np.empty((3, 6)), np.empty(6), np.empty(3)
    for e in range(len(nodes)):
        b = bodies[e]
        between(x, nodes[e], shares[e], at)
        seen(at, pivot[b], origin[b], angle[b], states[b], s, slope)
        between(moved, nodes[e], shares[e], at)
        step[:3], step[3:] = at, turned[b]
        if kinds[e] == FACE:
            gap, grown = high[b] - s[0], -np.sum(slope[0] * step)
        else:
            rho = np.sqrt(s[1] * s[1] + s[2] * s[2]) / swell
            r, d, _ = bore_at(pieces, s[0], low[b], high[b], RIM)
            gap = r - rho
            grown = d * np.sum(slope[0] * step) - (
                s[1] * np.sum(slope[1] * step) + s[2] * np.sum(slope[2] * step)) / (rho * swell**2)
        _, w1, _ = onset(gap, PENALTY * area[e], SOFT)
        pressed[e] = max(0.0, -w1 - stiff[e] * grown)
        if not np.isnan(anchors[e]):
            now, grows = bond(s[0] - anchors[e])
            dragged[e] = min(1.0, max(-1.0, now + grows * np.sum(slope[0] * step)))


@njit(cache=True)
def drag(x, nodes, shares, bodies, kinds, normal, pivot, origin, angle, states, anchors):
    """Move the anchors of friction after an accepted step: a bond that slides follows at SLIP.

    Where nothing touches the anchor goes along: what comes to touch has rubbed all the way of that step.
    """
    s, slope, at = np.empty(3), np.empty((3, 6)), np.empty(3)
    for e in range(len(nodes)):
        if kinds[e] != BORE:
            continue
        b = bodies[e]
        between(x, nodes[e], shares[e], at)
        seen(at, pivot[b], origin[b], angle[b], states[b], s, slope)
        if np.isnan(anchors[e]) or normal[e] <= 0.0:
            anchors[e] = s[0]
        else:
            anchors[e] = min(s[0] + SLIP, max(s[0] - SLIP, anchors[e]))


@njit(cache=True)
def add_plane(points, bodies, area, level, pivot, origin, angle, states, dofs, place, force, matrix):
    """Contact of points (k, 3) of the bones' straight frames with the plane z = level below them.

    Adds forces and tangent in the bones' unknowns; returns (energy, force on the plane of this half, N).
    """
    fe, ke, step = np.empty((1, 3)), np.empty((3, 3)), np.empty(3)
    energy, pushed = 0.0, 0.0
    for e in range(len(points)):
        b = bodies[e]
        a = angle[b] + states[b, 2]
        c, n = np.cos(a), np.sin(a)
        u, w = points[e, 0] - pivot[b], points[e, 2]
        height = origin[b, 1] + states[b, 1] - n * u + c * w
        value, w1, w2 = onset(height - level, PENALTY * area[e], SOFT)
        if w2 == 0.0:
            continue
        energy += value
        pushed -= w1
        step[0], step[1], step[2] = 0.0, 1.0, -c * u - n * w
        for i in range(3):
            fe[0, i] = w1 * step[i]
            for j in range(3):
                ke[i, j] = w2 * step[i] * step[j]
        ke[2, 2] += w1 * (n * u - c * w)
        scatter(dofs[e], place[e], fe, ke, force, matrix)
    return energy, pushed
