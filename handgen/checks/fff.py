"""Rules on fused filament: walls in whole lines, and nothing drawn into the air (Table B.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from handgen.checks import hanging
from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.checks.sections import Outline, Triangles
from handgen.checks.walls import CAST, keys
from handgen.geometry.palm import facing
from handgen.geometry.part import Part
from handgen.geometry.thickness import FACING, gauge_of
from handgen.parameters.model import Hand
from handgen.parameters.process import PrintProcess

ROUNDING = 1e-6
SLICES = 7
"""Layers of each part whose walls are measured."""
PACE = 1.5
"""Distance, mm, along a layer's outlines at which walls are measured."""
RAYS = 120
"""Walls measured in a layer at most, at first."""
CLOSE = 0.25
"""The same distance where a wall looks odd."""
OPPOSED = -0.9
"""Cosine between the normals of a wall's two faces: beyond it they are no wall."""


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
    def surface(self) -> Triangles:
        return Triangles.of(self.part.triangles).seen_from(self.rotation)

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

    A wall takes the fewest lines that are no wider than the widest; what each must then be wide is
    compared with the thinnest. Walls are measured in the plane of the layers.
    """
    rule = "print.line-width"
    findings, poorest = _layers(hand, parts, limits), None
    for item in printed(hand, parts):
        nozzle = item.process.nozzle_size
        least, widest, detail = (limits.get(rule, n, item.process.material, item.key)
                                 for n in ("least_line", "widest_line", "detail"))
        low, high = nozzle * least.value, nozzle * widest.value
        layers = slices(item)
        wall = min((w for layer in layers for w in layer.odd(low, high, detail.value)), default=None)
        if wall:
            findings.append(_odd(item, wall, low, least))
        elif item.process.infill_pattern == "concentric":
            wall = min((w for layer in layers if (w := layer.poorest(low, high))), default=None)
            findings += [_lines(item, wall, widest)] if wall else []
        if wall and (poorest is None or wall.line / low < poorest[0]):
            poorest = (wall.line / low, wall, low, item.part.name)
    if poorest is None:
        return skipped(rule, "no wall is all lines")
    _, wall, low, name = poorest
    return judged(rule, wall.line, low, f"thinnest line, for {wall.thickness:.2f} mm of {name}", findings)


def line_for(thickness: np.ndarray, widest: float) -> np.ndarray:
    """How wide the lines of a wall are when it takes the fewest that are no wider than `widest`, mm."""
    return thickness / np.maximum(1, np.ceil(thickness / widest - ROUNDING))


@dataclass(frozen=True, order=True)
class Wall:
    """A wall in one layer: the lines it takes and its thickness (mm); where, in the printing frame."""

    line: float
    thickness: float
    where: tuple[float, float, float]


@dataclass(frozen=True)
class Layer:
    """One layer of a part: its outlines at height z, and its walls where they were measured."""

    item: Printed
    z: float
    cut: Outline
    thickness: np.ndarray
    at: np.ndarray

    def poorest(self, low: float, high: float) -> Wall | None:
        """The wall that takes the thinnest lines, of those that lines of `low` to `high` mm fill."""
        filled = line_for(self.thickness, high) >= low - ROUNDING
        return _poorest(self.thickness[filled], self.at[filled], self.z, high) if filled.any() else None

    def odd(self, low: float, high: float, detail: float) -> list[Wall]:
        """Walls whose lines are thinner than `low`, each at least `detail` mm long.

        Where there may be one, its neighbourhood is measured closely, to tell a wall from a letter.
        """
        suspects = self.at[line_for(self.thickness, high) < low - ROUNDING]
        if not len(suspects):
            return []
        gaps = np.linalg.norm(self.cut.middle[:, None] - suspects[None], axis=2).min(1)
        near = self.cut.where(gaps < detail + self.cut.lengths / 2)
        thickness, at = thicknesses(self.item, self.z, near, CLOSE)
        odd = line_for(thickness, high) < low - ROUNDING
        thickness, at = thickness[odd], at[odd]
        return [_poorest(thickness[rows], at[rows], self.z, high) for rows in _stretches(at)
                if np.ptp(at[rows], axis=0).max() + CLOSE >= detail]


def _poorest(thickness: np.ndarray, at: np.ndarray, z: float, widest: float) -> Wall:
    lines = line_for(thickness, widest)
    i = int(np.argmin(lines))
    return Wall(float(lines[i]), float(thickness[i]), (*at[i].tolist(), z))


def slices(item: Printed) -> list[Layer]:
    """A few layers of a part, not at simple fractions of its height: there lie flat faces."""
    low, high = item.surface.vertices[:, 2].min(), item.surface.vertices[:, 2].max()
    layers = []
    for z in (low + (np.arange(SLICES) + 0.43) / SLICES * (high - low)).tolist():
        cut = item.surface.section(2, z)
        if len(cut):  # between bodies that do not touch there is nothing
            pace = max(PACE, cut.lengths.sum() / RAYS)
            layers.append(Layer(item, z, cut, *thicknesses(item, z, cut, pace)))
    return layers


def thicknesses(item: Printed, z: float, sources: Outline, pace: float) -> tuple[np.ndarray, np.ndarray]:
    """(thickness mm, place (n, 2)) of the walls behind `sources`, every `pace` mm along them.

    `sources` are pieces of the layer's outline at height `z`. Straight inwards within the layer to
    the first surface, where that faces the other way: in the layer, and in space, or the layer
    passes through a corner that is as thin only here.
    """
    until = np.cumsum(sources.lengths)
    n = max(1, int(until[-1] / pace))
    target = (np.arange(n) + 0.5) / n * until[-1]
    of = np.minimum(np.searchsorted(until, target), len(sources) - 1)
    back = ((until[of] - target) / sources.lengths[of])[:, None]
    origin = sources.end[of] - back * (sources.end - sources.start)[of]
    inward = -sources.outward[of]
    level = np.c_[origin, np.full(n, z)], np.c_[inward, np.zeros(n)]
    rays = gauge_of(item.part.triangles).surface
    start, heading = (v @ item.rotation.T for v in level)
    distance, face, _ = rays.shoot(start, heading)
    across = (rays.normals[face] @ item.rotation)[:, :2]
    facing = np.einsum("ij,ij->i", across, inward) / np.maximum(np.linalg.norm(across, axis=1), 1e-12)
    keep = np.isfinite(distance) & (distance > ROUNDING) & (facing > -OPPOSED)
    distance, origin, start, heading, face = (
        v[keep] for v in (distance, origin, start, heading, face))
    _, back, _ = rays.shoot(start + distance[:, None] * heading, -heading)
    keep = np.einsum("ij,ij->i", rays.normals[face], rays.normals[back]) < -FACING
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


def _odd(item: Printed, wall: Wall, low: float, limit: Limit) -> Finding:
    """A wall that no whole number of lines fills: an error where not even one does."""
    nozzle, lost = item.process.nozzle_size, wall.thickness < low - ROUNDING
    message = ("is thinner than the thinnest line: it is dropped" if lost
               else f"is {wall.thickness / nozzle:.1f} lines: it stays hollow or swells")
    return Finding(
        "print.line-width", "error" if lost else "warning", item.part.name, wall.line, low, "mm",
        f"a wall of {wall.thickness:.2f} mm {message}",
        f"make it a multiple of printing.{item.key}.nozzle_size ({nozzle:g} mm):"
        f" {keys(item.part)}", limit.source, item.own(wall.where))


def _lines(item: Printed, wall: Wall, limit: Limit) -> Finding:
    """How the poorest wall of a part that is all lines is filled."""
    nozzle = item.process.nozzle_size
    return Finding(
        "print.line-width", "info", item.part.name, wall.thickness / nozzle, None, "1",
        f"a wall of {wall.thickness:.2f} mm is {wall.thickness / nozzle:.1f} lines of the nozzle:"
        f" {round(wall.thickness / wall.line)} of {wall.line:.3f} mm fill it",
        "let the slicer vary the width of lines, or it leaves a gap", limit.source, item.own(wall.where))


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
        bridge, reach, bed, least, failed = (
            limits.get(rule, n, item.process.material, item.key)
            for n in ("bridge", "reach", "bed", "least_area", "failed_area"))
        mask = hanging.steep(item.surface, angle, bed.value)
        supported, largest = 0.0, None
        for patch in hanging.patches(item.surface, mask):
            hard = patch.reach() > reach.value + ROUNDING
            helped = hard & item.supports(patch.places)
            supported += patch.share * float(helped.sum())
            if helped.any() and (largest is None or helped.sum() > len(largest)):
                largest = patch.places[helped]
            span = patch.span(hard & ~helped)
            bad = hard & ~helped & (span > bridge.value + ROUNDING)
            area = patch.share * float(bad.sum())
            if area > least.value + ROUNDING:
                steepest = max(steepest, patch.angle)
                severity = "error" if area > failed.value + ROUNDING else "warning"
                findings.append(_in_the_air(item, patch, bad, span, bridge, reach, severity))
        if supported > least.value:
            findings.append(_supported(item, supported, angle, largest))
    if not items:
        return skipped(rule, "nothing is printed")
    return judged(rule, steepest, angle, "steepest surface that nothing holds; 0: none", findings)


def _in_the_air(item: Printed, patch: hanging.Patch, bad: np.ndarray, span: np.ndarray, bridge: Limit,
                reach: Limit, severity: Literal["error", "warning"]) -> Finding:
    """The patch's worst place: as a bridge or as an overhang, whichever it is nearer to."""
    reaches = patch.reach()
    excess = np.where(bad, np.minimum(span / bridge.value, reaches / reach.value), 0.0)
    at = int(np.argmax(excess))
    bridges = span[at] / bridge.value < reaches[at] / reach.value
    limit, need = (bridge, float(span[at])) if bridges else (reach, float(reaches[at]))
    held = (f"spans {need:.1f} mm" if bridges
            else f"reaches {need:.1f} mm out" if np.isfinite(need) else "starts in the air")
    where = (f"printing.{item.key}.part_support.{item.part.role}" if item.key == "tooling"
             else f"printing.{item.key}.support")
    return Finding(
        "print.overhang", severity, item.part.name, need if np.isfinite(need) else None, limit.value,
        limit.unit,
        f"{patch.share * bad.sum():.0f} mm2, up to {patch.angle:.0f} deg from the vertical,"
        f" {held} without support",
        f"allow support ({where}), or turn the part", limit.source, item.own(patch.places[at]))


def _supported(item: Printed, area: float, angle: float, places: np.ndarray) -> Finding:
    middle = places[np.linalg.norm(places - places.mean(axis=0), axis=1).argmin()]
    return Finding(
        "print.overhang", "info", item.part.name, area, None, "mm2",
        f"{area:.0f} mm2 steeper than {angle:g} deg are supported ({item.support})",
        "clean them after the print", "Table B.1", item.own(middle))
