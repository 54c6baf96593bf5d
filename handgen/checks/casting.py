"""Rules on the casting: cores that come out, halves that open (Sections 4.1.2, 4.2.2).

A core is pulled towards -x, out of silicone that closes around its tip; the halves are opened
along -z and +z. All is measured on the meshes of the tooling in its place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, skipped
from handgen.checks.sections import Outline, Triangles
from handgen.checks.worst import telling
from handgen.geometry.casting import Setup
from handgen.geometry.part import Part
from handgen.parameters.model import Hand

ROUNDING = 1e-6
STATIONS = 24
"""Sections along a core between the silicone's surface and the core's tip."""
SECTORS = 64
"""Directions in which a core's undercut is looked for."""
APEX = 0.3
"""Nearer to the axis than this, mm, there is no flank."""
FLANK = 0.5
"""Faces whose normals point more than this along the pull belong to a tip, not to a flank."""
ROUNDED = 1.0
"""Length of a core's rounded tip at most, mm."""
PIN_HEIGHT = 1.0
"""Height above the split at which pins and holes are compared, mm: where both are cylinders."""

Tooling = Mapping[str, Part]


def setups(hand: Hand, parts: Mapping[str, Part], *roles: str) -> Iterator[tuple[Setup, list[Part]]]:
    """(casting set-up, its parts of `roles`) of every actuator all of whose `roles` are there."""
    for name in hand.actuators.present():
        wanted = [f"tooling/{name}/{role}" for role in roles]
        if all(key in parts for key in wanted):
            yield Setup(hand, name), [parts[key] for key in wanted]


