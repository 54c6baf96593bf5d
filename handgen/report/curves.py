"""The fingers' curves over the pressure, drawn in the page's colours, with a dot each for the slider."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from handgen.bending.result import Bend

SHOWN = (("bend_angle_deg", "bend, degrees"), ("tip_drop_mm", "tip below the palm, mm"))
COLOURS = ("#d1495b", "#2a7fb8", "#3a9a5b", "#c9822b", "#8a63b8")
"""Of the fingers in their order: legible on light and dark ground."""
INK, GRID = "#010203", "#040506"
"""Stand in for the page's own colours until the drawing is written."""
SIZE = (7.4, 3.1)
"""Inches of 72 units each."""
DASHES = ("-", (0, (6, 2)), (0, (4, 1.5, 1, 1.5)), (0, (2, 1.5)), (0, (8, 2, 1, 2)))
"""Of the lines in the same order: colour is not all that tells them apart."""


@dataclass(frozen=True)
class Curves:
    svg: str
    data: dict[str, Any]
    """finger -> {"pressures": [kPa], "values": {key: [...]}, "places": {key: [[x, y] in the drawing]}}."""


def draw(bent: Mapping[str, Bend]) -> Curves | None:
    """None where no finger has a converged point."""
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    rows = {name: [p for p in found.document["points"] if p["converged"]] for name, found in bent.items()}
    rows = {name: points for name, points in rows.items() if points}
    if not rows:
        return None
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "handgen", "font.size": 9,
                                "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": INK,
                                "xtick.color": INK, "ytick.color": INK}):
        figure = Figure(figsize=SIZE, layout="constrained")
        canvas = FigureCanvasSVG(figure)
        axes = figure.subplots(1, len(SHOWN))
        for axis, (key, label) in zip(axes, SHOWN, strict=True):
            _plot(axis, rows, key, label)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(rows),
                      frameon=False)
        figure.patch.set_alpha(0.0)
        stream = io.StringIO()
        canvas.print_svg(stream, metadata={"Date": None, "Creator": None})
        data = {name: _data(points, axes) for name, points in rows.items()}
    return Curves(_own(stream.getvalue(), data), data)


def _plot(axis, rows: Mapping[str, list], key: str, label: str) -> None:
    for (name, points), colour, dash in zip(rows.items(), COLOURS, DASHES, strict=False):
        axis.plot([p["pressure_kPa"] for p in points], [p[key] for p in points], color=colour, linestyle=dash,
                  linewidth=1.6, marker="o", markersize=2.5, label=name)
    axis.set_xlabel("pressure, kPa")
    axis.set_title(label, fontsize=9, loc="left", color=INK)
    axis.grid(color=GRID, linewidth=0.6)
    axis.patch.set_alpha(0.0)
    axis.spines[["top", "right"]].set_visible(False)


def _data(points: list[dict], axes) -> dict[str, Any]:
    pressures = [p["pressure_kPa"] for p in points]
    places = {}
    for axis, (key, _) in zip(axes, SHOWN, strict=True):
        pixels = axis.transData.transform([(p["pressure_kPa"], p[key]) for p in points])
        scale = 72.0 / axis.figure.dpi
        places[key] = [[round(x * scale, 2), round(72.0 * SIZE[1] - y * scale, 2)]
                       for x, y in pixels.tolist()]
    return {"pressures": pressures, "places": places,
            "values": {key: [round(p[key], 3) for p in points] for key, _ in SHOWN}}


def _own(svg: str, data: Mapping[str, Any]) -> str:
    """The drawing as part of a page: its colours, a title, and the slider's dots."""
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = svg.replace(INK, "currentColor").replace(f"stroke: {GRID}", "stroke: var(--line)")
    svg = re.sub(r"font: ([^;\"]*)(?:px)? [^;\"]*(?=[;\"])", r"font: \1 system-ui, sans-serif", svg)
    dots = "".join(
        f'<circle id="dot-{name}-{key}" cx="{x}" cy="{y}" r="5" fill="{colour}" '
        'stroke="var(--card)" stroke-width="1.5"/>'
        for (name, curve), colour in zip(data.items(), COLOURS, strict=False)
        for key, ((x, y), *_) in curve["places"].items())
    words = "Curves of bend and drop of the fingertips over the pressure"
    svg = svg.replace("<svg ", f'<svg role="img" aria-label="{words}" ', 1)
    return svg.replace("</svg>", dots + "</svg>")
