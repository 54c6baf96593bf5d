"""The model that the study of the diagnosis judges, simulated in full: a library over every test a lab may
do.

The model is params/models/calibrated.yaml without own weight in the assembly (as the source left it out), on
params/thesis_hand.yaml. Tests are the source's three of the finger and its parts, fingertip force, and all
that the diagnosis may ask for. Every bend is kept by the cache (HANDGEN_CACHE): an interrupted run goes on
where it was.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from handgen.bending.model import load_model
from handgen.discrepancy import simulated
from handgen.discrepancy.candidates import candidates
from handgen.discrepancy.library import Library
from handgen.discrepancy.simulated import Simulation
from handgen.discrepancy.worker import Bends
from handgen.measurements import load_measurements
from handgen.measurements.model import Test

MEASUREMENTS = Path(__file__).parents[2] / "params" / "measurements" / "coimbra_index.yaml"
GIVEN = ("exoskeleton-weights", "actuator-pressure", "assembly-pressure")
"""The source's tests, with which every diagnosis begins."""
FORCE = "fingertip-force"
SHIPPED = Path(__file__).parents[1] / "worlds" / "library.npz"
"""What `python -m tests.benchmarks.diagnosis_library` found, kept: hours of bends on a machine that does
other things."""
POWER = 1.42
"""Exponent of the judged silicone's law: its other convention gives POWER / 2 of its stress."""
CARRIED = 0.0
"""Share of own weight in the assembly that the judged model has."""


LEVELS = (
    lambda test: test.direct or (test.path == "loading" and test.obstacle is None),
    lambda test: test.part == "actuator",
    lambda test: test.path == "unloading",
    lambda test: test.path == "hold",
    lambda test: test.obstacle is not None)
"""Which tests are simulated first, and which then: a library of the first few levels serves already."""


def simulation(workers: int, say=print, level: int = len(LEVELS)) -> Simulation:
    """The judged model over the tests of the study up to a level."""
    measured = load_measurements(MEASUREMENTS)
    tests = [_open(measured.test(name)) for name in GIVEN]
    force = _open(measured.test(FORCE))
    more = [test for test in (*candidates([*tests, force]), force)
            if any(wanted(test) for wanted in LEVELS[:level])]
    model = load_model("calibrated")[0]
    weight = model.own_weight.model_copy(update={"assembly": CARRIED})
    model = model.model_copy(update={"own_weight": weight, "name": "judged"})
    all_ = measured.measurements.model_copy(update={"tests": [*tests, *more]})
    measured = replace(measured, measurements=all_)
    return Simulation(measured, (*tests, *more), model, Bends(workers, say))


def _open(test: Test) -> Test:
    """`test` with all of its loads open to fits."""
    return test.model_copy(update={"held_out": False, "fit_up_to": None, "repeats": test.repeats})


def library(folder: Path, workers: int, say=print, level: int = len(LEVELS)) -> Library:
    """From `folder`, or simulated and kept there."""
    path = folder / f"library-{level}.npz"
    if not path.exists():
        simulated.library(simulation(workers, say, level)).save(path)
    return Library.load(path)


if __name__ == "__main__":
    import sys

    for level in range(1, len(LEVELS) + 1):
        found = library(Path(sys.argv[1]), 2, lambda line: print(line, flush=True), level)
        print(f"level {level}: {found.size} readings, {len(found.responses)} effects", flush=True)
    found.save(Path(sys.argv[1]) / "library.npz")
