"""The fibre-reinforced actuators (Table A.2): silicone, thread, silicone, a closed tip.

What is cast is one silicone body with the thread inside; CAD sees its three layers. The thread's
layer is the room that the source drew for it, not the thread itself, which is thinner (note 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from handgen.errors import GeometryError, InputError, Problem
from handgen.geometry import csg
from handgen.geometry.part import Body, Part
from handgen.geometry.profile import ActuatorProfile, Curve
from handgen.parameters import derive
from handgen.parameters.model import FINGERS, Hand

SILICONE = (0.93, 0.90, 0.80)
THREAD = (0.75, 0.20, 0.15)
CHAMBER = (0.70, 0.80, 0.90)
POINTS_PER_TURN = 72
"""Points of the thread's path: chords then shorten it by 0.03 %."""
LEAST_WALL = 0.8
"""Thinnest whole wall, mm, that the stack is thinned to: below it the cast layers tear on demoulding."""
LEAST_TIP = 0.25
"""Thinnest second pour over the tip, mm: silicone that still flows between the first and the core."""
LEAST_CHAMBER = 4.0
"""Shortest air chamber, mm, that is worth a core."""


@dataclass(frozen=True)
class Adaptation:
    """A parameter that cannot be built as asked, and what is built instead (manifest)."""

    path: str
    asked: dict[str, float]
    used: dict[str, float]
    reason: str
    source: str


def actuator(hand: Hand, name: str) -> Part:
    """The cast actuator `name`, base open at x = 0, closed tip at x = its length.

    Raises:
        GeometryError: no chamber, no wall, or a core that could not be pulled out.
    """
    profile = profile_of(hand, name)
    return Part(
        name=f"actuators/{name}",
        role="actuator",
        material=hand.casting.silicone.name,
        shape=csg.Revolve(_shell(outside(profile), profile.small_core)),
        colour=SILICONE,
        path=f"actuators.{name}",
        up=(-1.0, 0.0, 0.0),
        bodies=layers(profile),
    )


def profile_of(hand: Hand, name: str) -> ActuatorProfile:
    """The radii of actuator `name`, checked to leave a wall, a chamber and cores that come out.

    Raises:
        GeometryError: they do not.
    """
    given = getattr(hand.actuators, name)
    finger = getattr(hand.fingers, name) if name in FINGERS else None
    filled = hand.casting.tip == "filled afterwards"
    profile = ActuatorProfile(
        actuator=given,
        layers=hand.layers_of(name),
        minimum_core=hand.casting.minimum_core_tip_diameter,
        stations=tuple((float(x), float(share)) for x, share in derive.stations(given, finger)),
        tip_fill=hand.casting.tip_fill if filled else 0.0,
    )
    _check(profile, hand, name)
    return profile


def layers_path(hand: Hand, name: str) -> str:
    """Key path of the layers that actuator `name` uses."""
    return f"actuators.{name}.layers" if getattr(hand.actuators, name).layers else "layers"


def thread_key(hand: Hand, name: str) -> str:
    """Key path of the thread that actuator `name` uses."""
    return f"actuators.{name}.thread" if getattr(hand.actuators, name).thread else "thread"


def _check(profile: ActuatorProfile, hand: Hand, name: str) -> None:
    given, part, at = profile.actuator, f"actuators/{name}", f"actuators.{name}"
    shares = [share for _, share in profile.stations]
    if given.tip_outer_diameter > given.base_outer_diameter or shares != sorted(shares):
        key = "tip_outer_diameter" if shares == sorted(shares) else "taper"
        raise GeometryError(part, f"{at}.{key}", "it widens towards the tip: no core could be pulled out")
    tip_wall = (given.tip_outer_diameter - profile.minimum_core) / 2
    if tip_wall < LEAST_WALL:
        raise GeometryError(
            part, f"{at}.tip_outer_diameter",
            f"around the thinnest core ({profile.minimum_core:g} mm) it leaves a wall of {tip_wall:.2f} mm,"
            f" less than {LEAST_WALL:g} mm")
    if profile.small_core_end < LEAST_CHAMBER:
        raise GeometryError(
            part, f"{layers_path(hand, name)}.tip",
            f"a tip of {profile.layers.tip:g} mm leaves a chamber of {profile.small_core_end:.2f} mm,"
            f" shorter than {LEAST_CHAMBER:g} mm")
    between = profile.large_core_end - (profile.small_core_end + profile.tip_fill)
    if between < LEAST_TIP:
        raise GeometryError(
            part, f"{layers_path(hand, name)}.tip",
            f"a tip of {profile.layers.tip:g} mm, {profile.tip_fill:g} mm of it filled afterwards, leaves"
            f" {between:.2f} mm for the second pour, less than {LEAST_TIP:g} mm")


