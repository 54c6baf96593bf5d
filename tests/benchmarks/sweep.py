"""What a sweep costs: `python -m tests.benchmarks.sweep [VARIANTS]` prints markdown tables.

Processor seconds a variant, in one process; then whole sweeps on one and two workers and of a tenth of the
variants: wall and processor seconds, memory of the parent. Only an idle machine gives true wall seconds.
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
KINDS = {
    "rod, 60 kPa, rules on the definition": ({"solver": "rod", "bend": {"pressures": [60]}}, 40),
    "rod, 60 kPa, no rules": ({"solver": "rod", "rules": "none", "bend": {"pressures": [60]}}, 40),
    "rod, and force on a plane at 80 kPa": (
        {"solver": "rod", "bend": {"pressures": [60]}, "force": {"pressure": 80, "obstacle": 40}}, 20),
    "solid, 30 and 60 kPa": ({"solver": "solid", "bend": {"pressures": [30, 60]}}, 4),
}
RUN = """
import json, resource, sys
from handgen.sweep import run
found = run(sys.argv[1], out=sys.argv[2], workers=int(sys.argv[3]), store=sys.argv[4])
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
work = sum(sum(resource.getrusage(w)[:2]) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
print(json.dumps([found["wall_s"], found["computed"], memory, work]))
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


def whole(variants: int) -> None:
    print("| variants | workers | wall, s | processor, s | variants/s | parent's memory, MB |\n"
          + "|---" * 6 + "|")
    for count, workers in ((variants // 10, 1), (variants // 10, 2), (variants, 2)):
        with tempfile.TemporaryDirectory() as folder:
            file = sweep_file(Path(folder), method="sobol", budget=count, vary=AXES, solver="rod",
                              bend={"pressures": [60]})
            done = subprocess.run([sys.executable, "-c", RUN, file, f"{folder}/out", str(workers),
                                   f"{folder}/store"], check=True, capture_output=True, text=True)
            wall, computed, memory, work = json.loads(done.stdout)
        print(f"| {computed} | {workers} | {wall:.1f} | {work:.1f} | {computed / wall:.1f} | {memory:.0f} |",
              flush=True)


if __name__ == "__main__":
    single()
    if len(sys.argv) > 1:
        whole(int(sys.argv[1]))
