"""The solid model: a case in, its curve out."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from handgen.simulation.case import Case, Curve, State

if TYPE_CHECKING:
    from handgen.simulation.revolution import Revolution
    from handgen.simulation.system import System

THREADS = "HANDGEN_THREADS"
"""Environment variable: threads that share the elements of one bend. Two by default, where there are two
cores; more do not pay. One where many bends run side by side."""

FACTORISER = "HANDGEN_FACTORISER"
"""Environment variable: envelope (if not set), CHOLMOD, PARDISO or SuperLU."""


def simulate(case: Case, progress: Callable[[str], None] | None = None) -> Curve:
    """Bend `case` from no load through all of its points, in the order asked for.

    The first call ever compiles the kernels, which takes about half a minute; they are kept on disk.

    Raises:
        ValueError: a law that the kernels do not know, gravity across the plane of symmetry, or a factoriser
            that there is not.
        ImportError: the factoriser's package is missing.
    """
    if case.gravity[1] != 0.0:
        raise ValueError("half of the finger is modelled: gravity may not act across its plane of symmetry")

    def drawn(threads: int):
        from handgen.simulation.system import System

        return System(case, threads)

    return follow(case, drawn, progress)


def follow(case: Case, drawn: Callable[[int], System | Revolution],
           progress: Callable[[str], None] | None = None) -> Curve:
    """Follow the equilibrium of the system that `drawn`(threads) makes of `case` through all its points."""
    say = progress or (lambda line: None)
    if not _compiled():
        say("compiling the kernels, once (about half a minute)")
    from handgen.simulation import observe
    from handgen.simulation.loads import Load
    from handgen.simulation.solve import Solver

    begun = time.perf_counter()
    system = drawn(_threads())
    solver = Solver(system, os.environ.get(FACTORISER, ""))
    weight, fit = (1.0 if on else 0.0 for on in (any(case.gravity), case.curl_strains or case.tight))
    targets = ([Load(weight, 0.0, t) for t in case.tip_loads] if case.part == "exoskeleton"
               else [Load(weight, p, case.tip_loads[0], lost, fit) for p, lost in zip(
                   case.pressures, case.softening or [0.0] * len(case.pressures), strict=True)])
    states: list[State] = []
    point = solver.begin()
    reached, stopped = 0.0, "" if point else "the unloaded finger finds no balance"
    if point and targets[0].tip and case.part != "exoskeleton":
        point, _ = solver.advance(point, Load(weight, 0.0, targets[0].tip, 0.0, fit))
    for target in targets:
        if not stopped:
            point, there = solver.advance(point, target)
            if there:
                states.append(observe.state(system, point, _note(point)))
                reached = max(reached, target.tip if case.part == "exoskeleton" else target.pressure)
                say(f"{_amount(case, target)}: tip {states[-1].tip_drop:.1f} mm below the palm")
                continue
            stopped = _why(case, point.load, solver.ran_away)
        states.append(State(target.pressure, target.tip, False, note=stopped))
    return Curve(tuple(states), system.grids, reached, tuple(solver.folds), system.size,
                 solver.cost.factorisations, time.perf_counter() - begun, stopped)


def _threads() -> int:
    given = os.environ.get(THREADS, "")
    return max(1, int(given)) if given.isdecimal() else min(2, os.cpu_count() or 1)


def _compiled() -> bool:
    """Whether the kernels lie compiled on disk already; a guess that only decides what is said."""
    from pathlib import Path

    from handgen.simulation import element

    folder = Path(element.assemble.stats.cache_path)
    return any(folder.glob("element.assemble-*.nbc"))


def _why(case: Case, load, wall) -> str:
    """Why a curve ends at `load`."""
    if wall is None:
        return f"no stable state was found beyond {_amount(case, load)}"
    return (f"the actuator balloons beyond {_amount(case, load)} {wall.where(case.finger)}: its wall"
            f" stretches {wall.stretch:.1f} times and more before it finds a stable state")


def _note(point) -> str:
    return f"folds at {1e3 * point.folds[-1]:.1f} kPa" if point.folds else ""


def _amount(case: Case, load) -> str:
    return f"{load.tip:.3g} N" if case.part == "exoskeleton" else f"{1e3 * load.pressure:.1f} kPa"

