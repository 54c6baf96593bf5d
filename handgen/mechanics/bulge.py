"""How far the wall of an actuator bulges between two turns of its thread.

The inner layer, a membrane strip of thickness t and mid radius r, is held by two rings a gap g
apart and pressed by p from inside; the external layer lies on it as a sleeve. Four steps:

1. Shape. Over a gap that is short against the radius the meridian is a circular arc (Laplace: one
   tension, one pressure): half angle a, radius of curvature rho = g / (2 sin a), height
   w = g/2 tan(a/2), meridional stretch m = a / sin a, mean hoop stretch h = 1 + (2/3) w / r.
2. Law. Tensions of a neo-Hookean membrane per length of the stretched wall (Adkins and Rivlin,
   Large elastic deformations of isotropic materials IX, Phil. Trans. R. Soc. A 244 (1952) 505-531):
   T = mu t (m/h - (m h)^-3) along the meridian, N = mu t (h/m - (m h)^-3) around it.
3. Sleeve. The thread parts the layers and a pour may not bond, so that the rings hold the inner one
   only; the external one, blown up from A to A' = A + (2/3) w inside and B to B' outside, presses back
   with mu (ln(B A' / (A B')) + (A'^2 - A^2) (A'^-2 - B'^-2) / 2), a thick tube of fixed length.
4. Balance. p = (T / rho + N / r_mid) r_mid / r_in + sleeve, where r_in and r_mid are the inner and middle
   radius of the bulged layer, thinned to t / (m h): in a thick wall the pressure acts on less area.

The limit is the half circle, a = 90 degrees: up to there a strip that grows curves more tightly
and so holds more; beyond, it curves less, lies over the thread on its neighbour, and balloons: the
pressure has its peak at 120 to 140 degrees. For r much larger than g the limit is
g = 2 mu t / p (pi/2 - (2/pi)^3). A wall stretched along its axis reaches it later: gap and tension
grow together.

Against finite elements with both layers bonded (see the tests): within 15 % for walls as in Table A.2 at
the source's 2 mm; too careful, by up to two thirds, where the inner layer is thinner than 1 mm; over
gaps of about 1 mm the elements add 0.1 mm by which the thread sinks into the wall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

HALF_CIRCLE = math.pi / 2
STEPS = 48
"""Half angles between flat and a full circle among which the peak pressure is looked for."""


ITERATIONS = 60
CLOSE = 1e-13
"""Of a gap: nearer its root is not looked for."""


@dataclass(frozen=True)
class Wall:
    """An actuator's wall at one place: radii of chamber, thread and outside, mm; shear modulus, MPa.

    The radii may be arrays: many places, of which `widest_gap` asks at once.
    """

    inside: float
    thread: float
    outside: float
    mu: float

    def at(self, place: int) -> Wall:
        """One of many places."""
        return Wall(float(self.inside[place]), float(self.thread[place]), float(self.outside[place]), self.mu)

    def pressure(self, half_angle: float, gap: float) -> float:
        """Pressure, MPa, that bulges the wall over `gap` mm to `half_angle` rad."""
        mu, thickness = self.mu, self.thread - self.inside
        m = stretch(half_angle)
        outwards = 2 / 3 * height(half_angle, gap)
        h = 1 + outwards / (self.thread - thickness / 2)
        thinned = thickness / (m * h)
        middle, inside = self.thread + outwards - thinned / 2, self.thread + outwards - thinned
        along = mu * thickness * (m / h - (m * h) ** -3)
        around = mu * thickness * (h / m - (m * h) ** -3)
        held = along * 2 * math.sin(half_angle) / gap + around / middle
        return held * middle / inside + self._sleeve(outwards)

    def _sleeve(self, outwards: float) -> float:
        """Pressure of the external layer on the inner one, MPa."""
        a, b = self.thread**2, self.outside**2
        grown = (self.thread + outwards) ** 2 - a
        curve = grown / 2 * (1 / (a + grown) - 1 / (b + grown))
        return self.mu * (0.5 * np.log(b * (a + grown) / (a * (b + grown))) + curve)

    def half_angle(self, pressure: float, gap: float) -> float:
        """Half angle, rad, to which `pressure` (MPa) bulges the wall; infinite: it balloons."""
        from scipy.optimize import brentq

        def excess(angle: float) -> float:
            return self.pressure(angle, gap) - pressure

        low = 1e-4
        for step in range(1, STEPS):
            high = math.pi * step / STEPS
            if excess(high) > 0:
                return brentq(excess, low, high)
            low = high
        return math.inf

    def widest_gap(self, pressure: float):
        """Gap, mm, over which `pressure` (MPa) bulges the wall to a half circle; infinite: none.

        Pressure times gap is nearly straight in the gap: a secant between two bounds (the Illinois rule).
        """
        def excess(gap):
            return (self.pressure(HALF_CIRCLE, gap) - pressure) * gap

        flat = 2 * self.mu * (self.thread - self.inside) / pressure * (HALF_CIRCLE - HALF_CIRCLE**-3)
        low, high = 0.2 * np.asarray(flat), 20 * np.asarray(flat)
        over, under = excess(low), excess(high)
        bounded, gap, last = under < 0, low, 0
        with np.errstate(invalid="ignore", divide="ignore"):
            for _ in range(ITERATIONS):
                before, gap = gap, np.where(over > under, (low * under - high * over) / (under - over), low)
                found = excess(gap)
                above = found > 0
                # A bound that stays where it is twice counts half.
                under = np.where(above, np.where(last == 1, under / 2, under), found)
                over = np.where(above, found, np.where(last == -1, over / 2, over))
                low, high, last = (np.where(above, gap, low), np.where(above, high, gap),
                                   np.where(above, 1, -1))
                if np.all((np.abs(gap - before) <= CLOSE * gap) | ~bounded):
                    break
        widest = np.where(bounded, gap, math.inf)
        return widest if widest.ndim else float(widest)


def height(half_angle: float, gap: float) -> float:
    """Height of the arc over its chord `gap`, mm."""
    return gap / 2 * math.tan(half_angle / 2)


def stretch(half_angle: float) -> float:
    """Stretch along the arc."""
    return half_angle / math.sin(half_angle)
