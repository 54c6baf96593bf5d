"""What is to be known of any STL before it is printed: size, volume, closed or not, its walls.

The mesh is taken as it is in the file: nothing is repaired. Surfaces that pass through one another
are not looked for; there the walls are those of the surfaces, not of what a slicer makes of them.
"""

from __future__ import annotations

import hashlib
import math
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from handgen.checks import stl_file
from handgen.geometry.measure import FLAT, weld
from handgen.geometry.mesh_kernel import Triangles
from handgen.geometry.surface import Surface
from handgen.geometry.thickness import BREADTH, COARSE, PARALLEL, ROUNDING, Gauge

SCHEMA = "handgen.measure/1"
PERCENTILES = (1, 5, 25, 50, 75, 95)
BINS = (0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)
"""Between these thicknesses, mm, lie the histogram's classes; below and above is one more each."""
SAMPLES = (4e3, 1e6)
"""Least and most places where a mesh is gauged. Beyond, the gauge is set on a larger or smaller copy."""
METRES = 2.0
"""A part whose longest side is shorter, mm, was probably drawn in metres."""
ASIDE = np.array([1.0, 0.0137, 0.0071])
"""A direction along which hardly any two meshes have an edge in line."""
FLATNESS = 1e-9
"""A mesh that encloses less than this share of its area to the power of 3/2 is flat; rounding does."""
NO_FACING = "no two of its surfaces face one another"


def measure_stl(path: str | os.PathLike) -> dict[str, Any]:
    """The report `handgen.measure/1` of the STL at `path`, whose unit is taken to be mm.

    {"schema", "file", "sha256", "format", "passed", "watertight", "triangles", "degenerate_triangles",
    "bbox_mm", "size_mm", "area_mm2", "volume_mm3", "edges": {"open", "crowded", "flipped"},
    "fault_at", "bodies", "voids", "inside_out", "thickness", "thickness_missing", "hints"}.

    `passed`: every edge joins exactly two triangles that agree about outside, no body is inside
    out, and something is enclosed. `edges` counts those with one triangle, with more than two, and
    with two that disagree; `fault_at` is one of them. `bodies` are counted without the shells around
    `voids`. `volume_mm3` is null for a mesh that encloses none. `thickness` is null, with the reason
    in `thickness_missing`, or {"least_mm", "at", "area_mm2" of the spot, "percentiles_mm",
    "histogram": [{"from_mm", "to_mm", "area_mm2"}], "finest_spot_mm"}: spots less broad than the
    last are not looked for.

    Raises:
        InputError: the file is missing or no whole STL with finite coordinates.
    """
    path = Path(path)
    kind, corners = stl_file.read(path)
    mesh = Mesh.of(corners)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    thickness, missing = (None, mesh.unclosed) if mesh.unclosed else _thickness(mesh)
    return {
        "schema": SCHEMA,
        "file": str(path),
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "format": kind,
        "passed": not mesh.unclosed and mesh.watertight and not len(mesh.inside_out),
        "watertight": mesh.watertight,
        "triangles": len(corners),
        "degenerate_triangles": len(corners) - int((mesh.areas >= FLAT).sum()),
        "bbox_mm": [low.tolist(), high.tolist()],
        "size_mm": (high - low).tolist(),
        "area_mm2": float(mesh.areas.sum()),
        "volume_mm3": None if mesh.unclosed else float(mesh.volumes.sum()),
        "edges": mesh.edges,
        "fault_at": mesh.fault_at,
        "bodies": mesh.shells - len(mesh.voids),
        "voids": len(mesh.voids),
        "inside_out": len(mesh.inside_out),
        "thickness": thickness,
        "thickness_missing": missing,
        "hints": _hints(mesh, float((high - low).max())),
    }