def outside(profile: ActuatorProfile) -> csg.Path:
    """Meridian from (0, outside radius) along the actuator to its tip's centre; not closed."""
    path = profile.outer.append_to(csg.Path((0.0, profile.outer(0.0)), ()))
    return path.line((profile.length, 0.0))


def core_end(curve: Curve) -> tuple[Curve, float]:
    """A core's flank up to where its tip is rounded, and the radius of that rounding, mm.

    Rounded because an inner corner at the tip is where the blown-up actuator tears first.
    """
    rounding = min(1.0, 0.4 * curve(curve.end))
    return curve.between(0.0, curve.end - rounding), rounding


def along_core(path: csg.Path, curve: Curve) -> csg.Path:
    """Extend `path` from (0, radius) along a core's flank and rounded tip to its axis."""
    flank, rounding = core_end(curve)
    radius = flank.pieces[-1].y1
    path = flank.append_to(path)
    path = path.quarter((curve.end, radius), (curve.end, radius - rounding))
    return path.line((curve.end, 0.0))


def back_along_core(path: csg.Path, curve: Curve) -> csg.Path:
    """The same, from the core's tip on the axis back to (0, radius)."""
    flank, rounding = core_end(curve)
    radius = flank.pieces[-1].y1
    path = path.line((curve.end, 0.0), (curve.end, radius - rounding))
    path = path.quarter((curve.end, radius), (flank.end, radius))
    return flank.append_reversed_to(path)


def _shell(outer: csg.Path, inner: Curve) -> csg.Path:
    return back_along_core(outer, inner)


def layers(profile: ActuatorProfile) -> tuple[Body, Body, Body]:
    """External layer with the tip of the first pour, the thread's room, internal layer.

    A tip that is filled afterwards is the same silicone and counts to the internal layer.
    """
    flank, _ = core_end(profile.large_core)
    wound = profile.thread.between(0.0, flank.end)
    end, radius = flank.end, flank.pieces[-1].y1
    rounding = profile.large_core_end - end

    thread = wound.append_to(csg.Path((0.0, wound(0.0)), ())).line((end, radius))
    thread = flank.append_reversed_to(thread)

    external = outside(profile).line(
        (profile.large_core_end, 0.0), (profile.large_core_end, radius - rounding))
    external = external.quarter((profile.large_core_end, radius), (end, radius))
    external = wound.append_reversed_to(external.line((end, wound.pieces[-1].y1)))

    first = along_core(csg.Path((0.0, flank(0.0)), ()), profile.large_core)
    return (
        Body("external_layer", csg.Revolve(external), SILICONE),
        Body("thread_layer", csg.Revolve(thread), THREAD),
        Body("internal_layer", csg.Revolve(_shell(first, profile.small_core)), CHAMBER),
    )


@dataclass(frozen=True)
class Wound:
    """The thread as it is wound on the large core: points a small, even turn apart."""

    turn: np.ndarray
    x: np.ndarray
    """Along the axis, mm."""
    radius: np.ndarray
    """Of the thread's centre line, mm."""

    @property
    def turns(self) -> float:
        """Whole and parts."""
        return float(self.turn[-1])

    @property
    def length(self) -> float:
        """Of the chords, mm, without tied ends."""
        across = 2 * np.sin(np.pi * self.turn[1])
        steps = (np.diff(self.x) ** 2 + np.diff(self.radius) ** 2
                 + self.radius[1:] * self.radius[:-1] * across**2)
        return float(np.sqrt(steps).sum())


