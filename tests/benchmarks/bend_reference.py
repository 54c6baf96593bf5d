"""The solid model beside NGSolve: `python -m tests.benchmarks.bend_reference [exoskeleton|speed|...]`.

Prints markdown: every point of the free actuator, the bare exoskeleton, the bonded assembly and the one that
slides without friction by both, what each cost and how far it went; then what NGSolve costs where its error
is no larger than that of our section of revolution, and of our solid mesh, all held against the finest
affordable NGSolve solution. Kernels are compiled before a clock starts; seconds are of the wall and, as other
work stretches those, of the processor.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace

from handgen.simulation import reference, revolution, solid
from handgen.simulation.case import Case, Curve
from handgen.simulation.reference.tube import Division
from tests.fingers import case

CASES = {
    "actuator, weightless": ("elongation", dict(
        part="actuator", pressures="0:60:10", orientation="weightless")),
    "actuator, palm down": ("tip_drop", dict(part="actuator", pressures="0:60:10")),
    "bonded assembly, weightless": ("tip_drop", dict(
        part="assembly", pressures="0:60:10", bonded=True, orientation="weightless")),
    "bonded assembly, palm down": ("tip_drop", dict(part="assembly", pressures="0:60:10", bonded=True)),
    "sliding assembly, weightless": ("tip_drop", dict(
        part="assembly", pressures="0:60:10", orientation="weightless")),
    "sliding assembly, palm down": ("tip_drop", dict(part="assembly", pressures="0:60:10")),
    "exoskeleton": ("tip_drop", dict(part="exoskeleton", tip_loads="0,0.07,0.16,0.28,0.41,0.56")),
}
"""What is compared, and of which part."""
COARSE = Division(32, 1, 1, 1, 5, 1)
"""Of the actuator in the assemblies, whose exoskeleton NGSolve gets with edges twice as long."""
COARSER = (Division(4, 1, 1, 1, 2, 1), Division(6, 1, 1, 1, 2, 1), Division(8, 1, 1, 1, 3, 1),
           Division(12, 1, 1, 1, 3, 1), Division(16, 2, 1, 1, 4, 2), Division(22, 2, 1, 1, 4, 2), Division())
"""NGSolve's meshes of the actuator, coarsest first."""
FINEST = Division(50, 3, 2, 2, 7, 2)
ROUNDS = 5
"""Of the faster solver; its median counts."""


class Run:
    """One curve with its seconds."""

    def __init__(self, simulate, *arguments):
        wall, used = time.perf_counter(), time.process_time()
        self.curve: Curve = simulate(*arguments)
        self.wall, self.used = time.perf_counter() - wall, time.process_time() - used

    def row(self, name: str) -> str:
        c = self.curve
        points = sum(s.converged for s in c.states)
        return (f"| {name} | {c.unknowns} | {c.factorisations} | {self.wall:.2f} | {self.used:.2f} | "
                f"{points} of {len(c.states)} points {c.stopped} |")


def values(curve: Curve, observable: str) -> list[float | None]:
    return [getattr(state, observable) for state in curve.states]


def compared(what: str, observable: str, one: Case) -> None:
    """Ours at two refinements and NGSolve, point by point."""
    runs = {"ours": Run(solid.simulate, one), "ours, refined": Run(solid.simulate, replace(one, refine=1)),
            "NGSolve": Run(reference.simulate, *((replace(one, refine=-1), None, COARSE)
                                                 if one.part == "assembly" else (one,)))}
    print(f"\n### {what}: {observable}, mm\n")
    print("| load | ours | ours, refined | NGSolve | difference, % | refined, % |")
    print("|---|---|---|---|---|---|")
    columns = [values(run.curve, observable) for run in runs.values()]
    # Per cent are of how far the tip has come from where it was drawn.
    drawn = getattr(solid.simulate(replace(one, gravity=(0.0, 0.0, 0.0), pressures=(0.0,), tip_loads=(0.0,)))
                    .states[0], observable)
    for state, ours, fine, other in zip(runs["ours"].curve.states, *columns, strict=True):
        load = f"{state.tip_load:.2f} N" if one.part == "exoskeleton" else f"{1e3 * state.pressure:.0f} kPa"
        cells = [" - " if v is None else f"{v:.3f}" for v in (ours, fine, other)]
        off = [" - " if None in (v, other) or abs(other - drawn) < 0.1
               else f"{100 * (v - other) / (other - drawn):+.2f}" for v in (ours, fine)]
        print("| " + " | ".join([load, *cells, *off]) + " |")
    print("\n| solver | unknowns | factorisations | wall s | processor s | reached |")
    print("|---|---|---|---|---|---|")
    for name, run in runs.items():
        print(run.row(name), flush=True)


def speed() -> None:
    """Ours and NGSolve at equal error, free actuator, 20, 40 and 60 kPa."""
    one = case("actuator", pressures="20,40,60", orientation="weightless")
    truth = Run(reference.simulate, one, None, FINEST)
    rows: list[tuple[str, float, Run]] = []

    def line(name: str, run: Run) -> Run:
        pairs = zip(values(run.curve, "elongation"), values(truth.curve, "elongation"), strict=True)
        rows.append((name, max(abs(v / t - 1) for v, t in pairs), run))
        print(run.row(f"{name} | {100 * rows[-1][1]:.3f}"), flush=True)
        return run

    print("\n### Speed at equal error: free actuator to 60 kPa, elongation\n")
    print("| solver | largest error, % | unknowns | factorisations | wall s | processor s | reached |")
    print("|---|---|---|---|---|---|---|")
    for name, simulate in (("section of revolution", revolution.simulate), ("solid", solid.simulate)):
        simulate(one)
        line(f"{name}, median of {ROUNDS}", sorted((Run(simulate, one) for _ in range(ROUNDS)),
                                                   key=lambda run: run.wall)[ROUNDS // 2])
    for division in COARSER:
        line(f"NGSolve {division.along} x {division.around}", Run(reference.simulate, one, None, division))
    line("NGSolve, finest", truth)
    for name, error, ours in rows[:2]:
        other, off, theirs = next(row for row in rows[2:] if row[1] <= error)
        print(f"\n{name}: at no larger error ({other}: {100 * off:.2f} %) NGSolve takes "
              f"{theirs.wall / ours.wall:.1f} times as long, {theirs.used / ours.used:.1f} times the work.")


def main(wanted: list[str]) -> None:
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    solid.simulate(case("assembly", pressures="0,2"))
    for what, (observable, arguments) in CASES.items():
        if not wanted or any(word in what for word in wanted):
            compared(what, observable, case(**arguments))
    if not wanted or "speed" in wanted:
        speed()


if __name__ == "__main__":
    main(sys.argv[1:])
