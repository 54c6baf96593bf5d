"""The reduced model: a planar chain of rigid bones and extensible, geometrically exact rods.

One rod of even curvature stands for each joint: the palmar strip, whose fibres follow its own law at any
strain, bent and stretched by the actuator that pushes from behind. The actuator is one tube whose thread
holds every circle, so that its wall is in planar tension, and which slides through the bones: a thrust
T = p pi r_f^2 - A P(l) runs along it, less behind every turn, and acts at each joint with the lever between
strip and axis. Own weight, a weight on the tip and a plane below it act on the bones.

What a chain cannot know (how far a strip's bending reaches into the bones, how stiff a bent chamber is, how
far it leaves the axis, what rubs) are the coefficients of `known.json`, fitted on the solid model with random
fingers (`python -m tests.benchmarks.rod`). The file also holds the range of those fingers, and how far off
the rod was: a state says how far off it may be, and where it lies beyond that range. It ranks; the solid
model confirms.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from handgen.simulation.case import Case, Curve, State
from handgen.simulation.rod.balance import Balance
from handgen.simulation.rod.chain import Chain
from handgen.simulation.rod.known import known

STEP = 0.030
"""MPa; the longest step of pressure."""
SHORTEST = 0.0005


def simulate(case: Case, progress: Callable[[str], None] | None = None) -> Curve:
    """Bend `case` through its pressures, or the first that finds no balance.

    Raises:
        ValueError: a part, contact or effect that the rod does not know.
    """
    if case.part != "assembly" or case.winding is None:
        raise ValueError("the rod knows whole fingers with a thread only")
    if case.contact.bonded or case.extended:
        raise ValueError(f"the rod does not know {', '.join(case.extended) or 'an actuator that sticks'}")
    say, begun = progress or (lambda line: None), time.perf_counter()
    chain = Chain(case)
    balance = Balance(chain, known().coefficients)
    q, stopped, states, reached = balance.unloaded(1), "", [], 0.0
    if q is None:
        stopped = "the unloaded finger finds no balance"
    here = 0.0
    for pressure in case.pressures:
        if not stopped:
            there = towards(balance, q, here, pressure)
            if there is not None:
                q, here = there, pressure
                states.append(_state(case, balance, q, pressure))
                reached = max(reached, pressure)
                say(f"{1e3 * pressure:.1f} kPa: bend {math.degrees(states[-1].bend_angle):.1f} degrees")
                continue
            stopped = f"the rod finds no balance on the way to {1e3 * pressure:.1f} kPa"
        states.append(State(pressure, case.tip_loads[0], False, note=stopped))
    return Curve(tuple(states), {}, reached, (), chain.unknowns, balance.factorisations,
                 time.perf_counter() - begun, stopped)


def towards(balance: Balance, q: np.ndarray, here: float, there: float) -> np.ndarray | None:
    """The state at the pressure `there`, in steps that are halved where they fail."""
    step = STEP
    while here != there:
        gap = there - here
        target = there if abs(gap) <= step * (1 + 1e-9) else here + math.copysign(step, gap)
        found = balance.solve(q, target)
        if found is None:
            step /= 2
            if step < SHORTEST:
                return None
        else:
            q, here = found, target
    return q


def _state(case: Case, balance: Balance, q: np.ndarray, pressure: float) -> State:
    chain = balance.chain
    turns = chain.rest + q[:chain.joints]
    stretch = balance.stretches(q, pressure)
    angle = float(turns.sum())
    beyond = known().beyond(chain, turns, stretch["actuator"], pressure)
    return State(
        pressure, case.tip_loads[0], True, tip_drop=chain.drop(q), bend_angle=angle,
        elongation=balance.elongation(q, pressure),
        tip_force=balance.pushed(q) if case.obstacle is not None else None,
        max_stretch=float(max(s.max() for s in stretch.values())), residual=balance.residual_of(q, pressure),
        note="; ".join(beyond), stretch=stretch, bend_error=known().error(angle, bool(beyond)))
