"""Dry friction of a point in a bore: an elastic bond to where it rests, which slides at mu N.

N is the normal force. With d the way from the bond's anchor and root = sqrt(d^2 + STICK^2), the bond pulls
with the share d / root / FULL of mu N up to d = SLIP, where it is all of it; from there on its anchor is
dragged along. How a bond pulls depends on where it has turned back only: a way taken in one step or in ten
leaves it the same.

Newton rattles on such a knee: the share is therefore extrapolated like a stress, and the bond's slope is
linearised with it (`chord`; T. F. Chan, G. H. Golub, P. Mulet, SIAM J. Sci. Comput. 20 (1999) 1964-1977, do
the same for |x| in images).
"""

from __future__ import annotations

import numpy as np
from numba import njit

STICK = 0.05
"""mm; at the slope it begins with, a bond would pull fully after FULL of it."""
SLIP = 2 * STICK
"""mm; a node at rest creeps so far before it slides."""
FULL = SLIP / np.hypot(SLIP, STICK)
"""d / root at SLIP."""


@njit(cache=True)
def bond(way):
    """(share of mu N with which a bond pulls that is stretched by `way`, its slope, 1/mm)."""
    if abs(way) >= SLIP:
        return np.sign(way), 0.0
    root = np.sqrt(way * way + STICK * STICK)
    return way / root / FULL, STICK * STICK / root**3 / FULL


@njit(cache=True)
def chord(way, now, along):
    """Slope, 1/mm, for Newton of a bond of the share `now`, expected to become `along`; where the two are one
    it is the tangent.

    Linearised is now root = way / FULL up to SLIP, and now |way| = way beyond.
    """
    if abs(way) >= SLIP:
        return (1.0 - along * now) / abs(way)
    return (1.0 - FULL * FULL * along * now) / FULL / np.sqrt(way * way + STICK * STICK)
