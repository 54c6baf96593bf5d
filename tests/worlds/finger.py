"""A finger of a world: its physical constants, the chain they make, and what is read off it.

Units: mm, N, MPa, rad. Nothing of the model that is judged is used here, neither its geometry nor its laws:
a strip is one bending stiffness, the actuator a spring beside the hinges.
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
    wall: tuple[float, float, float] = (0.34, 1.85, 0.0)
    """MPa, 1, MPa: see `chain.wall_pressure`."""
    active: float = 80.0
    """Length of the actuator that stretches."""
    shell_mass: float = 7.0
    """g, strips and bones."""
    tube_mass: float = 10.0
    """g, the actuator, along the bore."""
    tip_mass: float = 1.5
    """g, the cap."""
    stop: float = 10.0
    """Turn at which the bones beside a slot meet, rad a slot."""
    stop_stiffness: float = 400.0
    root_give: float = 0.0
    """rad/(N mm): how the palm yields to the finger's moment. The actuator's push ends in the finger
    itself."""
    root_harden: float = 0.0
    """Of the root, 1/rad2."""
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
        # The first joint's share reaches half the way to the next.
        ratio = np.where(starts < sum(self.joints[:2]) / len(self.joints[:2]), self.first, 1.0)
        give = free / (ratio * self.strip) + (link - free) / (self.bone * self.strip)
        bend = free / self.beam + (link - free) / (self.bone * self.beam)
        inside = np.clip((self.bore - starts) / link, 0.0, 1.0)
        weight = 1e-3 * GRAVITY * self.shell_mass * inside / inside.sum()
        weight_tip = np.where(inside < 1.0, 1.0 - inside, 0.0)
        weight = weight + 1e-3 * GRAVITY * self.tip_mass * weight_tip / (weight_tip.sum() or 1.0)
        strip, beam = 1.0 / give, 1.0 / bend
        harden, arm = self.harden / np.maximum(free, 0.3 * link) ** 2, np.full(n, self.arm)
        if self.root_give > 0.0:
            strip[0], harden[0], beam[0], arm[0] = 1.0 / self.root_give, self.root_harden, 0.0, 0.0
        return {
            "rest": rest, "strip": strip, "harden": harden, "bend": beam, "arm": arm, "stop": stop,
            "links": np.full(n, link),
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
            drag: np.ndarray | None = None) -> State:
    """The finger under `pressure` (MPa) and tip `load` (N); `drag`: moments against every hinge's turn, N
    mm."""
    a = finger.arrays
    both = pose.part == "assembly"
    arm = a["arm"] if both else np.zeros(chain.LINKS)
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
    act = np.array([finger.area, finger.active])
    rest = a["rest"]
    t0 = np.cumsum(rest) if start is None else start
    t, imbalance = chain.equilibrium(
        t0, rest, a["strip"], a["harden"], beam, arm, a["stop"],
        np.zeros(chain.LINKS) if drag is None else drag, a["links"], weight, a["off"], body, act,
        np.array(finger.wall), loads)
    state = State(t, imbalance)
    heights = [chain.tip_height(t, a["links"], a["off"], body, reach)[0] for reach in body[:2]]
    low = _lowest(finger, t, heights)
    turns = np.diff(t, prepend=0.0) - rest
    state.values = {
        "tip_drop": -low - finger.palm, "bend_angle": math.degrees(t[-1]),
        "elongation": float((a["arm"] * turns).sum()),
        "tip_force": finger.floor * max(plane - low, 0.0) if pose.plane else 0.0}
    return state


def _lowest(finger: Finger, t: np.ndarray, heights: list[float]) -> float:
    """Height of the tip's lowest point, mm: of a tube that ends in half a ball.

    `heights`: of the underside of a ball about the tube's axis, 5 mm before the end of the bore and there.
    """
    ring = finger.tip_radius * (1.0 - abs(math.cos(t[-1])))
    ball = 0.0 if t[-1] >= 0.0 else ring
    return min(heights[0] + ring, heights[1] + ball)


def free_elongation(finger: Finger, pressure: float) -> float:
    """Of the actuator alone, mm; pressure MPa."""
    x = max(pressure, 0.0) / finger.wall[0]
    for _ in range(60):
        p, slope, _ = chain.wall_pressure(x * finger.active, finger.active, np.array(finger.wall))
        x -= max(min((p - pressure) / (slope * finger.active), 0.1), -0.1)
    return x * finger.active
