"""A finger of a world: its physical constants, the chain they make, and what is read off it.

Units: mm, N, MPa, rad. Nothing of the model that is judged is used here, neither its geometry nor its laws: a strip
is one bending stiffness, the actuator a spring beside the hinges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from tests.worlds import chain

GRAVITY = 9.80665
"""m/s2."""
FILE = Path(__file__).parent / "constants.yaml"


@dataclass(frozen=True)
class Finger:
    """Constants of one printed and cast finger."""

    length: float = 102.5
    bore: float = 94.5
    """End of the bore: the tip is a cap from there on."""
    tip_radius: float = 7.85
    palm: float = 10.0
    """Underside of the palm below the finger's axis at the root."""
    joints: tuple[float, ...] = (13.7, 57.5, 81.5)
    slots: tuple[float, ...] = (9.0, 9.0, 9.0)
    curls: tuple[float, ...] = (math.radians(26.7), 0.0, 0.0)
    """Rest angles."""
    curl_everywhere: float = 0.0
    """Rest angle that is spread evenly over all the length."""
    offset: float = 8.0
    """Hinge line below the axis."""
    arm: float = 8.0
    """Actuator's middle above the hinge line."""
    strip: float = 250.0
    """Bending stiffness of the strips, N mm2."""
    first: float = 1.0
    """Times as stiff as the others is the strip of the first joint."""
    harden: float = 0.0
    """Of the strips: moment = strip (c + harden c^3) of the curvature c, mm2."""
    bone: float = 60.0
    """Times as stiff as a strip is a bone."""
    blur: float = 1.0
    """Over which a slot's end fades, mm."""
    beam: float = 250.0
    """Bending stiffness of the actuator pressed into the bore, N mm2."""
    loose: float = 0.5
    """Share of `beam` that a tube without pressure has, which lies loosely in its bore."""
    seated: float = 0.006
    """Pressure at which half of the rest is there, MPa."""
    area: float = 75.0
    """On which the pressure pushes."""
    wall: tuple[float, float, float] = (0.08, 0.0, 0.0)
    """MPa: pressure that stretches the free actuator by x is wall[0] x + wall[1] x^2 + wall[2] x^3."""
    active: float = 80.0
    """Length of the actuator that stretches."""
    slack: float = 0.0
    """The actuator's way until it pushes."""
    soft: float = 0.4
    """Over which slack is taken up."""
    shell_mass: float = 7.0
    """g, strips and bones."""
    tube_mass: float = 10.0
    """g, the actuator, along the bore."""
    tip_mass: float = 1.5
    """g, the cap."""
    stop: float = 10.0
    """Turn at which a slot's palmar side is closed, rad a slot."""
    stop_stiffness: float = 400.0
    root_give: float = 0.0
    """rad/(N mm) at 10 N mm: how the palm yields to the finger's moment."""
    root_power: float = 1.0
    floor: float = 50.0
    """Stiffness of balance and fingertip, N/mm."""

    @cached_property
    def arrays(self) -> dict[str, np.ndarray]:
        """The chain's arguments but for loads and start; see `chain.assemble`."""
        n = chain.LINKS
        link = self.length / n
        starts = np.arange(n) * link
        free = np.zeros(n)
        rest = np.full(n, self.curl_everywhere / n)
        stop = np.full(n, np.inf)
        for place, slot, curl in zip(self.joints, self.slots, self.curls, strict=True):
            share = self._overlap(starts, link, place - slot / 2, place + slot / 2)
            free += share
            rest += curl * share / share.sum()
            stop = np.where(share > 0.05 * link, self.stop * share / slot, stop)
        ratio = np.repeat(1.0, n)
        ratio[starts < (self.joints[0] + self.joints[1]) / 2] = self.first
        give = free / (ratio * self.strip) + (link - free) / (self.bone * self.strip)
        bend = free / self.beam + (link - free) / (self.bone * self.beam)
        inside = np.clip((self.bore - starts) / link, 0.0, 1.0)
        weight = 1e-3 * GRAVITY * self.shell_mass * inside / inside.sum()
        weight_tip = np.where(inside < 1.0, 1.0 - inside, 0.0)
        weight = weight + 1e-3 * GRAVITY * self.tip_mass * weight_tip / weight_tip.sum()
        return {
            "rest": rest, "strip": 1.0 / give, "harden": self.harden * (1.0 / np.maximum(free, 0.3 * link)) ** 2,
            "bend": 1.0 / bend, "arm": np.full(n, self.arm), "stop": stop, "links": np.full(n, link),
            "weight": weight, "tube": 1e-3 * GRAVITY * self.tube_mass * inside / inside.sum(),
            "off": np.full(n, self.offset)}

    def _overlap(self, starts: np.ndarray, link: float, low: float, high: float) -> np.ndarray:
        """mm of a slot that each hinge stands for: it stands for half a link to both sides, ends blurred."""
        def filled(x):
            return self.blur * np.logaddexp(0.0, x / self.blur)
        a, b = starts - link / 2, starts + link / 2
        return (filled(b - low) - filled(a - low)) - (filled(b - high) - filled(a - high))