def demould(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Both cores come out of the silicone: no undercut, no widening, nothing torn, nothing broken."""
    rule = "core.demould"
    findings, worst, unknown = [], [], set()
    for setup, (large, small) in setups(hand, parts, "core_large", "core_small"):
        for core in (large, small):
            whole = Triangles.of(core.triangles)
            surface = whole.where(whole.corners[:, :, 0].max(1) > setup.top)
            depth, limit, found = _undercut(setup, core, surface, limits)
            worst.append((depth - limit, depth, limit))
            findings += [*found, *_draft(setup, core, surface, limits)]
            pull = Pull.of(setup, core, surface, limits)
            findings += _broken(setup, core, pull, limits, unknown)
            findings += _torn(setup, core, pull, limits, unknown)
    if not worst:
        return skipped(rule, "no cores")
    besides = "; not judged, no strength known: " + ", ".join(sorted(unknown)) if unknown else ""
    _, depth, limit = max(worst)
    return telling(rule, depth, limit, f"worst undercut of {len(worst)} cores", findings, besides)


def undercut(vertices: np.ndarray, pull: np.ndarray) -> tuple[float, np.ndarray]:
    """(depth mm, where) of the deepest place that a cast around `vertices` hangs behind.

    `vertices` (n, 3) about the axis x; `pull` +1 or -1 along x. In every direction from the axis a
    place hangs as deep as the highest place that must pass over it on its way out is higher.
    """
    radius = np.hypot(vertices[:, 1], vertices[:, 2])
    # Half a 256th of a turn aside, so that corners of circles stay clear of the sectors' borders.
    turn = np.arctan2(vertices[:, 2], vertices[:, 1]) / (2 * np.pi) + 1 / 512
    sector = np.floor(turn % 1.0 * SECTORS).astype(int)
    # Rings of a flat end lie at one x: the narrower one passes first.
    order = np.lexsort((radius, np.round(pull * vertices[:, 0], 4), sector))
    depth, where = 0.0, vertices[0]
    for rows in np.split(order, np.flatnonzero(np.diff(sector[order])) + 1):
        hangs = np.maximum.accumulate(radius[rows]) - radius[rows]
        at = int(np.argmax(hangs))
        if hangs[at] > depth:
            depth, where = float(hangs[at]), vertices[rows[at]]
    return depth, where


def _undercut(setup: Setup, core: Part, surface: Triangles,
              limits: Limits) -> tuple[float, float, list[Finding]]:
    """(depth, its limit, the finding if it is deeper), mm."""
    limit = limits.get("core.demould", "undercut", core.role)
    points = surface.vertices
    flank = points[(points[:, 0] >= -ROUNDING) & (np.hypot(points[:, 1], points[:, 2]) > APEX)]
    depth, where = undercut(flank, -1)
    if depth <= limit.value + ROUNDING:
        return depth, limit.value, []
    fix = (f"wind without a groove ({setup.path}.thread.groove: false) or take a thinner thread"
           if core.role == "core_large" and setup.thread.groove
           else f"let {setup.path} narrow towards its tip everywhere")
    return depth, limit.value, [Finding(
        "core.demould", "error", core.name, depth, limit.value, limit.unit,
        f"the cast hangs {depth:.2f} mm behind the core", fix, limit.source, tuple(where.tolist()))]


def draft(surface: Triangles) -> float:
    """Mean slope of a core's flank beyond the actuator's base, deg; above 0: it narrows to its tip."""
    start, end = 0.0, surface.vertices[:, 0].max() - ROUNDED
    along, normal = surface.corners[:, :, 0], surface.normals[:, 0]
    flank = ((surface.centres[:, 0] > start) & (along.min(1) < end - ROUNDING) & (np.abs(normal) < FLANK)
             & (np.hypot(surface.centres[:, 1], surface.centres[:, 2]) > APEX))
    areas = surface.areas[flank]
    return float(np.degrees((np.arcsin(normal[flank]) * areas).sum() / areas.sum()))


def _draft(setup: Setup, core: Part, surface: Triangles, limits: Limits) -> list[Finding]:
    limit, slope = limits.get("core.demould", "draft", core.role), draft(surface)
    if slope >= limit.value - 1e-3:
        return []
    return [Finding(
        "core.demould", "error", core.name, slope, limit.value, limit.unit,
        f"the flank narrows by {slope:.2f} deg only", f"lower {setup.path}.tip_outer_diameter",
        limit.source, (setup.length / 2, 0.0, 0.0))]


@dataclass(frozen=True)
class Pull:
    """What it takes to pull a core: at every station x (mm) the force (N) that holds beyond it.

    The silicone lets go everywhere at once (an upper bound), and no air gets behind the tip.
    """

    x: np.ndarray
    sections: list[Outline]
    force: np.ndarray

    @classmethod
    def of(cls, setup: Setup, core: Part, surface: Triangles, limits: Limits) -> Pull:
        stress = limits.get("core.demould", "release_stress", core.material, setup.casting.silicone.name)
        suction = limits.get("core.demould", "suction")
        end = float(surface.vertices[:, 0].max())
        edges = np.linspace(setup.top, end, STATIONS + 1)
        x = (edges[:-1] + edges[1:]) / 2
        sections = [surface.section(0, float(at)) for at in x]
        wetted = np.array([cut.lengths.sum() for cut in sections]) * np.diff(edges)
        # With a salience the tip stands in the mould's floor: air comes in there.
        tip = 0.0 if setup.salience else suction.value * sections[-1].area
        beyond = np.cumsum((stress.value * wetted)[::-1])[::-1]
        return cls(x, sections, beyond + tip)

    @property
    def total(self) -> float:
        return float(self.force[0])


def _broken(setup: Setup, core: Part, pull: Pull, limits: Limits, unknown: set[str]) -> list[Finding]:
    """Tension and, pulled a little askew, bending against the core's strength across its layers."""
    strength = limits.find("core.demould", "core_strength", core.material)
    if strength is None:
        unknown.add(core.material)
        return []
    safety, offset = (limits.get("core.demould", n).value for n in ("core_safety", "pull_offset"))
    stresses = np.array([
        force * (1 / cut.area + offset * np.ptp(cut.start[:, 1]) / 2 / cut.second_moment(1))
        for force, cut in zip(pull.force, pull.sections, strict=True)])
    at = int(np.argmax(stresses))
    allowed = strength.value / safety
    if stresses[at] <= allowed + ROUNDING:
        return []
    return [Finding(
        "core.demould", "error", core.name, float(stresses[at]), allowed, "MPa",
        f"pulled with {pull.total:.1f} N, {offset:g} mm beside its axis, the core may break here",
        f"widen {setup.path}.tip_outer_diameter or casting.minimum_core_tip_diameter",
        strength.source, (float(pull.x[at]), 0.0, 0.0))]


def _torn(setup: Setup, core: Part, pull: Pull, limits: Limits, unknown: set[str]) -> list[Finding]:
    """The pull against the force that would carry a nick in the thinnest wall on."""
    silicone = setup.casting.silicone.name
    tear = limits.find("core.demould", "tear_strength", silicone)
    if tear is None:
        unknown.add(silicone)
        return []
    within = [(float(x), float(setup.profile.outer(x)) - cut.radii().max())
              for x, cut in zip(pull.x, pull.sections, strict=True) if x > 0.0]
    x, wall = min(within, key=lambda place: place[1])
    share = limits.get("core.demould", "tear_share")
    ratio = pull.total / (tear.value * wall)
    if ratio <= share.value + ROUNDING:
        return []
    return [Finding(
        "core.demould", "error", core.name, ratio, share.value, share.unit,
        f"the pull of {pull.total:.1f} N would carry a nick on through the {wall:.2f} mm of silicone here",
        f"thicken {setup.path}.layers or `layers`, or let air in at the tip", tear.source, (x, 0.0, 0.0))]


def split(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Both halves come off the cast along z, meet in the split plane, and their pins fit."""
    rule = "mould.split"
    limit = limits.get(rule, "undercut")
    findings, worst, moulds = [], 0.0, 0
    for setup, (a, b) in setups(hand, parts, "mould_a", "mould_b"):
        moulds += 1
        lower, upper = Triangles.of(a.triangles), Triangles.of(b.triangles)
        for half, surface, opens in ((a, lower, -1.0), (b, upper, 1.0)):
            depth, where = behind(surface, setup, opens)
            worst = max(worst, depth)
            if depth > limit.value + ROUNDING:
                message = f"{depth:.2f} mm of it reach behind the cast"
                findings.append(_faulty(half, depth, limit, message, where))
        gap = _face(upper, -1.0) - _face(lower, 1.0)
        most = limits.get(rule, "gap")
        if abs(gap) > most.value + ROUNDING:
            findings.append(_faulty(b, gap, most, f"it lies {gap:.2f} mm off the other half",
                                    (setup.length / 2, setup.base, 0.0)))
        findings += _pins(setup, b, lower, upper, limits)
    if not moulds:
        return skipped(rule, "no moulds")
    return telling(rule, worst, limit.value, f"deepest undercut of {moulds} moulds", findings)


def behind(surface: Triangles, setup: Setup, opens: float) -> tuple[float, tuple[float, float, float]]:
    """(depth mm, where) by which a half's cavity reaches behind the cast, opening along `opens` z.

    A face that looks the way its half must go hooks the cast; the depth is how far such faces
    reach across, side by side within a length of two millimetres.
    """
    rims = np.hypot(surface.corners[:, :, 1], surface.corners[:, :, 2]).max(1)
    cavity = rims < setup.cup + 0.25 * (setup.half_width - setup.cup)
    hooked = np.flatnonzero(cavity & (surface.normals[:, 2] * opens > 1e-4))
    if not len(hooked):
        return 0.0, (0.0, 0.0, 0.0)
    corners, centres = surface.corners[hooked], surface.centres[hooked]
    _, places = np.unique(
        np.c_[np.floor(centres[:, 0] / 2.0), np.sign(centres[:, 1])], axis=0, return_inverse=True)
    depths = [np.ptp(corners[places == p, :, 1]) for p in range(places.max() + 1)]
    at = int(np.argmax(depths))
    return float(depths[at]), tuple(centres[places == at].mean(0).tolist())


def _faulty(half: Part, measured: float, limit: Limit, message: str, where) -> Finding:
    """A fault that no parameter can cause: the geometry itself is wrong."""
    return Finding("mould.split", "error", half.name, measured, limit.value, limit.unit, message,
                   "report it with the parameter file: no parameters may make such a mould",
                   limit.source, where)


def _face(surface: Triangles, up: float) -> float:
    """Height z of a half's face in the split: the largest plane that faces `up` along z."""
    flat = surface.normals[:, 2] * up > 0.9999
    levels, of = np.unique(np.round(surface.centres[flat, 2], 4), return_inverse=True)
    return float(levels[np.argmax(np.bincount(of, surface.areas[flat]))])


def _pins(setup: Setup, b: Part, lower: Triangles, upper: Triangles, limits: Limits) -> list[Finding]:
    """Every pin of a finds a hole of b around it, with the room that a print needs and no more."""
    least, most = (limits.get("mould.split", f"{n}_pin_clearance", b.material) for n in ("least", "most"))
    findings = []
    for room, where in pin_rooms(lower.section(2, PIN_HEIGHT), upper.section(2, PIN_HEIGHT)):
        if least.value - ROUNDING <= room <= most.value + ROUNDING:
            continue
        limit = least if room < least.value else most
        fits = f"has {room:.2f} mm of room in its hole" if room > 0 else "does not fit into its hole"
        findings.append(Finding(
            "mould.split", "error", b.name, room, limit.value, limit.unit, f"a pin {fits}",
            f"{'raise' if room < least.value else 'lower'} casting.mould_fit", limit.source,
            (*where, PIN_HEIGHT)))
    return findings


def pin_rooms(pins: Outline, block: Outline) -> list[tuple[float, tuple[float, float]]]:
    """(radial room mm, (x, y)) of every loop of `pins` within the holes of `block`; below 0: none."""
    rooms = []
    for centre, radius in _circles(pins):
        hole = block.where(np.linalg.norm(block.middle - centre, axis=1) < 2.0 * radius)
        # Material that is not a hole around the pin lies on it.
        room = float(hole.facing(False, centre).radii(centre).min()) - radius if len(hole) else -radius
        rooms.append((room, tuple(centre.tolist())))
    return rooms


def _circles(pins: Outline) -> list[tuple[np.ndarray, float]]:
    """(centre, largest radius) of the separate loops of a section."""
    from scipy.cluster.hierarchy import fcluster, linkage

    if not len(pins):
        return []
    groups = fcluster(linkage(pins.middle, "single"), 1.0, "distance")
    loops = [pins.where(groups == g) for g in np.unique(groups)]
    return [(loop.centroid, float(loop.radii(loop.centroid).max())) for loop in loops]
