"""The differences as text for people: only what changes, before -> after."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from handgen.diff.bends import UNSOLVED
from handgen.diff.parts import LEAST

Style = Callable[[str, str], str]
BAD, GOOD, HEAD = "31", "32", "1"
SHOWN = (20.0, 60.0, 100.0)
"""kPa of the line of a bend."""
UNSLICED = "  not sliced: least times of a filled print; `handgen slice` of both files gives a slicer's"
HOW_TO_SOLVE = "  `--bend` solves what is not solved yet, in seconds a finger"
LINE = 24
"""Parts that are listed one by one; a design with more of them changed has changed as a whole."""


def told(document: Mapping[str, Any], style: Style) -> str:
    """All sections that have something to say, then both verdicts."""
    if document["same"]:
        return f"{document['a']['file']} and {document['b']['file']} have the same parameters"
    sections = [
        (f"parameters ({len(document['parameters'])})", _parameters(document["parameters"])),
        ("adapted", _adapted(document["adaptations"], style)),
        (_counted(document["parts"]), _parts(document["parts"])),
        ("masses, g", [_values(row["words"], row["a"], row["b"], ".1f") for row in document["masses"]
                       if row["a"] != row["b"]]),
        ("print times, h", _times(document["times"])),
        ("rules", [_rule(row, style) for row in document["rules"] or ()]),
        ("findings", _findings(document["findings"] or {}, style)),
        (f"bend, degrees at {', '.join(f'{p:g}' for p in SHOWN)} kPa, and reached",
         _bends(document["bends"])),
    ]
    lines = [line for title, rows in sections if rows for line in (style(title, HEAD), *rows, "")]
    verdicts = " -> ".join(f"{side['name']} {_verdict(side['passed'], style)}"
                           for side in (document["a"], document["b"]))
    return "\n".join([*lines, verdicts])


def _verdict(passed: bool | None, style: Style) -> str:
    if passed is None:
        return "is not judged yet"
    return style("passes", GOOD) if passed else style("fails", BAD)


def _values(name: str, a: float | None, b: float | None, form: str) -> str:
    """`name   before -> after   (+difference)`."""
    change = f"  ({b - a:+{form}})" if a is not None and b is not None else ""
    return f"  {name:<40}{_number(a, form):>9} -> {_number(b, form):<9}{change}".rstrip()


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else f"{value:{form}}"


def _parameters(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    return [f"  {row['path']:<46}{_plain(row['a'])} -> {_plain(row['b'])}" for row in rows]


def _plain(value: Any) -> str:
    text = "-" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _adapted(found: Mapping[str, list], style: Style) -> list[str]:
    return [f"  {style(mark, colour)} {each['path']}: {each['reason']}" for key, mark, colour in
            (("gone", "-", GOOD), ("new", "+", BAD)) for each in found[key]]


def _counted(rows: Iterable[Mapping[str, Any]]) -> str:
    rows = list(rows)
    counts = {word: sum(row["change"] == word for row in rows) for word in ("changed", "gone", "new", "same")}
    return "parts: " + ", ".join(f"{count} {word}" for word, count in counts.items() if count)


def _parts(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Volumes, cm3, of the parts that differ."""
    other = [row for row in rows if row["change"] != "same"]
    lines = [_values(f"{row['name']}, cm3", *(row[side] and row[side]["volume_mm3"] / 1e3 for side in "ab"),
                     ".2f") for row in other[:LINE]]
    return lines + ([f"  and {len(other) - LINE} more"] if len(other) > LINE else [])


def _times(rows: list[Mapping[str, Any]]) -> list[str]:
    """Of parts whose time differs; the least time only where no slicer tells one of both."""
    lines = []
    sliced = {row["part"] for row in rows if row["how"] != LEAST and None not in (row["a"], row["b"])}
    for row in rows:
        known = row["a"] is not None and row["b"] is not None
        alike = _number(row["a"], ".1f") == _number(row["b"], ".1f")
        if alike or (row["how"] == LEAST and row["part"] in sliced):
            continue
        if row["how"] == LEAST:
            words = f"{row['part']}, at least"
        elif known:
            words = f"{row['part']}, {row['how']}"
        else:
            continue
        lines.append(_values(words, row["a"], row["b"], ".1f"))
    return [UNSLICED, *lines] if lines and not sliced else lines


def _rule(row: Mapping[str, Any], style: Style) -> str:
    unit = (row["b"] or row["a"])["unit"]
    return f"  {row['rule']:<24}{_judged(row['a'], style)} -> {_judged(row['b'], style)} {unit}"


def _judged(judged: Mapping[str, Any] | None, style: Style) -> str:
    if judged is None:
        return "-"
    colour = {"pass": GOOD, "fail": BAD}.get(judged["status"], "33")
    measured, limit = (_number(judged[key], ".4g") for key in ("measured", "limit"))
    return f"{style(judged['status'], colour)} {measured} (limit {limit})"


def _findings(found: Mapping[str, list], style: Style) -> list[str]:
    return [f"  {style(mark, colour)} {each['severity']} {each['rule']} {each['part']}: {each['message']}"
            for key, mark, colour in (("gone", "-", GOOD), ("new", "+", BAD)) for each in found.get(key, ())
            if each["severity"] != "info"]


def _bends(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    lines, open_ = [], False
    for row in rows:
        if row["change"] == "same":
            known = _curve(row, "a")
            words = "the same" if known == UNSOLVED else f"the same: {known}"
        else:
            words = " -> ".join(_curve(row, side) for side in "ab")
            open_ = open_ or UNSOLVED in row["why"].values()
        lines.append(f"  {row['finger']:<10}{words}")
    return [*lines, HOW_TO_SOLVE] if open_ else lines


def _curve(row: Mapping[str, Any], side: str) -> str:
    found = row[side]
    if found is None:
        return row["why"].get(side, "-")
    angles = {point["pressure_kPa"]: point["bend_angle_deg"] for point in found["points"]}
    numbers = " ".join(f"{_number(angles.get(pressure), '.0f'):>4}" for pressure in SHOWN)
    return f"{numbers}, {found['reached']:g} {found['reached_unit']}"
