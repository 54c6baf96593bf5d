"""How far two actuators fold the sheet that joins thumb and palm.

Frame: u across the gap, v along the fold, w away from the palm's skin, 0 at the actuators' axes.
Two rigid walls, L apart at rest, are joined by the sheet and pushed apart by n actuators. The far wall
moves by q = (e, a, b): it leaves along u by e on the line v = w = 0, turns by a about v (the
opposition) and by b about w. The actuator at v_i then grows by e_i = e + b v_i.

Sheet. Every section carries the same force F_u and moments about v and w. A beam whose plane
sections stay plane strains by (1, w, v) . k(u), and S(u) = integral of (1, w, v)(1, w, v)^T over the
section gives E' S k = (F_u, M_v, M_w). So q = (integral of S^-1 du) / E' . (F_u, M_v, M_w): the sheet is
a spring of stiffness K = E' (integral of S^-1 du)^-1, its stretch included, wherever its neutral axis
lies, whatever shape its sections have. E' = E (1 + 1/(1 - nu^2)) / 2: about as wide as it is long, it
bends neither like a strip (E) nor like a plate (E / (1 - nu^2)).

Actuator. Its thread keeps every circle as long as it is, so a wall of neo-Hookean silicone stretched by
l along its axis thins by l: energy mu/2 (l^2 + l^-2 - 2), stress mu (l - l^-3), stiffness mu (1 + 3 l^-4),
4 mu at first (planar tension). What the pressure encloses grows by pi r_f^2 e_i, r_f the radius where
the thread lies: inside it the silicone passes the pressure on. With wall area A, second moment I,
chamber length C and l_i = 1 + e_i / C the potential energy is

    q K q / 2 + sum_i [ A C mu/2 (l_i^2 + l_i^-2 - 2) - p pi r_f^2 e_i
                        + mu (1 + 3 l_i^-4) I (a^2 + b^2) / (2 C) ]

and its minimum the answer. It holds for large angles: bodies that bend about one axis keep their
stretch whatever the angle. For a sheet that does not stretch, of thickness t and width B at distance d,
and small l - 1 it is a = L n p pi r_f^2 d / (E' B t^3 / 12 + n 4 mu (A d^2 + I)).

Ends. A wall glued to plug and tip cannot thin there; the finite-element model of the tests makes a tube
as stiff as one that is shorter by 0.4 wall thicknesses an end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

RESTRAINT = 0.4
"""Length that each glued end takes from an actuator, in wall thicknesses (measured, see above)."""
POISSON = 0.49
"""Of the sheet: a rubber."""


@dataclass(frozen=True)
class Pusher:
    """One actuator across the gap, mm: place along the fold, chamber's length, radii of its wall."""

    at: float
    length: float
    inside: float
    thread: float
    outside: float

    @property
    def free_length(self) -> float:
        """Length that stretches freely, mm."""
        return self.length - 2 * RESTRAINT * (self.outside - self.inside)

    @property
    def area(self) -> float:
        return math.pi * (self.outside**2 - self.inside**2)

    @property
    def second_moment(self) -> float:
        return math.pi / 4 * (self.outside**4 - self.inside**4)


def section_matrix(triangles: np.ndarray) -> np.ndarray:
    """S (3, 3) of a section given as triangles (n, 3, 2) of (v, w): area, moments, second moments."""
    (v, w) = np.moveaxis((triangles + np.roll(triangles, 1, axis=1)) / 2, -1, 0)
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
    # The mean of the edges' middles integrates quadratics exactly.
    base = np.stack([np.ones_like(v), w, v], axis=-1)
    return np.einsum("n,nki,nkj->ij", areas / 3, base, base)


def rectangle(width: float, low: float, high: float) -> np.ndarray:
    """S (3, 3) of a section `width` wide about v = 0, from w = `low` to `high`."""
    v, w = width / 2, np.array([low, high])
    corners = np.array([[-v, w[0]], [v, w[0]], [v, w[1]], [-v, w[1]]])
    return section_matrix(corners[[[0, 1, 2], [0, 2, 3]]])


def flexibility(sections: np.ndarray, length: float) -> np.ndarray:
    """Integral of S^-1 over a gap of `length` mm from sections (n, 3, 3) in the middle of n equal parts."""
    return length * np.linalg.inv(sections).mean(axis=0)


def opposition_angle(sheet: np.ndarray, pushers: Sequence[Pusher], pressure: float, modulus: float,
                     mu: float) -> float:
    """Angle about the fold, deg, at `pressure`; arguments as those of `balance`."""
    return math.degrees(balance(sheet, pushers, pressure, modulus, mu)[1])


def balance(sheet: np.ndarray, pushers: Sequence[Pusher], pressure: float, modulus: float, mu: float,
            start: np.ndarray | None = None) -> np.ndarray:
    """q = (e mm, a rad, b rad) at `pressure`; `modulus` of the sheet, `mu` of the silicone, all MPa.

    `sheet` is its `flexibility`; `start` a q nearby.

    Raises:
        ArithmeticError: no equilibrium was found.
    """
    from scipy.optimize import root

    stiffness = modulus * (1 + 1 / (1 - POISSON**2)) / 2 * np.linalg.inv(sheet)

    def force(q: np.ndarray) -> np.ndarray:
        """Gradient of the potential energy."""
        total = stiffness @ q
        bent = q[1] ** 2 + q[2] ** 2
        for p in pushers:
            length = p.free_length
            stretch = 1 + (q[0] + q[2] * p.at) / length
            bending = mu * p.second_moment / length
            pull = (mu * p.area * (stretch - stretch**-3) - pressure * math.pi * p.thread**2
                    - 6 * bending * bent * stretch**-5 / length)
            total = total + pull * np.array([1.0, 0.0, p.at])
            total = total + bending * (1 + 3 * stretch**-4) * np.array([0.0, q[1], q[2]])
        return total

    found = root(force, np.zeros(3) if start is None else start, tol=1e-10)
    if not found.success:
        raise ArithmeticError(f"no equilibrium of the hinge: {found.message}")
    return found.x


def turned_out(direction: Sequence[float], elevation: float) -> float:
    """Turn about v, deg, that lifts `direction` (u, v, w) to `elevation` deg out of the palm's plane.

    Below zero: it is out as far already. Never more than where the direction stands out farthest.
    """
    u, _, w = direction
    reach = math.hypot(u, w)
    share = math.sin(math.radians(elevation)) / reach
    return math.degrees((math.asin(share) if share < 1 else math.pi / 2) - math.atan2(-w, u))
