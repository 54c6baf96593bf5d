"""Random valid fingers to bend, each of its number alone, so that a study may be cut anywhere.

Two kinds. `named` varies what was asked for by name: lengths and diameters 0.6 to 1.4 times the adult's,
walls of 0.8 to 3 mm, numbers and places of joints, splay; layers, thread, slots, strips and seal stay the
adult's. `anything` is `strategies.files`: any layers from 1.1 mm together, threads from 0.02 mm, slots of 2
to 39 mm, strips, clearances, rest angles.
"""

from __future__ import annotations

import copy
import json
import random
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from handgen.errors import InputError
from handgen.parameters.load import load
from tests.strategies import ADULT, write

RING, PHALANX = 1.01, 2.01
"""mm, least lengths of a finger's ends and between two slots."""
MOST_JOINTS = 4
ENDS = "base", "tip"
TRIES = 4
"""Files drawn for each that is new: hypothesis repeats itself."""


def named(number: int) -> tuple[str, dict]:
    """(finger, data of its parameter file): the first of a row of evenly random fingers that can be loaded.

    One finger of a hand is random; two in three of those drawn leave room for layers, core and tube.
    """
    rng = random.Random(f"finger {number}")
    with tempfile.TemporaryDirectory() as folder:
        while True:
            name = rng.choice(list(ADULT["fingers"]))
            data = _fingers_only(copy.deepcopy(ADULT))
            _vary(rng, data["fingers"][name], data["actuators"][name])
            try:
                load(write(data, Path(folder)))
            except InputError:
                continue
            return name, data


def _vary(rng: random.Random, finger: dict, actuator: dict) -> None:
    """Another length, width, wall, splay and row of joints; the actuator follows."""
    loose = [finger[f"{e}_bore_diameter"] - actuator[f"{e}_outer_diameter"] for e in ENDS]
    dome = finger["outer_length"] - finger["inner_length"]
    finger["outer_length"] = round(finger["outer_length"] * rng.uniform(0.6, 1.4), 2)
    finger["inner_length"] = round(finger["outer_length"] - dome, 2)
    width = rng.uniform(0.6, 1.4)
    bores = [round(finger[f"{e}_bore_diameter"] * width, 2) for e in ENDS]
    base_wall = rng.uniform(0.8, 3.0)
    # A finger may not widen towards its tip.
    walls = base_wall, rng.uniform(0.8, min(3.0, base_wall + (bores[0] - bores[1]) / 2))
    for end, bore, wall, gap in zip(ENDS, bores, walls, loose, strict=True):
        finger[f"{end}_bore_diameter"] = bore
        finger[f"{end}_outer_diameter"] = round(bore + 2 * wall, 2)
        actuator[f"{end}_outer_diameter"] = round(bore - gap, 2)
    actuator["outer_length"] = finger["inner_length"]
    finger["joints"] = list(_joints(rng, finger["inner_length"], finger["joints"][0]))
    finger["placement"]["splay"] += rng.uniform(-8, 8)


def _joints(rng: random.Random, length: float, like: dict) -> Iterator[dict]:
    """One to four joints with slot and strip of the adult's, anywhere along `length` mm where they fit."""
    slot = like["slot_length"]
    fitting = [n for n in range(1, MOST_JOINTS + 1) if _room(length, n, slot) > 0]
    count = rng.choice(fitting)
    starts = sorted(rng.uniform(0, _room(length, count, slot)) for _ in range(count))
    for i, start in enumerate(starts):
        place = RING + start + i * (slot + PHALANX) + slot / 2
        yield {**like, "name": f"joint_{i + 1}", "position": round(place, 2)}


def _room(length: float, count: int, slot: float) -> float:
    return length - count * slot - 2 * RING - (count - 1) * PHALANX


def _fingers_only(data: dict) -> dict:
    """A hand without palm and opposition, named `random`."""
    data["name"] = "random"
    del data["palm"], data["opposition"]
    for key in ("opposition_1", "opposition_2"):
        del data["actuators"][key]
    data["assumed"] = {k: v for k, v in data["assumed"].items() if k.startswith("fingers.")}
    return data


def anything(number: int) -> tuple[str, dict]:
    """(finger, data of its parameter file): one of those that hypothesis draws, no finger twice."""
    return _drawn(100 * (number // 100 + 1))[number]


@cache
def _drawn(count: int) -> list[tuple[str, dict]]:
    from hypothesis import Phase, given, settings

    from tests import strategies

    found, seen, pick = [], set(), random.Random(0)

    @settings(max_examples=TRIES * count, phases=[Phase.generate])
    @given(strategies.files(fingers_only=True))
    def draw(data):
        finger = pick.choice(list(data["fingers"]))
        key = json.dumps([data["fingers"][finger], data["actuators"][finger]], sort_keys=True)
        if key not in seen:
            seen.add(key)
            found.append((finger, data))

    draw()
    return found


KINDS = {"named": named, "anything": anything}
