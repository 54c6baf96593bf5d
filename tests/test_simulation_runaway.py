"""A wall that balloons: where the elements' curve ends, and what is said of it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from handgen.materials.law import law
from handgen.simulation import revolution, solid
from handgen.simulation.runaway import Wall
from tests.fingers import case

MU = 0.047
"""MPa, shear modulus of a neo-Hookean silicone."""


def limit_pressure(inner: float, outer: float) -> float:
    """Peak pressure, MPa, of a long closed neo-Hookean tube of radii at rest, mm, incompressible.

    With a the bore's radius and m the axial stretch, r^2 = a^2 + (R^2 - inner^2) / m; p is the integral of
    mu (h^2 - k^2) dr / r, h = r/R around, k = R / (r m) across the wall; lids pull so that the integral of
    mu (2 m^2 - h^2 - k^2) r dr vanishes.
    """
    def integral(a, m, weight):
        def at(r):
            h = r / np.sqrt(inner**2 + m * (r**2 - a**2))
            return weight(r, h, 1 / (h * m))
        return quad(at, a, np.sqrt(a**2 + (outer**2 - inner**2) / m))[0]

    def pressure(a):
        m = brentq(lambda m: integral(a, m, lambda r, h, k: (2 * m**2 - h**2 - k**2) * r), 0.5, 5)
        return MU * integral(a, m, lambda r, h, k: (h**2 - k**2) / r)

    return -minimize_scalar(lambda a: -pressure(a), bounds=(inner, 4 * inner), options={"xatol": 1e-3}).fun


@pytest.mark.parametrize("simulate", [solid.simulate, revolution.simulate])
def test_an_actuator_without_thread_balloons_at_the_tubes_limit_pressure(simulate):
    """At that of its section there, which its stronger neighbours help a little."""
    wound = case("actuator", orientation="weightless", pressures=[0, 100])
    bare = replace(wound, winding=None, silicone=replace(
        wound.silicone, law=law("neo_hookean", {"c10": MU / 2})))
    curve = simulate(bare)
    assert not curve.states[-1].converged
    found = re.fullmatch(r"the actuator balloons beyond (.*) kPa at x = (\d+) mm: its wall stretches .* times"
                         " and more before it finds a stable state", curve.stopped)
    assert found, curve.stopped
    pressure, x = float(found[1]), float(found[2])
    section = 1e3 * limit_pressure(float(bare.actuator.small_core(x)), float(bare.actuator.outer(x)))
    assert section < pressure < 1.06 * section
    # Widest against its wall near the base, which is held.
    assert bare.held < x < bare.actuator.small_core_end / 2


def test_the_slot_is_named_in_whose_opening_a_wall_gives_way():
    finger = case("assembly").finger
    joint = finger.finger.joints[1]
    assert Wall(7.0, joint.position + joint.slot_length / 2).where(finger).endswith(f"slot of {joint.name}")
    assert "slot" not in Wall(7.0, joint.position + joint.slot_length / 2 + 0.1).where(finger)
    assert "slot" not in Wall(7.0, joint.position).where(None)


@pytest.mark.parametrize("inner, outer", [(5.0, 5.01), (2.0, 2.004)])
def test_a_thin_tube_peaks_where_the_membrane_does(inner, outer):
    """A membrane's stress is p r / t around, half of it along: p R / (mu T) = (h^2 - k^2) / (h^2 m)."""
    def lost(h):
        m = brentq(lambda m: 2 * (m**2 - (h * m) ** -2) - (h**2 - (h * m) ** -2), 0.5, 5)
        return -(h**2 - (h * m) ** -2) / (h**2 * m)

    peak = -minimize_scalar(lost, bounds=(1.0, 4.0)).fun
    assert limit_pressure(inner, outer) * inner / (MU * (outer - inner)) == pytest.approx(peak, rel=1e-2)
