"""The page of a sweep: one HTML file that holds every row, drawn on canvases; it loads nothing else."""

from __future__ import annotations

import base64
import html
import json
from pathlib import Path
from typing import Any

import numpy as np

from handgen import atomic
from handgen.sweep import figures

TEMPLATE = Path(__file__).with_name("page.html")
NAME = "sweep.html"
MOST = 16
"""Columns of numbers on the page: axes first, then what the sweep asks for, then the rest."""
FEW = 20_000
"""Rows up to which the page holds texts of each."""


def write(frame, about: dict[str, Any], document: dict[str, Any], folder: Path) -> Path:
    """The page, in `folder`; four bytes a number, so that a hundred thousand rows stay usable."""
    wanted = [*about["axes"], *about["objectives"], *about["constraints"], *document["effects"],
              "bend_angle_deg", "bend_angle_error_deg", "hinge_strain", "finger_g", "rules_passed", "wall_s"]
    names = [n for n in dict.fromkeys(wanted) if n in frame and frame[n].notna().any()][:MOST]
    allowed = np.isfinite(figures.costs(frame, about)).all(axis=1) if about["objectives"] else (
        (frame["status"] == "done") & (frame["rules_passed"] != 0.0)).to_numpy()
    statuses, few = list(document["statuses"]), len(frame) <= FEW
    data = {
        "name": about["name"], "solver": about["solver"], "rows": len(frame), "axes": about["axes"],
        "objectives": about["objectives"], "constraints": about["constraints"],
        "statuses": document["statuses"], "effects": document["effects"],
        "columns": [{"short": figures.short(n) if n in about["axes"] else n, **_column(frame[n])}
                    for n in names],
        "allowed": _packed(allowed.astype(np.uint8)),
        "names": statuses, "status": _packed(frame["status"].map(statuses.index).to_numpy(np.uint8)),
        "hash": [str(h)[:8] for h in frame["hash"]] if few else [],
        "reasons": {str(i): r for i, r in enumerate(frame["reason"].fillna("")) if r} if few else {},
    }
    text = TEMPLATE.read_text(encoding="utf-8")
    # "</" would end the script that carries the data.
    carried = json.dumps(data, allow_nan=False).replace("</", "<\\/")
    text = text.replace("@TITLE@", html.escape(about["name"])).replace("@DATA@", carried)
    path = folder / NAME
    atomic.write(path, text)
    return path


def _column(series) -> dict[str, Any]:
    """A column's name and numbers; of texts, the number of each among `labels`."""
    found: dict[str, Any] = {"name": series.name}
    if series.dtype.kind not in "if":
        found["labels"] = sorted(series.dropna().unique())
        series = series.map({label: i for i, label in enumerate(found["labels"])})
    return {**found, "data": _packed(series.to_numpy(np.float32))}


def _packed(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()
