"""One picture of a curling finger: cut open along the plane of bending, coloured by stretch."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from handgen.bending.surface import surface
from handgen.export import preview
from handgen.simulation.case import Curve, State

SIDE = preview.Camera((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""From the cut, dorsal side up, fingertip to the right."""
COLUMNS = 3
BAR, BAR_HIGH, BAR_WIDE = 110, 60, 0.5
"""Height of the strip under the fingers, and of the colour bar in it, pixels; its share of the width."""
COLOURS = "YlOrRd"
"""Pale where little is strained: the section stays visible."""
INK = "#26262e"
SHARP = 30.0
"""Edges that turn by more than this, deg, are drawn."""
AMBIENT = 0.4
"""Share of the light that comes from everywhere: a colour is read, also inside a bore."""
LEAST_RANGE = 0.05
"""Of stretch: a finger that is hardly strained is not shown in all colours."""


def draw(path: Path, curve: Curve, states: Sequence[State], labels: Sequence[str],
         plane: float | None = None) -> None:
    """The fingers of `states` side by side to one scale, their roots in line, with one colour bar.

    `plane`: height z of an obstacle, mm, drawn as a line.

    Raises:
        EngineError: this machine cannot draw off screen.
    """
    import pyvista

    axes = SIDE.axes()
    surfaces = {body: surface(grid) for body, grid in curve.grids.items()}
    everything = np.vstack([p for state in states for p in state.positions.values()]) @ axes[:2].T
    low, high = everything.min(axis=0), everything.max(axis=0)
    if plane is not None:
        low[1] = min(low[1], plane)
    scale, height, places = preview.layout([(low, high)] * len(states), min(COLUMNS, len(states)))
    height += BAR
    most = max(float(s.max()) for state in states for s in state.stretch.values())
    plotter, coloured = preview.canvas(height), None
    for state, label, (centre, (left, below)) in zip(states, labels, places, strict=True):
        centre, below = centre + np.array([0, BAR]), below + BAR
        shift = ((centre - np.array([preview.WIDTH, height]) / 2) / scale - (low + high) / 2) @ axes[:2]
        for body, positions in state.positions.items():
            mesh = pyvista.PolyData.from_regular_faces(positions + shift, surfaces[body].triangles)
            mesh.cell_data["stretch"] = state.stretch[body][surfaces[body].owner]
            coloured = plotter.add_mesh(
                mesh.compute_normals(split_vertices=True, feature_angle=SHARP, auto_orient_normals=False,
                                     consistent_normals=False),
                scalars="stretch", clim=(1.0, max(most, 1.0 + LEAST_RANGE)), cmap=COLOURS,
                show_scalar_bar=False, interpolation="gouraud", ambient=AMBIENT, diffuse=1.0 - AMBIENT)
            lines = mesh.extract_feature_edges(SHARP, manifold_edges=False, non_manifold_edges=False)
            plotter.add_mesh(lines, color=INK, line_width=1.2)
        if plane is not None:
            ends = np.array([(low[0], 0.0, plane), (high[0], 0.0, plane)]) + shift
            plotter.add_mesh(pyvista.Line(*ends), color=INK, line_width=3)
        preview.caption(plotter, label, (left, below))
    plotter.add_scalar_bar("", mapper=coloured.mapper, n_labels=5, fmt="%.2f", color=INK, label_font_size=20,
                           width=BAR_WIDE, height=BAR_HIGH / height, position_x=(1 - BAR_WIDE) / 2,
                           position_y=8 / height)
    preview.caption(plotter, "largest principal stretch", (preview.WIDTH / 2, BAR_HIGH + 30))
    preview.light(plotter, axes, height / scale)
    plotter.screenshot(str(path))
    plotter.close()
