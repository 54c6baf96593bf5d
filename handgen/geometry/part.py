"""A part: a named piece of geometry that somebody prints, casts or winds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from handgen.errors import GeometryError
from handgen.geometry import csg

if TYPE_CHECKING:
    import cadquery
    import trimesh

    from handgen.geometry.mesh_kernel import Triangles


@dataclass(frozen=True)
class Body:
    """One named, coloured solid inside a part's STEP file (an actuator has three layers)."""

    name: str
    shape: csg.Shape
    colour: tuple[float, float, float]


@dataclass(frozen=True)
class Part:
    """One part of the hand, in the frame of the contract (mm).

    `name` is its path in the output folder without ending ("tooling/index/mould_a"), `path` the
    key path of the parameters that shape it, `up` the direction in its own frame that points up
    on the print bed. `bodies` is what STEP shows when that differs from `shape` (layers of an
    actuator, the unblended hand).
    """

    name: str
    role: str
    material: str
    shape: csg.Shape
    colour: tuple[float, float, float]
    path: str
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    bodies: tuple[Body, ...] = ()

    @property
    def key(self) -> str:
        """Hash of everything that determines the part's files."""
        return csg.digest((self.name, self.role, self.material, self.shape, self.colour,
                           self.up, self.bodies))

    @cached_property
    def triangles(self) -> Triangles:
        """The mesh that is exported: vertices and faces.

        Raises:
            GeometryError: the parameters leave no closed solid.
        """
        from handgen.geometry.mesh_kernel import evaluate, triangles

        try:
            return triangles(evaluate(self.shape))
        except ValueError as error:
            raise GeometryError(self.name, self.path, str(error)) from error

    @cached_property
    def mesh(self) -> trimesh.Trimesh:
        """`triangles` as a trimesh."""
        import trimesh

        return trimesh.Trimesh(*self.triangles, process=False)

    @cached_property
    def solid(self) -> cadquery.Shape:
        """The B-rep, one solid or a compound of `bodies`.

        Raises:
            GeometryError: OCCT cannot make a valid solid of these parameters.
        """
        from cadquery import Compound

        solids = [solid for _, solid, _ in self.solids()]
        return solids[0] if len(solids) == 1 else Compound.makeCompound(solids)

    @property
    def wrapped(self):
        """The OCCT shape; by it CQ-editor's and ocp-vscode's `show_object` know what they can draw."""
        return self.solid.wrapped

    def solids(self) -> list[tuple[str, cadquery.Shape, tuple[float, float, float]]]:
        """(name, B-rep, colour) of every body for STEP."""
        from handgen.geometry.brep_kernel import evaluate

        bodies = self.bodies or (Body(self.name.rsplit("/", 1)[-1], self.shape, self.colour),)
        try:
            return [(b.name, evaluate(b.shape), b.colour) for b in bodies]
        except ValueError as error:
            raise GeometryError(self.name, self.path, str(error)) from error
