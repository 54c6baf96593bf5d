"""How far the wall of an actuator bulges between two turns of its thread.

The inner layer, a membrane strip of thickness t and mid radius r, is held by two rings a gap g
apart and pressed by p from inside. Three steps:

1. Shape. Over a gap that is short against the radius the meridian is a circular arc (Laplace: one
   tension, one pressure): half angle a, radius of curvature rho = g / (2 sin a), height
   w = g/2 tan(a/2), meridional stretch m = a / sin a, mean hoop stretch h = 1 + (2/3) w / r.
2. Law. Tensions of a neo-Hookean membrane per length of the stretched wall (Adkins and Rivlin,
   Large elastic deformations of isotropic materials IX, Phil. Trans. R. Soc. A 244 (1952) 505-531):
   T = mu t (m/h - (m h)^-3) along the meridian, N = mu t (h/m - (m h)^-3) around it.
3. Balance. p r_in = (T / rho + N / r_mid) r_mid, where r_in and r_mid are the inner and middle radius
   of the bulged wall, which has thinned to t / (m h): in a thick wall the pressure acts on less area.

The limit is the half circle, a = 90 degrees: up to there a strip that grows curves more tightly
and so holds more; beyond, it curves less, lies over the thread on its neighbour, and balloons: the
pressure has its peak at 120 to 140 degrees, 15 to 35 % above that of the half circle. For r much
larger than g the limit is g = 2 mu t / p (pi/2 - (2/pi)^3).

A wall stretched along its axis is not worse off: gap and tension grow together (see the tests). The
external layer is left out: the thread parts it from the internal one and a pour may not bond. In a
finite-element model with both layers bonded a gap of 1.85 mm bulges by 0.85 mm at 100 kPa; this
gives 0.86 mm.
"""

from __future__ import annotations

import math

HALF_CIRCLE = math.pi / 2
STEPS = 48
"""Half angles between flat and a full circle among which the peak pressure is looked for."""


def pressure(half_angle: float, gap: float, thickness: float, radius: float, mu: float) -> float:
    """Pressure, MPa, that bulges a strip to `half_angle` (rad).

    `gap`, `thickness` in mm, `radius`: outside of the inner layer, where the thread lies, mm; `mu`:
    shear modulus, MPa.
    """
    m = half_angle / math.sin(half_angle)
    outwards = 2 / 3 * height(half_angle, gap)
    h = 1 + outwards / (radius - thickness / 2)
    thinned = thickness / (m * h)
    middle, inside = radius + outwards - thinned / 2, radius + outwards - thinned
    along = mu * thickness * (m / h - (m * h) ** -3)
    around = mu * thickness * (h / m - (m * h) ** -3)
    return (along * 2 * math.sin(half_angle) / gap + around / middle) * middle / inside


def height(half_angle: float, gap: float) -> float:
    """Height of the arc over its chord `gap`, mm."""
    return gap / 2 * math.tan(half_angle / 2)


def stretch(half_angle: float) -> float:
    """Stretch along the arc."""
    return half_angle / math.sin(half_angle)


def half_angle(at: float, gap: float, thickness: float, radius: float, mu: float) -> float:
    """Half angle, rad, to which the pressure `at` (MPa) bulges a strip; infinite: it balloons."""
    from scipy.optimize import brentq

    def excess(angle: float) -> float:
        return pressure(angle, gap, thickness, radius, mu) - at

    low = 1e-4
    for step in range(1, STEPS):
        high = math.pi * step / STEPS
        if excess(high) > 0:
            return brentq(excess, low, high)
        low = high
    return math.inf


def widest_gap(at: float, thickness: float, radius: float, mu: float) -> float:
    """Gap, mm, over which the pressure `at` (MPa) bulges the strip to a half circle."""
    from scipy.optimize import brentq

    flat = 2 * mu * thickness / at * (HALF_CIRCLE - HALF_CIRCLE**-3)

    def excess(gap: float) -> float:
        return pressure(HALF_CIRCLE, gap, thickness, radius, mu) - at

    # A curved wall holds more than a flat one, at any gap.
    return brentq(excess, flat * 0.5, flat * 20)
