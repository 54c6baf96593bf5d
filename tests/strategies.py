"""Random valid parameter files, drawn around the adult hand.

Lengths and diameters 0.6 to 1.4 times the source's, walls of 0.8 to 3 mm, one to four joints
anywhere, any layers that leave room for a core. `files()` draws plain data; `write` makes a file.
"""

import copy
import math
from pathlib import Path

import yaml
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

PARAMS = Path(__file__).parent.parent / "params"
ADULT = yaml.safe_load((PARAMS / "adult.yaml").read_text(encoding="utf-8"))

# The same files on every machine and in every run, and no clock: a busy machine is no failure.
settings.register_profile(
    "handgen", derandomize=True, deadline=None, database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
settings.load_profile("handgen")


def write(data: dict, folder: Path, name: str = "hand.yaml") -> Path:
    """A parameter file with `data` in `folder`."""
    path = Path(folder) / name
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return path


def number(low: float, high: float) -> st.SearchStrategy[float]:
    """A number with three decimals, as people write them; `low` where the range is empty."""
    first, last = math.ceil(low * 1000 - 1e-6), math.floor(high * 1000 + 1e-6)
    return st.integers(first, max(first, last)).map(lambda n: n / 1000)


@st.composite
def files(draw: st.DrawFn, fingers_only: bool = False) -> dict:
    """The data of a valid parameter file; `fingers_only` leaves out palm and opposition."""
    data = copy.deepcopy(ADULT)
    data["name"] = "random"
    data["side"] = draw(st.sampled_from(["right", "left"]))
    for name, finger in data["fingers"].items():
        _exoskeleton(draw, finger)
        data["actuators"][name] = _actuator(draw, finger)
    if fingers_only:
        for key in ("palm", "opposition"):
            del data[key]
        for key in ("opposition_1", "opposition_2"):
            del data["actuators"][key]
        data["assumed"] = {k: v for k, v in data["assumed"].items() if k.startswith("fingers.")}
    else:
        del data["palm"]["length"]
        # The actuators drawn here have no thread of their own.
        del data["assumed"]["actuators.little.thread.pitch"]
    _stack(draw, data)
    data["exoskeleton"] = {"joint_fillet": draw(number(0, 3))}
    return data


def _exoskeleton(draw: st.DrawFn, finger: dict) -> None:
    length, width = draw(number(0.6, 1.4)), draw(number(0.6, 1.4))
    finger["outer_length"] = round(finger["outer_length"] * length, 3)
    finger["inner_length"] = round(finger["outer_length"] - draw(number(2, 10)), 3)
    base = round(finger["base_bore_diameter"] * width, 3)
    tip = round(finger["tip_bore_diameter"] * width, 3)
    base_wall = draw(number(0.8, 3))
    tip_wall = draw(number(0.8, min(3.0, base_wall + (base - tip) / 2)))
    finger["base_bore_diameter"], finger["tip_bore_diameter"] = base, tip
    finger["base_outer_diameter"] = round(base + 2 * base_wall, 3)
    finger["tip_outer_diameter"] = round(tip + 2 * tip_wall, 3)
    if draw(st.booleans()):
        finger["taper"] = draw(tapers())
    finger["joints"] = draw(joints(finger["inner_length"], finger["base_outer_diameter"]))
    finger["placement"]["splay"] += draw(number(-8, 8))


@st.composite
def tapers(draw: st.DrawFn) -> list[list[float]]:
    """Stations that only narrow."""
    count = draw(st.integers(0, 3))
    steps = [draw(number(0.1, 1)) for _ in range(count + 1)]
    places = [round(sum(steps[:i + 1]) / sum(steps), 3) for i in range(count)]
    shares = sorted(draw(number(0, 1)) for _ in range(count))
    return [[0.0, 0.0], *map(list, zip(places, shares, strict=True)), [1.0, 1.0]]


@st.composite
def joints(draw: st.DrawFn, inner_length: float, diameter: float) -> list[dict]:
    """One to four joints anywhere on a finger, slots and phalanges of any length that fits.

    Slots too short for a rest angle get none.
    """
    count = draw(st.integers(1, 4))
    # Ring, slot, phalanx, slot, ..., ring: each gets its least and a random share of the rest.
    least = [1.01] + [2.01] * (2 * count - 1) + [1.01]
    weights = [draw(number(0.1, 1)) for _ in least]
    rest = inner_length - sum(least)
    lengths = [a + rest * w / sum(weights) for a, w in zip(least, weights, strict=True)]
    found, start = [], 0.0
    for i in range(count):
        start += lengths[2 * i]
        slot = lengths[2 * i + 1]
        found.append({
            "name": f"joint_{i + 1}",
            "position": round(start + slot / 2, 3),
            "slot_length": round(min(slot, 39.0), 3),
            "palmar_arc": draw(number(40, 170)),
            "rest_angle": draw(st.sampled_from([a for a in (0.0, 0.0, 10.0, 30.0)
                                                if slot - math.radians(a) * diameter / 2 > 0.51])),
        })
        start += slot
    return found


def _actuator(draw: st.DrawFn, finger: dict) -> dict:
    """An actuator that slides into the finger, with its taper."""
    base, tip = finger["base_bore_diameter"], finger["tip_bore_diameter"]
    clearance = draw(number(0, 0.5))
    return {
        "outer_length": round(finger["inner_length"] - draw(number(0, 2)), 3),
        "base_outer_diameter": round(base - 2 * clearance, 3),
        "tip_outer_diameter": round(tip - 2 * draw(number(max(0.0, clearance - (base - tip) / 2), 0.5)), 3),
    }


def _stack(draw: st.DrawFn, data: dict) -> None:
    """Layers, core, thread and tube that fit the narrowest actuator."""
    base = min(a["base_outer_diameter"] for a in data["actuators"].values())
    tip = min(a["tip_outer_diameter"] for a in data["actuators"].values())
    core = draw(number(0.8, min(2.5, tip - 2.4)))
    tube = draw(number(1.5, min(4.0, base - 3.2)))
    room = (base - max(core, tube + 0.92)) / 2
    stack = draw(number(1.1, min(4.5, room)))
    share = draw(number(0.1, 0.25))
    outer = draw(number(0.4, 0.6))
    layers = {
        "external": round(stack * (1 - share) * outer, 3),
        "thread": round(stack * share, 3),
        "internal": round(stack * (1 - share) * (1 - outer), 3),
        "tip": draw(number(1.5, 8)),
    }
    # At the narrowest tip the layers may be thinned; the thread must still fit its room there.
    thinned = layers["thread"] * min(1.0, (tip - core) / 2 / stack)
    data["layers"] = layers
    data["thread"] = {"material": "PET", "diameter": draw(number(0.02, 0.95 * thinned)),
                      "pitch": draw(number(0.8, 5)), "groove": draw(st.booleans())}
    data["casting"]["minimum_core_tip_diameter"] = core
    data["seal"] = {"tube_outer_diameter": tube, "plug_length": draw(number(4, 12))}
