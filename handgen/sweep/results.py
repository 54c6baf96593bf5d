"""What a variant's row holds: names, units, meaning."""

from __future__ import annotations

from collections.abc import Sequence

from handgen.sweep.model import Sweep

BEND = {
    "bend_angle_deg": "turn of the fingertip",
    "tip_drop_mm": "how far the tip's lowest point lies below the palm's underside",
    "elongation_mm": "growth of the actuator",
    "max_stretch": "largest stretch anywhere",
}
"""Results of a bend: at the last pressure, and with `_<kPa>` behind at each one."""
FORCED = "fingertip_force_N"
"""The one result that a sweep must ask for, by `force`."""
FIXED = {
    "bend_angle_error_deg": "what the solver itself says its bend may be off; empty where it says nothing",
    FORCED: "force on the plane of `force`, at its pressure",
    "hinge_strain": "largest strain of the finger's strips at full curl, as the rule hinge.strain has it",
    "least_wall_mm": "thinnest wall of the finger's exoskeleton, radially",
    "chamber_ml": "air in the actuator's chamber",
    "exoskeleton_g": "of the finger, printed solid",
    "silicone_g": "of its actuator",
    "finger_g": "both",
    "print_h": "at least: the finger's volume over line width, layer height and speed; no travel",
    "rules_passed": "1 if no rule that was asked finds an error, else 0",
    "rules_unmet": "how many rules find anything, warnings too, that is not overridden",
}
STATUSES = {
    "done": "bent and judged",
    "incomplete": "the solver found no stable state at some pressure",
    "invalid": "no valid parameter file",
    "refused": "valid, but cannot be made or bent",
    "failed": "the solver or a rule failed",
    "timeout": "took longer than the sweep's time limit",
    "killed": "its worker died again and again",
}
FINISHED = ("done", "incomplete")
"""Statuses with results."""


def at(name: str, pressure: float) -> str:
    """The column of `name` at `pressure` kPa: `bend_angle_deg_60`."""
    return f"{name}_{pressure:g}"


def names(sweep: Sweep, pressures: Sequence[float]) -> list[str]:
    """Every number of a row, in the table's order."""
    forced = () if sweep.force else (FORCED,)
    return [*BEND, *(at(name, p) for p in pressures for name in BEND), *(n for n in FIXED if n not in forced)]
