"""Rules on parts that go into one another: cores hung in a mould, seals in an actuator's base.

Radii, centres and lengths are measured on the meshes; only the air tube comes from the
definition.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handgen.checks.casting import setups
from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.checks.sections import Outline, Triangles
from handgen.checks.worst import telling
from handgen.geometry.actuator import layers_path
from handgen.geometry.casting import LAND, Setup
from handgen.geometry.palm import Hole, facing, seat
from handgen.geometry.part import Part
from handgen.geometry.seals import bore_radius
from handgen.geometry.thumb import Hinge
from handgen.parameters.model import OPPOSITION, Hand

ROUNDING = 1e-6
STATIONS = 6
"""Places along an actuator where a core's eccentricity is measured."""
HANGING = ("mould_a", "mould_b", "mould_base", "suspender", "core_large", "core_small")
SEALS = ("plug", "collar")


@dataclass(frozen=True)
class Play:
    """How far a core's axis can stray in its set-up, mm: sideways at the hub and as it leans.

    A flange that is held down on the hub leans by its own flatness only (`lean`, rad), one that is
    not by all that the shank has in the hub (`loose`). `middle` is the hub's, on x; a salience at
    `foot` holds the tip within `foot_play`.
    """

    shank: float
    mould: float
    lean: float
    loose: float
    middle: float
    foot: float | None
    foot_play: float

    def loose_at(self, x: float) -> float:
        """The same with nothing that holds the flange down."""
        return self.mould + self.loose * (x - self.middle)

    def at(self, x: float) -> float:
        """Worst distance of the core's axis from the hub's, mm, at x."""
        hung = self.shank + self.mould + self.lean * (x - self.middle)
        if self.foot is None:
            return hung
        top, share = self.shank + self.mould, (x - self.middle) / (self.foot - self.middle)
        return min(hung, top + (self.foot_play - top) * share)


