"""Figures of a diagnosis: curves and residuals, probabilities, gaps; PNG, or SVG in the colours of its
page."""

from __future__ import annotations

import io
import re
from typing import Any

STATES = {"before": "model as it was", "retuned": "re-tuned only", "patched": "patched"}
SHORT = {"before": "as it\nwas", "retuned": "re-tuned\nonly", "patched": "patched"}
DASHES = {"before": (0, (1, 1.5)), "retuned": (0, (4, 2)), "patched": "solid"}
PRINT = {"before": "#b3541e", "retuned": "#8a8a94", "patched": "#1f5f8b", "ink": "#26262e", "grid": "#e3e3e8"}
"""Colours of a PNG on white."""
MARKS = {"before": "#010203", "retuned": "#010204", "patched": "#010205", "ink": "#010206", "grid": "#010207"}
"""Colours that stand for the page's variables of these names in an SVG."""
READINGS = {
    "tip_drop": "tip below the palm",
    "elongation": "actuator longer by",
    "bend_angle": "bend of the tip",
    "tip_force": "fingertip force",
    "chamber_pressure": "pressure at the inlet",
    "force_angle": "slant of the force",
}
LOADS = {"pressure": "pressure", "tip_load": "weight on the tip"}
MOST, LEAST = 8, 1e-3
"""Explanations that are drawn: so many, each at least so probable."""


def overview(document: dict[str, Any], colours: dict[str, str]):
    """Curves above, residuals below, a column a test."""
    curves = document["curves"]
    figure = _figure(3.9 * len(curves), 5.6)
    axes = figure.subplots(2, len(curves), squeeze=False, sharex="col", height_ratios=(3, 2))
    for i, curve in enumerate(curves):
        _curve(axes[0][i], curve, shown(document), colours)
        _residuals(axes[1][i], curve, shown(document), colours)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=4,
        frameon=False,
        fontsize=9,
        labelcolor=colours["ink"],
    )
    return figure


def panel(document: dict[str, Any], curve: dict[str, Any], colours: dict[str, str]):
    """One test of `overview`, as wide as a telephone."""
    figure = _figure(3.7, 4.6)
    axes = figure.subplots(2, 1, sharex="col", height_ratios=(3, 2))
    _curve(axes[0], curve, shown(document), colours)
    _residuals(axes[1], curve, shown(document), colours)
    return figure


def probabilities(document: dict[str, Any], colours: dict[str, str], names: dict[str, str]):
    """What explains the data, the most probable first."""
    shown = likely(document)
    figure = _figure(7.2, 0.7 + 0.36 * len(shown))
    axis = figure.subplots()
    bars = axis.barh(
        range(len(shown)), [c["probability"] for c in shown], color=colours["patched"], height=0.62
    )
    axis.bar_label(
        bars, [percent(c["probability"]) for c in shown], padding=4, color=colours["ink"], fontsize=9
    )
    axis.set_yticks(range(len(shown)), [names.get(c["id"], c["id"]) for c in shown])
    axis.invert_yaxis()
    axis.set_xlim(0, 1.15)
    axis.set_xticks([0, 0.5, 0.9], ["0", "50 %", "90 %"])
    _plain(axis, colours)
    return figure


def likely(document: dict[str, Any]) -> list[dict[str, Any]]:
    """The explanations to draw."""
    return [c for c in document["candidates"] if c["probability"] >= LEAST][:MOST]


def gap_bars(document: dict[str, Any], colours: dict[str, str]):
    """RMS error of the models at loads that the fit had not seen, a panel a test."""
    tests = [t for t in document["gap"]["tests"] if any(v is not None for v in t["held_out"].values())]
    states = shown(document)
    figure = _figure(2.9 * max(len(tests), 1), 3.0)
    axes = figure.subplots(1, max(len(tests), 1), squeeze=False)[0]
    for axis, test in zip(axes, tests, strict=False):
        values = [test["held_out"][state] for state in states]
        bars = axis.bar(
            range(len(states)), [v or 0.0 for v in values], color=[colours[s] for s in states], width=0.66
        )
        axis.bar_label(
            bars,
            ["no balance" if v is None else f"{v:.2g}" for v in values],
            color=colours["ink"],
            fontsize=9,
            padding=2,
        )
        axis.set_xticks(range(len(states)), [SHORT[state] for state in states], fontsize=8.5)
        axis.set_title(
            test["test"] + ("\n(never fitted)" if test["held_out_test"] else ""),
            fontsize=9.5,
            loc="left",
            color=colours["ink"],
        )
        axis.set_ylabel(f"error, {test['unit']}", color=colours["ink"], fontsize=9)
        axis.margins(y=0.15)
        _plain(axis, colours)
    return figure


