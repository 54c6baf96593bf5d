"""What a rule is, what it finds, and the table of all rules with their limits."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any, Literal


@dataclass(frozen=True)
class Rule:
    """A row of the table; `limit` None where the hand's own parameters give it."""

    name: str
    unit: str
    limit: float | None = None
    source: str = ""


@dataclass(frozen=True)
class Finding:
    """One place where a rule is broken, as the contract's `findings` lists it."""

    rule: str
    severity: Literal["error", "warning", "info"]
    part: str
    measured: float | None
    limit: float | None
    unit: str
    message: str
    fix: str
    source: str
    where: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Outcome:
    """What became of one rule, as the contract's `rules` lists it, and all that it found."""

    rule: str
    status: Literal["pass", "fail", "skipped", "overridden"]
    measured: float | None
    limit: float | None
    unit: str
    reason: str
    findings: tuple[Finding, ...] = field(default=(), repr=False)

    def as_dict(self) -> dict[str, Any]:
        row = asdict(self)
        del row["findings"]
        return row


RULES = {rule.name: rule for rule in (
    Rule("wall.minimum", "mm"),
    Rule("wall.between-bores", "mm"),
    Rule("bore.breakthrough", "mm"),
    Rule("thread.gap", "mm"),
    Rule("thread.layer", "mm"),
    Rule("thumb.palm-stiffness", "deg"),
    Rule("actuator.layers", "mm", None, "Table A.2; casting.minimum_core_tip_diameter"),
    Rule("actuator.clearance", "mm", 0.0, "Table A.2: the index and middle actuators fill their bores"),
    Rule("actuator.length", "mm", 1.0, "Table A.2: an actuator is as long as its bore"),
    Rule("core.demould", "mm"),
    Rule("mould.split", "mm"),
    Rule("suspender.centring", "mm"),
    Rule("seal.fit", "mm"),
    Rule("print.build-volume", "mm", 0.0, "printing.build_volume"),
    Rule("print.line-width", "mm"),
    Rule("print.overhang", "deg"),
    Rule("fingers.interference", "mm3"),
    Rule("solid.watertight", "faults", 0.0, "a slicer needs a closed solid"),
    Rule("hinge.strain", "1"),
)}
"""Every rule of the contract, in its order."""


def judged(rule: str, measured: float | None, limit: float | None, reason: str,
           findings: list[Finding]) -> Outcome:
    """The outcome of a rule that ran: it fails with its first finding above `info`."""
    broken = any(f.severity != "info" for f in findings)
    return Outcome(rule, "fail" if broken else "pass", measured, limit, RULES[rule].unit, reason,
                   tuple(findings))


def skipped(rule: str, reason: str) -> Outcome:
    return Outcome(rule, "skipped", None, RULES[rule].limit, RULES[rule].unit, reason)
