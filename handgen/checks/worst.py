"""The one number that a rule of several tests reports."""

from __future__ import annotations

from handgen.checks.rule import RULES, Finding, Outcome, judged


def telling(rule: str, measured: float, limit: float, reason: str, findings: list[Finding],
            besides: str = "") -> Outcome:
    """The outcome of `rule`; where its own number holds, that and the reason are the first broken test's.

    A test in another unit is told in the reason only. `besides` is said in any case.
    """
    broken = [f for f in findings if f.severity != "info"]
    own = [f for f in broken if f.unit == RULES[rule].unit]
    if broken and measured not in [f.measured for f in own]:
        first = (own or broken)[0]
        reason = f"{first.part}: {first.message}"
        if own:
            measured, limit = first.measured, first.limit
    return judged(rule, measured, limit, reason + besides, findings)
