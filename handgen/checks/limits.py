"""The rules' limits as data: shipped ones with their source, a lab's own beside them.

`limits.yaml` says what each limit means. Looking one up names what it is asked for, from the most
particular to the most general: `limits.get("hinge.strain", "full_curl", "PIP")`.
"""

from __future__ import annotations

import copy
import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from handgen.errors import InputError, Problem

FILE = Path(__file__).with_name("limits.yaml")
SCHEMA = "handgen.limits/1"
KEY = "rules.limits"
"""Where a parameter file puts its own."""


@dataclass(frozen=True)
class Limit:
    """One number: what a rule compares with, and where it comes from."""

    value: float
    unit: str
    source: str


class Limits:
    """Limits by rule and name; `for` a material, a print process or a part's role first."""

    def __init__(self, table: Mapping[str, Mapping[str, Mapping[str, Any]]]):
        self._table = table

    def find(self, rule: str, name: str, *kinds: str) -> Limit | None:
        """The limit for the first of `kinds` that has its own, else for everything; None: unknown."""
        entry = self._table[rule][name]
        own = entry.get("for", {})
        rows = [own[kind] for kind in kinds if kind in own] + [entry]
        row = next((r for r in rows if "value" in r), None)
        return None if row is None else Limit(float(row["value"]), entry["unit"], _origin(row))

    def get(self, rule: str, name: str, *kinds: str) -> Limit:
        """As `find`, where a value for everything is known to exist.

        Raises:
            KeyError: there is none.
        """
        limit = self.find(rule, name, *kinds)
        if limit is None:
            raise KeyError(f"{rule}: no {name} for {', '.join(kinds) or 'everything'}")
        return limit

    def beside(self, own: Mapping[str, Any], file: str = "") -> Limits:
        """These limits with a lab's `own`: rule -> limit -> {value, reason} or {for: {kind: ...}}.

        `file` is the parameter file that says so, for errors.

        Raises:
            InputError: an unknown rule or limit, a value that is no number, no reason; all at once.
        """
        problems: list[Problem] = []
        table = copy.deepcopy(dict(self._table))
        for rule, limits in own.items():
            if rule not in table:
                problems.append(_unknown(file, f"{KEY}.{rule}", rule, table))
                continue
            for name, entry in limits.items():
                path = f"{KEY}.{rule}.{name}"
                if name not in table[rule]:
                    problems.append(_unknown(file, path, name, table[rule]))
                    continue
                target = table[rule][name]
                if "value" in entry or "for" not in entry:
                    _replace(target, entry, file, path, problems)
                for kind, row in entry.get("for", {}).items():
                    place = target.setdefault("for", {}).setdefault(kind, {})
                    _replace(place, row, file, f"{path}.for.{kind}", problems)
        if problems:
            raise InputError(problems)
        return Limits(table)


@cache
def standard() -> Limits:
    """The limits that ship with handgen."""
    table = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    if table.pop("schema") != SCHEMA:
        raise ValueError(f"{FILE.name} is not {SCHEMA}")
    return Limits(table)


def _origin(row: Mapping[str, Any]) -> str:
    if "source" in row:
        return row["source"]
    return f"assumed: {row['assumed']}" if "assumed" in row else f"own limit: {row['reason']}"


def _replace(row: dict, given: Mapping[str, Any], file: str, path: str, problems: list[Problem]) -> None:
    value, reason = given.get("value"), given.get("reason")
    if isinstance(value, bool) or not isinstance(value, int | float):
        problems.append(Problem(file, path, value, "an own limit needs a number as `value`"))
    if not isinstance(reason, str) or not reason.strip():
        problems.append(Problem(file, path, reason, "an own limit needs a `reason`"))
    for key in ("source", "assumed"):
        row.pop(key, None)
    row.update(value=value, reason=reason)


def _unknown(file: str, path: str, name: str, known: Mapping[str, Any]) -> Problem:
    nearest = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)
    return Problem(file, path, name, "there is no such limit", ", ".join(known),
                   nearest[0] if nearest else None)