@dataclass(frozen=True)
class Mesh:
    """Vertices (n, 3), mm, each place once, and the faces (m, 3) that have three corners."""

    vertices: np.ndarray
    faces: np.ndarray

    @classmethod
    def of(cls, corners: np.ndarray) -> Mesh:
        """From the `corners` (n, 3, 3) of an STL."""
        points = corners.reshape(-1, 3)
        number = weld(points)
        _, first = np.unique(number, return_index=True)
        faces = number.reshape(-1, 3)
        return cls(points[first], faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)])

    @cached_property
    def _seams(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(edge of every side of the faces; per edge its faces, and those one way less those the other)."""
        start, end = self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()
        code = np.minimum(start, end) * len(self.vertices) + np.maximum(start, end)
        _, edge, count = np.unique(code, return_inverse=True, return_counts=True)
        return edge, count, np.bincount(edge, np.where(start < end, 1, -1), len(count)).astype(int)

    @cached_property
    def edges(self) -> dict[str, int]:
        """Edges of one face, of more than two, and of two that run along it in the same direction."""
        _, count, net = self._seams
        return {"open": int((count == 1).sum()), "crowded": int((count > 2).sum()),
                "flipped": int(((count == 2) & (net != 0)).sum())}

    @property
    def watertight(self) -> bool:
        return len(self.faces) > 0 and not any(self.edges.values())

    @cached_property
    def unclosed(self) -> str:
        """Why the mesh encloses nothing; empty for one that does."""
        if not len(self.faces):
            return "all its triangles are without area"
        if self._seams[2].any():
            return f"it is not closed: {_listed(self.edges)}"
        flat = np.abs(self._signed).sum() <= FLATNESS * self.areas.sum() ** 1.5
        return "it is flat and encloses nothing" if flat else ""

    @cached_property
    def areas(self) -> np.ndarray:
        """Area of each face, mm2."""
        a, b, c = self.vertices[self.faces].transpose(1, 0, 2)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2

    @property
    def fault_at(self) -> list[float] | None:
        """The middle of the faulty edge that is nearest to the middle of them all."""
        edge, count, net = self._seams
        side = np.flatnonzero(((count != 2) | (net != 0))[edge])
        if not len(side):
            return None
        ends = np.stack([self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()])[:, side]
        middles = self.vertices[ends].mean(axis=0)
        return middles[np.linalg.norm(middles - middles.mean(axis=0), axis=1).argmin()].tolist()

    @cached_property
    def shell(self) -> np.ndarray:
        """Number of the shell of each face: faces that edges of two faces join."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        edge, count, _ = self._seams
        side = np.flatnonzero((count == 2)[edge])
        one, two = side[np.argsort(edge[side], kind="stable")].reshape(-1, 2).T // 3
        joined = coo_array((np.ones(len(one), bool), (one, two)), 2 * (len(self.faces),))
        return connected_components(joined, directed=False)[1]

    @cached_property
    def shells(self) -> int:
        return int(self.shell.max(initial=-1)) + 1

    @cached_property
    def _signed(self) -> np.ndarray:
        """Volume that each shell encloses, mm3; below 0: its faces look inwards."""
        # About the middle: far from the origin the sum would lose digits.
        a, b, c = (self.vertices - self.vertices.mean(axis=0))[self.faces].transpose(1, 0, 2)
        return np.bincount(self.shell, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6, self.shells)

    @cached_property
    def voids(self) -> np.ndarray:
        """Shells that look inwards because they surround a void within a body."""
        negative = np.flatnonzero(self._signed < 0.0)
        if self.unclosed or not len(negative):
            return negative[:0]
        # From a shell's furthest point outwards lies the body around it, seen from inside, if there is one.
        away = ASIDE / np.linalg.norm(ASIDE)
        along = (self.vertices @ away)[self.faces].max(axis=1)
        order = np.lexsort((along, self.shell))
        furthest = order[np.searchsorted(self.shell[order], negative, side="right") - 1]
        corner = (self.vertices @ away)[self.faces[furthest]].argmax(axis=1)
        points = self.vertices[self.faces[furthest, corner]]
        middle, scale = self._copy
        struck = Surface((self.vertices - middle) * scale, self.faces).shoot(
            (points - middle) * scale, np.tile(away, (len(points), 1)))[1]
        return negative[struck >= 0]

    @cached_property
    def inside_out(self) -> np.ndarray:
        """Shells that look inwards and surround no void."""
        return np.setdiff1d(np.flatnonzero(self._signed < 0.0), self.voids)

    @property
    def volumes(self) -> np.ndarray:
        """Volume of each shell, mm3, negative for a void; bodies inside out count as what they mean."""
        signed = self._signed.copy()
        signed[self.inside_out] *= -1.0
        return signed

    @cached_property
    def _copy(self) -> tuple[np.ndarray, float]:
        """(middle, scale) of the copy on which the gauge takes no fewer and no more samples than SAMPLES."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        samples = COARSE * float(self.areas.sum())
        return (low + high) / 2, math.sqrt(np.clip(samples, *SAMPLES) / samples)

    def gauged(self) -> tuple[Gauge, np.ndarray, float]:
        """(gauge on a copy of this mesh with every body outside out, its middle, its scale)."""
        middle, scale = self._copy
        turned = np.isin(self.shell, self.inside_out)[:, None]
        faces = np.where(turned, self.faces[:, ::-1], self.faces)
        return Gauge(Triangles((self.vertices - middle) * scale, faces)), middle, scale


def _thickness(mesh: Mesh) -> tuple[dict[str, Any] | None, str]:
    """(the walls of a closed mesh, "") or (None, why there are none)."""
    gauge, middle, scale = mesh.gauged()
    walls = gauge.walls.where(gauge.walls.parallel > PARALLEL)
    least = gauge.least() if len(walls.points) else None
    if least is None:
        return None, NO_FACING
    edges = np.array([0.0, *BINS, max(2 * BINS[-1], walls.thickness.max() / scale * 1.001)])
    # A wall drawn between two classes belongs to the upper one, rounded as it may be.
    areas = gauge.histogram((edges - ROUNDING) * scale) / scale**2
    return {
        "least_mm": least.thickness / scale,
        "at": (np.array(least.middle) / scale + middle).tolist(),
        "area_mm2": least.area / scale**2,
        "percentiles_mm": {str(p): float(np.percentile(walls.thickness, p)) / scale for p in PERCENTILES},
        "histogram": [{"from_mm": float(a), "to_mm": float(b), "area_mm2": float(area)}
                      for a, b, area in zip(edges, edges[1:], areas, strict=False)],
        "finest_spot_mm": BREADTH / scale,
    }, ""


def _hints(mesh: Mesh, longest: float) -> list[str]:
    found = []
    if longest < METRES:
        found.append(f"its longest side is {longest:.3g} mm: if it was drawn in metres, scale it by 1000")
    if not mesh.unclosed and mesh.edges["crowded"]:
        found.append("bodies, or parts of one, touch along an edge; move them apart or into one another")
    if len(mesh.inside_out):
        found.append(f"{_number(len(mesh.inside_out), 'body is', 'bodies are')} inside out")
    return found


def _listed(edges: dict[str, int]) -> str:
    names = {"open": "with one triangle", "crowded": "with more than two", "flipped": "whose two disagree"}
    return ", ".join(f"{_number(count, 'edge', 'edges')} {names[kind]}"
                     for kind, count in edges.items() if count)


def _number(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"
