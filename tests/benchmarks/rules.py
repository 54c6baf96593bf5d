"""How long the rules take once the meshes are made: `python -m tests.benchmarks.rules [rounds]`.

Prints a markdown table: processor seconds of every rule in one process (medians), and the wall
seconds of all of them, those on walls in one process and the others in a second, as `handgen check`
shares them out. New processes each round, their imports done before the clock starts.
"""

from __future__ import annotations

import importlib
import os
import statistics
import sys
import time
from multiprocessing import get_context
from pathlib import Path

from handgen import checks
from handgen.builder.verdict import WALLS
from handgen.checks.limits import standard
from handgen.geometry.catalogue import catalogue, select
from handgen.parameters.load import load

PARAMS = Path(__file__).parents[2] / "params" / "adult.yaml"
CASES = {"the adult hand": (None, 6.0), "its index finger": (["index"], 1.0)}
"""What is judged: the parts that are asked for, and the seconds that it may take."""
IMPORTED = "scipy.cluster.hierarchy", "scipy.optimize", "scipy.sparse.csgraph", "scipy.spatial"
"""What rules import when they are first asked."""


def timed(names, hand, parts, ready) -> tuple[float, float, dict[str, float]]:
    """(start, end) of all rules `names`, wall clock, and the processor seconds of each."""
    for name in IMPORTED:
        importlib.import_module(name)
    limits = standard()
    ready.wait()
    start, seconds = time.time(), {}
    for name in names:
        before = time.process_time()
        checks.outcome(name, hand, parts, limits)
        seconds[name] = time.process_time() - before
    return start, time.time(), seconds


def worker(names, hand, parts, ready, results) -> None:
    results.put(timed(names, hand, parts, ready))


def judged(hand, parts) -> tuple[float, dict[str, float]]:
    """(wall seconds, processor seconds of every rule) in two new processes."""
    context = get_context("spawn")
    shares = WALLS, tuple(name for name in checks.names() if name not in WALLS)
    ready, results = context.Barrier(len(shares)), context.Queue()
    processes = [context.Process(target=worker, args=(names, hand, parts, ready, results))
                 for names in shares]
    for process in processes:
        process.start()
    starts, ends, seconds = zip(*(results.get() for _ in shares), strict=True)
    for process in processes:
        process.join()
    return max(ends) - min(starts), {name: s for row in seconds for name, s in row.items()}


def main(rounds: int) -> None:
    hand = load(PARAMS).hand
    parts = catalogue(hand)
    triangles = sum(len(part.triangles.faces) for part in parts.values())  # made before the clock starts
    print(f"{triangles} triangles, {rounds} rounds, {os.cpu_count()} processors,"
          f" load {os.getloadavg()[0]:.1f}\n")
    print("| | wall s | bar | processor s | the slowest rules, processor s |\n|---|---|---|---|---|")
    for what, (wanted, bar) in CASES.items():
        chosen = {name: parts[name] for name in select(parts, wanted)}
        runs = [judged(hand, chosen) for _ in range(rounds)]
        rules = {name: statistics.median(run[1][name] for run in runs) for name in runs[0][1]}
        slowest = sorted(rules, key=rules.get, reverse=True)[:8]
        wall, named = statistics.median(run[0] for run in runs), [f"{n} {rules[n]:.2f}" for n in slowest]
        print(f"| {what} | {wall:.2f} | {bar:g} | {sum(rules.values()):.2f} | {', '.join(named)} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
