"""What the rules say of two designs: whose status or number changed, findings that went or came."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from handgen.diff.parameters import apart

SAME = 1e-6
"""Share below which a measured number is the same."""
TOLD = ("status", "measured", "limit", "unit", "reason")


def judged(a: Mapping[str, Any] | None, b: Mapping[str, Any] | None) -> dict[str, Any]:
    """{"rules", "findings"} of two reports; null where one of the designs was not judged yet."""
    if a is None or b is None:
        return {"rules": None, "findings": None}
    return {"rules": rules(a, b), "findings": findings(a, b)}


def rules(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Rules that judge otherwise: [{"rule", "a", "b"}], each as in the contract's `rules`, or null."""
    before, after = ({row["rule"]: {key: row[key] for key in TOLD} for row in report["rules"]}
                     for report in (a, b))
    return [{"rule": name, "a": before.get(name), "b": after.get(name)}
            for name in {**before, **after} if _differs(before.get(name), after.get(name))]


def _differs(a: Mapping[str, Any] | None, b: Mapping[str, Any] | None) -> bool:
    if a is None or b is None:
        return True
    return a["status"] != b["status"] or not all(_equal(a[key], b[key]) for key in ("measured", "limit"))


def _equal(a: float | None, b: float | None) -> bool:
    if a is None or b is None:
        return a is b
    return abs(a - b) <= SAME * max(abs(a), abs(b))


def findings(a: Mapping[str, Any], b: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """{"gone", "new"}: findings of one report that the other has no counterpart to, at the same part."""
    return apart(a["findings"], b["findings"], lambda f: (f["rule"], f["severity"], f["part"]))
