"""What no effect of the catalogue describes: things that go wrong in a lab, each of random size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.worlds.effects import Draw, Drawn, stressed
from tests.worlds.finger import Finger
from tests.worlds.world import Moment, State, World


def growing_leak(world: World, rng: np.random.Generator) -> Drawn:
    """A seam opens as the test goes on, in the finger only: the last readings see much less than the gauge
    says."""
    size = rng.uniform(0.15, 0.45)

    def leaking(kilopascals: float, moment: Moment) -> float:
        return kilopascals * (1 - size * moment.share**2) if moment.test.part == "assembly" else kilopascals

    return world.then(chamber=leaking), size


def stick_slip(world: World, rng: np.random.Generator) -> Drawn:
    """The actuator sticks in its bore and lets go at steps of some kPa."""
    size = rng.uniform(14.0, 30.0)
    first = rng.uniform(0.0, 1.0)

    def jerking(kilopascals: float, moment: Moment) -> float:
        if moment.test.part != "assembly":
            return kilopascals
        return max(size * (np.floor(kilopascals / size + first) - first), 0.0) * 0.8 + 0.2 * kilopascals

    return world.then(chamber=jerking), size


def kinked_tube(world: World, rng: np.random.Generator) -> Drawn:
    """Beyond a pressure no more air comes through to the bent finger; kPa."""
    size = rng.uniform(18.0, 42.0)

    def closed(kilopascals: float, moment: Moment) -> float:
        if moment.test.part != "assembly":
            return kilopascals
        return min(kilopascals, size) + 0.05 * max(kilopascals - size, 0.0)

    return world.then(chamber=closed), size


def cold_day(world: World, rng: np.random.Generator) -> Drawn:
    """The finger as a whole was measured on another day: stiffer print and silicone than when they were
    alone."""
    size = rng.uniform(0.25, 0.8)

    def colder(finger: Finger, moment: Moment) -> Finger:
        if moment.test.part != "assembly":
            return finger
        return replace(finger, strip=finger.strip * (1 + size), beam=finger.beam * (1 + size),
                       wall=stressed(finger, 1 + size))

    return world.then(change=colder), size


def parallax(world: World, rng: np.random.Generator) -> Drawn:
    """A camera at one height: readings far from it are drawn out, those near it are right; mm at 40 mm
    away."""
    size, eye = float(rng.choice([-1.0, 1.0]) * rng.uniform(4.0, 10.0)), rng.uniform(35.0, 60.0)

    def slanting(value: float, moment: Moment, state: State) -> float:
        if moment.test.quantity != "tip_drop":
            return value
        away = (value - eye) / 40
        return value + size * away * abs(away)

    return world.then(read=slanting), size


def delamination(world: World, rng: np.random.Generator) -> Drawn:
    """Beyond a pressure the outer layer comes off and the wall gives way; kPa."""
    size = rng.uniform(25.0, 48.0)
    most = rng.uniform(0.25, 0.45)

    def peeled(finger: Finger, moment: Moment) -> Finger:
        lost = most / (1 + np.exp(-(moment.pressure - size) / 1.5))
        return replace(finger, wall=stressed(finger, 1 - lost))

    return world.then(change=peeled), size


def yielded_strip(world: World, rng: np.random.Generator) -> Drawn:
    """The largest weights leave a bend in the first strip, which the finger then starts from; rad."""
    size = rng.uniform(0.08, 0.25)

    def bent(finger: Finger, moment: Moment) -> Finger:
        if moment.test.part != "assembly":
            return finger
        return replace(finger, curls=(finger.curls[0] - size, *finger.curls[1:]))

    return world.then(change=bent), size


OUTSIDE: dict[str, Draw] = {one.__name__: one for one in (
    growing_leak, stick_slip, kinked_tube, cold_day, parallax, delamination, yielded_strip)}
