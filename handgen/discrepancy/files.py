"""A diagnosis' folder: diagnosis.json, model.yaml, diagnosis.html and the figures."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from handgen import atomic
from handgen.discrepancy import figures, patch
from handgen.discrepancy.document import document
from handgen.discrepancy.page import page
from handgen.discrepancy.run import Diagnosis
from handgen.discrepancy.sides import either_way
from handgen.effects import catalogue
from handgen.errors import InputError, Problem

JSON, PAGE, MODEL = "diagnosis.json", "diagnosis.html", "model.yaml"


def expect(folder: Path) -> None:
    """See that `folder` can be written to: nobody simulates for minutes to hear at the end that it cannot.

    Raises:
        InputError: it cannot.
    """
    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        why = "cannot be written to" if there.is_dir() else "is no folder"
        raise InputError([Problem("command line", "--out", str(folder), f"{there} {why}", "another folder")])


def write(found: Diagnosis, folder: Path) -> dict[str, Any]:
    """Write everything, each file beside and renamed. Returns what diagnosis.json holds."""
    folder.mkdir(parents=True, exist_ok=True)
    data = document(found, str(folder / MODEL))
    names = titles(data)
    patch.write(
        folder / MODEL,
        found.model,
        found.patched,
        found.materials,
        head=_head(found),
        tests=[test.id for test in found.tests],
    )
    drawn = {
        "diagnosis_curves.png": figures.overview(data, figures.PRINT),
        "diagnosis_gaps.png": figures.gap_bars(data, figures.PRINT),
        "diagnosis_probabilities.png": figures.probabilities(data, figures.PRINT, names),
    }
    for name, figure in drawn.items():
        atomic.write(folder / name, figures.png(figure))
    atomic.write(folder / PAGE, page(data, names).encode())
    atomic.write(folder / JSON, (json.dumps(data, indent=2, allow_nan=False) + "\n").encode())
    return data


def titles(data: dict[str, Any]) -> dict[str, str]:
    """Explanations in words."""
    known = catalogue()
    found = {"none": "nothing missing", "outside": "something unknown"}
    for candidate in data["candidates"]:
        parts = candidate["id"].split("+")
        if all(part in known or part in found for part in parts):
            found[candidate["id"]] = " and ".join(
                known[part].name if part in known else found[part] for part in parts)
    return found


def _head(found: Diagnosis) -> list[str]:
    lines = [
        f"Written by `handgen diagnose`: {found.model.name} against {found.measured.measurements.name}.",
        f"Verdict: {found.verdict.word}"
        + (f", {', '.join(found.verdict.effects)}" if found.verdict.effects else ""),
    ]
    lines += [f"Which way {name} goes is open: these readings do not rule out the other"
              for name in either_way(found.verdict)]
    nuisances = found.patched.nuisances()
    lines += [
        f"Of the measurement, no part of a model: {name} {value:+.3g}"
        for name, value in nuisances.items()
        if not name.startswith("stiffness")
    ]
    return lines


