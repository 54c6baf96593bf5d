"""The rod against the solid model: `python -m tests.benchmarks.rod collect|fit|state|judge [FOLDER]`.

`collect` bends random fingers by the solid model (an hour; FOLDER keeps what is done, default
outputs/rod_fingers); `fit` fits the rod's coefficients on the first of them and writes
`handgen/simulation/rod/known.json`; `state` only says anew how far off it was on those; `judge` bends the
rest, those drawn with another seed, and the tests' wild ones with the rod, and prints how far off it is.
"""

from __future__ import annotations

import json
import math
import pickle
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from handgen.simulation import rod, solid
from handgen.simulation.case import Case
from handgen.simulation.exoskeleton import exoskeleton_mesh
from handgen.simulation.rod.balance import Balance
from handgen.simulation.rod.chain import Chain
from handgen.simulation.rod.known import FILE, known, measures, state_measures
from tests import study_fingers

FOLDER = "outputs/rod_fingers"
TRAIN, REST, TEST = 32, 100, 65
"""Fingers around the adult hand's: fitted on, drawn after those, drawn with other seeds."""
SOFT, POROUS = 28, 0.31
"""More to fit on, of a print with this share of the filament's stiffness, as that of a whole hand is."""
WILD = 320
START = {"reach": 1.7, "strip": 1.35, "rub": 0.18, "chamber": 0.95, "lift": -0.08, "lever": 0.09, "bone": 1.4}
SCALE = {"reach": 0.5, "strip": 0.2, "rub": 0.3, "chamber": 0.5, "lift": 0.1, "lever": 0.1, "bone": 2.0}
FITTED, FRESH = ("train", "soft"), ("rest", "test", "porous")
FAR = 1.25
"""rad; joints that turn farther are not fitted on, and lie outside the range."""
COVERED = 0.9
"""Share of the training fingers whose every state the stated error covers."""
OUTSIDE = 4.0
"""Times as wide beyond the range: assumed."""


def cases() -> Iterator[tuple[str, Case]]:
    for i, case in enumerate(study_fingers.likely(1, TRAIN + REST)):
        yield f"{'train' if i < TRAIN else 'rest'}{i:03d}", case
    for kind, found in (("soft", study_fingers.likely(3, SOFT, POROUS)),
                        ("test", study_fingers.likely(2, TEST)),
                        ("porous", study_fingers.likely(4, TEST, POROUS)),
                        ("wild", study_fingers.wild(WILD))):
        for i, case in enumerate(found):
            yield f"{kind}{i:03d}", case


