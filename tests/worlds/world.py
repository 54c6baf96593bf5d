"""A world: one finger as it was made, what acts in it that no model knows, and how it is read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from tests.worlds.chain import wall_pressure
from tests.worlds.finger import Finger, Pose, State, balance, calibrated, free_elongation

READING = 20.0
"""s from one reading to the next."""
DOWN = {"palm_down": 1.0, "palm_up": -1.0, "sideways": 0.0, "weightless": 0.0}


@dataclass(frozen=True)
class Test:
    """What a lab does in one go; as the measurements file says it."""

    id: str
    part: str
    quantity: str
    loads: tuple[float, ...]
    orientation: str = "palm_down"
    path: str = "loading"
    obstacle: float | None = None
    times: tuple[float, ...] = ()
    """s since the first load of each reading; empty: READING apart."""

    @property
    def elapsed(self) -> tuple[float, ...]:
        return self.times or tuple(READING * (i + 1) for i in range(len(self.loads)))


@dataclass(frozen=True)
class Moment:
    """Where in a campaign a reading is taken."""

    test: Test
    repeat: int
    index: int
    """Of the reading in its test."""
    order: int
    """Of the test in the campaign."""
    pressure: float
    """kPa on the gauge."""
    before: float
    """kPa, largest in this run so far."""
    falling: bool
    time: float
    """s since the first load of this run."""
    highest: float
    """kPa, largest of this run and of all runs before."""

    @property
    def share(self) -> float:
        """Of the test's readings that lie behind this one, 0 to 1."""
        return self.index / max(len(self.test.loads) - 1, 1)


INSTRUMENTS = {"chamber_pressure": lambda pressure: {"chamber_pressure": pressure},
               "force_angle": lambda pressure: {"force_angle": 0.0}}
"""What is read beside the finger: a manometer at the inlet, kPa; the force's direction, deg off the plane's
normal. kPa in the chamber -> values of a state."""
Chamber = Callable[[float, Moment], float]
"""kPa on the gauge -> kPa in the chamber."""
Change = Callable[[Finger, Moment], Finger]
"""The finger at one reading."""
Read = Callable[[float, Moment, State], float]
"""True value -> value as the eye meets it."""


@dataclass(frozen=True)
class World:
    """Everything that a campaign needs but its noise."""

    finger: Finger = field(default_factory=calibrated)
    assembly_weight: float = 0.0
    """Share of own weight that acts on a finger with its actuator: the model to be judged leaves it out."""
    shell_weight: float = 1.0
    rub: float = 0.0
    """Capstan coefficient of the wound wall along the bore."""
    curling: float = 0.0
    """Curvature of the free actuator a kPa, 1/(mm kPa)."""
    chamber: tuple[Chamber, ...] = ()
    change: tuple[Change, ...] = ()
    read: tuple[Read, ...] = ()

    def with_(self, **values) -> World:
        return replace(self, **values)

    def then(self, *, chamber: Chamber | None = None, change: Change | None = None,
             read: Read | None = None) -> World:
        """This world with one more thing that happens."""
        return replace(self, chamber=self.chamber + ((chamber,) if chamber else ()),
                       change=self.change + ((change,) if change else ()),
                       read=self.read + ((read,) if read else ()))


def run(world: World, test: Test, repeat: int = 0, order: int = 0) -> np.ndarray:
    """The readings of one run of `test`, without noise."""
    found, start, before = [], None, 0.0
    for index, load in enumerate(test.loads):
        pressure = 0.0 if test.part == "exoskeleton" else load
        if index == 0 and test.path == "unloading":
            before = pressure
        before = max(before, pressure)
        falling = pressure < before
        highest = max(before, max(test.loads) if repeat and test.part != "exoskeleton" else 0.0)
        moment = Moment(test, repeat, index, order, pressure, before, falling, test.elapsed[index], highest)
        for one in world.chamber:
            pressure = one(pressure, moment)
        finger = world.finger
        for one in world.change:
            finger = one(finger, moment)
        if test.quantity in INSTRUMENTS:
            state = State(np.zeros(0), 0.0, INSTRUMENTS[test.quantity](pressure))
        else:
            state = _state(world, finger, moment, 1e-3 * pressure, load, start)
        start = state.angles if len(state.angles) else None
        value = state.values[test.quantity]
        for one in world.read:
            value = one(value, moment, state)
        found.append(value)
    return np.array(found)


def _state(world: World, finger: Finger, moment: Moment, pressure: float, load: float,
           start: np.ndarray | None) -> State:
    test = moment.test
    if test.part == "actuator":
        return _alone(world, finger, pressure)
    bare = test.part == "exoskeleton"
    share = world.shell_weight if bare else world.assembly_weight
    pose = Pose(test.part, share * DOWN[test.orientation], test.obstacle or 0.0)
    weight = load if bare else 0.0
    state = balance(finger, pose, pressure, weight, start)
    if bare or world.rub == 0.0:
        return state
    # A capstan: the wall's pull grows by what the wall has turned, towards the tip going up and the other
    # way coming down. The thrust on the closed end does not rub.
    sign = -1.0 if moment.falling else 1.0
    for _ in range(8):
        turned = np.cumsum(np.abs(np.diff(state.angles, prepend=0.0)))
        held = wall_pressure(state.values["elongation"], finger.active, np.array(finger.wall))[0]
        pull = finger.area * held
        drag = finger.arrays["arm"] * max(pull, 0.0) * np.expm1(sign * world.rub * turned)
        state = balance(finger, pose, pressure, weight, state.angles, drag)
    return state


def _alone(world: World, finger: Finger, pressure: float) -> State:
    """The free actuator; one that curls shows the chord of its arc."""
    grown = free_elongation(finger, pressure)
    turn = 1e3 * world.curling * pressure * (finger.active + grown)
    length = finger.active + grown
    chord = length * np.sinc(turn / np.pi) if turn else length
    return State(np.zeros(0), 0.0, {
        "elongation": chord - finger.active, "bend_angle": float(np.degrees(turn)), "tip_drop": 0.0,
        "tip_force": 0.0})
