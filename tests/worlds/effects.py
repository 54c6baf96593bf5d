"""Effects of the catalogue, each by a law of this world's own and of random size.

The laws say the same of nature as handgen's effects and share nothing with them: a capstan rubs where the
model has Coulomb, play is taken up smoothly, voids soften like spherical pores, a curl lies along the whole
print. Every function gives the world with the effect, and the size that was drawn, for the record.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.worlds.finger import Finger
from tests.worlds.world import Moment, State, World

Drawn = tuple[World, float]
Draw = Callable[[World, np.random.Generator], Drawn]


def of_finger(world: World, **values) -> World:
    return world.with_(finger=replace(world.finger, **values))


def stressed(finger: Finger, factor: float) -> tuple[float, float, float]:
    """The wall's law with all of its stresses times `factor`."""
    return factor * finger.wall[0], finger.wall[1], factor * finger.wall[2]


def either(rng: np.random.Generator, low: float, high: float) -> float:
    """Uniform, of either sign."""
    return float(rng.choice([-1.0, 1.0]) * rng.uniform(low, high))


def own_weight(world: World, rng: np.random.Generator) -> Drawn:
    size = rng.uniform(0.8, 1.2)
    return world.with_(assembly_weight=size), size


def rest_curl(world: World, rng: np.random.Generator) -> Drawn:
    """Half along the whole print as it shrinks, half in the joints by unequal shares; degrees."""
    size = rng.uniform(5.0, 40.0)
    shares = rng.dirichlet([6.0, 6.0, 6.0]) * 0.5
    curls = tuple(c + math.radians(size) * s for c, s in zip(world.finger.curls, shares, strict=True))
    return of_finger(world, curls=curls, curl_everywhere=math.radians(size) / 2), size


def print_porosity(world: World, rng: np.random.Generator) -> Drawn:
    """Spherical pores (Mackenzie's law, Poisson's ratio 1/2): stiffness (1 - c)/(1 + c) to a power near
    1.3."""
    size = rng.uniform(0.05, 0.40)
    left = ((1 - size) / (1 + size)) ** rng.uniform(1.1, 1.4)
    f = world.finger
    return of_finger(world, strip=f.strip * left, shell_mass=f.shell_mass * (1 - size),
                     tip_mass=f.tip_mass * (1 - size)), size


def silicone_softening(world: World, rng: np.random.Generator) -> Drawn:
    """Fewer cross-links: the small-strain modulus goes, the stiffening of long chains less."""
    size = rng.uniform(0.05, 0.45)
    f, kept = world.finger, rng.uniform(0.8, 1.0)
    wall = (f.wall[0] * (1 - size), f.wall[1] * (1 - 0.15 * (1 - kept) * size), f.wall[2] * (1 - size))
    return of_finger(world, wall=wall, beam=f.beam * (1 - size)), size


def wrong_convention(world: World, rng: np.random.Generator) -> Drawn:
    """The real silicone is what the constants mean in their own convention: for one term of power 1.42,
    0.71."""
    size = 1.42 / 2 * rng.uniform(0.97, 1.03)
    f = world.finger
    return of_finger(world, wall=stressed(f, size), beam=size * f.beam), size


def uniaxial_only_law(world: World, rng: np.random.Generator) -> Drawn:
    """Held around, the wall resists more the further it is stretched: a share of it grows with the strain."""
    size = rng.uniform(0.1, 0.5)
    f = world.finger
    wall = (f.wall[0] * (1 + 0.65 * size), f.wall[1], f.wall[2] + 0.1 * size * f.wall[0])
    return of_finger(world, wall=wall, beam=f.beam * (1 + 0.4 * size)), size


def bore_clearance(world: World, rng: np.random.Generator) -> Drawn:
    """A loose tube bends freely for a while and then lies on the slots' open side; mm."""
    size = rng.uniform(0.1, 0.9)
    grip = 1 - 0.3 * math.tanh(size / 0.6)

    def loose(finger: Finger, moment: Moment) -> Finger:
        share = grip + (1 - grip) * -math.expm1(-moment.pressure / 25.0)
        return replace(finger, beam=finger.beam * share, arm=finger.arm + 0.15 * size)

    return world.then(change=loose), size


def pressure_offset(world: World, rng: np.random.Generator) -> Drawn:
    """kPa; suction that a gauge below zero would ask for does not build up."""
    size = either(rng, 4.0, 11.0)

    def shifted(kilopascals: float, moment: Moment) -> float:
        return float(np.logaddexp(0.0, (kilopascals + size) / 0.5) * 0.5)

    return world.then(chamber=shifted), size


def pressure_gain(world: World, rng: np.random.Generator) -> Drawn:
    """A supply that is off by a share, a little less at the top."""
    size = 1 + either(rng, 0.06, 0.22)
    return world.then(chamber=lambda p, m: size * p * (1 - 0.1 * (size - 1) * p / 60)), size


