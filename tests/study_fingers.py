"""Random fingers for studies of the reduced model: wild ones, and ones that a maker may ask for.

Each comes as the case that `handgen bend` would solve.
"""

from __future__ import annotations

import contextlib
import copy
import tempfile
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from handgen.bending import request
from handgen.errors import InputError
from handgen.materials.law import Law
from handgen.simulation.case import Case, Contact
from tests import random_fingers
from tests.strategies import ADULT, write

PRESSURES = "0,20,40,60"
"""kPa."""


def wild(count: int) -> Iterator[Case]:
    """Cases of those of `count` files with any layers, threads and slots that are not refused by name."""
    for number in range(count):
        name, data = random_fingers.anything(number)
        with tempfile.TemporaryDirectory() as folder, contextlib.suppress(InputError):
            yield request(write(data, folder), finger=name, pressures=PRESSURES).case


def likely(seed: int, count: int, printed: float = 1.0) -> Iterator[Case]:
    """Cases of `count` fingers around the adult hand's, of any of its five.

    `printed`: share of the filament's stiffness that is left in the print.
    """
    rng = np.random.default_rng(seed)
    found = 0
    while found < count:
        name = str(rng.choice(list(ADULT["fingers"])))
        data = _drawn(rng, name)
        softer, stiffer = rng.uniform(0.75, 1.35), rng.choice([1.0, rng.uniform(0.7, 3.0)])
        orientation = str(rng.choice(["palm_down"] * 4 + ["palm_up", "weightless"]))
        friction = float(rng.choice([0.8, 0.8, rng.uniform(0.3, 1.2)]))
        with tempfile.TemporaryDirectory() as folder:
            try:
                case = request(write(data, folder), finger=name, pressures=PRESSURES,
                               orientation=orientation).case
            except InputError:
                continue
        found += 1
        yield replace(case, contact=Contact(friction), silicone=_scaled(case.silicone, softer),
                      tpu=_scaled(case.tpu, printed * stiffer))


def _scaled(substance, factor: float):
    law = substance.law
    constants = ((tuple(factor * m for m in law.constants[0]), law.constants[1]) if law.name == "ogden"
                 else tuple(factor * c for c in law.constants))
    return replace(substance, law=Law(law.name, constants), bulk=factor * substance.bulk)


def _drawn(rng: np.random.Generator, name: str) -> dict:
    """The adult hand with finger `name` changed, and layers and thread with it."""
    data = copy.deepcopy(ADULT)
    for key in ("palm", "opposition"):
        del data[key]
    data["assumed"] = {}
    data["fingers"] = {name: data["fingers"][name]}
    data["actuators"] = {name: data["actuators"][name]}
    finger, actuator = data["fingers"][name], data["actuators"][name]
    long, wide = rng.uniform(0.8, 1.25), rng.uniform(0.8, 1.25)
    rest = float(rng.choice([0.0, 0.0, rng.uniform(0, 25)]))
    for key in ("outer_length", "inner_length"):
        finger[key] = _rounded(finger[key] * long, 3)
    for end in ("base", "tip"):
        bore = _rounded(finger[f"{end}_bore_diameter"] * wide, 3)
        finger[f"{end}_bore_diameter"] = bore
        finger[f"{end}_outer_diameter"] = _rounded(bore + 2 * rng.uniform(1.2, 3.0), 3)
    slot, arc, each = rng.uniform(5, 16), rng.uniform(55, 130), bool(rng.random() < 0.5)
    for joint in finger["joints"]:
        joint["position"] = _rounded(joint["position"] * long + rng.uniform(-2, 2), 3)
        joint["slot_length"] = _rounded(rng.uniform(5, 16) if each else slot, 3)
        joint["palmar_arc"] = _rounded(rng.uniform(55, 130) if each else arc, 3)
        joint["rest_angle"] = _rounded(rest, 3)
    clearance = float(rng.choice([0.0, rng.uniform(0, 0.6)]))
    actuator["outer_length"] = _rounded(finger["inner_length"] - rng.choice([0.0, rng.uniform(0, 2)]), 3)
    for end in ("base", "tip"):
        actuator[f"{end}_outer_diameter"] = _rounded(finger[f"{end}_bore_diameter"] - 2 * clearance, 3)
    data["layers"] = {"external": _rounded(rng.uniform(0.9, 2.0), 3), "thread": 0.5,
                      "internal": _rounded(rng.uniform(0.9, 2.0), 3), "tip": _rounded(rng.uniform(3, 6), 3)}
    data["thread"] = {"material": "PET", "diameter": 0.15, "pitch": _rounded(rng.uniform(1.0, 2.2), 3)}
    data["exoskeleton"] = {"joint_fillet": _rounded(rng.uniform(0, 2.5), 3)}
    return data


def _rounded(number: float, digits: int) -> float:
    return round(float(number), digits)
