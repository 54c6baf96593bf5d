"""How much silicone each pour takes: from the cavities that the tooling leaves open, cup included."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from handgen.geometry import cores, csg, mould
from handgen.geometry.actuator import thread_length
from handgen.geometry.casting import Setup
from handgen.parameters.model import Hand
from handgen.parameters.process import Casting

FIRST, SECOND, TIP = 1, 2, 3
"""Outer layer with the thread, inner layer, and the tip where that is filled from inside afterwards."""


@dataclass(frozen=True)
class Portion:
    """Silicone to mix: `ml` in all; A and B by volume and by mass (one density for both)."""

    ml: float
    a_ml: float
    b_ml: float
    a_g: float
    b_g: float

    @classmethod
    def of(cls, ml: float, casting: Casting) -> Portion:
        """`ml` to be poured, with what stays on cup and stirrer."""
        mixed = ml * (1 + casting.mixing_loss / 100)
        share = casting.silicone.mix_ratio / (1 + casting.silicone.mix_ratio)
        a, b, density = mixed * share, mixed * (1 - share), casting.silicone.density
        return cls(mixed, a, b, a * density, b * density)


@dataclass(frozen=True)
class Pour:
    """What one pour fills, mm3: the layer itself and what stands above it in the cup."""

    actuator: str
    layer: int
    cavity: float
    cup: float

    @property
    def ml(self) -> float:
        return (self.cavity + self.cup) / 1000


def pours(hand: Hand, name: str) -> list[Pour]:
    """The pours of one actuator in order.

    Before the second, the first layer is trimmed to the actuator's base: the cup is filled anew.
    """
    setup = Setup(hand, name)
    large, small = cores.large_core(setup), cores.small_core(setup)
    first = _open(setup, large)
    thread = math.pi * setup.thread.diameter**2 / 4 * thread_length(hand, name)
    # Of the room that the large core had, the small core leaves the inner layer.
    second = _open(setup, small) - first
    found = [Pour(name, FIRST, first - thread, _cup(setup, large)),
             Pour(name, SECOND, second, _cup(setup, small))]
    if hand.casting.tip == "filled afterwards":
        found.append(Pour(name, TIP, _hole(setup), 0.0))
    return found


def portion(made: Iterable[Pour], casting: Casting) -> Portion:
    """One mix for several pours."""
    return Portion.of(sum(pour.ml for pour in made), casting)


def between(setup: Setup, start: float, end: float) -> csg.Shape:
    """The cavity of the mould with its cup from one x to another."""
    out = 2 * (setup.cup + setup.half_width)
    return csg.Intersection((mould.cavity(setup), csg.box((start, -out, -out), (end, out, out))))


def _open(setup: Setup, core: csg.Shape) -> float:
    """What a core leaves open in the mould between the actuator's base and the floor, mm3."""
    return _volume(csg.Difference(between(setup, 0.0, setup.length), (core,)))


def _cup(setup: Setup, core: csg.Shape) -> float:
    """What is filled of the cup around a core, mm3."""
    level = setup.top * setup.casting.cup_fill / 100
    return 0.0 if level == 0.0 else _volume(csg.Difference(between(setup, level, 0.0), (core,)))


def _hole(setup: Setup) -> float:
    """What the small core leaves at the tip beyond the chamber, its salience's hole included, mm3."""
    chamber = setup.profile.small_core_end
    return _volume(csg.Intersection((between(setup, chamber, setup.length), cores.small_core(setup))))


def _volume(shape: csg.Shape) -> float:
    from handgen.geometry import mesh_kernel

    return float(mesh_kernel.evaluate(shape).volume())
