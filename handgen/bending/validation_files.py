"""A validation's folder: JSON, CSV, and the source's figures drawn anew."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

from handgen import atomic
from handgen.bending.validation import Validation

JSON, CSV, ALL = "validation.json", "validation.csv", "validation.png"
QUANTITIES = {"tip_load": "weight on the tip", "pressure": "pressure", "tip_drop": "tip below the palm",
              "elongation": "actuator longer by", "bend_angle": "bend", "tip_force": "fingertip force"}
COLUMNS = ("test", "load", "load_unit", "model", "fitted", "measured_mean", "measured_least",
           "measured_largest", "simulated", "residual", "unit")
STYLES = {"literature": ("#8a8a94", (0, (4, 2))), "thesis": ("#c0792a", (0, (1, 1.5))),
          "calibrated": ("#1f5f8b", "solid")}
"""Colour and dashes of the models that come with handgen."""
OTHERS = (("#3f7d4e", "solid"), ("#7a4d8c", (0, (4, 2))), ("#a33b4a", (0, (1, 1.5))))
INK = "#26262e"


def write(found: Validation, folder: Path) -> dict[str, Any]:
    """Write validation.json, validation.csv, one PNG a test and validation.png with all of them.

    Each file is written beside and renamed. Returns what validation.json holds.
    """
    document = found.document
    folder.mkdir(parents=True, exist_ok=True)
    atomic.write(folder / JSON, (json.dumps(document, indent=2, allow_nan=False) + "\n").encode())
    atomic.write(folder / CSV, rows(document).encode())
    for test in document["tests"]:
        atomic.write(folder / f"{test['id']}.png", picture([test]))
    atomic.write(folder / ALL, picture(document["tests"]))
    return document


def rows(document: dict[str, Any]) -> str:
    """CSV: a line a test, load and model; an empty field where nothing was read or nothing converged."""
    text = io.StringIO()
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    for test in document["tests"]:
        for i, load in enumerate(test["loads"]):
            read = [row[i] for row in test["repeats"] if row[i] is not None]
            for name, model in test["models"].items():
                table.writerow({
                    "test": test["id"], "load": load, "load_unit": test["load_unit"], "model": name,
                    "fitted": int(model["fitted"] and test["may_be_fitted"][i]),
                    "measured_mean": test["means"][i], "measured_least": min(read, default=None),
                    "measured_largest": max(read, default=None), "simulated": model["simulated"][i],
                    "residual": model["residuals"][i], "unit": test["unit"]})
    return text.getvalue()


def picture(tests: list[dict[str, Any]]) -> bytes:
    """PNG of the tests side by side, two in a row."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    across = min(2, len(tests))
    down = -(-len(tests) // across)
    figure = Figure(figsize=(5.6 * across, 4.0 * down), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for axis in axes[len(tests):]:
        axis.set_axis_off()
    for axis, test in zip(axes, tests, strict=False):
        _draw(axis, test)
    image = io.BytesIO()
    figure.savefig(image, format="png")
    return image.getvalue()


def _draw(axis, test: dict[str, Any]) -> None:
    """One test: repeats as dots, others' simulations as squares, each model as a line."""
    others = iter(OTHERS)
    for name, model in test["models"].items():
        colour, dashes = STYLES.get(name) or next(others, (INK, "solid"))
        curve = model["curve"]
        over = test["times"] or curve["loads"]
        pairs = [(at, v) for at, v in zip(over, curve["values"], strict=True) if v is not None]
        word = "fitted" if model["fitted"] else "predicted"
        if pairs:
            axis.plot(*zip(*pairs, strict=True), color=colour, linestyle=dashes, linewidth=1.6,
                      label=f"{name}, {word}")
    for other in test["others"]:
        axis.plot(other["loads"], other["values"], "s", color="none", markeredgecolor=INK, markersize=6,
                  label=f"{other['name']} (its text)")
    dots = [(at, reading) for row in test["repeats"]
            for at, reading in zip(test["times"] or test["loads"], row, strict=True) if reading is not None]
    axis.plot(*zip(*dots, strict=True), "o", color=INK, markersize=3.5, alpha=0.55, linewidth=0,
              label="measured, every repeat")
    allowed = [load for load, may in zip(test["loads"], test["may_be_fitted"], strict=True) if may]
    if allowed and test["path"] == "loading":
        _limit(axis, test, allowed[-1])
    load = f"{QUANTITIES[test['load']]}, {test['load_unit']}"
    axis.set_xlabel(f"time, s, at {test['loads'][0]:g} {test['load_unit']}" if test["times"] else load)
    axis.set_ylabel(f"{QUANTITIES[test['observable']]}, {test['unit']}")
    axis.set_title(test["title"], fontsize=10, loc="left")
    axis.grid(color="#e6e6ea", linewidth=0.6)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(fontsize=7.5, frameon=False)


def _limit(axis, test: dict[str, Any], last: float) -> None:
    """Mark where fitting ends, if before the last reading."""
    if last < test["loads"][-1]:
        axis.axvspan(last, test["loads"][-1], color="#f0f0f4", zorder=0)
        axis.annotate("never fitted", (last, 0.01), xycoords=("data", "axes fraction"), fontsize=7.5,
                      color=INK, xytext=(3, 2), textcoords="offset points")
