"""A planar chain of rigid links on springs, pushed open by an actuator that runs beside it: its equilibrium.

Links lie on the hinge line of the palmar strips. Unknown are their absolute angles t[i], rad, flexion
positive (t = 0 along x, t = pi/2 straight down); link i starts where link i - 1 ends, the first one at the
root. Energy, N mm, of the turns v[i] = t[i] - t[i-1] - rest[i]:

    sum_i strip[i] (v^2/2 + harden[i] v^4/4)                    strips
    + sum_i beam[i] v^2/2                                       the actuator, bent with them
    + area (integral of P over d - pressure d)                  the actuator, stretched by d
    - sum_i weight[i] (fall of the middle of link i's axis)     own weight, times `down`
    + sum_i drag[i] v[i]                                        what rubs
    - load (fall of the tip)                                    a weight on the tip
    + floor/2 (depth of the tip below the plane)^2              the plane of a force test

d = sum_i arm[i] v[i]; P(d) is the pressure that stretches the free actuator by d: wall[0] x / (1 + wall[1] x)
+ wall[2] x^2 with x = d / length. Every term is smooth; the Hessian is a tridiagonal matrix and a few dyads,
small enough to be solved densely.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

LINKS = 30
STEPS = 200
TOLERANCE = 1e-9
"""Largest out-of-balance moment, N mm."""


@njit(cache=True)
def wall_pressure(d, length, wall):
    """(pressure, its slope, its integral) of a free actuator stretched by `d`, MPa, MPa/mm, MPa mm."""
    x = d / length
    if x < 0.0:
        return wall[0] * x, wall[0] / length, length * wall[0] * x * x / 2
    u = 1.0 + wall[1] * x
    p = wall[0] * x / u + wall[2] * x * x
    slope = (wall[0] / u**2 + 2 * wall[2] * x) / length
    integral = length * (wall[0] * (x - math.log(u) / wall[1]) / wall[1] + wall[2] * x**3 / 3)
    return p, slope, integral


@njit(cache=True)
def assemble(t, rest, strip, harden, beam, arm, stop, drag, links, weight, off, body, act, wall, loads):
    """(energy, gradient, Hessian) at the angles `t`.

    links: lengths, mm. off: axis above the hinge line, mm. body = (tip start, tip end, tip radius, height of
    the root's hinge line, floor stiffness, stop stiffness) - tip points along the last link, mm. act = (area,
    length). loads = (pressure, down, tip load, plane z, sign of the tip load). stop: turn from which a hinge
    is blocked, rad.
    """
    n = len(t)
    g, h = np.zeros(n), np.zeros((n, n))
    energy, d = 0.0, 0.0
    for i in range(n):
        v = t[i] - (t[i - 1] if i else 0.0) - rest[i]
        m = strip[i] * (v + harden[i] * v**3) + beam[i] * v + drag[i]
        k = strip[i] * (1 + 3 * harden[i] * v**2) + beam[i]
        energy += strip[i] * (v**2 / 2 + harden[i] * v**4 / 4) + beam[i] * v**2 / 2
        energy += drag[i] * v
        over = v - stop[i]
        if over > 0.0:
            energy += body[5] * over**3 / 3
            m += body[5] * over**2
            k += 2 * body[5] * over
        d += arm[i] * v
        g[i] += m
        h[i, i] += k
        if i:
            g[i - 1] -= m
            h[i - 1, i - 1] += k
            h[i, i - 1] -= k
            h[i - 1, i] -= k
    p, stiff, work = wall_pressure(d, act[1], wall)
    push = act[0] * (p - loads[0])
    energy += act[0] * (work - loads[0] * d)
    for i in range(n):
        a = arm[i] - (arm[i + 1] if i + 1 < n else 0.0)
        g[i] += push * a
        for j in range(n):
            h[i, j] += act[0] * stiff * a * (arm[j] - (arm[j + 1] if j + 1 < n else 0.0))
    # Heights: link i contributes -links[i] sin t[i]; its axis lies off[i] along (sin t, cos t) beside it.
    beyond = 0.0
    for i in range(n - 1, -1, -1):
        w = loads[1] * weight[i]
        half = (beyond + w / 2) * links[i]
        energy += w * off[i] * math.cos(t[i]) - half * math.sin(t[i])
        g[i] += -w * off[i] * math.sin(t[i]) - half * math.cos(t[i])
        h[i, i] += -w * off[i] * math.cos(t[i]) + half * math.sin(t[i])
        beyond += w
    energy += _at_tip(t, links, off, body, loads, g, h)
    return energy, g, h


@njit(cache=True)
def _at_tip(t, links, off, body, loads, g, h):
    """Adds the tip's load and the plane to `g` and `h`; their energy."""
    n = len(t)
    low, reach = tip_height(t, links, off, body, body[1])
    if loads[2] == 0.0 and not (loads[3] < 0.0 and low < loads[3]):
        return 0.0
    depth = max(loads[3] - low, 0.0) if loads[3] < 0.0 else 0.0
    # A finger that meets weight or plane points down: the foremost of the tip's points is the lowest.
    force = loads[4] * loads[2] - body[4] * depth
    z = np.empty(n)
    for i in range(n):
        length = reach if i == n - 1 else links[i]
        o = off[n - 1] if i == n - 1 else 0.0
        z[i] = -length * math.cos(t[i]) - o * math.sin(t[i])
        h[i, i] += force * (length * math.sin(t[i]) - o * math.cos(t[i]))
        g[i] += force * z[i]
    if depth > 0.0:
        for i in range(n):
            for j in range(n):
                h[i, j] += body[4] * z[i] * z[j]
    return loads[4] * loads[2] * low + body[4] * depth**2 / 2


@njit(cache=True)
def tip_height(t, links, off, body, reach):
    """(height above the root's axis, mm, of the round tip's underside at `reach` along the last link;
    reach)."""
    n = len(t)
    z = body[3]
    for i in range(n - 1):
        z -= links[i] * math.sin(t[i])
    return z - reach * math.sin(t[n - 1]) + off[n - 1] * math.cos(t[n - 1]) - body[2], reach


@njit(cache=True)
def equilibrium(t0, rest, strip, harden, beam, arm, stop, drag, links, weight, off, body, act, wall, loads):
    """(angles, out-of-balance moment) of the stable state that a damped Newton finds from `t0`."""
    t = t0.copy()
    n = len(t)
    e, g, h = assemble(t, rest, strip, harden, beam, arm, stop, drag, links, weight, off, body, act, wall,
                       loads)
    shift = 0.0
    for _ in range(STEPS):
        size = np.abs(g).max()
        if size < TOLERANCE:
            break
        step = -np.linalg.solve(h + shift * np.eye(n), g)
        most = np.abs(step).max()
        if most > 0.3:
            step *= 0.3 / most
        slope = (g * step).sum()
        if slope >= 0.0:
            shift = max(4 * shift, 1e-2)
            continue
        share, moved = 1.0, False
        for _ in range(30):
            new = t + share * step
            e1, g1, h1 = assemble(new, rest, strip, harden, beam, arm, stop, drag, links, weight, off, body,
                                  act, wall, loads)
            if e1 <= e + 1e-4 * share * slope + 1e-13 * abs(e):
                moved = True
                break
            share /= 2
        # Round-off in the energy: near enough to judge by the forces alone.
        if not moved and np.abs(g1).max() >= size:
            break
        t, e, g, h = new, e1, g1, h1
        shift = shift / 8 if shift > 1e-6 else 0.0
    return t, np.abs(g).max()
