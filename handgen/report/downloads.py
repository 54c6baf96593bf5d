"""Files that the page carries: parameters, rules' report, dimensions, parts, curves."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping
from typing import Any

import yaml

from handgen.bending.result import Bend
from handgen.builder.survey import Survey
from handgen.report import making
from handgen.report.dimensions import Dimension

YAML, JSON, CSV = "application/yaml", "application/json", "text/csv"


def downloads(survey: Survey, bent: Mapping[str, Bend], dimensions: Iterable[Dimension]
              ) -> dict[str, dict[str, str]]:
    """Key -> {"name", "type", "text", "words"}."""
    loaded, name = survey.loaded, survey.loaded.hand.name
    whole = loaded.hand.model_dump(mode="json", by_alias=True, exclude_none=True)
    found = {
        "file": _file(loaded.file.name, YAML, loaded.file.read_text(encoding="utf-8"), "the parameter file"),
        "whole": _file(f"{name}_whole.yaml", YAML, yaml.safe_dump(whole, sort_keys=False),
                          "with all that it extends and every default"),
        "checks": _file("checks.json", JSON, json.dumps(survey.report, indent=1), "rules and findings"),
        "dimensions": _file("dimensions.csv", CSV, _csv(d.row() for d in dimensions),
                            "as built, asked, source"),
        "parts": _file("parts.csv", CSV, _csv(_parts(survey)), "sizes, volumes, masses"),
    }
    if survey.built:
        found["manifest"] = _file("manifest.json", JSON, json.dumps(survey.built, indent=1),
                                  "of the build beside it")
    for finger, bend in bent.items():
        points = [point | {"flags": "; ".join(point["flags"])} for point in bend.document["points"]]
        found[f"curve_{finger}"] = _file(f"curve_{finger}.csv", CSV, _csv(points),
                                          "bend, drop, stretch over pressure")
    return found


def _file(name: str, kind: str, text: str, words: str) -> dict[str, str]:
    return {"name": name, "type": kind, "text": text, "words": words}


def _csv(rows: Iterable[Mapping[str, Any]]) -> str:
    rows, text = list(rows), io.StringIO()
    if rows:
        writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return text.getvalue()


def _parts(survey: Survey) -> Iterable[dict[str, Any]]:
    mass = making.masses(survey)
    for name, each in survey.parts.items():
        low, high = each.facts.bbox_mm
        yield {"part": name, "material": each.part.material, "role": each.part.role,
               "volume_mm3": round(each.facts.volume_mm3, 2), "area_mm2": round(each.facts.area_mm2, 2),
               "mass_g": None if mass[name] is None else round(mass[name], 2),
               **{f"size_{axis}_mm": round(b - a, 3) for axis, a, b in zip("xyz", low, high, strict=True)},
               "triangles": each.facts.triangles}
