"""A mesh as arrays, whoever made it, and its way into NGSolve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MIDDLE = "middle"
"""Name of the surface in the plane of symmetry, of every body."""


@dataclass(frozen=True)
class Drawing:
    """One body with straight edges."""

    name: str
    nodes: np.ndarray
    """(n, 3) mm."""
    solids: list[tuple[int, ...]]
    """Corners: 4 of a tetrahedron, 6 of a prism, 8 of a hexahedron (two ends, one above the other)."""
    faces: dict[str, list[tuple[int, ...]]]
    """Surface -> corners of its faces; normals out of the body. An "inner" one cuts through it."""


def mesh_of(bodies: list[Drawing]):
    """The bodies as one NGSolve mesh, each the domain of its name; they share no node."""
    import ngsolve as ng
    from netgen.meshing import Element2D, Element3D, FaceDescriptor, Mesh, MeshPoint, Pnt

    mesh, names = Mesh(), []
    for material, body in enumerate(bodies, start=1):
        mesh.SetMaterial(material, body.name)
        used = np.unique(np.concatenate([np.ravel(solid) for solid in body.solids]))
        number = {int(n): mesh.Add(MeshPoint(Pnt(*body.nodes[n]))) for n in used}
        for solid in body.solids:
            mesh.Add(Element3D(material, [number[n] for n in solid]))
        for name, faces in body.faces.items():
            names.append(name)
            inside = material if name.startswith("inner") else 0
            index = mesh.Add(FaceDescriptor(surfnr=len(names), domin=material, domout=inside, bc=len(names)))
            for face in faces:
                mesh.Add(Element2D(index, [number[n] for n in face]))
    for index, name in enumerate(names):
        mesh.SetBCName(index, name)
    return ng.Mesh(mesh)
