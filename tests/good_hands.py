"""Random hands that nothing is wrong with, and what the rules hold against them all the same."""

from __future__ import annotations

import copy
import tempfile
from pathlib import Path

import numpy as np

from handgen import checks
from handgen.errors import GeometryError, InputError
from handgen.geometry.catalogue import catalogue
from handgen.parameters.load import load
from handgen.parameters.model import Hand
from tests.strategies import ADULT, write


def variant(rng: np.random.Generator) -> Hand:
    """A hand that a maker would ask for: other lengths, walls, strips, splay, thread, nozzle, side.

    No finger is longer by more than an eighth: a little finger longer still, its tip no wider, has cores
    that may really stray too far (suspender.centring says so from 1.13 on).
    """
    data = copy.deepcopy(ADULT)
    data["side"] = str(rng.choice(["right", "left"]))
    del data["palm"]["length"]
    whole, thicker = rng.uniform(0.88, 1.09), rng.uniform(-0.2, 0.5)
    for name, finger in data["fingers"].items():
        share = whole * rng.uniform(0.97, 1.03)
        for key in ("outer_length", "inner_length"):
            finger[key] = round(finger[key] * share, 2)
        finger["outer_length"] = max(finger["outer_length"], finger["inner_length"] + 6.0)
        for key in ("base_outer_diameter", "tip_outer_diameter"):
            finger[key] = round(finger[key] + thicker, 2)
        for joint in finger["joints"]:
            joint["position"] = round(joint["position"] * share, 2)
            joint["palmar_arc"] = float(round(rng.uniform(75, 100)))
        finger["placement"]["splay"] += round(rng.uniform(-1.5, 1.5), 1)
        data["actuators"][name]["outer_length"] = finger["inner_length"]
    data["thread"]["pitch"] = round(rng.uniform(1.25, 1.75), 2)
    data["actuators"]["little"]["thread"]["pitch"] = round(rng.uniform(1.25, 1.5), 2)
    nozzle = float(rng.choice([0.35, 0.4]))
    for process in ("finger", "hand", "tooling"):
        data["printing"][process]["nozzle_size"] = nozzle
    with tempfile.TemporaryDirectory() as folder:
        try:
            return load(write(data, Path(folder))).hand
        except InputError:
            return variant(rng)


def false_findings(hand: Hand) -> list[dict] | None:
    """Findings of error level on a good hand; None: it is refused by name, and there is nothing to judge."""
    try:
        report = checks.judge(hand, catalogue(hand))
    except GeometryError:
        return None
    return [f for f in report["findings"] if f["severity"] == "error"]
