"""Plots of a sweep: main effects, parallel coordinates, the Pareto front."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from handgen import atomic

MOST_LINES = 2000
"""Rows drawn as lines; an even choice of more."""
WIDTH = 11.0
"""Inches."""


def draw(frame, about: dict[str, Any], document: dict[str, Any], folder: Path) -> list[Path]:
    """PNG files in `folder`; those that the sweep has nothing for are left out."""
    import matplotlib

    matplotlib.use("Agg")
    made = [_effects(document, folder)]
    explained = [name for name in document["effects"] if frame[name].notna().any()]
    numeric = [axis for axis in document["axes"] if frame[axis].dtype.kind in "if"]
    if explained:
        made.append(_parallel(frame, numeric, explained, folder))
    if len(about["objectives"]) > 1:
        made.append(_pareto(frame, about, folder))
    return [path for path in made if path is not None]


def short(name: str) -> str:
    """An axis's name without what leads to it."""
    keys = [key for key in name.replace("[", ".").replace("]", "").split(".") if key != "*"]
    return ".".join(keys[-2:]) if len(keys) > 2 and len(keys[-1]) < 5 else keys[-1]


def front(costs: np.ndarray) -> np.ndarray:
    """(n,) whether a row is beaten by no other in every one of its costs (n, m), least best; NaN never is."""
    whole = np.isfinite(costs).all(axis=1)
    order = np.lexsort(costs[:, ::-1].T)
    best = np.zeros(len(costs), bool)
    if costs.shape[1] == 2:
        least = np.inf
        for i in order:
            if whole[i] and costs[i, 1] < least:
                best[i], least = True, costs[i, 1]
        return best
    kept: list[int] = []
    for i in order:
        if whole[i] and not (len(kept) and (costs[kept] <= costs[i]).all(axis=1).any()):
            kept.append(i)
    best[kept] = True
    return best


def costs(frame, about: dict[str, Any]) -> np.ndarray:
    """Objectives as numbers of which less is better; NaN where a row breaks a rule or a bound."""
    signs = [-1.0 if way == "maximise" else 1.0 for way in about["objectives"].values()]
    found = frame[list(about["objectives"])].to_numpy(float) * signs
    out = ~((frame["status"] == "done") & (frame["rules_passed"] != 0.0)).to_numpy()
    for name, bound in about["constraints"].items():
        out |= ~frame[name].between(bound.get("min", -np.inf), bound.get("max", np.inf)).to_numpy()
    found[out] = np.nan
    return found


def _effects(document: dict[str, Any], folder: Path) -> Path | None:
    from matplotlib import pyplot as plt

    rows, axes = document["effects"], document["axes"]
    if not rows:
        return None
    figure, panels = plt.subplots(len(rows), len(axes), squeeze=False, sharey="row",
                                  figsize=(max(4.0, min(2.4 * len(axes), 20.0)), 2.3 * len(rows)))
    for line, (result, found) in zip(panels, rows.items(), strict=True):
        for panel, axis in zip(line, axes, strict=True):
            points = found["main"][axis]["points"]
            where = [p["value"] for p in points]
            panel.plot(where, [p["mean"] for p in points], "o-", ms=3, lw=1.2, color="#2b6ca3")
            panel.tick_params(labelsize=7)
            indices = found["sobol"].get("axes", {}).get(axis)
            title = short(axis) + (f"\nS1 {indices['S1']:.2f}  ST {indices['ST']:.2f}" if indices else "")
            panel.set_title(title, fontsize=8)
            panel.grid(alpha=0.3)
        line[0].set_ylabel(result, fontsize=8)
    return _saved(figure, folder / "effects.png")


def _parallel(frame, axes: list[str], explained: list[str], folder: Path) -> Path:
    from matplotlib import pyplot as plt

    names = [*axes, *explained]
    data = frame[names].to_numpy(float)
    data = data[np.isfinite(data).all(axis=1)]
    if len(data) > MOST_LINES:
        data = data[np.linspace(0, len(data) - 1, MOST_LINES).astype(int)]
    figure, panel = plt.subplots(figsize=(WIDTH, 4.0))
    if len(data):
        low, high = data.min(0), data.max(0)
        scaled = (data - low) / np.where(high > low, high - low, 1.0)
        faint = max(0.08, min(0.7, 60 / len(data)))
        colour = plt.get_cmap("viridis")(scaled[:, len(axes)])
        for i in np.argsort(scaled[:, len(axes)]):
            panel.plot(range(len(names)), scaled[i], color=colour[i], lw=1, alpha=faint)
        for x, (a, b) in enumerate(zip(low, high, strict=True)):
            panel.text(x, -0.05, f"{a:.3g}", ha="center", va="top", fontsize=7)
            panel.text(x, 1.03, f"{b:.3g}", ha="center", fontsize=7)
    panel.set_xticks(range(len(names)), [short(n) if n in axes else n for n in names], fontsize=8)
    panel.tick_params(axis="x", pad=14, length=0)
    panel.set_yticks([])
    panel.vlines(range(len(names)), 0, 1, color="#888888", lw=0.8)
    for side in ("top", "right", "left", "bottom"):
        panel.spines[side].set_visible(False)
    return _saved(figure, folder / "parallel.png")


def _pareto(frame, about: dict[str, Any], folder: Path) -> Path:
    from matplotlib import pyplot as plt

    names, cost = list(about["objectives"]), costs(frame, about)
    best, allowed = front(cost), np.isfinite(cost).all(axis=1)
    x, y = frame[names[0]].to_numpy(float), frame[names[1]].to_numpy(float)
    figure, panel = plt.subplots(figsize=(6.0, 4.5))
    size = float(np.clip(8 * MOST_LINES / max(len(x), 1), 0.5, 8))
    panel.scatter(x[~allowed], y[~allowed], s=size, lw=0, color="#bbbbbb", label="breaks a rule or a bound")
    panel.scatter(x[allowed], y[allowed], s=size, lw=0, color="#2b6ca3", label="keeps to all")
    panel.scatter(x[best], y[best], s=22, color="#d1495b", label="not beaten")
    panel.set_xlabel(names[0])
    panel.set_ylabel(names[1])
    panel.grid(alpha=0.3)
    for handle in panel.legend(fontsize=8).legend_handles:
        handle.set_sizes([22])
    return _saved(figure, folder / "pareto.png")


def _saved(figure, path: Path) -> Path:
    from matplotlib import pyplot as plt

    figure.tight_layout()
    with atomic.writing(path) as beside:
        figure.savefig(beside, dpi=110, format="png", metadata={"Software": None})
    plt.close(figure)
    return path
