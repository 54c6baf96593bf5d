"""The same finger by other means: what the fast solver is held against, and `--solver reference`.

The same physics as `handgen.simulation.solid`: the case (`case.py`), its profiles and its laws, the thread as
a fibre family, air that works as -p V, own weight, a weight on the tip, contact without friction, symmetry
about y = 0.

Solved differently, and with no line of code in common: NGSolve's finite elements, which derive forces and
tangent from the energy by themselves; quadratic displacements with a linear volumetric stress in every
element instead of trilinear ones with a constant; hexahedra and prisms mapped onto the true circles for the
actuator, plain Newton, another direct solver. It is some fifty times slower and judges no stability.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from handgen.errors import EngineError
from handgen.simulation.case import Case, Curve, State
from handgen.simulation.reference.tube import Division


def simulate(case: Case, progress: Callable[[str], None] | None = None,
             division: Division | None = None) -> Curve:
    """Bend `case` through all of its points; states carry numbers, no fields.

    `division` of the actuator into elements; left out, the standard one, `case.refine` times halved.

    Raises:
        EngineError: the package ngsolve is missing.
        ValueError: gravity across the plane of symmetry, an obstacle, friction, or a law of principal
            stretches.
    """
    if case.gravity[1] != 0.0:
        raise ValueError("half of the finger is modelled: gravity may not act across its plane of symmetry")
    if case.obstacle is not None:
        raise ValueError("the reference knows no obstacle")
    if case.part == "assembly" and case.contact.friction and not case.contact.bonded:
        raise ValueError("the reference knows no friction: an assembly must slide freely or be bonded")
    try:
        import ngsolve
    except ImportError as error:
        raise EngineError(f"the reference solver needs the package `ngsolve`: {error}") from error
    from handgen.simulation.reference.balance import Balance
    from handgen.simulation.reference.model import Model
    from handgen.simulation.reference.observe import state

    say = progress or (lambda line: None)
    begun, states, stopped = time.perf_counter(), [], ""
    weight = 1.0 if any(case.gravity) else 0.0
    alone = case.part == "exoskeleton"
    targets = [(weight, p, t) for p in ((0.0,) if alone else case.pressures)
               for t in (case.tip_loads if alone else case.tip_loads[:1])]
    with ngsolve.TaskManager():
        model = Model(case, division)
        balance = Balance(model.form, model.space, model.loads, model.upright, model.find)
        first = weight, 0.0, 0.0 if alone else targets[0][2]
        say(f"{sum(balance.space.FreeDofs(True))} unknowns")
        if not balance.reach(np.array(first)):
            stopped = "the finger finds no balance before the first point"
        for target in targets:
            if not stopped and balance.reach(np.array(target)):
                states.append(state(model, balance))
                say(_line(states[-1]))
                continue
            stopped = stopped or f"no balance was found beyond {_amount(balance.now)}"
            states.append(State(target[1], target[2], False, note=stopped))
    held = [s.tip_load if alone else s.pressure for s in states if s.converged]
    return Curve(tuple(states), {}, max(held, default=0.0), (), sum(balance.space.FreeDofs(True)),
                 balance.factorisations, time.perf_counter() - begun, stopped)


def _line(found: State) -> str:
    load = f"{1e3 * found.pressure:.0f} kPa, {found.tip_load:.2f} N"
    return f"{load}: tip {found.tip_drop:.1f} mm below the palm"


def _amount(now: np.ndarray) -> str:
    return f"{now[0]:.0%} of own weight, {1e3 * now[1]:.1f} kPa, {now[2]:.3g} N"
