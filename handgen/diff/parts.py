"""Parts, masses and print times of two surveyed designs side by side."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from handgen.builder.survey import Survey
from handgen.report import making
from handgen.slicing import known
from handgen.slicing.profile import column

LEAST = "least"
"""Of a time: the filled volume at the speed of the print, without travel; no slicer was asked."""
GROUPS = (("exoskeleton/hand", "hand", "exoskeleton, filled"), ("exoskeleton/", "fingers",
          "single fingers, filled"), ("actuators/", "silicone", "silicone in the actuators"))
"""Beginning of a part's name, key, and words of the masses that are summed."""


def described(survey: Survey) -> dict[str, dict[str, Any]]:
    """Part -> size, volume, and mass where nothing but the volume decides it."""
    mass = making.masses(survey)
    return {name: {
        "size_mm": [round(high - low, 3) for low, high in zip(*each.facts.bbox_mm, strict=True)],
        "volume_mm3": round(each.facts.volume_mm3, 2), "area_mm2": round(each.facts.area_mm2, 2),
        "mass_g": None if mass[name] is None else round(mass[name], 3),
    } for name, each in survey.parts.items()}


def parts(a: Mapping[str, dict], b: Mapping[str, dict], keys_a: Mapping[str, str],
          keys_b: Mapping[str, str]) -> list[dict[str, Any]]:
    """A row a part: "change" is same, changed, gone or new; "a" and "b" as `described`.

    Those are null where there is no such part, or it is not made yet.
    """
    return [{"name": name, "change": change(name, keys_a, keys_b), "a": a.get(name), "b": b.get(name)}
            for name in {**keys_a, **keys_b}]


def change(name: str, a: Mapping[str, Any], b: Mapping[str, Any]) -> str:
    if name not in b:
        return "gone"
    if name not in a:
        return "new"
    return "same" if a[name] == b[name] else "changed"


def masses(a: Mapping[str, dict], b: Mapping[str, dict], keys_a: Mapping[str, str],
           keys_b: Mapping[str, str]) -> list[dict[str, Any]]:
    """Sums of what is printed filled or cast, g; null where a design has none, or a part is not made yet."""
    rows, counted = [], set()
    for start, key, words in GROUPS:
        names = {name for name in {**keys_a, **keys_b} if name.startswith(start)} - counted
        counted |= names
        if names:
            rows.append({"what": key, "words": words, "unit": "g", "a": _sum(a, names & keys_a.keys()),
                         "b": _sum(b, names & keys_b.keys())})
    return rows


def _sum(rows: Mapping[str, dict], names: Iterable[str]) -> float | None:
    names = sorted(names)
    if not names or any(name not in rows for name in names):
        return None
    return round(sum(rows[name]["mass_g"] for name in names), 3)


def times(survey: Survey, folder: Path) -> dict[tuple[str, str], float]:
    """(part, how) -> h to print: as sliced into `folder`, and the least that a filled part takes."""
    hand = survey.loaded.hand
    found = {(row["part"], row["slicer"]): round(row["print_time_s"] / 3600.0, 3)
             for row in known.rows(hand, folder)}
    for name, each in survey.parts.items():
        of = column(each.part.role, name)
        if of in ("hand", "finger"):
            rate = getattr(hand.printing, of).rate
            found[name, LEAST] = round(each.facts.volume_mm3 / rate / 3600.0, 3)
    return found


def timed(a: Mapping[tuple[str, str], float], b: Mapping[tuple[str, str], float]) -> list[dict[str, Any]]:
    """A row a part and way to know its time; null where it is not known."""
    return [{"part": part, "how": how, "unit": "h", "a": a.get((part, how)), "b": b.get((part, how))}
            for part, how in {**a, **b}]
