"""Stands in for the solver: a finger in closed form that knows weight, curl, stiffness and pressure."""

import math

from handgen.simulation.case import STANDARD_GRAVITY, Curve, State


def curve(case):
    """What `case` would read, by formulas that have the right signs and nothing else."""
    states = tuple(_state(case, pressure, load) for pressure, load in _loads(case))
    return Curve(states, {}, max(case.pressures), (), 1, 1, 0.0)


def _loads(case):
    if case.part == "exoskeleton":
        return [(0.0, load) for load in case.tip_loads]
    return [(pressure, case.tip_loads[0]) for pressure in case.pressures]


def _state(case, pressure, load):
    weight = -case.gravity[2] / STANDARD_GRAVITY
    curl = sum(math.radians(joint.rest_angle) for joint in case.finger.finger.joints) if case.finger else 0.0
    printed = case.tpu.law.shear_modulus if case.tpu else 0.0
    soft = case.silicone.law.shear_modulus if case.silicone else 0.0
    longer = 18.0 * (pressure / 0.05) * (0.0569 / soft) if soft else None
    turn = curl
    if case.part == "exoskeleton":
        turn += (0.3 * weight * case.tpu.density / 827e-12 + 2.2 * load) / printed
    elif case.part == "assembly":
        turn += 0.7 * weight / (printed + 4 * soft) + 1.1 * (pressure / 0.05) * (0.0569 / soft)
    drop = 85.0 * (1.0 - math.exp(-turn)) if case.part != "actuator" else 0.0
    return State(pressure, load, True, tip_drop=drop, bend_angle=turn, elongation=longer, tip_force=0.0,
                 max_stretch=1.1)
