"""Run the rules and put their outcomes into the contract's `handgen.checks/1`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from handgen.checks import actuators, printing
from handgen.checks.limits import standard
from handgen.checks.rule import RULES, Outcome, skipped
from handgen.geometry.catalogue import catalogue
from handgen.parameters.model import Hand

SCHEMA = "handgen.checks/1"
ON_DEFINITION = {
    "actuator.layers": actuators.layers,
    "actuator.clearance": actuators.clearance,
    "actuator.length": actuators.length,
}
"""Rules on the parameters alone: they run before any geometry is made."""
ON_MESHES = {
    "solid.watertight": printing.watertight,
    "print.build-volume": printing.build_volume,
}
"""Rules on the meshes of what was made."""
MISSING = "not implemented yet"


def definition(hand: Hand) -> dict[str, Any]:
    """The rules that need no geometry; the others are skipped."""
    parts = catalogue(hand)
    return _report({name: rule(hand, parts, standard()) for name, rule in ON_DEFINITION.items()},
                   "no geometry was made")


def everything(hand: Hand, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """All rules, those on meshes over the parts that the manifest's `rows` name."""
    parts = catalogue(hand)
    made = {row["name"]: parts[row["name"]] for row in rows}
    return _report({name: rule(hand, parts, standard()) for name, rule in ON_DEFINITION.items()}
                   | {name: rule(hand, made, standard()) for name, rule in ON_MESHES.items()}, "")


def _report(ran: dict[str, Outcome], why_not: str) -> dict[str, Any]:
    outcomes = [
        ran.get(name) or skipped(name, why_not if name in ON_MESHES else MISSING) for name in RULES
    ]
    findings = [finding for outcome in outcomes for finding in outcome.findings]
    return {
        "schema": SCHEMA,
        "passed": all(f.severity != "error" for f in findings),
        "findings": [_rounded(asdict(f)) for f in findings],
        "rules": [_rounded(outcome.as_dict()) for outcome in outcomes],
    }


def _rounded(row: dict[str, Any]) -> dict[str, Any]:
    return {k: round(v, 6) if isinstance(v, float) else v for k, v in row.items()}
