"""Rules on fused filament: walls in whole lines, and nothing drawn into the air (Table B.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handgen.checks import hanging
from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.checks.surface import Outline, Surface
from handgen.geometry.palm import facing
from handgen.geometry.part import Part
from handgen.parameters.model import Hand
from handgen.parameters.process import PrintProcess

ROUNDING = 1e-6
SLICES = 7
"""Layers of each part whose walls are measured."""
PACE = 1.5
"""Distance, mm, along a layer's outlines at which walls are measured."""
RAYS = 160
"""Walls measured in a layer at most, at first."""
CLOSE = 0.25
"""The same distance where a wall looks odd."""
OPPOSED = -0.9
"""Cosine between the normals of a wall's two faces: beyond it they are no wall."""
KEYS = {"plug": "seal.tube_outer_diameter or seal.plug_squeeze", "collar": "seal.collar_fit or seal.glue_gap",
        "mould_a": "casting.mould_wall", "mould_b": "casting.mould_wall"}
"""Role of a part -> the parameters of its walls, where its own path does not say."""
CAST = "actuator"
"""Role of parts that are cast, not printed."""


@dataclass(frozen=True)
class Printed:
    """A part as it stands on the bed: z up."""

    hand: Hand
    part: Part

    @property
    def key(self) -> str:
        """Of its process under `printing`."""
        if self.part.role != "exoskeleton":
            return "tooling"
        return "hand" if self.part.name == "exoskeleton/hand" else "finger"

    @property
    def process(self) -> PrintProcess:
        return getattr(self.hand.printing, self.key)

    @property
    def support(self) -> str:
        return self.process.part_support.get(self.part.role, self.process.support)

    @property
    def rotation(self) -> np.ndarray:
        """Columns: the printing frame's axes in the part's own."""
        return np.array(facing(self.part.up))[:, [1, 2, 0]]

    @cached_property
    def surface(self) -> Surface:
        return Surface.of(self.part.mesh).seen_from(self.rotation)

    @cached_property
    def bed(self) -> hanging.Bed:
        return hanging.Bed(self.surface)

    def supports(self, places: np.ndarray) -> np.ndarray:
        """Under which of `places` (n, 3), in the printing frame, the process puts support."""
        if self.support == "touching build plate":
            return self.bed.seen_from(places)
        return np.full(len(places), self.support == "everywhere")

    def own(self, point) -> tuple[float, float, float]:
        """A point of the printing frame in the part's own."""
        return tuple((self.rotation @ np.asarray(point)).tolist())


def printed(hand: Hand, parts: Mapping[str, Part]) -> Iterator[Printed]:
    return (Printed(hand, part) for part in parts.values() if part.role != CAST)


