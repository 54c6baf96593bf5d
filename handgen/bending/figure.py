"""The curve of a bend as a plot: drop, angle, and force or elongation over the load."""

from __future__ import annotations

from pathlib import Path
from typing import Any

DROP = ("tip_drop_mm", "tip below the palm, mm")
ANGLE = ("bend_angle_deg", "bend, degrees")
GROWTH = ("elongation_mm", "actuator longer by, mm")
FORCE = ("tip_force_N", "fingertip force, N")
COLOUR, QUIET, EMPTY = "#1f5f8b", "#8a8a94", "#f0f0f2"


def draw(path: Path, document: dict[str, Any]) -> None:
    """A PNG of what the contract's `document` holds; loads without a converged point are shaded."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    points = [p for p in document["points"] if p["converged"]]
    bare = document["part"] == "exoskeleton"
    load, name = ("tip_load_N", "weight on the tip, N") if bare else ("pressure_kPa", "pressure, kPa")
    missing = [p[load] for p in document["points"] if not p["converged"]]
    wanted = [DROP, ANGLE, FORCE if document["obstacle_mm"] is not None else GROWTH]
    shown = [(key, label) for key, label in wanted if any(p[key] is not None for p in points)]
    figure = Figure(figsize=(3.6 * max(len(shown), 1), 3.4), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, max(len(shown), 1), squeeze=False)[0]
    for axis, (key, label) in zip(axes, shown, strict=False):
        rows = [(p[load], p[key]) for p in points if p[key] is not None]
        axis.plot(*zip(*rows, strict=True), color=COLOUR, marker="o", markersize=4, linewidth=1.5)
        for fold in document["folds_kPa"]:
            axis.axvline(fold, color=QUIET, linewidth=1, linestyle=":")
            axis.annotate("folds", (fold, 0.02), xycoords=("data", "axes fraction"), fontsize=8, color=QUIET)
        if missing:
            _mark_missing(axis, rows[-1][0], missing[-1])
        axis.set_xlabel(name)
        axis.set_title(label, fontsize=10, loc="left")
        axis.grid(color="#e6e6ea", linewidth=0.6)
        axis.spines[["top", "right"]].set_visible(False)
    words = [document[key].replace("_", " ") for key in ("name", "finger", "part", "orientation")]
    words += [f"model {document['model']}", f"solver {document['solver']}"]
    figure.suptitle(", ".join(words), fontsize=9, color=QUIET)
    figure.savefig(path)


def _mark_missing(axis, reached: float, last: float) -> None:
    """Shade the loads beyond `reached`."""
    axis.axvspan(reached, last, color=EMPTY, linewidth=0)
    axis.annotate("no solution", ((reached + last) / 2, 0.5), xycoords=("data", "axes fraction"), ha="center",
                  va="center", rotation=90, fontsize=8, color=QUIET)
    axis.margins(x=0.02)
