"""For tests that slice: skipped with a reason where a slicer is missing; plain bodies to slice."""

import manifold3d
import numpy as np
import pytest

from handgen.export import stl
from handgen.geometry.mesh_kernel import Triangles
from handgen.slicing import engines, gcode, table

ABSENT = [reason for slicer in engines.SLICERS if (reason := engines.missing(slicer))]
needs_slicers = pytest.mark.skipif(bool(ABSENT), reason="; ".join(ABSENT))


def box(x, y, z):
    """A block about the origin on z = 0."""
    return triangles(manifold3d.Manifold.cube((x, y, z), True).translate((0, 0, z / 2)))


def triangles(solid):
    mesh = solid.to_mesh()
    return Triangles(np.asarray(mesh.vert_properties[:, :3], np.float32), np.asarray(mesh.tri_verts))


def cut(slicer, profile, machine, mesh, folder):
    """(what the slicer says, toolpath) of a mesh."""
    file, target = folder / "part.stl", folder / f"part.{slicer}.gcode"
    file.write_bytes(stl.to_bytes(mesh))
    ran = engines.run(slicer, profile, machine, file, target)
    return ran, gcode.read(target)


def rows(profile, path, volume):
    return {row.row: row for row in table.compare(profile, path, volume)}
