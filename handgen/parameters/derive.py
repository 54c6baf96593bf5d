"""Dimensions that follow from the parameters: pure functions on plain numbers, mm."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from operator import itemgetter

from handgen.parameters.finger import Actuator, Finger, Joint, Layers

LEAST_FOLD = 0.5
"""Least length, mm, of a strip's palmar side as printed with its rest angle: with less it folds up."""
STRAIGHT = ([0.0, 0.0], [1.0, 1.0])
"""Taper of an actuator that fills no finger."""

Pieces = tuple[tuple[float, float, float, float, float, float], ...]
"""Cubics (x0, x1, y0, y1, slope at x0, slope at x1) end to end."""


def monotone(length: float, start: float, end: float, stations: Sequence[Sequence[float]]) -> Pieces:
    """The taper from `start` at 0 to `end` at `length` through `stations`, without overshoot.

    Fritsch and Carlson's monotone interpolant (SIAM J. Numer. Anal. 17, 1980) with the harmonic
    mean for inner slopes; level at both ends, so that the diameter quoted for base or tip holds
    over a visible length and the rounded tip joins without an edge.
    """
    x = [s[0] * length for s in stations]
    y = [start + (end - start) * s[1] for s in stations]
    secants = [(y[i + 1] - y[i]) / (x[i + 1] - x[i]) for i in range(len(x) - 1)]
    slopes = [0.0] * len(x)
    for i, (a, b) in enumerate(pairwise(secants), start=1):
        slopes[i] = 2 * a * b / (a + b) if a * b > 0 else 0.0
    return tuple((x[i], x[i + 1], y[i], y[i + 1], slopes[i], slopes[i + 1]) for i in range(len(x) - 1))


def value_at(pieces: Pieces, x: float) -> float:
    """The curve's value at one x; beyond its ends it keeps its end value."""
    x = min(max(x, pieces[0][0]), pieces[-1][1])
    x0, x1, y0, y1, m0, m1 = pieces[bisect_right(pieces, x, key=itemgetter(0)) - 1]
    h = x1 - x0
    t = (x - x0) / h
    u = 1 - t
    return (y0 * (1 + 2 * t) + h * m0 * t) * u * u + (y1 * (1 + 2 * u) - h * m1 * u) * t * t


def stations(actuator: Actuator, finger: Finger | None) -> Sequence[Sequence[float]]:
    """The actuator's own taper; else that of the finger it fills; else straight."""
    if actuator.taper is not None:
        return actuator.taper
    return STRAIGHT if finger is None else finger.taper


def palmar_fold(finger: Finger, joint: Joint) -> float:
    """Length, mm, that the palmar side of a joint's strip keeps when all of the slot is bent.

    The axis keeps its length; the finger's outside lies on the inner side of the bend. Judged by
    the finger's radius at its base, its largest.
    """
    return joint.slot_length - math.radians(joint.rest_angle) * finger.base_outer_diameter / 2


def tightest(actuator: Actuator, finger: Finger) -> tuple[float, float, float]:
    """(x, actuator's diameter, bore's diameter) where the actuator has least room in its bore.

    Compared at 0.5 mm steps and at all stations: the curves are smooth and monotone between.
    """
    outside = monotone(
        actuator.outer_length,
        actuator.base_outer_diameter,
        actuator.tip_outer_diameter,
        stations(actuator, finger),
    )
    bore = monotone(finger.inner_length, finger.base_bore_diameter, finger.tip_bore_diameter, finger.taper)
    return _tightest(outside, bore, actuator.outer_length)


@lru_cache(maxsize=64)
def _tightest(outside: Pieces, bore: Pieces, length: float) -> tuple[float, float, float]:
    """Kept, for most fingers of a sweep's hands are alike, and relations and rules ask for the same."""
    places = {p[1] for p in (*outside, *bore)} | {0.5 * i for i in range(int(2 * length) + 1)}
    pairs = ((x, value_at(outside, x), value_at(bore, x)) for x in sorted(places) if x <= length)
    return min(pairs, key=lambda place: place[2] - place[1])


def thinning(actuator: Actuator, layers: Layers, minimum_core: float) -> float:
    """Share of the asked layers that is left at the tip so that the small core fits; 1: all of it."""
    return min(1.0, (actuator.tip_outer_diameter - minimum_core) / 2 / layers.stack)
