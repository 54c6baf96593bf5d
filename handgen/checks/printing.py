"""Rules on the meshes that are printed, read from the rows of the manifest."""

from __future__ import annotations

from typing import Any

from handgen.checks.rule import RULES, Finding, Outcome, judged, skipped
from handgen.parameters.model import Hand

CAST = "actuator"
"""Role of parts that are cast, not printed."""


def watertight(hand: Hand, rows: list[dict[str, Any]]) -> Outcome:
    """Every mesh is closed, wound one way, and one body."""
    rule = RULES["solid.watertight"]
    findings = [
        Finding(rule.name, "error", row["name"], 1.0, rule.limit, rule.unit,
                "not closed" if not row["watertight"] else f"falls into {row['bodies']} bodies",
                "report it with the parameter file: no build may write such a mesh", rule.source)
        for row in rows if not row["watertight"] or row["bodies"] != 1
    ]
    return judged(rule.name, float(len(findings)), rule.limit, f"{len(rows)} meshes", findings)


def build_volume(hand: Hand, rows: list[dict[str, Any]]) -> Outcome:
    """Every printed part fits the printer standing as `print_up` says, turned on the bed at will."""
    rule, volume = RULES["print.build-volume"], hand.printing.build_volume
    excess, findings = [], []
    for row in (r for r in rows if r["role"] != CAST):
        over = overhang(row, volume)
        excess.append(over)
        if over > rule.limit:
            size = " x ".join(f"{b - a:.1f}" for a, b in zip(*row["bbox_mm"], strict=True))
            findings.append(Finding(
                rule.name, "error", row["name"], over, rule.limit, rule.unit,
                f"{size} mm sticks {over:.1f} mm out of {' x '.join(f'{v:g}' for v in volume)} mm",
                "make the part smaller or name a larger printer", rule.source))
    if not excess:
        return skipped(rule.name, "nothing in this build is printed")
    return judged(rule.name, max(excess), rule.limit, "excess over the build volume; below 0: room", findings)


def overhang(row: dict[str, Any], volume: list[float]) -> float:
    """How far a part's box sticks out of the printer's, mm, standing on the bed; below 0: room.

    The upright axis is the one that `print_up` points along most; the other two may be swapped.
    """
    size = [b - a for a, b in zip(*row["bbox_mm"], strict=True)]
    upright = max(range(3), key=lambda axis: abs(row["print_up"][axis]))
    height = size.pop(upright)
    bed = sorted(volume[:2])
    return max(height - volume[2], *(s - b for s, b in zip(sorted(size), bed, strict=True)))
