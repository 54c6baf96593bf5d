"""What a worker does: the mesh of a part, its B-rep, and what the rules say of the meshes."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from handgen import checks
from handgen.checks.rule import Outcome
from handgen.errors import GeometryError
from handgen.export import step, stl, threemf
from handgen.geometry import csg
from handgen.geometry.catalogue import catalogue
from handgen.geometry.measure import Facts, measure, read_stl
from handgen.geometry.part import Part
from handgen.parameters.model import Hand

if TYPE_CHECKING:
    from handgen.geometry.mesh_kernel import Triangles

AGREEMENT = 0.005
"""Largest difference of a mesh's volume from its B-rep's, as a share (contract)."""
INTEGRAL = 1e-4
"""Share to which OCCT integrates a B-rep's volume."""
HAND = "exoskeleton/hand"
BLENDED_NOTE = (f"{HAND}.step is the unblended body: its step_volume_mm3 was held against the mesh of "
                "that same body, not against the blended skin of the STL")


@dataclass(frozen=True)
class Meshed:
    """A part's files without its B-rep's, and what was measured on the STL."""

    facts: Facts
    expected_mm3: float
    """Volume that the B-rep must have, by the mesh kernel."""
    files: dict[str, str]
    """Path relative to the build -> sha256."""


@dataclass(frozen=True)
class Solid:
    """A part's STEP file and the volume of what it holds."""

    volume_mm3: float
    files: dict[str, str]


def mesh(part: Part, stage: Path, extra: dict[str, bytes]) -> Meshed:
    """Write the STL of `part` below `stage`; `extra` maps further endings to their contents.

    Everything about the mesh is measured on the bytes of the STL.

    Raises:
        GeometryError: the parameters leave no closed solid.
    """
    from handgen.geometry import mesh_kernel

    triangles = part.triangles
    content = stl.to_bytes(triangles)
    facts = measure(read_stl(content))
    expected = facts.volume_mm3
    if blended(part.shape):
        # A blended skin has no B-rep: STEP shows the part's unblended bodies.
        expected = sum(mesh_kernel.evaluate(body.shape).volume() for body in part.bodies)
    mesh_kernel.forget()
    files = {".stl": content, **extra}
    if part.name == HAND:
        files[".3mf"] = threemf.to_bytes(triangles, part.name.rsplit("/", 1)[-1], part.material, part.colour)
    target = stage / part.name
    target.parent.mkdir(parents=True, exist_ok=True)
    for ending, data in files.items():
        Path(f"{target}{ending}").write_bytes(data)
    return Meshed(facts, expected, {f"{part.name}{ending}": hashlib.sha256(data).hexdigest()
                                    for ending, data in files.items()})


def solid(part: Part, stage: Path, meshed: Meshed) -> Solid:
    """Write the STEP of `part` beside its STL, after holding the two kernels against each other.

    Raises:
        GeometryError: a fault in the mesh, no valid B-rep, or kernels that disagree.
    """
    from handgen.geometry import brep_kernel

    for fault in meshed.facts.faults():
        raise GeometryError(part.name, part.path, f"the mesh {fault}")
    solids = part.solids()
    # Without a tolerance OCCT integrates a spline face in a few points, up to 1 % off.
    volume = sum(solid.Volume(INTEGRAL) for _, solid, _ in solids)
    if abs(volume - meshed.expected_mm3) > AGREEMENT * meshed.expected_mm3:
        raise GeometryError(
            part.name, part.path,
            f"mesh and B-rep disagree: {meshed.expected_mm3:.2f} and {volume:.2f} mm3")
    path = stage / f"{part.name}.step"
    path.parent.mkdir(parents=True, exist_ok=True)
    step.write(path, path.stem, solids)
    if part.role != "exoskeleton":
        # Only the hand's fingers are made a second time.
        brep_kernel.forget()
    return Solid(volume, {f"{part.name}.step": hashlib.sha256(path.read_bytes()).hexdigest()})


@dataclass(frozen=True)
class Printed(Part):
    """A part whose mesh is read from the STL that was written."""

    file: Path = Path()

    @cached_property
    def triangles(self) -> Triangles:
        from handgen.geometry.mesh_kernel import Triangles

        return Triangles(*welded(self.file))


def judge(rules: tuple[str, ...], hand: Hand, names: tuple[str, ...], stage: Path,
          file: str) -> list[Outcome]:
    """What `rules` say of the parts `names` whose meshes lie in `stage`, one after the other."""
    listed = catalogue(hand)
    made = {name: _printed(listed[name], stage) for name in names}
    limits = checks.own_limits(hand, file)
    return [checks.outcome(rule, hand, made, limits) for rule in rules]


def _printed(part: Part, stage: Path) -> Printed:
    known = {f.name: getattr(part, f.name) for f in fields(part)}
    return Printed(**known, file=stage / f"{part.name}.stl")


def welded(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and faces (m, 3) of an STL; equal corners are one vertex."""
    corners = np.ascontiguousarray(read_stl(path.read_bytes())).reshape(-1, 3)
    _, first, faces = np.unique(corners.view("V12"), return_index=True, return_inverse=True)
    return corners[first], faces.reshape(-1, 3)


def blended(shape: object) -> bool:
    """Whether a tree holds a blended skin anywhere."""
    if isinstance(shape, csg.Field):
        return True
    if isinstance(shape, tuple):
        return any(map(blended, shape))
    return is_dataclass(shape) and any(blended(getattr(shape, f.name)) for f in fields(shape))
