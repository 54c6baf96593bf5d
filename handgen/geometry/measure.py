"""Facts about a mesh, measured from the very bytes of the STL that will be printed.

Independent of the kernels that made the mesh: only numpy, and scipy to tell bodies apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

HEADER = 80
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
FLAT = 1e-10
"""Area, mm2, below which a triangle is degenerate: what rounding leaves of a line of 0.01 mm."""


@dataclass(frozen=True)
class Facts:
    """What a closed triangle mesh encloses and what is wrong with it; mm, mm2, mm3."""

    volume_mm3: float
    area_mm2: float
    bbox_mm: tuple[tuple[float, float, float], tuple[float, float, float]]
    triangles: int
    bodies: int
    unpaired_edges: int
    degenerate_faces: int

    @property
    def watertight(self) -> bool:
        """Closed and consistently wound: every edge is run once in either direction."""
        return self.unpaired_edges == 0

    def faults(self) -> list[str]:
        """What keeps the mesh from being printed, in words; empty for a sound mesh."""
        found = []
        if self.unpaired_edges:
            found.append(f"is not watertight: {self.unpaired_edges} edges have no partner")
        if self.bodies != 1:
            found.append(f"falls into {self.bodies} bodies")
        if self.degenerate_faces:
            found.append(f"has {self.degenerate_faces} triangles without area")
        if not self.volume_mm3 > 0.0:
            found.append(f"encloses {self.volume_mm3:.4g} mm3: it is inside out or empty")
        return found


def read_stl(content: bytes) -> np.ndarray:
    """Corners (n, 3, 3) of a binary STL, float32, mm.

    Raises:
        ValueError: the bytes are not a whole binary STL.
    """
    count = int.from_bytes(content[HEADER:HEADER + 4], "little")
    if len(content) != HEADER + 4 + count * TRIANGLE.itemsize:
        raise ValueError(f"{len(content)} bytes are not a binary STL of {count} triangles")
    return np.frombuffer(content, TRIANGLE, offset=HEADER + 4)["corners"]


def measure(corners: np.ndarray) -> Facts:
    """Facts about the triangles with `corners` (n, 3, 3), mm: an STL, which names no vertices."""
    return measure_mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


def measure_mesh(vertices: np.ndarray, faces: np.ndarray) -> Facts:
    """Facts about the triangles `faces` (n, 3) of `vertices` (m, 3), mm; equal vertices are one."""
    points, number = vertices.astype(float), weld(vertices)
    welded = number[faces]
    a, b, c = points[faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    areas = 0.5 * np.sqrt(np.einsum("ij,ij->i", normals, normals))
    collapsed = (welded == np.roll(welded, 1, axis=1)).any(axis=1)
    unpaired, bodies = _connect(welded, int(number.max()) + 1)
    used = points[np.unique(faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    # About the middle of the box: far from the origin the sum would lose digits.
    volume = np.einsum("ij,ij->", a - (low + high) / 2, normals) / 6.0
    return Facts(
        volume_mm3=float(volume),
        area_mm2=float(areas.sum()),
        bbox_mm=(tuple(map(float, low)), tuple(map(float, high))),
        triangles=len(faces),
        bodies=bodies,
        unpaired_edges=unpaired,
        degenerate_faces=int(np.count_nonzero(collapsed | (areas < FLAT))),
    )


def weld(points: np.ndarray) -> np.ndarray:
    """The number of each of `points` (n, 3), counted from 0; equal coordinates are one vertex."""
    code = np.zeros(len(points), np.int64)
    for axis in range(3):
        values, rank = np.unique(points[:, axis], return_inverse=True)
        code = code * len(values) + rank
        # Renumbered after every axis, so that the product cannot overflow.
        _, code = np.unique(code, return_inverse=True)
    return code


def fault_place(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, float, float] | None:
    """Where a mesh is at fault: amid its open edges, else on its smallest body, else a flat triangle."""
    points, number = vertices.astype(float), weld(vertices)
    welded = number[faces]
    one, two = _partners(welded, int(number.max()) + 1)
    alone = np.setdiff1d(np.arange(faces.size), np.concatenate([one, two]))
    if len(alone):
        middles = (points[faces.ravel()[alone]] + points[np.roll(faces, -1, axis=1).ravel()[alone]]) / 2
        # Nearest to the middle of all, so that the place lies on an edge.
        return tuple(middles[np.linalg.norm(middles - middles.mean(axis=0), axis=1).argmin()].tolist())
    corners = points[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    count, body = _bodies(one, two, len(faces))
    if count > 1:
        small = corners[body == np.bincount(body, areas).argmin()]
        return tuple(small.mean(axis=(0, 1)).tolist())
    return tuple(corners[areas.argmin()].mean(axis=0).tolist()) if areas.min() < FLAT else None


def _connect(faces: np.ndarray, count: int) -> tuple[int, int]:
    """(directed edges without exactly one partner, bodies joined by paired edges)."""
    one, two = _partners(faces, count)
    return faces.size - 2 * len(one), _bodies(one, two, len(faces))[0]


def _partners(faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the directed edges (face * 3 + side) that run along one another once in either direction."""
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    code = np.minimum(start, end) * count + np.maximum(start, end)
    order = np.argsort(code, kind="stable")
    runs = np.flatnonzero(np.diff(code[order], prepend=-1))
    first = runs[np.diff(runs, append=len(order)) == 2]
    one, two = order[first], order[first + 1]
    paired = start[one] == end[two]
    return one[paired], two[paired]


def _bodies(one: np.ndarray, two: np.ndarray, count: int) -> tuple[int, np.ndarray]:
    """(bodies, that of each of `count` faces) joined by the paired edges `one` and `two`."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = (np.ones(len(one), bool), (one // 3, two // 3))
    bodies, body = connected_components(coo_array(links, shape=(count, count)), directed=False)
    return int(bodies), body
