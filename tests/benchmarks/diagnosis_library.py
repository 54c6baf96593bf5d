"""The model that the study of the diagnosis judges, simulated in full: a library over every test a lab may
do.

The model is params/models/calibrated.yaml without own weight in the assembly (as the source left it out), on
params/thesis_hand.yaml. Tests are the source's three of the finger and its parts, fingertip force, and all
that the diagnosis may ask for. Every bend is kept by the cache (HANDGEN_CACHE): an interrupted run goes on
where it was.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

from handgen.discrepancy.candidates import candidates
from handgen.discrepancy.simulated import Simulation
from handgen.discrepancy.worker import Bends

from handgen.bending.model import load_model
from handgen.discrepancy import simulated
from handgen.discrepancy.library import Library
from handgen.measurements import load_measurements
from handgen.measurements.model import Test

MEASUREMENTS = Path(__file__).parents[2] / "params" / "measurements" / "coimbra_index.yaml"
GIVEN = ("exoskeleton-weights", "actuator-pressure", "assembly-pressure")
"""The source's tests, with which every diagnosis begins."""
FORCE = "fingertip-force"
SHIPPED = Path(__file__).parents[1] / "worlds" / "library.npz"
"""What `python -m tests.benchmarks.diagnosis_library` found, kept: hours of bends on a machine that does
other things."""
CARRIED = 0.0
"""Share of own weight in the assembly that the judged model has."""


def simulation(workers: int, say=print, *, force: bool = True, holds: bool = True) -> Simulation:
    """The judged model over all tests of the study."""
    measured = load_measurements(MEASUREMENTS)
    tests = [_open(measured.test(name)) for name in GIVEN]
    more = [test for test in candidates(tests) if holds or test.path != "hold"]
    if force:
        more.append(_open(measured.test(FORCE)))
    model = load_model("calibrated")[0]
    weight = model.own_weight.model_copy(update={"assembly": CARRIED})
    model = model.model_copy(update={"own_weight": weight, "name": "judged"})
    measured = replace(measured, measurements=measured.measurements.model_copy(update={"tests": [*tests, *more]}))
    return Simulation(measured, (*tests, *more), model, Bends(workers, say))


def _open(test: Test) -> Test:
    """`test` with all of its loads open to fits."""
    return test.model_copy(update={"held_out": False, "fit_up_to": None, "repeats": test.repeats})


def library(folder: Path, workers: int, say=print, **which: bool) -> Library:
    """From `folder`, or simulated and kept there."""
    name = hashlib.sha256(repr(sorted(which.items())).encode()).hexdigest()[:8]
    path = folder / f"library-{name}.npz"
    if not path.exists():
        simulated.library(simulation(workers, say, **which)).save(path)
    return Library.load(path)


if __name__ == "__main__":
    import sys

    folder = Path(sys.argv[1])
    for stage in ({"force": False, "holds": False}, {"force": False, "holds": True}, {"force": True, "holds": True}):
        found = library(folder, 2, lambda line: print(line, flush=True), **stage)
        print(stage, {k: v.predictions.shape for k, v in found.responses.items()}, flush=True)