def line_width(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Every wall is a whole number of lines that the nozzle can draw; no layer is too thick.

    A wall of thickness t takes n lines of t / n; the rule asks for an n that keeps t / n between
    the thinnest and the widest line. Walls are measured in the plane of the layers.
    """
    rule = "print.line-width"
    findings, thinnest = _layers(hand, parts, limits), (float("inf"), "", 0.0)
    for item in printed(hand, parts):
        nozzle = item.process.nozzle_size
        low, high, detail = (limits.get(rule, n, item.process.material, item.key).value
                             for n in ("least_line", "widest_line", "detail"))
        layers = slices(item.surface)
        odd = odd_wall(layers, nozzle * low, nozzle * high, detail)
        if odd:
            findings.append(_odd(item, odd, limits, nozzle * low))
        elif item.process.infill_pattern == "concentric":
            odd = min((wall for layer in layers if (wall := layer.thinnest())), default=None)
            findings += [_lines(item, odd, limits)] if odd else []
        if odd:
            thinnest = min(thinnest, (odd.thickness, item.part.name, nozzle))
    if not thinnest[1]:
        return skipped(rule, "nothing is printed")
    least = limits.get(rule, "least_line").value * thinnest[2]
    return judged(rule, thinnest[0], least, f"thinnest wall, of {thinnest[1]}", findings)


def fits_lines(thickness: np.ndarray, low: float, high: float) -> np.ndarray:
    """Whether some whole number of lines between `low` and `high` mm wide fills each wall."""
    fewest = np.maximum(1, np.ceil(thickness / high - ROUNDING))
    return thickness / fewest >= low - ROUNDING


@dataclass(frozen=True, order=True)
class Wall:
    """A wall in one layer: least thickness (mm) and where, in the printing frame."""

    thickness: float
    where: tuple[float, float, float]


def odd_wall(layers: list[Layer], low: float, high: float, detail: float) -> Wall | None:
    """The thinnest wall that no whole number of lines fills over a stretch of `detail` mm."""
    return min((wall for layer in layers for wall in layer.odd(low, high, detail)), default=None)


@dataclass(frozen=True)
class Layer:
    """One layer of a part: its outlines at height z, and its walls where they were measured."""

    z: float
    cut: Outline
    thickness: np.ndarray
    at: np.ndarray

    def thinnest(self) -> Wall | None:
        if not len(self.thickness):
            return None
        i = int(np.argmin(self.thickness))
        return Wall(float(self.thickness[i]), (*self.at[i].tolist(), self.z))

    def odd(self, low: float, high: float, detail: float) -> list[Wall]:
        """Walls that no whole number of lines fills, each at least `detail` mm long.

        Where there may be one, its neighbourhood is measured closely, to tell a wall from a letter.
        """
        suspects = self.at[~fits_lines(self.thickness, low, high)]
        if not len(suspects):
            return []
        gaps = np.linalg.norm(self.cut.middle[:, None] - suspects[None], axis=2).min(1)
        near = self.cut.where(gaps < detail + self.cut.lengths / 2)
        thickness, at = thicknesses(self.cut, near, CLOSE)
        strange = ~fits_lines(thickness, low, high)
        thickness, at = thickness[strange], at[strange]
        walls = [(thickness[rows], at[rows]) for rows in _stretches(at)]
        return [
            Wall(float(t.min()), (*p[np.argmin(t)].tolist(), self.z))
            for t, p in walls if np.ptp(p, axis=0).max() + CLOSE >= detail]


def slices(surface: Surface) -> list[Layer]:
    """A few layers of a part, not at simple fractions of its height: there lie flat faces."""
    low, high = surface.vertices[:, 2].min(), surface.vertices[:, 2].max()
    heights = low + (np.arange(SLICES) + 0.43) / SLICES * (high - low)
    cuts = [surface.section(2, float(z)) for z in heights]
    return [Layer(float(z), cut, *thicknesses(cut, cut, max(PACE, cut.lengths.sum() / RAYS)))
            for z, cut in zip(heights, cuts, strict=True)]


def thicknesses(cut: Outline, sources: Outline, pace: float) -> tuple[np.ndarray, np.ndarray]:
    """(thickness mm, place (n, 2)) of the walls behind `sources`, every `pace` mm along them.

    Straight inwards to the first piece of `cut`, where that faces the other way.
    """
    until = np.cumsum(sources.lengths)
    n = max(1, int(until[-1] / pace))
    target = (np.arange(n) + 0.5) / n * until[-1]
    of = np.minimum(np.searchsorted(until, target), len(sources) - 1)
    back = ((until[of] - target) / sources.lengths[of])[:, None]
    origin = sources.end[of] - back * (sources.end - sources.start)[of]
    inward = -sources.outward[of]
    # origin + t inward = start + s along
    along, to_start = cut.end - cut.start, cut.start[None] - origin[:, None]
    cross = inward[:, None, 0] * along[None, :, 1] - inward[:, None, 1] * along[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (to_start[..., 0] * along[None, :, 1] - to_start[..., 1] * along[None, :, 0]) / cross
        s = (to_start[..., 0] * inward[:, None, 1] - to_start[..., 1] * inward[:, None, 0]) / cross
    t = np.where((s >= 0.0) & (s <= 1.0) & (t > ROUNDING), t, np.inf)
    first = np.argmin(t, axis=1)
    distance = t[np.arange(n), first]
    keep = np.isfinite(distance) & (np.einsum("ij,ij->i", cut.outward[first], -inward) < OPPOSED)
    return distance[keep], origin[keep]


def _stretches(at: np.ndarray) -> list[np.ndarray]:
    """Rows of the places (n, 2) that follow one another."""
    from scipy.spatial import cKDTree

    groups, left = [], set(range(len(at)))
    tree = cKDTree(at) if len(at) else None
    while left:
        stack, group = [left.pop()], []
        while stack:
            i = stack.pop()
            group.append(i)
            new = left.intersection(tree.query_ball_point(at[i], 3 * CLOSE))
            left -= new
            stack += new
        groups.append(np.array(group))
    return groups


def _layers(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> list[Finding]:
    findings = []
    for item in {i.key: i for i in printed(hand, parts)}.values():
        most = limits.get("print.line-width", "most_layer", item.process.material, item.key)
        share = item.process.layer_height / item.process.nozzle_size
        if share > most.value + ROUNDING:
            findings.append(Finding(
                "print.line-width", "error", item.part.name, share, most.value, most.unit,
                f"layers of {item.process.layer_height:g} mm from a nozzle of {item.process.nozzle_size:g} mm"
                " do not bond", f"lower printing.{item.key}.layer_height", most.source))
    return findings


def _odd(item: Printed, wall: Wall, limits: Limits, low: float) -> Finding:
    """A wall that no whole number of lines fills: an error where not even one does."""
    limit = limits.get("print.line-width", "least_line", item.process.material, item.key)
    lost = wall.thickness < low - ROUNDING
    message = ("is thinner than the thinnest line: it is dropped" if lost
               else f"is {wall.thickness / item.process.nozzle_size:.1f} lines: it stays hollow or swells")
    return Finding(
        "print.line-width", "error" if lost else "warning", item.part.name, wall.thickness, low, "mm",
        f"a wall of {wall.thickness:.2f} mm {message}",
        f"make it a multiple of printing.{item.key}.nozzle_size ({item.process.nozzle_size:g} mm):"
        f" {KEYS.get(item.part.role, item.part.path)}", limit.source, item.own(wall.where))


def _lines(item: Printed, wall: Wall, limits: Limits) -> Finding:
    """How the thinnest wall of a part that is all lines is filled."""
    nozzle = item.process.nozzle_size
    lines = max(1, round(wall.thickness / nozzle))
    return Finding(
        "print.line-width", "info", item.part.name, wall.thickness / nozzle, None, "1",
        f"its thinnest wall of {wall.thickness:.2f} mm takes {lines} lines of"
        f" {wall.thickness / lines:.3f} mm",
        "let the slicer vary the width of lines, or it fills the rest with a gap",
        limits.get("print.line-width", "widest_line", item.process.material, item.key).source,
        item.own(wall.where))


def overhang(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Nothing is drawn into the air: no patch steeper than the support angle without support.

    Bridges and short overhangs that a printer draws by itself pass; what the process supports is
    listed with its area.
    """
    rule = "print.overhang"
    findings, steepest, angle, items = [], 0.0, None, 0
    for item in printed(hand, parts):
        items += 1
        angle = item.process.support_angle
        mask = hanging.steep(item.surface, angle, item.process.layer_height)
        bridge, reach, least = (limits.get(rule, n, item.process.material, item.key)
                                for n in ("bridge", "reach", "least_area"))
        supported = 0.0
        for patch in hanging.patches(item.surface, mask):
            helped = item.supports(patch.places)
            hard = patch.reach() > reach.value + ROUNDING
            span = patch.span(hard)
            hard &= span > bridge.value + ROUNDING
            supported += patch.share * float((hard & helped).sum())
            bad = hard & ~helped
            if patch.share * bad.sum() > least.value + ROUNDING:
                steepest = max(steepest, patch.angle)
                findings.append(_in_the_air(item, patch, bad, span, bridge, reach))
        if supported > least.value:
            findings.append(_supported(item, supported, angle))
    if not items:
        return skipped(rule, "nothing is printed")
    return judged(rule, steepest, angle, "steepest surface that nothing holds; 0: none", findings)


def _in_the_air(item: Printed, patch: hanging.Patch, bad: np.ndarray, span: np.ndarray, bridge: Limit,
                reach: Limit) -> Finding:
    """The patch's worst place: the widest bridge, else the farthest overhang, else none that holds."""
    bridges = bad & np.isfinite(span)
    needs, limit = (span, bridge) if bridges.any() else (patch.reach(), reach)
    rows = np.flatnonzero(bridges if bridges.any() else bad)
    at = rows[int(np.argmax(needs[rows]))]
    need = float(needs[at]) if np.isfinite(needs[at]) else None
    held = ("starts in the air" if need is None
            else f"spans {need:.1f} mm" if bridges.any() else f"reaches {need:.1f} mm out")
    where = (f"printing.{item.key}.part_support.{item.part.role}" if item.key == "tooling"
             else f"printing.{item.key}.support")
    return Finding(
        "print.overhang", "error", item.part.name, need, limit.value, limit.unit,
        f"{patch.share * bad.sum():.0f} mm2, up to {patch.angle:.0f} deg from the vertical,"
        f" {held} without support",
        f"allow support ({where}), or turn the part", limit.source, item.own(patch.places[at]))


def _supported(item: Printed, area: float, angle: float) -> Finding:
    return Finding(
        "print.overhang", "info", item.part.name, area, None, "mm2",
        f"{area:.0f} mm2 steeper than {angle:g} deg are supported ({item.support})",
        "clean them after the print", "Table B.1")
