"""Rulers for meshes: what a person with calipers would measure on the printed part."""

import numpy as np
import trimesh


def section_radii(mesh: trimesh.Trimesh, x: float) -> np.ndarray:
    """Largest distance from the x axis of each closed outline in the section at x, ascending, mm.

    The largest, because an outline of chords touches its circle in its corners.
    """
    section = mesh.section(plane_origin=(x, 0, 0), plane_normal=(1, 0, 0))
    if section is None:
        return np.array([])
    return np.sort([np.hypot(loop[:, 1], loop[:, 2]).max() for loop in section.discrete])


def walls_along(mesh: trimesh.Trimesh, origin, direction) -> np.ndarray:
    """Distances from `origin` at which a ray passes the surface, ascending, mm."""
    hits, _, _ = mesh.ray.intersects_location([origin], [direction], multiple_hits=True)
    return np.unique(np.round(np.linalg.norm(hits - np.asarray(origin), axis=1), 6))


def assert_printable(mesh: trimesh.Trimesh) -> None:
    """Closed, one body, outward, no triangle without area."""
    assert mesh.is_watertight and mesh.is_winding_consistent
    assert mesh.volume > 0
    assert mesh.body_count == 1
    assert mesh.area_faces.min() > 0