def bore_friction(world: World, rng: np.random.Generator) -> Drawn:
    """A capstan: what the wall has turned holds it back."""
    size = rng.uniform(0.3, 1.5)
    return world.with_(rub=0.05 * size), size


def base_compliance(world: World, rng: np.random.Generator) -> Drawn:
    """The palm yields, less and less; deg at 10 N mm."""
    size = rng.uniform(1.0, 8.0)
    return of_finger(world, root_give=math.radians(size) / 10, root_harden=rng.uniform(0.5, 3.0)), size


def scale_error(world: World, rng: np.random.Generator) -> Drawn:
    """The paper hangs behind the finger; what lies farther down is seen a little flatter."""
    size = 1 + either(rng, 0.03, 0.12)

    def seen(value: float, moment: Moment, state: State) -> float:
        if moment.test.quantity not in ("tip_drop", "elongation"):
            return value
        return value * size / (1 + 0.05 * (size - 1) * value / 50)

    return world.then(read=seen), size


def contact_angle(world: World, rng: np.random.Generator) -> Drawn:
    """deg at no pressure; the tip rolls on by a few degrees as it is pressed."""
    size = rng.uniform(15.0, 55.0)

    def slanted(value: float, moment: Moment, state: State) -> float:
        angle = size + 4 * moment.pressure / 80
        if moment.test.quantity == "force_angle":
            return value + angle
        return value * math.cos(math.radians(angle)) if moment.test.quantity == "tip_force" else value

    return world.then(read=slanted), size


def thread_spacing(world: World, rng: np.random.Generator) -> Drawn:
    """Between turns that lie farther apart the wall bulges.

    A tube that is not held around does not grow longer at all at first (Lame, incompressible): what it grows
    wider it loses in length, in proportion. Then the bulging wall gets thinner, and gives way.
    """
    size = rng.uniform(1.3, 2.6)
    loose = 0.04 * (size**2 - 1)

    def bulged(finger: Finger, moment: Moment) -> Finger:
        held = 1 + loose * (1.0 if moment.test.part == "actuator" else 0.6)
        return replace(finger, wall=stressed(finger, held * (1 - loose * (moment.pressure / 60) ** 2)))

    return world.then(change=bulged), size


def asymmetric_winding(world: World, rng: np.random.Generator) -> Drawn:
    """Turns denser on one side: the free actuator becomes an arc, in the finger it bends the joints; deg at
    60, as a tube does whose wall is up to half a millimetre thicker on one side than drawn."""
    size = either(rng, 10.0, 55.0)
    f = world.finger
    curvature = math.radians(size) / 60 / f.active

    def arched(finger: Finger, moment: Moment) -> Finger:
        turn = [curvature * moment.pressure * s * finger.beam / (finger.beam + finger.strip)
                for s in finger.slots]
        return replace(finger, curls=tuple(c + t for c, t in zip(finger.curls, turn, strict=True)))

    def lone(finger: Finger, moment: Moment) -> Finger:
        return arched(finger, moment) if moment.test.part == "assembly" else finger

    return world.with_(curling=curvature).then(change=lone), size


def mullins(world: World, rng: np.random.Generator) -> Drawn:
    """Filler bonds break up to the highest pressure so far; below it the wall is softer, most at the
    bottom."""
    size = rng.uniform(0.08, 0.40)

    def worn(finger: Finger, moment: Moment) -> Finger:
        if moment.highest <= 0.0:
            return finger
        lost = size * math.tanh(moment.highest / 30) * (1 - (moment.pressure / moment.highest) ** 2)
        return _weaker(finger, lost)

    return world.then(change=worn), size


def creep(world: World, rng: np.random.Generator) -> Drawn:
    """Compliance grows by a power of time; share lost after 1000 s."""
    size = rng.uniform(0.05, 0.35)
    power = rng.uniform(0.1, 0.3)

    def tired(finger: Finger, moment: Moment) -> Finger:
        return _weaker(finger, 1 - 1 / (1 + size / (1 - size) * (moment.time / 1000) ** power))

    return world.then(change=tired), size


def self_contact(world: World, rng: np.random.Generator) -> Drawn:
    """The palmar sides of neighbouring bones meet, softly; rad a joint."""
    size = rng.uniform(0.35, 1.0)
    return of_finger(world, stop=size, stop_stiffness=rng.uniform(2e4, 2e5)), size


def _weaker(finger: Finger, lost: float) -> Finger:
    return replace(finger, wall=stressed(finger, 1 - lost), beam=finger.beam * (1 - lost))


EFFECTS: dict[str, Draw] = {one.__name__: one for one in (
    own_weight, rest_curl, print_porosity, silicone_softening, wrong_convention, uniaxial_only_law,
    bore_clearance, pressure_offset, pressure_gain, bore_friction, base_compliance, scale_error,
    contact_angle, thread_spacing, asymmetric_winding, mullins, creep, self_contact)}
"""The contract's names -> what draws them."""