@cache
def calibrated() -> Finger:
    """The finger near the solid model's, see `tests.worlds.calibrate`."""
    import yaml

    return with_values(Finger(), yaml.safe_load(FILE.read_text(encoding="utf-8")))


def with_values(finger: Finger, values: dict[str, float]) -> Finger:
    """`finger` with other constants; "wall.1" names the second of `wall`."""
    changes: dict[str, object] = {}
    for key, value in values.items():
        name, _, at = key.partition(".")
        if at:
            row = list(changes.get(name, getattr(finger, name)))
            row[int(at)] = value
            value = tuple(row)
        changes[name] = value
    return replace(finger, **changes)


@dataclass(frozen=True)
class Pose:
    """How a finger is tested."""

    part: str = "assembly"
    down: float = 1.0
    """Share of gravity towards the palm's side: 1 palm down, -1 palm up, 0 carried."""
    plane: float = 0.0
    """Distance of a plane below the palm side, mm; 0: none."""


@dataclass
class State:
    """One equilibrium."""

    angles: np.ndarray
    imbalance: float
    values: dict[str, float] = field(default_factory=dict)


def balance(finger: Finger, pose: Pose, pressure: float, load: float, start: np.ndarray | None = None,
            friction: np.ndarray | float = 1.0) -> State:
    """The finger under `pressure` (MPa) and tip `load` (N); `friction`: share of the push that each hinge gets."""
    a = finger.arrays
    both = pose.part == "assembly"
    arm = a["arm"] * friction if both else np.zeros(chain.LINKS)
    pressed = finger.loose + (1.0 - finger.loose) * pressure / (pressure + finger.seated)
    beam = pressed * a["bend"] if both else np.zeros(chain.LINKS)
    weight = a["weight"] + a["tube"] if both else a["weight"]
    sign = -1.0 if pose.down < 0 else 1.0
    plane = -finger.palm - pose.plane if pose.plane else 0.0
    loads = np.array([pressure if both else 0.0, pose.down, load, plane, sign])
    body = np.array([finger.bore - 5.0, finger.bore, finger.tip_radius, -finger.offset, finger.floor,
                     finger.stop_stiffness])
    last = (chain.LINKS - 1) * finger.length / chain.LINKS
    body[:2] -= last
    act = np.array([finger.area, finger.active, finger.slack, finger.soft])
    root = root_turn(finger, weight, pose, load)
    rest = a["rest"].copy()
    rest[0] += root
    t0 = np.cumsum(rest) if start is None else start
    t, imbalance = chain.equilibrium(
        t0, rest, a["strip"], a["harden"], beam, arm, a["stop"], a["links"], weight, a["off"], body, act,
        np.array(finger.wall), loads)
    state = State(t, imbalance)
    low = min(chain.tip_height(t, a["links"], a["off"], body, reach)[0] for reach in body[:2])
    turns = np.diff(t, prepend=0.0) - rest
    state.values = {
        "tip_drop": -low - finger.palm, "bend_angle": math.degrees(t[-1]),
        "elongation": float((a["arm"] * turns).sum()),
        "tip_force": finger.floor * max(plane - low, 0.0) if pose.plane else 0.0}
    return state


def root_turn(finger: Finger, weight: np.ndarray, pose: Pose, load: float) -> float:
    """Turn of the root under the moment of weights with the finger straight, rad (power law)."""
    if finger.root_give == 0.0:
        return 0.0
    link = finger.length / chain.LINKS
    moment = pose.down * (weight * (np.arange(chain.LINKS) + 0.5) * link).sum() + load * finger.bore
    return math.copysign(finger.root_give * 10.0 * (abs(moment) / 10.0) ** finger.root_power, moment)


def free_elongation(finger: Finger, pressure: float) -> float:
    """Of the actuator alone, mm; pressure MPa."""
    x = max(pressure, 0.0) / finger.wall[0]
    for _ in range(60):
        p, slope, _ = chain.wall_pressure(x * finger.active, finger.active, np.array(finger.wall))
        x -= max(min((p - pressure) / (slope * finger.active), 0.1), -0.1)
    return x * finger.active
