"""How much of Newton's step contact lets pass.

Of points and bores Newton knows only those that touch, or are expected to: a whole step may drive others in,
or throw a sliding one back, by far more than they can bear. Along the step the forces of contact and friction
are therefore taken as they are, all else as Newton reckons with it, up to where the sum drives no further:
a line search, but one that leaves alone the false strains of a turning step, which mixed integration points
bear. It costs no elements: a look is a fiftieth of an assembly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from handgen.simulation.contact import BORE, PENALTY, RIM, SOFT, between, bore_at, onset, seen
from handgen.simulation.friction import bond, chord

if TYPE_CHECKING:
    from handgen.simulation.system import System

OVERSHOT = 0.3
"""Force along the step after it, over that before, from which on the step is shortened."""
LEAST = 0.1
"""Share of a step that is taken in any case."""
LOOKS = 8
"""Bisections at most."""


def share(system: System, q: np.ndarray, step: np.ndarray, force: np.ndarray) -> float:
    """The share of `step` to take from `q`, where the system was assembled last and `force` is out of
    balance."""
    if not len(system.pair_nodes) or system.case.contact.bonded:
        return 1.0
    moved, turned = system.moved(step)
    what = (*system.touching(q), system.case.contact.friction, system.anchors, system.pair_stiffness,
            system.pressed, system.dragged)
    before = -float(step @ force)
    if before <= 0.0:
        return 1.0
    at_first, reckoned = along(system.placed, moved, turned, 0.0, *what)
    other = before - reckoned

    def beyond(part: float) -> float:
        """The force along the step after a part of it, N mm."""
        return along(system.placed, moved, turned, part, *what)[0] - at_first - before + part * other

    if beyond(1.0) <= OVERSHOT * before:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(LOOKS):
        middle = (low + high) / 2
        if 0.0 <= (left := beyond(middle)) <= OVERSHOT * before:
            break
        low, high = (low, middle) if left > 0.0 else (middle, high)
    return max(LEAST, middle)


@njit(cache=True)
def along(x, moved, turned, part, nodes, shares, bodies, kinds, area, swell, pieces, low, high, pivot, origin,
          angle, states, friction, anchors, stiff, pressed, dragged):
    """(force of contact and friction along the step of nodes `moved` (N, 3) and bones `turned` (b, 3) after
    a `part` of it, its slope as Newton reckons with it), N mm; the rest as `contact.add_contact` takes it."""
    s, slope, step, at, go = np.empty(3), np.empty((3, 6)), np.empty(6), np.empty(3), np.empty(3)
    total, reckoned = 0.0, 0.0
    for e in range(len(nodes)):
        b = bodies[e]
        between(x, nodes[e], shares[e], at)
        between(moved, nodes[e], shares[e], go)
        step[:3], step[3:] = go, turned[b]
        at += part * go
        seen(at, pivot[b], origin[b], angle[b], states[b] + part * turned[b], s, slope)
        slid, aside, up = np.sum(slope[0] * step), np.sum(slope[1] * step), np.sum(slope[2] * step)
        # How the turn bends the way of s: what `contact.add_turning` adds, along the step.
        bent_x = -turned[b, 2] * (2 * up - turned[b, 2] * slope[2, 5])
        bent_z = turned[b, 2] * (2 * slid - turned[b, 2] * slope[0, 5])
        if kinds[e] != BORE:
            gap, grown, bends = high[b] - s[0], -slid, -bent_x
        else:
            rho = np.sqrt(s[1] * s[1] + s[2] * s[2]) / swell
            q = rho * swell**2
            r, d, c = bore_at(pieces, s[0], low[b], high[b], RIM)
            gap = r - rho
            closes = (s[1] * aside + s[2] * up) / q
            grown = d * slid - closes
            bends = (c * slid**2 + closes**2 / rho - (aside**2 + up**2) / q + d * bent_x - s[2] / q * bent_z)
        _, push, _ = onset(gap, PENALTY * area[e], SOFT)
        total += push * grown
        reckoned += stiff[e] * grown * grown
        if stiff[e] > 0.0:
            # As the tangent takes it: no more than the gap's force in a bore.
            reckoned -= bends * (pressed[e] if kinds[e] != BORE else min(pressed[e], -push))
        if kinds[e] == BORE and friction > 0.0 and push < 0.0:
            way = s[0] - anchors[e]
            now, _ = bond(way)
            total -= friction * push * now * slid
            reckoned += friction * (pressed[e] * (chord(way, now, dragged[e]) * slid**2 + now * bent_x)
                                    - now * slid * stiff[e] * grown)
    return total, reckoned
