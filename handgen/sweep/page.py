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


def write(frame, about: dict[str, Any], document: dict[str, Any], folder: Path) -> Path:
    """The page, in `folder`; four bytes a number, so that a hundred thousand rows stay usable."""
    wanted = [*about["axes"], *about["objectives"], *about["constraints"], *document["effects"],
              "bend_angle_deg", "bend_angle_error_deg", "hinge_strain", "finger_g", "rules_passed", "wall_s"]
    names = [n for n in dict.fromkeys(wanted) if n in frame and frame[n].dtype.kind in "if"
             and frame[n].notna().any()][:MOST]
    allowed = np.isfinite(figures.costs(frame, about)).all(axis=1) if about["objectives"] else (
        (frame["status"] == "done") & (frame["rules_passed"] != 0.0)).to_numpy()
    data = {
        "name": about["name"], "solver": about["solver"], "rows": len(frame), "axes": about["axes"],
        "objectives": about["objectives"], "constraints": about["constraints"],
        "statuses": document["statuses"], "effects": document["effects"],
        "columns": [{"name": n, "short": figures.short(n) if n in about["axes"] else n,
                     "data": _packed(frame[n].to_numpy(np.float32))} for n in names],
        "allowed": _packed(allowed.astype(np.uint8)),
        "hash": [str(h)[:8] for h in frame["hash"]] if len(frame) <= 20_000 else [],
    }
    text = TEMPLATE.read_text(encoding="utf-8")
    # "</" would end the script that carries the data.
    carried = json.dumps(data, allow_nan=False).replace("</", "<\\/")
    text = text.replace("@TITLE@", html.escape(about["name"])).replace("@DATA@", carried)
    path = folder / NAME
    atomic.write(path, text)
    return path


def _packed(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()
