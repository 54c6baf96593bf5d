"""How long a build takes: `python -m tests.benchmarks.build [rounds]` prints a markdown table.

Cold: a new process (and, for the whole hand, an empty folder). Warm: in a process that has its
kernels loaded and has made another part before. Medians; memory is summed over all processes.
"""

from __future__ import annotations

import multiprocessing
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PARAMS = Path(__file__).parents[2] / "params" / "adult.yaml"
BUILD = "import sys; from handgen.builder import build; build(sys.argv[1], out=sys.argv[2])"
STL_OF = """
import sys
from pathlib import Path
from handgen.export import stl
from handgen.geometry.catalogue import catalogue, select
from handgen.parameters.load import load
parts = catalogue(load(sys.argv[1]).hand)
for name in select(parts, [sys.argv[2]]):
    stl.to_bytes(parts[name].triangles)
"""
CASES = {
    "one finger with its STL": ("exoskeleton/index", 0.6),
    "hand mesh at palm.resolution": ("exoskeleton/hand", 3.0),
    "one tooling set, STL": ("tooling/index", None),
}
INTERVAL = 0.1


def timed(command: list[str]) -> float:
    """Wall seconds of a whole process."""
    start = time.perf_counter()
    subprocess.run(command, check=True)
    return time.perf_counter() - start


def peak(command: list[str]) -> float:
    """Peak resident bytes of the process and all its descendants; watching slows it, so no time."""
    process, most = subprocess.Popen(command), 0.0
    while process.poll() is None:
        most = max(most, tree_memory(process.pid))
        time.sleep(INTERVAL)
    return most


def tree_memory(root: int) -> float:
    """Proportional set size, bytes, of `root` and its descendants: shared pages count once (Linux)."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(stat.parent.name)] = int(stat.read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, IndexError):
            continue
    family = {root}
    while grown := {pid for pid, parent in parents.items() if parent in family} - family:
        family |= grown
    return sum(map(proportional, family))


def proportional(pid: int) -> float:
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
        return sum(1024.0 * int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    except OSError:
        return 0.0


def warm(pattern: str) -> float:
    """Seconds for the STL of `pattern` in a process that has its kernels loaded."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_warm, (pattern,))


def _warm(pattern: str) -> float:
    from handgen.export import stl
    from handgen.geometry import mesh_kernel
    from handgen.geometry.catalogue import catalogue, select
    from handgen.parameters.load import load

    hand = load(PARAMS).hand
    stl.to_bytes(catalogue(hand)["exoskeleton/little"].triangles)
    if pattern == "exoskeleton/hand":
        # Loads marching cubes.
        stl.to_bytes(catalogue(hand)["exoskeleton/hand"].triangles)
    mesh_kernel.forget()
    start = time.perf_counter()
    parts = catalogue(hand)
    for name in select(parts, [pattern]):
        stl.to_bytes(parts[name].triangles)
    return time.perf_counter() - start


def table(rounds: int) -> list[str]:
    rows = ["| what | cold, s | warm, s | to reach, s | peak memory, MB |", "|---|---|---|---|---|"]
    for title, (pattern, target) in CASES.items():
        cold = [timed([sys.executable, "-c", STL_OF, str(PARAMS), pattern]) for _ in range(rounds)]
        memory = peak([sys.executable, "-c", STL_OF, str(PARAMS), pattern])
        rows.append(row(title, cold, [warm(pattern) for _ in range(rounds)], target, memory))
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "adult"
        command = [sys.executable, "-c", BUILD, str(PARAMS), str(out)]
        everything = []
        for _ in range(rounds):
            shutil.rmtree(out, ignore_errors=True)
            everything.append(timed(command))
        unchanged = [timed(command) for _ in range(rounds)]
        idle = peak(command)
        shutil.rmtree(out)
        rows.append(row("everything, process start included", everything, [], 25.0, peak(command)))
        rows.append(row("everything again, nothing changed", unchanged, [], 2.0, idle))
    return rows


def row(title: str, cold: list[float], warmed: list[float], target: float | None, memory: float) -> str:
    again = f"{statistics.median(warmed):.2f}" if warmed else ""
    return f"| {title} | {statistics.median(cold):.2f} | {again} | {target or ''} | {memory / 1e6:.0f} |"


def machine() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        name = platform.processor() or platform.machine()
    return f"{name}, {len(os.sched_getaffinity(0))} cores, load {os.getloadavg()[0]:.1f} at the start"


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    print(f"{machine()}; Python {platform.python_version()}; median of {count}\n")
    print("\n".join(table(count)))
