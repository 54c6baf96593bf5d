"""Outlines of lettering, shared by both kernels so that they emboss the same shapes."""

from __future__ import annotations

import functools

FLATNESS = 0.04
"""Largest distance of the polygon from the glyph's curve, as a share of the capital height."""


@functools.cache
def outlines(text: str, size: float) -> list[tuple[list, list[list]]]:
    """(outer ring, holes) per separate piece, rings as lists of (x, y) in mm, centred.

    Glyphs come from matplotlib, because it ships its font: no machine differs. `size` is the
    height of a capital letter.
    """
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath
    from shapely import Polygon, affinity

    font = FontProperties(family="DejaVu Sans", weight="bold")
    capital = TextPath((0, 0), "H", size=100.0, prop=font).get_extents().height
    path = TextPath((0, 0), text, size=100.0 * size / capital, prop=font)
    rings = [Polygon(p) for p in path.to_polygons() if len(p) > 3]
    # Glyph outlines are even-odd: a counter is a ring inside a ring.
    ink = functools.reduce(Polygon.symmetric_difference, rings).simplify(FLATNESS * size).buffer(0)
    x0, y0, x1, y1 = ink.bounds
    ink = affinity.translate(ink, -(x0 + x1) / 2, -(y0 + y1) / 2)
    pieces = sorted(getattr(ink, "geoms", [ink]), key=lambda g: g.bounds)
    return [
        (list(g.exterior.coords)[:-1], [list(hole.coords)[:-1] for hole in g.interiors])
        for g in pieces
    ]
