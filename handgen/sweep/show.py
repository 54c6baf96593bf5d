"""What a sweep found: a table, main effects, Sobol indices, plots and a page."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from handgen.errors import InputError, Problem
from handgen.sweep import draw, effects, results, table
from handgen.sweep.model import Axis
from handgen.sweep.run import RESULTS

SHOWN = ("bend_angle_deg", "hinge_strain", "finger_g")
"""Results that are explained where a sweep has no objectives."""


def show(folder: str | os.PathLike, out: str | os.PathLike | None = None) -> dict[str, Any]:
    """Explain the sweep in `folder` (outputs/<name>); plots and `sweep.html` go to `out`, or there.

    Raises:
        InputError: there is no table of a sweep.
    """
    from handgen.sweep import figures, page

    path = Path(folder)
    path = path / RESULTS if path.is_dir() else path
    about, frame = _read(path)
    place = Path(out) if out is not None else path.parent
    place.mkdir(parents=True, exist_ok=True)
    axes = {name: Axis.model_validate(one) for name, one in about["vary"].items()}
    asked = [name for name in (*about["objectives"], *about["constraints"]) if name in frame]
    explained = list(dict.fromkeys(asked)) or [n for n in SHOWN if n in frame and frame[n].notna().any()]
    shares = np.column_stack([_shares(axis, frame[name].tolist()) for name, axis in axes.items()])
    values = [frame[name].to_numpy() for name in axes]
    found = {}
    for name in explained:
        numbers = frame[name].to_numpy(float)
        found[name] = {
            "main": dict(zip(axes, effects.main_effects(shares, values, numbers), strict=True)),
            "sobol": effects.sobol_indices(axes, shares, numbers, seed=0)}
    document = {
        "schema": "handgen.sweep-report/1", "name": about["name"], "variants": len(frame), "out": str(place),
        "statuses": {k: int(v) for k, v in frame["status"].value_counts().items()},
        "axes": list(axes), "objectives": about["objectives"], "constraints": about["constraints"],
        "effects": found, "best": _best(frame, about)}
    figures.draw(frame, about, document, place)
    document["page"] = str(page.write(frame, about, document, place))
    return document


def _read(path: Path):
    """(what the table says of its sweep, its rows as a pandas frame)."""
    import pandas as pd

    if not path.is_file():
        raise InputError([Problem("command line", "show", str(path), "there is no table of a sweep here",
                                  "the output folder of a sweep, outputs/<name>")])
    try:
        return table.about(path), pd.read_parquet(path)
    except (KeyError, ValueError, OSError) as error:
        problem = Problem("command line", "show", str(path), f"is no table of a sweep: {error}")
        raise InputError([problem]) from error


def _shares(axis: Axis, values: list[Any]) -> np.ndarray:
    import json

    if axis.choices is None:
        return np.array([draw.share(axis, value) for value in values])
    texts = [c if isinstance(c, str) else json.dumps(c) for c in axis.choices]
    known = {**{c: i for i, c in enumerate(texts)},
             **{float(c): i for i, c in enumerate(axis.choices) if isinstance(c, int | float)}}
    return np.array([(known[value] + 0.5) / len(axis.choices) for value in values])


def _best(frame, about: dict[str, Any], most: int = 10) -> list[dict[str, Any]]:
    """The best rows that keep to everything."""
    if not about["objectives"]:
        return []
    kept = frame[(frame["status"] == "done") & (frame["rules_passed"] != 0.0)]
    for name, bound in about["constraints"].items():
        kept = kept[kept[name].between(bound.get("min", -np.inf), bound.get("max", np.inf))]
    for name in about["objectives"]:
        kept = kept[kept[name].notna()]
    rising = [way == "minimise" for way in about["objectives"].values()]
    kept = kept.sort_values([*about["objectives"], "variant"], ascending=[*rising, True]).head(most)
    names = ["variant", "hash", *about["axes"], *results.BEND, *about["objectives"], *about["constraints"]]
    rows = kept[list(dict.fromkeys(n for n in names if n in kept))].to_dict("records")
    return [{k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in row.items()}
            for row in rows]
