"""Rules on walls, measured on the meshes that are printed and cast."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np

from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.checks.voids import FIT, STEP, Region, Void, alone, regions, voids
from handgen.geometry.palm import PART as HAND
from handgen.geometry.part import Part
from handgen.geometry.thickness import PARALLEL, ROUNDING, Readings, Spot, gauge_of
from handgen.parameters.model import Hand

CAST = "actuator"
"""Role of parts that are cast, not printed."""
KEYS = {"plug": "seal.tube_outer_diameter or seal.plug_squeeze", "collar": "seal.collar_fit or seal.glue_gap",
        "mould_a": "casting.mould_wall", "mould_b": "casting.mould_wall"}
"""Role of a part -> the parameters of its walls, where its own path does not say."""
THINNEST = 0.02
"""Share of its surface under which a part is thinnest, when sound parts are compared: letters are less."""
THICK = 6.0
"""Two bores that are farther apart share no wall, mm."""
OFF = (0.1, 1.0, 2.0)
"""How far off a wall's face it is asked which bore lies there, mm: a bore may lie beside its place."""
GONE = 0.1
"""A bore's wall that is farther away than drawn by this, mm, is not there; chords are 20 times nearer."""


def minimum(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Every wall is thick enough for its process: whole lines of the nozzle, or pourable silicone.

    A printed wall counts as thick as it comes out: as drawn less the under-extrusion. A wall that
    prints but breaks when it is handled is a warning.
    """
    rule = "wall.minimum"
    findings, nearest = [], None
    for part in parts.values():
        least, handled = least_wall(hand, part, limits), _handled(part, limits)
        gauge = gauge_of(part.triangles)
        for spot in gauge.thin_spots(max(least.value, handled.value if handled else 0.0)):
            limit = least if spot.thickness < least.value - ROUNDING or not handled else handled
            findings.append(_thin(part, spot, limit, "error" if limit is least else "warning"))
        walls = gauge.walls.thickness[gauge.walls.parallel > PARALLEL]
        margin = np.quantile(walls, THINNEST) - least.value if len(walls) else np.inf
        if nearest is None or margin < nearest[0]:
            nearest = margin, part, gauge, least
    if nearest is None:
        return skipped(rule, "no parts in this build")
    if findings:
        worst = min(findings, key=lambda f: f.measured / f.limit)
        return judged(rule, worst.measured, worst.limit, f"thinnest for its process: {worst.part}", findings)
    _, part, gauge, least = nearest
    spot = gauge.least()
    return judged(rule, spot and spot.thickness, least.value, f"thinnest for its process: {part.name}", [])


def least_wall(hand: Hand, part: Part, limits: Limits) -> Limit:
    """The drawn thickness, mm, that every wall of `part` must have."""
    rule = "wall.minimum"
    if part.role == CAST:
        return limits.get(rule, "pourable", part.material)
    process = getattr(hand.printing, _process(part))
    lines, less = (limits.get(rule, name, *_kinds(part)) for name in ("lines", "under_extrusion"))
    return Limit(lines.value * process.nozzle_size / (1.0 - less.value), "mm",
                 f"{lines.value:g} lines of {process.nozzle_size:g} mm less {less.value:.0%}: {lines.source}")


def _handled(part: Part, limits: Limits) -> Limit | None:
    return None if part.role == CAST else limits.find("wall.minimum", "handled", *_kinds(part))


def _process(part: Part) -> str:
    """Key of a printed part's process under `printing`."""
    if part.role != "exoskeleton":
        return "tooling"
    return "hand" if part.name == HAND else "finger"


def keys(part: Part) -> str:
    """The parameters that set the walls of `part`."""
    if part.role in KEYS:
        return KEYS[part.role]
    if part.name == HAND:
        return "palm.wall, opposition or what lies beside it"
    if part.role == CAST:
        return f"`layers`, {part.path}.layers or its diameters"
    diameters = "base_outer_diameter, tip_outer_diameter or its bore's"
    return f"{part.path}.{diameters}" if part.role == "exoskeleton" else part.path


def _kinds(part: Part) -> tuple[str, str, str]:
    return part.role, part.material, _process(part)


def between_bores(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """The hand's bores, channels and pockets leave a sound wall between one another."""
    rule = "wall.between-bores"
    part = parts.get(HAND)
    if part is None:
        return skipped(rule, "no hand in this build")
    limit = least_between(hand, limits)
    known, gauge = voids(hand), gauge_of(part.triangles)
    owners = np.array([v.owner for v in known])
    nearest = _thinnest_between(hand, known, owners, gauge.walls + gauge.contacts)
    if nearest is None:
        return judged(rule, None, limit.value, f"no wall between two bores is thinner than {THICK:g} mm", [])
    findings = []
    for spot in gauge.thin_spots(limit.value):
        places = _mirrored(hand, np.array([spot.point, spot.opposite]))
        line = (places[1] - places[0]) / max(spot.thickness, 1e-9)
        ends = _beside(known, places, np.array([-line, line]))
        if min(ends) >= 0 and owners[ends[0]] != owners[ends[1]]:
            findings.append(_shared(part, spot, limit, [known[end] for end in ends]))
    thickness, one, two = nearest
    return judged(rule, min([thickness, *(f.measured for f in findings)]), limit.value,
                  f"thinnest between {one.name} and {two.name}", findings)


def _thinnest_between(hand: Hand, known: list[Void], owners: np.ndarray, walls: Readings
                      ) -> tuple[float, Void, Void] | None:
    """(thickness mm, the voids to both sides) of the thinnest wall between two actuators' voids."""
    walls = walls.where((walls.parallel > PARALLEL) & (walls.thickness < THICK))
    outward = _mirrored(hand, walls.normals)
    one = _beside(known, _mirrored(hand, walls.points), outward)
    here = np.flatnonzero(one >= 0)
    one, two = one[here], _beside(known, _mirrored(hand, walls.opposite[here]), -outward[here])
    apart = (two >= 0) & (owners[one] != owners[two])
    if not apart.any():
        return None
    at = int(np.where(apart, walls.thickness[here], np.inf).argmin())
    return float(walls.thickness[here[at]]), known[one[at]], known[two[at]]


def least_between(hand: Hand, limits: Limits) -> Limit:
    """The drawn thickness, mm, that a wall between two bores of the hand must have."""
    process = hand.printing.hand
    lines = limits.get("wall.between-bores", "lines", process.material, "hand")
    return Limit(lines.value * process.nozzle_size, "mm",
                 f"{lines.value:g} lines of {process.nozzle_size:g} mm: {lines.source}")


def breakthrough(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """No bore, channel or pocket opens where it must not, in the hand or in a finger on its own.

    From every void's axis its wall must be in sight where it is drawn, unless there another void
    begins that this one leads into.
    """
    rule = "bore.breakthrough"
    holes: list[tuple[float, Finding | None]] = []
    if HAND in parts:
        limit = limits.get(rule, "opening", *_kinds(parts[HAND]))
        holes += _holes(hand, parts[HAND], voids(hand), dict(regions(hand)), limit)
    for name in hand.fingers.present():
        part = parts.get(f"exoskeleton/{name}")
        if part is not None:
            limit = limits.get(rule, "opening", *_kinds(part))
            # A finger on its own is drawn alike for both sides.
            holes += _holes(hand.model_copy(update={"side": "right"}), part, [alone(hand, name)], {}, limit)
    if not holes:
        return skipped(rule, "no exoskeleton in this build")
    largest = max(across for across, _ in holes)
    return judged(rule, largest, limit.value, "largest opening in a bore's wall",
                  [found for _, found in holes if found])


def _holes(hand: Hand, part: Part, known: list[Void], open_to: dict[str, list[Region]], limit: Limit
           ) -> list[tuple[float, Finding | None]]:
    """(width, finding where it is too wide) of every opening in the walls of `known`; (0, None): none."""
    surface = gauge_of(part.triangles).surface
    places: dict[str, list] = {v.name: [v] for v in known} | open_to
    found: list[tuple[float, Finding | None]] = [(0.0, None)]
    for void in known:
        origins, directions, distances, share = void.wall()
        seen = surface.sight(_mirrored(hand, origins), _mirrored(hand, directions))
        gone = seen > distances + GONE
        wall = origins + distances[:, None] * directions
        for name in set(void.into) - {void.name}:
            for place in places.get(name, ()):
                gone &= ~place.holds(wall, FIT)
        for hole in _patches(wall[gone]):
            across = 2 * math.sqrt(share * len(hole) / math.pi)
            broken = across > limit.value
            found.append((across, _broken(hand, part, void, hole, across, limit, known) if broken else None))
    return found


def _mirrored(hand: Hand, vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) of this hand in the frame of a right one, where the voids are known, and back."""
    return vectors * (1.0, -1.0, 1.0) if hand.side == "left" else vectors


def _beside(known: list[Void], points: np.ndarray, outward: np.ndarray) -> np.ndarray:
    """Number of the void that lies off each wall's face; -1: none of them."""
    found = np.full(len(points), -1)
    for off in OFF:
        left = np.flatnonzero(found < 0)
        places = points[left] + off * outward[left]
        for number, void in enumerate(known):
            found[left[void.holds(places)]] = number
    return found


def _thin(part: Part, spot: Spot, limit: Limit, severity: Literal["error", "warning"]) -> Finding:
    return Finding(
        "wall.minimum", severity, part.name, spot.thickness, limit.value, limit.unit,
        f"a wall of {spot.thickness:.2f} mm over {spot.area:.1f} mm2", f"thicken it: {keys(part)}",
        limit.source, spot.middle)


def _shared(part: Part, spot: Spot, limit: Limit, ends: list[Void]) -> Finding:
    one, two = ends
    return Finding(
        "wall.between-bores", "error", part.name, spot.thickness, limit.value, limit.unit,
        f"{one.name} and {two.name} leave {spot.thickness:.2f} mm between them, over {spot.area:.1f} mm2",
        f"move one of them: {one.path} or {two.path}", limit.source, spot.middle)


def _broken(hand: Hand, part: Part, void: Void, hole: np.ndarray, across: float, limit: Limit,
            known: list[Void]) -> Finding:
    middle = hole[np.linalg.norm(hole - hole.mean(axis=0), axis=1).argmin()]
    met = [v.name for v in known if v is not void and v.holds(middle[None], FIT)[0]]
    return Finding(
        "bore.breakthrough", "error", part.name, across, limit.value, limit.unit,
        f"{void.name} breaks through into {' and '.join(met) or 'the open'}: {across:.1f} mm wide",
        f"move it, or thicken what lies around it: {void.path}", limit.source,
        tuple(_mirrored(hand, middle).tolist()))


def _patches(points: np.ndarray) -> list[np.ndarray]:
    """Points (n, 3) in groups of neighbours, the largest first."""
    from scipy.cluster.hierarchy import fclusterdata

    if len(points) < 2:
        return [points] if len(points) else []
    label = fclusterdata(points, 2.5 * STEP, criterion="distance", method="single")
    groups = [points[label == k] for k in np.unique(label)]
    return sorted(groups, key=len, reverse=True)
