"""A solver that answers at once, hung in like another package's: boxes that shear with the load.

STUB_STOPS_AT: load (kPa, or N of a bare exoskeleton) beyond which it finds nothing; STUB_SECONDS: what a
point takes; STUB_HANGS_AT, STUB_DIES_AT: loads at which it never returns, or takes its process with it;
STUB_LOG: a file that gets a line for every bend that begins.
"""

import math
import os
import re
import signal
import time
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np

from handgen.simulation.case import Curve, Grid, State

NAME, GROUP = "stub", "handgen.solvers"
VALUE = "tests.bend_stub:simulate"
ENTRY = EntryPoint(NAME, VALUE, GROUP)


def box(length: float, inner: float, outer: float) -> Grid:
    """Half a beam, y >= 0, of two hexahedra between z = `inner` and `outer`."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    high = outer - inner
    nodes = [(x, y * high, inner + z * high) for x in np.linspace(0, length, 3) for y, z in corners]
    cells = [[*range(4 * i, 4 * i + 4), *range(4 * i + 4, 4 * i + 8)] for i in range(2)]
    return Grid(np.array(nodes, float), np.array(cells))


def bent(grid: Grid, angle: float) -> np.ndarray:
    """Nodes turned about y by `angle` (rad) times their x over the length, flexion positive."""
    x, y, z = grid.nodes.T
    turn = angle * x / x.max()
    return np.stack([x * np.cos(turn) + z * np.sin(turn), y, z * np.cos(turn) - x * np.sin(turn)], -1)


def simulate(case, progress=None) -> Curve:
    bare = case.part == "exoskeleton"
    loads = [(0.0, t) for t in case.tip_loads] if bare else [(p, case.tip_loads[0]) for p in case.pressures]
    stop = float(os.environ.get("STUB_STOPS_AT", "inf"))
    if "STUB_LOG" in os.environ:
        with open(os.environ["STUB_LOG"], "a", encoding="utf-8") as log:
            log.write(f"{loads}\n")
    grids = {}
    if case.part != "exoskeleton":
        grids["actuator"] = box(case.actuator.length, -3.0, 3.0)
    if case.part != "actuator":
        grids["exoskeleton"] = box(case.finger.length, -8.0, -6.0)
    states, reached, stopped = [], 0.0, ""
    for pressure, tip in loads:
        time.sleep(float(os.environ.get("STUB_SECONDS", "0")))
        load = tip if bare else 1e3 * pressure
        _misbehave(load)
        if load > stop + 1e-9:
            stopped = f"nothing was found beyond {stop:g}"
            states.append(State(pressure, tip, False, note=stopped))
            continue
        reached, angle = (tip if bare else pressure), 0.02 * load
        states.append(State(
            pressure, tip, True, tip_drop=load, bend_angle=angle, elongation=0.1 * load,
            tip_force=None if case.obstacle is None else 0.0, max_stretch=1.0 + load / 50.0, residual=1e-7,
            positions={body: bent(grid, angle) for body, grid in grids.items()},
            stretch={body: np.full(len(grid.cells), 1.0 + load / (50.0 if body == "actuator" else 5000.0))
                     for body, grid in grids.items()}))
        if progress:
            progress(f"{load:g}: {math.degrees(angle):.1f} degrees")
    return Curve(tuple(states), grids, reached, (), 12, len(states), 0.01, stopped)


def _misbehave(load: float) -> None:
    if f"{load:g}" == os.environ.get("STUB_DIES_AT"):
        os.kill(os.getpid(), signal.SIGKILL)
    if f"{load:g}" == os.environ.get("STUB_HANGS_AT"):
        # Holds the interpreter's lock, as compiled code may: no other thread can end it.
        re.match(r"(a+)+$", "a" * 40 + "b")


def install(folder: Path) -> Path:
    """A distribution in `folder`, which then goes on the path, that registers the stub."""
    info = Path(folder) / "handgen_stub-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: handgen-stub\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{GROUP}]\n{NAME} = {VALUE}\n")
    return Path(folder)