def png(figure) -> bytes:
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=150, facecolor="white")
    return out.getvalue()


def svg(figure) -> str:
    """An <svg> that fills its place and takes its colours from the page around it."""
    import matplotlib

    out = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "handgen"}):
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    for name, colour in MARKS.items():
        text = text.replace(colour, f"var(--{name})")
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    head, rest = text.split(">", 1)
    return re.sub(r' (width|height)="[^"]*"', "", head) + ' role="img">' + rest


def shown(document: dict[str, Any]) -> list[str]:
    """The models to draw: without an effect the patched one is the re-tuned one."""
    return list(STATES) if document["patch"] else ["before", "retuned"]


def _curve(axis, curve: dict[str, Any], states: list[str], colours: dict[str, str]) -> None:
    for state in states:
        axis.plot(
            *_pairs(curve["loads"], curve[state]),
            color=colours[state],
            linestyle=DASHES[state],
            linewidth=1.8,
            label=STATES[state],
        )
    dots = [
        (load, r)
        for row in curve["repeats"]
        for load, r in zip(curve["loads"], row, strict=True)
        if r is not None
    ]
    axis.plot(
        *zip(*dots, strict=True), "o", color=colours["ink"], markersize=3.5, alpha=0.6, label="measured"
    )
    axis.set_title(curve["title"], fontsize=10, loc="left", color=colours["ink"])
    axis.set_ylabel(f"{READINGS[curve['quantity']]}, {curve['unit']}", color=colours["ink"], fontsize=9)
    _plain(axis, colours)


def _residuals(axis, curve: dict[str, Any], states: list[str], colours: dict[str, str]) -> None:
    """Simulated less measured; the band is what two deviations of the repeats allow."""
    loads = curve["loads"]
    means = [[r for r in column if r is not None] for column in zip(*curve["repeats"], strict=True)]
    means = [sum(column) / len(column) if column else None for column in means]
    band = [(load, s) for load, s in zip(loads, curve["sigma"], strict=True) if s is not None]
    if band:
        x, s = zip(*band, strict=True)
        axis.fill_between(x, [-2 * v for v in s], [2 * v for v in s], color=colours["grid"], linewidth=0)
    for state in states:
        off = [None if v is None or m is None else v - m for v, m in zip(curve[state], means, strict=True)]
        axis.plot(
            *_pairs(loads, off),
            marker="o",
            color=colours[state],
            linestyle=DASHES[state],
            markersize=3.5,
            linewidth=1.4,
        )
    for load, may in zip(loads, curve["fitted"], strict=True):
        if not may:
            axis.annotate(
                "not fitted",
                (load, 0.02),
                xycoords=("data", "axes fraction"),
                fontsize=7.5,
                ha="right",
                color=colours["ink"],
            )
    axis.axhline(0, color=colours["ink"], linewidth=0.7)
    axis.set_xlabel(f"{LOADS[curve['load']]}, {curve['load_unit']}", color=colours["ink"], fontsize=9)
    axis.set_ylabel(f"off by, {curve['unit']}", color=colours["ink"], fontsize=9)
    _plain(axis, colours)


def _pairs(loads: list[float], values: list[float | None]) -> tuple[list[float], list[float]]:
    there = [(load, value) for load, value in zip(loads, values, strict=True) if value is not None]
    return [load for load, _ in there], [value for _, value in there]


def percent(share: float) -> str:
    return f"{100 * share:.1f} %" if share < 0.999 else "above 99.9 %"


def _figure(width: float, height: float):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _plain(axis, colours: dict[str, str]) -> None:
    axis.grid(color=colours["grid"], linewidth=0.6)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
    for side in ("left", "bottom"):
        axis.spines[side].set_color(colours["ink"])
    axis.tick_params(colors=colours["ink"], labelsize=8.5)
