"""How long a bend takes, and what mesh, friction and factoriser do to it: `python -m tests.benchmarks.bend`.

`... bend [what ...]`, of: times, mesh, friction, factorisers, first, random, anything. Prints markdown.
`first` is the first call ever, which compiles. `random` bends 300 random valid fingers to 60 kPa, `anything`
as many of any file that loads (`tests.random_fingers`): `random:50:2` 50 of them, in two processes. Both take
most of an hour, go on where they were cut off, and are left out unless named.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from handgen.bending import request
from handgen.simulation import solid
from handgen.simulation.case import Case, Contact
from tests.benchmarks import random_fingers

PARAMS = Path(__file__).parents[2] / "params"
ROUNDS = 5
WEIGHTS = "0,0.07,0.14,0.28,0.42,0.56"
CASES = {
    "index, assembly, 0-100 kPa": (4.0, dict(pressures="0:100:10")),
    "middle": (4.0, dict(finger="middle")),
    "ring": (4.0, dict(finger="ring")),
    "little": (4.0, dict(finger="little")),
    "thumb": (4.0, dict(finger="thumb")),
    "index of thesis_hand": (4.0, dict(params="thesis_hand")),
    "thesis_finger": (4.0, dict(params="thesis_finger")),
    "index against a plane at 40 mm, 0-80 kPa": (15.0, dict(pressures="0:80:10", obstacle=40)),
    "free actuator, 0-60 kPa": (1.0, dict(part="actuator", pressures="0:60:10")),
    "bare exoskeleton, six weights": (3.0, dict(part="exoskeleton", tip_loads=WEIGHTS)),
}
"""What is timed: the seconds that it may take, and the arguments of the bend."""


def case_of(params: str = "adult", **arguments) -> Case:
    return request(PARAMS / f"{params}.yaml", **arguments).case


def times() -> None:
    print("| what | s, median | bar | factorisations | unknowns | reached | folds, kPa |\n"
          + "|---" * 7 + "|")
    for what, (bar, arguments) in CASES.items():
        case = case_of(**arguments)
        solid.simulate(case)
        curves = [solid.simulate(case) for _ in range(ROUNDS)]
        seconds, curve = statistics.median(c.wall for c in curves), curves[-1]
        unit = f"{curve.reached:.2f} N" if case.part == "exoskeleton" else f"{1e3 * curve.reached:.0f} kPa"
        folds = ", ".join(f"{1e3 * p:.1f}" for p in curve.folds)
        print(f"| {what} | {seconds:.2f} | {bar:g} | {curve.factorisations} | {curve.unknowns} | {unit} |"
              f" {folds} |", flush=True)


def mesh() -> None:
    print("| refinement | unknowns | bend at 60 kPa, deg | drop, mm | s |\n" + "|---" * 5 + "|")
    for refine in (0, 1):
        curve = solid.simulate(case_of(pressures="0,30,60", refine=refine))
        state = curve.states[-1]
        if state.converged:
            print(f"| {refine} | {curve.unknowns} | {57.2958 * state.bend_angle:.2f} | {state.tip_drop:.2f} |"
                  f" {curve.wall:.1f} |", flush=True)
        else:
            print(f"| {refine} | {curve.unknowns} | {curve.stopped} | | {curve.wall:.1f} |", flush=True)


def friction() -> None:
    print("| friction | bend at 40, 60, 80, 100 kPa, deg | folds, kPa | how far |\n" + "|---" * 4 + "|")
    for mu in (0.0, 0.1, 0.25, 0.5, 0.8, 1.2):
        curve = solid.simulate(replace(case_of(pressures="0,20,40,60,80,100"), contact=Contact(mu)))
        angles = ", ".join(f"{57.2958 * s.bend_angle:.1f}" if s.converged else "-" for s in curve.states[2:])
        folds = ", ".join(f"{1e3 * p:.1f}" for p in curve.folds)
        print(f"| {mu:g} | {angles} | {folds} | {curve.stopped or 'all'} |", flush=True)


def factorisers() -> None:
    import numpy as np

    from handgen.simulation.sparse import FACTORISERS, factoriser
    from handgen.simulation.system import Load, System

    system = System(case_of(), 2)
    _, _, values, _ = system.assemble(np.zeros(system.size), Load(), exact=False)
    values[system.pattern.diagonal] += 1.0  # what nothing touches yet is held
    right = np.ones(system.size)
    print(f"One tangent of the assembly, {system.size} unknowns, {system.pattern.entries} entries.\n")
    print("| factoriser | factorise, ms | solve, ms |\n" + "|---" * 3 + "|")
    for name in FACTORISERS:
        try:
            matrix, spent = factoriser(system.pattern, system.crew, name), ([], [])
        except ImportError as error:
            print(f"| {name} | {error} | |")
            continue
        for _ in range(4 * ROUNDS):
            start = time.perf_counter()
            matrix.factorise(values)
            middle = time.perf_counter()
            matrix.solve(right)
            for row, seconds in zip(spent, (middle - start, time.perf_counter() - middle), strict=True):
                row.append(1e3 * seconds)
        print(f"| {name} | {statistics.median(spent[0]):.1f} | {statistics.median(spent[1]):.2f} |")


def first() -> None:
    """The first call ever: a new process with no compiled kernels."""
    command = ("from tests.benchmarks.bend import case_of; from handgen.simulation import solid;"
               "solid.simulate(case_of())")
    with tempfile.TemporaryDirectory() as empty:
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", command], check=True,
                       env={**os.environ, "NUMBA_CACHE_DIR": empty})
        print(f"first call ever, compilation and process included: {time.perf_counter() - start:.1f} s")


def named(count: int = 300, processes: int = 1) -> None:
    random_fingers.study("named", count, processes)


def anything(count: int = 300, processes: int = 1) -> None:
    random_fingers.study("anything", count, processes)


TABLES = {"times": times, "mesh": mesh, "friction": friction, "factorisers": factorisers, "first": first,
          "random": named, "anything": anything}
UNASKED = "random", "anything"

if __name__ == "__main__":
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}\n")
    for wanted in sys.argv[1:] or [name for name in TABLES if name not in UNASKED]:
        name, *numbers = wanted.split(":")
        print(f"\n## {name}\n")
        TABLES[name](*map(int, numbers))