def wound(hand: Hand, name: str) -> Wound:
    """The thread of actuator `name`: a helix of constant pitch.

    On a plain core the thread lies on the surface; in a groove (`thread.groove`) it is sunk by its radius.

    Raises:
        GeometryError: turns would lie on one another, or no length is left to wind on.
    """
    profile, thread = profile_of(hand, name), hand.thread_of(name)
    part, key = f"actuators/{name}", thread_key(hand, name)
    start, end = thread.held_back, profile.large_core_end - thread.held_back
    if end - start < thread.pitch:
        raise GeometryError(
            part, f"{key}.held_back", f"{end - start:.2f} mm are left to wind, less than a turn")
    rounded = profile.large_core_end - core_end(profile.large_core)[0].end
    if thread.held_back < rounded + thread.diameter:
        raise GeometryError(
            part, f"{key}.held_back",
            f"the last turn would slip off the rounded tip: at least {rounded + thread.diameter:.2f} mm")
    if thread.pitch <= thread.diameter:
        raise GeometryError(part, f"{key}.pitch", "neighbouring turns would lie on one another")
    turns = (end - start) / thread.pitch
    turn = np.linspace(0.0, turns, math.ceil(turns * POINTS_PER_TURN) + 1)
    x = start + turn * thread.pitch
    return Wound(turn, x, profile.large_core(x) + (0.0 if thread.groove else thread.diameter / 2))


def thread_path(hand: Hand, name: str) -> np.ndarray:
    """The thread's centre line as wound on the large core: (n, 4) columns x, y, z (mm), turn.

    A right-handed helix that starts on the dorsal side.

    Raises:
        GeometryError: see `wound`.
    """
    w = wound(hand, name)
    around = 2 * np.pi * w.turn
    return np.c_[w.x, -w.radius * np.sin(around), w.radius * np.cos(around), w.turn]


def thread_turns(hand: Hand, name: str) -> float:
    """Number of turns of the thread, whole and parts."""
    return wound(hand, name).turns


def thread_length(hand: Hand, name: str) -> float:
    """Length of the wound thread, mm, without its tied ends."""
    return wound(hand, name).length


def adaptations(hand: Hand) -> list[Adaptation]:
    """Every actuator whose layers leave no room for the small core, and what is cast instead.

    `asked` and `used` hold the layers at the tip and the diameter that they leave for the core
    there (mm); `used` also the x from which the stack is thinned.
    """
    found = []
    for name, given in hand.actuators.present().items():
        profile, asked = profile_of(hand, name), hand.layers_of(name)
        if profile.thinned_from is None:
            continue
        room = asked.core_room(given.tip_outer_diameter)
        share = derive.thinning(given, asked, profile.minimum_core)
        found.append(Adaptation(
            path=f"actuators.{name}.layers",
            asked={"external": asked.external, "thread": asked.thread, "internal": asked.internal,
                   "core_tip_diameter": room},
            used={"external": asked.external * share, "thread": asked.thread * share,
                  "internal": asked.internal * share, "core_tip_diameter": profile.minimum_core,
                  "thinned_from_x": profile.thinned_from},
            reason=(
                f"layers of {asked.stack:g} mm inside a tip of {given.tip_outer_diameter:g} mm leave a small"
                f" core of {room:g} mm; it needs {profile.minimum_core:g} mm"
                " (casting.minimum_core_tip_diameter):"
                f" thinned in proportion from x = {profile.thinned_from:.1f} mm to the tip"),
            source="Table A.2",
        ))
    return found


def refuse_forbidden(hand: Hand, file: str) -> None:
    """Nothing may be made of layers that `adapt: false` forbids to thin; `file` is named in the errors.

    Raises:
        InputError: every such actuator at once.
    """
    problems = []
    for adapted in adaptations(hand):
        path = adapted.path.removesuffix(".layers")
        name = path.removeprefix("actuators.")
        given, core = getattr(hand.actuators, name), adapted.used["core_tip_diameter"]
        if not given.adapt:
            problems.append(Problem(
                file, f"{path}.tip_outer_diameter", given.tip_outer_diameter,
                f"core tip diameter would be {adapted.asked['core_tip_diameter']:g} mm ({name}); "
                "`adapt: false` forbids thinner layers",
                f"at least {core + 2 * hand.layers_of(name).stack:g} mm, or `adapt: true`"))
    if problems:
        raise InputError(problems)