def collect(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, case in cases():
        file = folder / f"{name}.pkl"
        if not file.exists():
            curve = solid.simulate(case)
            states = tuple(replace(s, positions={}, stretch={}) for s in curve.states)
            turns = [joints_of(case, s.positions["exoskeleton"]) if s.converged else None
                     for s in curve.states]
            file.write_bytes(pickle.dumps((case, states, turns)))
            print(name, *(f"{math.degrees(s.bend_angle):.1f}" for s in states if s.converged), flush=True)


def joints_of(case: Case, nodes: np.ndarray) -> np.ndarray:
    """Turns of the joints beyond rest, rad, from the nodes that each bone carries."""
    mesh = exoskeleton_mesh(case.finger, case.fillet, case.refine)
    found = []
    for bone in range(len(mesh.bones.start)):
        mine = mesh.body == bone
        a, b = mesh.straight[mine][:, [0, 2]], nodes[mine][:, [0, 2]]
        a, b = a - a.mean(0), b - b.mean(0)
        found.append(math.atan2((a[:, 1] * b[:, 0] - a[:, 0] * b[:, 1]).sum(), (a * b).sum()))
    rest = np.radians([j.rest_angle for j in case.finger.finger.joints])
    return (np.diff(found) + math.pi) % (2 * math.pi) - math.pi - rest


def read(folder: Path, *kinds: str) -> list[tuple[Case, tuple, list]]:
    """(case, states, turns), each finger once, those that bent at all."""
    found, seen = [], set()
    for file in sorted(f for f in folder.glob("*.pkl") if f.name.startswith(kinds)):
        case, states, turns = pickle.loads(file.read_bytes())
        bends = tuple(s.bend_angle for s in states)
        if bends not in seen and bends[0] is not None:
            seen.add(bends)
            found.append((case, states, turns))
    return found


def states_of(case: Case, coefficients) -> list[np.ndarray | None]:
    """The rod's q at every pressure."""
    balance = Balance(Chain(case), coefficients)
    q, here, found = balance.unloaded(1), 0.0, []
    for pressure in case.pressures:
        q = None if q is None else rod.towards(balance, q, here, pressure)
        here = pressure
        found.append(q)
    return found


def fit(folder: Path) -> None:
    from scipy.optimize import least_squares

    train = read(folder, *FITTED)
    names = list(START)

    def residual(values: np.ndarray) -> np.ndarray:
        found, coefficients = [], dict(zip(names, values, strict=True))
        for case, states, turns in train:
            n = len(case.finger.finger.joints)
            rest = sum(math.radians(j.rest_angle) for j in case.finger.finger.joints)
            for q, state, turn in zip(states_of(case, coefficients), states, turns, strict=True):
                if turn is None or not inside(case, turn):
                    continue
                if q is None:
                    found += [1.0] * (n + 1)
                    continue
                found += list((q[:n] - turn) / (0.07 * abs(turn) + 0.03) * 0.7 / math.sqrt(n))
                found.append((q[:n].sum() + rest - state.bend_angle) / (0.05 * abs(state.bend_angle) + 0.04))
        print(f"{float((np.array(found) ** 2).mean()):.4f}", *(f"{v:.3f}" for v in values), flush=True)
        return np.array(found)

    best = least_squares(residual, list(START.values()), x_scale=list(SCALE.values()), loss="soft_l1",
                         max_nfev=5, diff_step=1e-3)
    write(dict(zip(names, (round(float(v), 4) for v in best.x), strict=True)), train)


def inside(case: Case, turn: np.ndarray) -> bool:
    """Whether a state is one that the rod is meant for."""
    chain = Chain(case)
    low, high = measures(chain)["slot length over bore radius"]
    arc, _ = measures(chain)["palmar arc, deg"]
    return abs(turn + chain.rest).max() < FAR and high <= 3.0 and arc >= 50.0 and low >= 0.4


def write(coefficients: dict, train: list) -> None:
    """known.json: the range of the training fingers, and the error that covers them."""
    ranges, errors = {}, []
    for finger, (case, states, turns) in enumerate(train):
        chain, balance = Chain(case), Balance(Chain(case), coefficients)
        for q, state, turn in zip(states_of(case, coefficients), states, turns, strict=True):
            if turn is None or q is None or not inside(case, turn):
                continue
            stretch = balance.stretches(q, state.pressure)["actuator"]
            found = {**measures(chain), **state_measures(chain, q[:chain.joints] + chain.rest, stretch,
                                                         state.pressure)}
            for name, (low, high) in found.items():
                least, most = ranges.get(name, (math.inf, -math.inf))
                ranges[name] = (min(low, least), max(high, most))
            bend = float(q[:chain.joints].sum() + chain.rest.sum())
            errors.append((finger, abs(bend), abs(bend - state.bend_angle)))
    share, least = error_law(*np.array(errors).T)
    text = {"rod": {
        "coefficients": coefficients, "range": {k: rounded(*v) for k, v in ranges.items()},
        "share": round(share, 4), "least": round(least, 5), "outside": OUTSIDE},
        "about": "written by `python -m tests.benchmarks.rod fit`; do not edit",
        "fitted_on": f"{len(train)} fingers, {len(errors)} states of the solid model"}
    FILE.write_text(json.dumps(text, indent=1) + "\n", encoding="utf-8")
    print(FILE.read_text())


def rounded(low: float, high: float, digits: int = 4) -> list[float]:
    """A range with few digits that leaves neither end out."""
    unit = [10.0 ** (math.floor(math.log10(abs(x))) + 1 - digits) if x else 1.0 for x in (low, high)]
    ends = math.floor(low / unit[0]) * unit[0], math.ceil(high / unit[1]) * unit[1]
    return [float(f"{x:.{digits + 2}g}") for x in ends]


def error_law(finger: np.ndarray, bend: np.ndarray, off: np.ndarray) -> tuple[float, float]:
    """(share, least, rad) of the stated error, share * bend + least.

    Errors scatter by a law that grows evenly with the bend (the likeliest, were they normal); it is widened
    until it covers every state of COVERED of the fingers: states of one finger err alike.
    """
    from scipy.optimize import minimize

    def unlikely(logs: np.ndarray) -> float:
        scatter = np.exp(logs[0]) * bend + np.exp(logs[1])
        return float((np.log(scatter) + (off / scatter) ** 2 / 2).sum())

    share, least = np.exp(minimize(unlikely, np.log([0.05, 0.03]), method="Nelder-Mead").x)
    worst = [(off / (share * bend + least))[finger == one].max() for one in np.unique(finger)]
    widened = float(np.quantile(worst, COVERED))
    return float(share) * widened, float(least) * widened


def state(folder: Path) -> None:
    """The range and the error anew, coefficients as they are."""
    write(dict(known().coefficients), read(folder, *FITTED))


def judge(folder: Path) -> None:
    from scipy.stats import spearmanr

    print("| fingers | kPa | number | Spearman | median error | 95th percentile | stated error covers |\n"
          + "|---" * 7 + "|")
    for kinds, within in (*(((kind,), True) for kind in FRESH), (FRESH, True), (FRESH, False),
                          (("wild",), True), (("wild",), False)):
        found = [(states, rod.simulate(case).states) for case, states, _ in read(folder, *kinds)]
        for at in (2, 3):
            pairs = [(mine[at].bend_angle, theirs[at].bend_angle, theirs[at].bend_error)
                     for mine, theirs in found if mine[at].converged and theirs[at].converged
                     and not (within and theirs[at].note)]
            if len(pairs) < 3:
                continue
            truth, bend, stated = np.array(pairs).T
            off = abs(bend - truth) / abs(truth)
            print(f"| {' and '.join(kinds)}{', in range' if within else ''} | {20 * at} | {len(pairs)} |"
                  f" {spearmanr(truth, bend)[0]:.3f} | {np.median(off):.1%} | {np.quantile(off, 0.95):.1%} |"
                  f" {(abs(bend - truth) <= stated).mean():.0%} |", flush=True)


WHAT = {"collect": collect, "fit": fit, "state": state, "judge": judge}

if __name__ == "__main__":
    WHAT[sys.argv[1]](Path(sys.argv[2] if len(sys.argv) > 2 else FOLDER))
