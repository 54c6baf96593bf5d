"""Rules on every mesh as it goes to the printer or shows what is cast: closed, and within the printer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from handgen.checks.limits import Limit, Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.checks.walls import CAST
from handgen.geometry.measure import fault_place, measure_mesh
from handgen.geometry.part import Part
from handgen.parameters.model import Hand

ROUNDING = 1e-4
"""mm; boxes are those of single-precision meshes."""


def watertight(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Every mesh is closed, wound one way, without slivers, and one body."""
    rule, most = "solid.watertight", limits.get("solid.watertight", "faults")
    if not parts:
        return skipped(rule, "no parts in this build")
    found = {name: measure_mesh(*part.triangles).faults() for name, part in parts.items()}
    findings = [
        Finding(rule, "error", name, float(len(faults)), most.value, most.unit, f"it {', '.join(faults)}",
                "report it with the parameter file: no build may write such a mesh", most.source,
                fault_place(*parts[name].triangles))
        for name, faults in found.items() if len(faults) > most.value
    ]
    worst = max(len(faults) for faults in found.values())
    return judged(rule, float(worst), most.value, f"most faults of {len(parts)} meshes", findings)


def build_volume(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Every printed part fits the printer standing as its `up` says, turned on the bed at will."""
    rule, most = "print.build-volume", limits.get("print.build-volume", "excess")
    volume = hand.printing.build_volume
    excess, findings = [], []
    for part in (p for p in parts.values() if p.role != CAST):
        low, high = part.triangles.vertices.min(axis=0), part.triangles.vertices.max(axis=0)
        size = [float(b - a) for a, b in zip(low, high, strict=True)]
        over, axis = overhang(size, part.up, volume)
        excess.append(over)
        if over > most.value + ROUNDING:
            end = [float(a + b) / 2 for a, b in zip(low, high, strict=True)]
            end[axis] = float(high[axis])
            findings.append(_too_large(part, size, over, volume, most, tuple(end)))
    if not excess:
        return skipped(rule, "nothing in this build is printed")
    return judged(rule, max(excess), most.value, "excess over the build volume; below 0: room", findings)


def _too_large(part: Part, size: Sequence[float], over: float, volume: Sequence[float], limit: Limit,
               where: tuple[float, float, float]) -> Finding:
    box = " x ".join(f"{s:.1f}" for s in size)
    return Finding(
        "print.build-volume", "error", part.name, over, limit.value, limit.unit,
        f"{box} mm sticks {over:.1f} mm out of {' x '.join(f'{v:g}' for v in volume)} mm",
        f"make the part smaller ({part.path}) or name a larger printer (printing.build_volume)",
        limit.source, where)


def overhang(size: Sequence[float], up: Sequence[float], volume: Sequence[float]) -> tuple[float, int]:
    """How far a box of `size` sticks out of the printer's, mm, below 0: room; and along which axis.

    The upright axis is the one that `up` points along most; the other two may be swapped on the bed.
    """
    upright = max(range(3), key=lambda axis: abs(up[axis]))
    lying = sorted((axis for axis in range(3) if axis != upright), key=lambda axis: size[axis])
    room = dict(zip(lying, sorted(volume[:2]), strict=True)) | {upright: volume[2]}
    return max((size[axis] - room[axis], axis) for axis in range(3))
