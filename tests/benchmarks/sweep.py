"""What a sweep costs: `python -m tests.benchmarks.sweep [one|rod|solid]` prints markdown tables, or all.

`one`: processor seconds a variant, in one process. `rod`: whole sweeps of 100 and 1000 variants on one and
two workers, then the fixed start, the growth with the number of variants and the efficiency on two cores
that follow. `solid`: 60 variants on two workers. Wall seconds mean something on an idle machine only; there
all of it takes less than 15 minutes.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from handgen.sweep import draw
from handgen.sweep.evaluate import evaluate
from handgen.sweep.load import prepare
from handgen.sweep.variant import task
from tests.sweep_files import sweep_file

AXES = {"fingers.index.joints.*.slot_length": "7:12", "fingers.index.joints.*.palmar_arc": "65:100"}
FEW, MANY, SOLID = 100, 1000, 60
KINDS = {
    "rod, 60 kPa, rules on the definition": ({"solver": "rod", "bend": {"pressures": [60]}}, 40),
    "rod, 60 kPa, no rules": ({"solver": "rod", "rules": "none", "bend": {"pressures": [60]}}, 40),
    "rod, and force on a plane at 80 kPa": (
        {"solver": "rod", "bend": {"pressures": [60]}, "force": {"pressure": 80, "obstacle": 40}}, 20),
    "solid, 30 and 60 kPa": ({"solver": "solid", "bend": {"pressures": [30, 60]}}, 4),
}
RUN = """
import json, resource, sys, time
begun = time.perf_counter()
from handgen.sweep import run
found = run(sys.argv[1], out=sys.argv[2], workers=int(sys.argv[3]), store=sys.argv[4])
found["wall_s"] = time.perf_counter() - begun
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
work = sum(sum(resource.getrusage(w)[:2]) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
print(json.dumps([found["wall_s"], found["statuses"], memory, work]))
"""


def single() -> None:
    print("| a variant | processor, s | a core's variants a second |\n|---|---|---|")
    for label, (values, count) in KINDS.items():
        with tempfile.TemporaryDirectory() as folder:
            file = sweep_file(Path(folder), method="sobol", budget=count + 1, vary=AXES, **values)
            prepared = prepare(file)
            tasks = [task(prepared, point) for point in draw.points(prepared.sweep)]
            evaluate(tasks[0])
            begun = time.process_time()
            for one in tasks[1:]:
                evaluate(one)
            each = (time.process_time() - begun) / count
        print(f"| {label} | {each:.3f} | {1 / each:.3g} |", flush=True)


def swept(count: int, workers: int, **values) -> tuple[float, float]:
    """(wall, processor) seconds of a whole sweep; prints its row."""
    with tempfile.TemporaryDirectory() as folder:
        file = sweep_file(Path(folder), method="sobol", budget=count, vary=AXES, **values)
        done = subprocess.run([sys.executable, "-c", RUN, file, f"{folder}/out", str(workers),
                               f"{folder}/store"], check=True, capture_output=True, text=True)
        wall, statuses, memory, work = json.loads(done.stdout)
    ended = ", ".join(f"{number} {status}" for status, number in statuses.items())
    print(f"| {values['solver']} | {ended} | {workers} | {wall:.1f} | {work:.1f} | {60 * count / wall:.0f} |"
          f" {count / work:.3g} | {memory:.0f} |", flush=True)
    return wall, work


def head() -> None:
    print("| solver | variants | workers | wall, s | processor, s | variants/min | a core's variants/s |"
          " parent's memory, MB |\n" + "|---" * 8 + "|")


def rod() -> None:
    head()
    found = {(count, workers): swept(count, workers, solver="rod", bend={"pressures": [60]})
             for count in (FEW, MANY) for workers in (1, 2)}
    for kind, what in enumerate(("wall", "processor")):
        for workers in (1, 2):
            few, many = found[FEW, workers][kind], found[MANY, workers][kind]
            each = (many - few) / (MANY - FEW)
            print(f"{what}, {workers} workers: {few - FEW * each:.1f} s to start, {each:.4f} s a variant")
    alone, both = found[MANY, 1][0], found[MANY, 2][0]
    print(f"parallel efficiency on 2 cores, start included: {alone / both / 2:.0%}")


def solid() -> None:
    head()
    swept(SOLID, 2, solver="solid", bend={"pressures": [30, 60]})


WHAT = {"one": single, "rod": rod, "solid": solid}

if __name__ == "__main__":
    for name in sys.argv[1:] or WHAT:
        WHAT[name]()
