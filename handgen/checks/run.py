"""Run the rules and put their outcomes into the contract's `handgen.checks/1`.

A rule is a function `rule(hand, parts, limits) -> Outcome`. The shipped ones stand in `SHIPPED`; a
package adds its own by the entry point group `handgen.rules` (name of the rule -> the function).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, replace
from fnmatch import fnmatchcase
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from handgen.checks import actuators, casting, fff, fits, motion, printing, thread, thumb, walls
from handgen.checks.limits import Limits, standard
from handgen.checks.rule import RULES, Finding, Outcome
from handgen.errors import EngineError, InputError, Problem
from handgen.geometry.part import Part
from handgen.parameters.fault import nearest
from handgen.parameters.model import Hand
from handgen.parameters.rules import Override

SCHEMA = "handgen.checks/1"
GROUP = "handgen.rules"
Rule = Callable[[Hand, Mapping[str, Part], Limits], Outcome]
SHIPPED: dict[str, Rule] = {
    "wall.minimum": walls.minimum,
    "wall.between-bores": walls.between_bores,
    "bore.breakthrough": walls.breakthrough,
    "thread.gap": thread.gap,
    "thread.layer": thread.layer,
    "thumb.palm-stiffness": thumb.palm_stiffness,
    "actuator.layers": actuators.layers,
    "actuator.clearance": actuators.clearance,
    "actuator.length": actuators.length,
    "core.demould": casting.demould,
    "mould.split": casting.split,
    "suspender.centring": fits.centring,
    "seal.fit": fits.seal,
    "print.build-volume": printing.build_volume,
    "print.line-width": fff.line_width,
    "print.overhang": fff.overhang,
    "fingers.interference": motion.interference,
    "solid.watertight": printing.watertight,
    "hinge.strain": motion.strain,
}

@cache
def registered() -> dict[str, EntryPoint]:
    """Rules of other packages by name.

    Raises:
        EngineError: two packages register the same name, or one that handgen has.
    """
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=GROUP):
        if point.name in RULES or point.name in found:
            raise EngineError(f"the rule {point.name!r} is registered twice, once by {point.value}")
        found[point.name] = point
    return found


def names() -> list[str]:
    """Every rule's name: the contract's in its order, then those of other packages."""
    return [*RULES, *registered()]


def judge(hand: Hand, parts: Mapping[str, Part], file: str = "") -> dict[str, Any]:
    """All rules over `parts` of `hand`: the contract's report; `file` is named in errors.

    Raises:
        InputError: `rules` of the parameters names a rule or limit that does not exist.
        EngineError: another package's rule failed.
    """
    limits = own_limits(hand, file)
    return report(hand, [outcome(name, hand, parts, limits) for name in names()])


def outcome(name: str, hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """What the rule `name` says, before overrides.

    Raises:
        EngineError: a rule of another package cannot be loaded, fails, or returns no Outcome.
    """
    if name in SHIPPED:
        return SHIPPED[name](hand, parts, limits)
    point = registered()[name]
    try:
        result = point.load()(hand, parts, limits)
    except Exception as error:
        raise EngineError(f"the rule {name!r} of {point.value} failed: {error!r}") from error
    if not isinstance(result, Outcome) or result.rule != name:
        raise EngineError(f"the rule {name!r} of {point.value} returned no outcome of its own")
    return result


def own_limits(hand: Hand, file: str) -> Limits:
    """The shipped limits with the hand's own beside them.

    Raises:
        InputError: `rules` names a rule or a limit that does not exist; every such name at once.
    """
    problems = [
        Problem(file, f"rules.overrides[{i}].rule", override.rule, "there is no such rule",
                ", ".join(names()), nearest(override.rule, names()))
        for i, override in enumerate(hand.rules.overrides) if override.rule not in names()
    ]
    own = {rule: {name: entry.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True)
                  for name, entry in entries.items()}
           for rule, entries in hand.rules.limits.items()}
    try:
        limits = standard().beside(own, file)
    except InputError as error:
        problems += error.problems
    if problems:
        raise InputError(problems)
    return limits


def report(hand: Hand, outcomes: Iterable[Outcome]) -> dict[str, Any]:
    """The contract's report of `outcomes`, with the hand's overrides applied.

    It passes if no finding of error level is left and at least one rule really judged something.
    """
    settled = {o.rule: _settle(o, hand.rules.overrides) for o in outcomes}
    ordered = [settled[name] for name in names() if name in settled]
    findings = [finding for o in ordered for finding in o.findings]
    return {
        "schema": SCHEMA,
        "passed": all(f.severity != "error" for f in findings)
        and any(o.status != "skipped" for o in ordered),
        "findings": [_rounded(asdict(f)) for f in findings],
        "rules": [_rounded(o.as_dict()) for o in ordered],
    }


def _settle(outcome: Outcome, overrides: Iterable[Override]) -> Outcome:
    """The outcome with accepted findings lowered to `info`, and overridden when nothing else is left."""
    mine = [o for o in overrides if o.rule == outcome.rule]
    if not mine:
        return outcome
    findings, used = [], []
    for finding in outcome.findings:
        accepted = next((o for o in mine if fnmatchcase(finding.part, o.part)), None)
        if accepted and finding.severity != "info":
            used.append(accepted)
            finding = replace(finding, severity="info",
                              message=f"overridden ({accepted.reason}): {finding.message}")
        findings.append(finding)
    findings += [_idle(outcome, o) for o in mine if o not in used]
    if not used or any(f.severity != "info" for f in findings):
        return replace(outcome, findings=tuple(findings))
    reasons = "; ".join(dict.fromkeys(o.reason for o in used))
    return replace(outcome, status="overridden", reason=f"{outcome.reason}; accepted: {reasons}",
                   findings=tuple(findings))


def _idle(outcome: Outcome, override: Override) -> Finding:
    return Finding(outcome.rule, "info", override.part, None, None, outcome.unit,
                   "an override finds nothing to override here", "remove it from rules.overrides",
                   "rules.overrides")


def _rounded(row: dict[str, Any]) -> dict[str, Any]:
    """The row as JSON brings it back."""
    plain = {k: round(float(v), 6) if isinstance(v, float) else v for k, v in row.items()}
    if plain.get("where") is not None:
        plain["where"] = [round(float(v), 3) for v in plain["where"]]
    return plain
