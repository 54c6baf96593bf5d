"""Rules on the thread: does it fit its layer, and are its turns neither too far apart nor too near."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from handgen.checks import actuators
from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.geometry.actuator import profile_of, thread_key, wound
from handgen.geometry.part import Part
from handgen.geometry.profile import ActuatorProfile
from handgen.materials.library import library
from handgen.mechanics import bulge
from handgen.mechanics.silicone import shear_modulus
from handgen.parameters.finger import Thread
from handgen.parameters.model import FINGERS, Hand

ROUNDING = 1e-6
KPA = 1e-3
"""MPa in a kPa."""
STATIONS = 33
"""Places along a winding at which its layers are read; the taper is smooth."""


@dataclass(frozen=True)
class Winding:
    """One actuator's thread on the large core, from its first turn to its last."""

    name: str
    thread: Thread
    profile: ActuatorProfile

    @property
    def gap(self) -> float:
        """Free distance of neighbouring turns along the axis, mm; below 0 they lie on one another."""
        return self.thread.pitch - self.thread.diameter

    @property
    def stations(self) -> np.ndarray:
        held = self.thread.held_back
        return np.linspace(held, max(held, self.profile.large_core_end - held), STATIONS)

    @property
    def sunk(self) -> float:
        """How much of the thread's diameter lies inside the core's own surface, mm."""
        return self.thread.diameter / 2 if self.thread.groove else 0.0

    def spot(self, x: float) -> tuple[float, float, float]:
        """The dorsal point of the core's surface at `x`, actuator's frame, mm."""
        return float(x), 0.0, float(self.profile.large_core(x))


