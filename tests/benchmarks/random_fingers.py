"""Random fingers bent to 60 kPa with the calibrated model: `python -m tests.benchmarks.bend random[:N]`.

A row of JSON a finger, appended as it is found, to outputs/random-<kind>.jsonl: a study that was cut off
goes on where it stood; rows of other sources are made anew. Every row holds how far it got and why no
farther, what it cost (processor time and factorisations, which a busy machine leaves alone), what
`independent_balance` makes of its states (forces as differences of energies written down anew), and which
rules on use object to it.
"""

from __future__ import annotations

import hashlib
import json
import os
import statistics
import tempfile
import time
from collections import Counter
from multiprocessing import get_context
from pathlib import Path

from handgen.simulation import solid
from tests import random_fingers

ROOT = Path(__file__).parents[2]
TARGET = 60.0
"""kPa, that a random finger should reach."""
BALANCED = 1e-4
"""Largest force out of balance over the largest acting one that passes for balance, as in the tests."""
STRETCH = 6.0
"""Of a wall that has ballooned, whether or not a stable state was found there."""
IN_USE = "thread.gap", "hinge.strain", "actuator.clearance", "actuator.length", "thread.layer"
"""Rules that speak of the finger in use; the others, of its printing and casting, are not asked."""


def study(kind: str, count: int = 300, processes: int = 1) -> None:
    """Bend the first `count` fingers of `kind` and print what became of them."""
    os.environ[solid.THREADS] = "1"
    file, sources = ROOT / "outputs" / f"random-{kind}.jsonl", _sources()
    rows = {r["number"]: r for r in _read(file) if r["sources"] == sources}
    wanted = [(kind, n, sources) for n in range(count) if n not in rows]
    file.parent.mkdir(exist_ok=True)
    with get_context("spawn").Pool(processes, _warm) as pool, file.open("a", encoding="utf-8") as out:
        for row in pool.imap_unordered(_row, wanted):
            rows[row["number"]] = row
            out.write(json.dumps(row) + "\n")
            out.flush()
    _tell([rows[n] for n in range(count)])


def _read(file: Path) -> list[dict]:
    """Rows of an earlier run; a line that was cut off is none."""
    found = []
    for line in file.read_text(encoding="utf-8").splitlines() if file.exists() else []:
        try:
            found.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return found


def _sources() -> str:
    """Names what rows depend on: the simulation and how fingers are drawn."""
    files = [*sorted((ROOT / "handgen" / "simulation").glob("*.py")), Path(random_fingers.__file__),
             ROOT / "params" / "models" / "calibrated.yaml"]
    return hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()[:12]


def _warm() -> None:
    """Load the compiled kernels, so that the first finger is charged with its bend alone."""
    from handgen.bending import request

    solid.simulate(request(ROOT / "params" / "adult.yaml", finger="thumb", pressures="0").case)


def _row(what: tuple[str, int, str]) -> dict:
    import resource

    from handgen.bending import request
    from handgen.errors import InputError
    from handgen.parameters.load import load
    from tests.strategies import write

    kind, number, sources = what
    finger, data = random_fingers.KINDS[kind](number)
    row = {"number": number, "finger": finger, "sources": sources}
    with tempfile.TemporaryDirectory() as folder:
        file = write(data, Path(folder))
        row["objections"] = _objections(load(file).hand, finger)
        try:
            case = request(file, finger=finger, pressures=f"0:{TARGET:g}:10", model="calibrated").case
        except InputError as error:
            return row | {"refused": str(error)}
    before = time.process_time()
    curve = solid.simulate(case)
    row["processor_s"] = time.process_time() - before
    there = [s for s in curve.states if s.converged]
    return row | {
        "stopped": curve.stopped, "reached": 1e3 * curve.reached, "folds": [1e3 * p for p in curve.folds],
        "factorisations": curve.factorisations, "unknowns": curve.unknowns,
        "stretch": max((s.max_stretch for s in there), default=None), **_judged(case, there),
        "peak_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


def _judged(case, states: list) -> dict:
    """Largest force out of balance and least Jacobian, judged anew in the middle and in the last state."""
    from tests.independent_balance import Judge

    judge = Judge(case)
    balances = [judge.judge(s.positions, s.pressure) for s in {id(s): s for s in (
        states[len(states) // 2], states[-1])}.values()] if states else []
    return {"unbalanced": max((b.unbalanced for b in balances), default=0.0),
            "least": min((float(b.least) for b in balances), default=1.0)}


def _objections(hand, finger: str) -> list[str]:
    """Rules on the finger in use that find an error."""
    from handgen import checks
    from handgen.errors import GeometryError
    from handgen.geometry.catalogue import catalogue, select

    try:
        parts = catalogue(hand)
    except GeometryError as error:
        return [f"refused: {error.path}"]
    chosen, limits = {name: parts[name] for name in select(parts, [finger])}, checks.own_limits(hand, "")
    found = [checks.outcome(rule, hand, chosen, limits) for rule in IN_USE]
    return [o.rule for o in found if any(f.severity == "error" for f in o.findings)]


def _tell(rows: list[dict]) -> None:
    bent = [r for r in rows if "refused" not in r]
    for r in bent:
        if r["stopped"]:
            print(f"finger {r['number']} ({r['finger']}) reached {r['reached']:.0f} kPa: {r['stopped']}"
                  f"; objections: {', '.join(r['objections']) or 'none'}")
    print(f"\n{len(rows)} fingers, {len(rows) - len(bent)} refused by name before they are bent.\n")
    print(f"| fingers | bent | reach {TARGET:g} kPa | folded | stretched {STRETCH:g} times"
          " | s: median, most over it | factorisations: same | MB |\n|---|---|---|---|---|---|---|---|")
    for what, some in {"all": bent, "no rule on use objects": [r for r in bent if not r["objections"]],
                       "one does": [r for r in bent if r["objections"]]}.items():
        if some:
            print(f"| {what} | {' | '.join(_columns(some))} |")
    off = sum(r["unbalanced"] > BALANCED for r in bent)
    most, least = max(r["unbalanced"] for r in bent), min(r["least"] for r in bent)
    print(f"\nJudged anew, at most {most:.1e} of the largest acting force is out of balance, more than"
          f" {BALANCED:g} in {off}; least Jacobian {least:.2f}.")
    print("Objections:", dict(Counter(rule for r in rows for rule in r["objections"]).most_common()))


def _columns(rows: list[dict]) -> list[str]:
    """The table's columns but the first."""
    there = sum(not r["stopped"] for r in rows)
    stretched = sum((r["stretch"] or 1.0) > STRETCH for r in rows)
    costs = []
    for what in ("processor_s", "factorisations"):
        values = [r[what] for r in rows]
        middle = statistics.median(values)
        costs.append(f"{middle:.1f}, {max(values) / middle:.1f}")
    folded = sum(bool(r["folds"]) for r in rows)
    return [str(len(rows)), f"{there} ({100 * there / len(rows):.1f} %)", str(folded), str(stretched), *costs,
            f"{max(r['peak_MB'] for r in rows):.0f}"]