def centring(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Hung as badly as its fits let it, a core still leaves silicone all round.

    Eccentricity at x is the distance of the core's and the cavity's centres as drawn (0 unless the
    geometry is wrong), plus the shank's play in the hub, the suspender's on the mould, and the lean
    of a flange that does not lie flat, with the lever from the hub to x.
    """
    rule = "suspender.centring"
    least = limits.get(rule, "least_layer")
    findings, thinnest, loosest = [], (float("inf"), ""), None
    for setup, (a, b, base, cap, *cores) in setups(hand, parts, *HANGING):
        *mould, foot, hub = (Triangles.of(p.triangles) for p in (a, b, base, cap))
        for core in cores:
            surface = Triangles.of(core.triangles)
            play = _play(setup, mould, hub, foot, surface, limits)
            left, stray, x = min(_layers_left(setup, mould, surface, core.role, play))
            thinnest = min(thinnest, (left, f"{core.name}, which may stray by {stray:.2f} mm at x = {x:.0f}"))
            if left < least.value - ROUNDING:
                findings.append(_astray(setup, core, left, stray, x, least))
            if play.foot is None and (loosest is None or play.loose_at(x) > loosest.measured):
                loosest = _loose(core, play.loose_at(x), x)
    if not thinnest[1]:
        return skipped(rule, "no moulds")
    reason = f"thinnest layer around {thinnest[1]}"
    if loosest:
        reason += f"; flanges held down, else {loosest.part} could lean by {loosest.measured:.1f} mm"
        findings.append(loosest)
    return judged(rule, thinnest[0], least.value, reason, findings)


def _layers_left(setup: Setup, mould: list[Triangles], core: Triangles, role: str,
                 play: Play) -> list[tuple[float, float, float]]:
    """(silicone left on the thin side mm, eccentricity mm, x) along the core.

    Around the large core that is all up to the mould; around the small one what is poured inside
    the first layer, which lies in the mould as cast.
    """
    end = float(core.vertices[:, 0].max()) if not setup.salience else setup.profile.casting_core.end
    result = []
    for x in np.linspace(0.02 * end, end - 1.5, STATIONS):
        centre, radius = core.section(0, float(x)).circle()
        cavity, wide = _cavity(setup, mould, float(x))
        outside = wide if role == "core_large" else float(setup.profile.large_core(float(x)))
        stray = float(np.linalg.norm(centre - cavity)) + play.at(float(x))
        result.append((outside - radius - stray, stray, float(x)))
    return result


def _cavity(setup: Setup, mould: list[Triangles], x: float) -> tuple[np.ndarray, float]:
    """(centre, radius) of the closed mould's cavity at x, in (y, z)."""
    cuts = [half.section(0, x) for half in mould]
    both = Outline(np.vstack([c.start for c in cuts]), np.vstack([c.end for c in cuts]))
    # The holes of the pins lie at least LAND outside the cavity.
    return both.where(_farthest(both) < setup.base + LAND / 2).facing(False).circle()


def _play(setup: Setup, mould: list[Triangles], cap: Triangles, base: Triangles, core: Triangles,
          limits: Limits) -> Play:
    middle = (setup.seat + setup.top) / 2
    shank = _shank(core.section(0, middle))
    hub = cap.section(0, middle).facing(False)
    bore = hub.where(_farthest(hub) < setup.hub).radii().min()
    clearance = max(0.0, float(bore) - shank)
    # The skirt's inside against the halves' outside, halfway down the skirt.
    down = setup.top + setup.skirt / 2
    room = (_half_width(cap.section(0, down), inside=True)
            - _half_width(mould[0].section(0, down), inside=False))
    flange = core.section(0, setup.seat - ROUNDING * 1e3).radii().max()
    contact = 2.0 * min(float(flange), setup.hub)
    loose = 2.0 * clearance / (setup.top - setup.seat)
    lean = min(limits.get("suspender.centring", "seat_error").value / contact, loose)
    foot, foot_play = None, 0.0
    if setup.salience:
        foot = setup.length + 0.5
        hole = base.section(0, foot).facing(False)
        hole = hole.where(_farthest(hole) < 2 * setup.salience + 1.0)
        around = _half_width(base.section(0, setup.length - 1.0), inside=True)
        foot_play = (float(hole.radii().min() - core.section(0, foot).radii().max())
                     + around - _half_width(mould[0].section(0, setup.length - 2.0), inside=False))
    return Play(clearance, float(room), float(lean), float(loose), middle, foot, foot_play)


def _shank(cut: Outline) -> float:
    """Radius of a round section about its own centre, whatever slots are cut into it."""
    points = np.vstack([cut.start, cut.end])
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    far = cut.radii(centre).reshape(2, -1).min(axis=0)
    return float(cut.where(far > far.max() - 0.1).circle()[1])


def _farthest(cut: Outline) -> np.ndarray:
    """Larger distance of either end of every piece from the axis."""
    return cut.radii().reshape(2, -1).max(axis=0)


def _half_width(cut: Outline, *, inside: bool) -> float:
    """Largest |y| of the pieces that look straight along y: inwards (a cap) or outwards (a block)."""
    towards = cut.outward[:, 0] * np.sign(cut.middle[:, 0])
    straight = cut.where(towards < -0.999 if inside else towards > 0.999)
    return float(np.abs(straight.middle[:, 0]).max())


def _astray(setup: Setup, core: Part, left: float, stray: float, x: float, limit: Limit) -> Finding:
    return Finding(
        "suspender.centring", "error", core.name, left, limit.value, limit.unit,
        f"the core may stray by {stray:.2f} mm here, which leaves {left:.2f} mm of silicone on one side",
        f"tighten casting.core_fit or casting.mould_fit, or widen {setup.path}.tip_outer_diameter",
        limit.source, (x, 0.0, 0.0))


def _loose(core: Part, stray: float, x: float) -> Finding:
    return Finding(
        "suspender.centring", "info", core.name, stray, None, "mm",
        f"with its flange not held down, this core could lean by {stray:.1f} mm at its tip",
        "hold the knobs down while the silicone sets: a rubber band over the suspender",
        "lever arm of the shank's play in the hub", (x, 0.0, 0.0))


def seal(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """The plug seats in its channel, the tube in the plug, the collar on it and in its bore."""
    rule = "seal.fit"
    findings, tightest = [], None
    sockets = Sockets(hand, parts)
    for setup, (plug, collar) in setups(hand, parts, *SEALS):
        actuator = parts.get(f"actuators/{setup.name}")
        if actuator is None:
            continue
        fits = list(_fits(setup, plug, collar, actuator, sockets.radius(setup), limits))
        findings += [fit.finding(rule) for fit in fits if not fit.good]
        squeeze = fits[0]
        tightest = min(tightest or squeeze, squeeze, key=lambda fit: fit.measured)
    if tightest is None:
        return skipped(rule, "no seals")
    return telling(rule, tightest.measured, tightest.least.value, "least squeeze of a plug in its channel",
                   findings)


@dataclass(frozen=True)
class Fit:
    """One fit: what was measured, between which limits it must lie, and what to change."""

    part: str
    what: str
    measured: float
    least: Limit
    most: Limit
    fix: str
    where: tuple[float, float, float]

    @property
    def good(self) -> bool:
        return self.least.value - ROUNDING <= self.measured <= self.most.value + ROUNDING

    def finding(self, rule: str) -> Finding:
        low = self.measured < self.least.value
        limit = self.least if low else self.most
        return Finding(rule, "error", self.part, self.measured, limit.value, limit.unit,
                       f"{self.what} is too {'small' if low else 'large'}:"
                       f" {round(self.measured, 2) + 0.0:.2f} {limit.unit}".removesuffix(" 1"),
                       self.fix, limit.source, self.where)


def _fits(setup: Setup, plug: Part, collar: Part, actuator: Part, bore: float, limits: Limits):
    """All fits of one actuator's seal, the plug's squeeze first."""
    shank, ring, inner = (Triangles.of(p.triangles) for p in (plug, collar, actuator))
    zero, free = Limit(0.0, "mm", "parts cannot overlap"), Limit(float("inf"), "mm", "")
    at = setup.seal.plug_length / 2
    channel, outside = _radius(inner, at, False), _radius(shank, at, True)
    place, squeeze = (at, 0.0, outside), outside - channel
    wide = _limit(limits, "most_stretch")
    yield Fit(plug.name, "its squeeze in the channel", squeeze, _limit(limits, "least_squeeze"), free,
              "raise seal.plug_squeeze", place)
    yield Fit(plug.name, "the stretch of the channel around it", squeeze / channel,
              Limit(-float("inf"), "1", ""), wide, "lower seal.plug_squeeze", place)
    hole = _radius(shank, at, False)
    yield Fit(plug.name, "the room of the tube in it", hole - setup.seal.tube_outer_diameter / 2, zero,
              _limit(limits, "most_tube_clearance"), "change seal.tube_fit", (at, 0.0, hole))
    narrow = setup.seal.plug_length - 1.0
    wall = _radius(shank, narrow, True) - _radius(shank, narrow, False)
    yield Fit(plug.name, "its wall around the tube", wall, _limit(limits, "least_plug_wall"), free,
              f"take a thinner seal.tube_outer_diameter, or thinner {layers_path(setup.hand, setup.name)}",
              (narrow, 0.0, hole))
    behind = -setup.seal.collar_length / 2
    neck, eye = _radius(shank, behind, True), _radius(ring, behind, False)
    yield Fit(collar.name, "its glue gap to the plug", eye - neck, _limit(limits, "least_glue_gap"),
              _limit(limits, "most_glue_gap"), "change seal.glue_gap", (behind, 0.0, eye))
    rim = _radius(ring, behind, True)
    press = _limit(limits, "most_collar_press")
    yield Fit(collar.name, "its room in the bore", bore - rim, Limit(-press.value, press.unit, press.source),
              _limit(limits, "most_collar_clearance"), "change seal.collar_fit", (behind, 0.0, rim))


def _limit(limits: Limits, name: str) -> Limit:
    return limits.get("seal.fit", name)


class Sockets:
    """What the collars sit in: seats in the hand where it is among the parts, else the bores."""

    def __init__(self, hand: Hand, parts: Mapping[str, Part]):
        self.hand, self.parts = hand, parts

    @cached_property
    def palm(self) -> Triangles | None:
        """The hand's mesh, a left one mirrored, as all frames are those of a right hand."""
        part = self.parts.get("exoskeleton/hand")
        if part is None:
            return None
        surface = Triangles.of(part.triangles)
        if self.hand.side == "right":
            return surface
        return Triangles(surface.vertices * (1.0, -1.0, 1.0), surface.faces[:, ::-1])

    def radius(self, setup: Setup) -> float:
        """Radius of the socket, mm, in the middle of the collar; of a finger alone, at its root."""
        if self.palm is not None:
            return self._in_palm(setup)
        finger = self.parts.get(f"exoskeleton/{setup.name}")
        return bore_radius(setup) if finger is None else _radius(Triangles.of(finger.triangles), 0.5, False)

    def _in_palm(self, setup: Setup) -> float:
        hole = self._seat(setup.name)
        heading = np.subtract(hole.end, hole.start) / math.dist(hole.start, hole.end)
        cut = self.palm.seen_from(facing(heading), hole.start).section(0, setup.seal.collar_length / 2)
        inside = cut.facing(False)
        return float(inside.where(_farthest(inside) < 1.3 * hole.radius).radii().mean())

    def _seat(self, name: str) -> Hole:
        if name not in OPPOSITION:
            return seat(self.hand, name, self.hand.seal.collar_length)
        return next(h for h in Hinge(self.hand).bases() if h.name == f"{name} base")


def _radius(surface: Triangles, x: float, outwards: bool) -> float:
    """Mean radius of a round part's outside, or of its hole, at x."""
    return float(surface.section(0, x).facing(outwards).radii().mean())