def layer(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """The thread must fit between the large core and the external layer.

    Measured is the room left beside it, radially, where that is least. A thread thinner than its
    layer lies on the core, not in the middle of the room drawn for it: the pressure then pushes on
    the smaller circle, and the silicone outside it is thicker by the slack. That is said, and
    judged only beyond `most_slack`.

    Raises:
        GeometryError: an actuator without wall or chamber.
    """
    rule, most = "thread.layer", limits.get("thread.layer", "most_slack")
    findings, slacks, windings = [], [], _windings(hand, parts)
    if not windings:
        return skipped(rule, "no actuator in this build")
    for w in windings:
        x = w.stations
        slack = w.profile.thread(x) - w.profile.large_core(x) - (w.thread.diameter - w.sunk)
        least = int(np.argmin(slack))
        slacks.append(float(slack[least]))
        if slacks[-1] < -ROUNDING:
            findings.append(_too_thick(w, float(x[least]), slacks[-1], hand))
        elif (widest := float(slack.max())) > ROUNDING:
            findings.append(_loose(w, widest, float(x[int(np.argmax(slack))]), most))
    return judged(rule, min(slacks), 0.0, "room left beside the thread where it is tightest", findings)


def _too_thick(w: Winding, x: float, slack: float, hand: Hand) -> Finding:
    room = slack + w.thread.diameter - w.sunk
    return Finding(
        "thread.layer", "error", f"actuators/{w.name}", slack, 0.0, "mm",
        f"a thread of {w.thread.diameter:g} mm stands {-slack:.2f} mm out of the {room:.2f} mm drawn for it",
        f"use a thread of {math.floor(100 * room + 1e-9) / 100:g} mm, or make layers.thread "
        f"{-slack:.2f} mm thicker at x = {x:.0f} mm", f"{thread_key(hand, w.name)}; Table A.2, note 3",
        w.spot(x))


def _loose(w: Winding, slack: float, x: float, most: Limit) -> Finding:
    drawn = slack + w.thread.diameter - w.sunk
    core = float(w.profile.large_core(x))
    lies, middle = core + w.thread.diameter / 2 - w.sunk, core + drawn / 2
    too_much = slack > most.value + ROUNDING
    return Finding(
        "thread.layer", "warning" if too_much else "info", f"actuators/{w.name}", slack, most.value, "mm",
        f"a thread of {w.thread.diameter:g} mm in {drawn:.2f} mm lies on the core at radius {lies:.2f} mm,"
        f" not mid-layer: the pressure pushes on {100 * (1 - (lies / middle) ** 2):.0f} % less area",
        f"draw layers.thread {w.thread.diameter:g} mm thick", most.source, w.spot(x))


def gap(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """The turns must hold the wall between them, let silicone in, and stay where they are wound.

    Too wide a gap lets the inner layer balloon at working pressure (`handgen.mechanics.bulge`); it is an
    error where the actuator is free, at the joints and between its sockets, and only said where a
    closed bore holds it. Too narrow a gap keeps silicone out and bubbles in. A turn slides down a
    taper steeper than its friction, and gives way where it is too thin for the pressure over its pitch.
    Turns and length are in the reason.

    Raises:
        GeometryError: an actuator without wall or chamber, or no length to wind on.
    """
    rule = "thread.gap"
    findings, tightest, windings = [], (-math.inf, 0.0, 0.0), _windings(hand, parts)
    if not windings:
        return skipped(rule, "no actuator in this build")
    for w, places in zip(windings, _places(hand, windings, limits), strict=True):
        tightest = max(tightest, *_ballooning(hand, w, places, limits, findings))
        _narrow(hand, w, limits, findings)
        _sliding(w, limits, findings)
        _giving(hand, w, limits, findings)
    # What is broken comes first; else the place that is nearest to ballooning.
    broken = next((f for f in findings if f.severity == "error" and f.unit == "mm"), None)
    measured, limit = (broken.measured, broken.limit) if broken else tightest[1:]
    return judged(rule, measured, limit, _counted(hand, windings), findings)


@dataclass(frozen=True)
class Places:
    """Places along a winding, their wall, and the widest gap over which it holds, mm."""

    x: np.ndarray
    wall: bulge.Wall
    widest: np.ndarray


def _places(hand: Hand, windings: list[Winding], limits: Limits) -> Iterator[Places]:
    """Of every winding; their gaps are found all at once."""
    silicone = hand.casting.silicone
    mu = shear_modulus(silicone.modulus_100)
    pressure = limits.get("thread.gap", "working_pressure", silicone.name).value * KPA
    along = [_stations(hand, w) for w in windings]
    radii = [np.stack([w.profile.small_core(x), w.profile.large_core(x), w.profile.outer(x)])
             for w, x in zip(windings, along, strict=True)]
    widest = bulge.Wall(*np.concatenate(radii, 1), mu).widest_gap(pressure)
    ends = np.cumsum([len(x) for x in along])[:-1]
    for x, rows, gaps in zip(along, radii, np.split(widest, ends), strict=True):
        yield Places(x, bulge.Wall(*rows, mu), gaps)


def _ballooning(hand: Hand, w: Winding, places: Places, limits: Limits, findings: list[Finding]
                ) -> Iterator[tuple[float, float, float]]:
    """(gap over limit, gap, limit), mm, where the wall is free; adds what balloons to `findings`."""
    silicone = hand.casting.silicone
    pressure = limits.get("thread.gap", "working_pressure", silicone.name)
    free = _free(hand, w.name, places.x)
    for chosen, severity in ((free, "error"), (~free, "info")):
        if not chosen.any():
            continue
        at = int(np.argmin(np.where(chosen, places.widest, math.inf)))
        limit = float(places.widest[at])
        if severity == "error":
            yield w.gap / limit, w.gap, limit
        if w.gap > limit + ROUNDING:
            least = limits.get("thread.gap", "least_gap", silicone.name)
            findings.append(_balloons(w, severity, limit, float(places.x[at]), places.wall.at(at), pressure,
                                      least))


def _balloons(w: Winding, severity: str, limit: float, x: float, wall: bulge.Wall, pressure: Limit,
              least: Limit) -> Finding:
    angle = wall.half_angle(pressure.value * KPA, w.gap)
    how = (f"bulges {bulge.height(angle, w.gap):.2f} mm, stretched {bulge.stretch(angle):.1f} times"
           if math.isfinite(angle) else "balloons without end")
    held = " unless the closed bore holds it" if severity == "info" else ""
    return Finding(
        "thread.gap", severity, f"actuators/{w.name}", w.gap, limit, "mm",
        f"at {pressure.value:g} kPa the inner layer of {wall.thread - wall.inside:.2f} mm {how}"
        f" between turns {w.gap:.2f} mm apart{held}", _closer(w, limit, least),
        f"half circle between two rings (handgen.mechanics.bulge); {pressure.source}", w.spot(x))


def _closer(w: Winding, limit: float, least: Limit) -> str:
    """The mend for a wall that balloons: a pitch if there is one at which silicone still flows."""
    thicken = f"thicken layers.internal or widen actuators.{w.name}.tip_outer_diameter"
    pitch = math.floor(100 * (limit + w.thread.diameter)) / 100
    if pitch < least.value + w.thread.diameter - ROUNDING:
        return (f"{thicken}: turns near enough, at {pitch:g} mm, would lie less than {least.value:g} mm apart"
                " and keep the silicone out")
    return f"wind at a pitch of {pitch:g} mm or less (actuators.{w.name}.thread.pitch), or {thicken}"


def _stations(hand: Hand, w: Winding) -> np.ndarray:
    """The winding's stations and the edges of the slots that it passes, where layers may be thinnest."""
    x = w.stations
    edges = [e for start, end in _slots(hand, w.name) for e in (start, end) if x[0] < e < x[-1]]
    return np.union1d(x, edges)


def _free(hand: Hand, name: str, x: np.ndarray) -> np.ndarray:
    """Where actuator `name` has no closed bore around it: in the slots, or all along without a finger."""
    slots = _slots(hand, name)
    if not slots:
        return np.ones(len(x), bool)
    return np.any([(start <= x) & (x <= end) for start, end in slots], axis=0)


def _slots(hand: Hand, name: str) -> list[tuple[float, float]]:
    finger = getattr(hand.fingers, name) if name in FINGERS else None
    if finger is None:
        return []
    return [(j.position - j.slot_length / 2, j.position + j.slot_length / 2) for j in finger.joints]


def _narrow(hand: Hand, w: Winding, limits: Limits, findings: list[Finding]) -> None:
    least = limits.get("thread.gap", "least_gap", hand.casting.silicone.name)
    if w.gap < least.value - ROUNDING:
        what = "lie on one another" if w.gap <= 0 else f"are {w.gap:.2f} mm apart: silicone fills that badly"
        findings.append(Finding(
            "thread.gap", "error", f"actuators/{w.name}", w.gap, least.value, "mm",
            f"neighbouring turns {what}",
            f"wind at a pitch of {least.value + w.thread.diameter:g} mm or more", least.source,
            w.spot(w.stations[STATIONS // 2])))


def _sliding(w: Winding, limits: Limits, findings: list[Finding]) -> None:
    friction = limits.get("thread.gap", "friction")
    slopes = [abs(w.profile.large_core.slope(float(x))) for x in w.stations]
    steepest = int(np.argmax(slopes))
    if not w.thread.groove and slopes[steepest] > friction.value + ROUNDING:
        findings.append(Finding(
            "thread.gap", "error", f"actuators/{w.name}", slopes[steepest], friction.value, "1",
            f"turns slide towards the tip: the core falls {slopes[steepest]:.2f} mm a millimetre",
            "cut the thread's groove into the core (thread.groove) or taper the actuator less",
            friction.source, w.spot(w.stations[steepest])))


def _giving(hand: Hand, w: Winding, limits: Limits, findings: list[Finding]) -> None:
    """A turn of radius r holds the tension p r pitch.

    What the silicone bears is left out, and that turns move apart as the actuator grows longer; against
    elements that comes to within 15 % (see the tests).
    """
    thread, where = w.thread, f"actuators/{w.name}"
    pressure = limits.get("thread.gap", "working_pressure", hand.casting.silicone.name).value
    most = limits.get("thread.gap", "most_stretch", thread.material)
    x = _stations(hand, w)
    radii = w.profile.large_core(x) + thread.diameter / 2 - w.sunk
    widest = int(np.argmax(radii))
    tension = pressure * KPA * float(radii[widest]) * thread.pitch
    known = library().materials.get(thread.material)
    if known is None or known.elastic is None:
        findings.append(Finding(
            "thread.gap", "info", where, tension, None, "N",
            f"at {pressure:g} kPa a turn carries {tension:.2f} N; how far it stretches is not judged: no"
            f" modulus of {thread.material} is known", "name a thread of PET", most.source,
            w.spot(x[widest])))
        return
    stretch = tension / (known.elastic.young_mpa * math.pi / 4 * thread.diameter**2)
    if stretch > most.value + ROUNDING:
        thicker = math.ceil(100 * thread.diameter * math.sqrt(stretch / most.value)) / 100
        findings.append(Finding(
            "thread.gap", "error", where, stretch, most.value, "1",
            f"at {pressure:g} kPa a turn of {thread.diameter:g} mm carries {tension:.2f} N and stretches by"
            f" {100 * stretch:.0f} %: it holds no wall",
            f"use a thread of {thicker:g} mm ({thread_key(hand, w.name)}), or wind closer", most.source,
            w.spot(x[widest])))


def _counted(hand: Hand, windings: list[Winding]) -> str:
    counted = []
    for w in windings:
        if w.gap <= 0:
            counted.append(f"{w.name}: none")
            continue
        thread = wound(hand, w.name)
        counted.append(f"{w.name} {thread.turns:.1f} turns, {thread.length / 1000:.2f} m")
    return "; ".join(counted)


def _windings(hand: Hand, parts: Mapping[str, Part]) -> list[Winding]:
    return [Winding(n, hand.thread_of(n), profile_of(hand, n)) for n in actuators.present(hand, parts)]
