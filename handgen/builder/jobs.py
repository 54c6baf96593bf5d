"""What a worker does: one part from its tree to verified files."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from handgen.errors import GeometryError
from handgen.export import step, stl, threemf
from handgen.geometry import csg
from handgen.geometry.measure import Facts, measure, read_stl
from handgen.geometry.part import Part

if TYPE_CHECKING:
    import cadquery

AGREEMENT = 0.005
"""Largest difference of a mesh's volume from its B-rep's, as a share (contract)."""
INTEGRAL = 1e-4
"""Share to which OCCT integrates a B-rep's volume."""
HAND = "exoskeleton/hand"
BLENDED_NOTE = (f"{HAND}.step is the unblended body: its step_volume_mm3 was held against the mesh of "
                "that same body, not against the blended skin of the STL")


@dataclass(frozen=True)
class Made:
    """A part's files and what was measured on them."""

    facts: Facts
    step_volume_mm3: float
    files: dict[str, str]
    """Path relative to the build -> sha256."""


def make(part: Part, stage: Path, extra: dict[str, bytes]) -> Made:
    """Write the files of `part` below `stage`; `extra` maps further endings to their contents.

    Everything about the mesh is measured on the bytes of the STL.

    Raises:
        GeometryError: no closed solid, a fault in the mesh, or kernels that disagree.
    """
    mesh = part.triangles
    content = stl.to_bytes(mesh)
    facts = measure(read_stl(content))
    for fault in facts.faults():
        raise GeometryError(part.name, part.path, f"the mesh {fault}")
    solids = part.solids()
    volume = _compare(part, facts, [solid for _, solid, _ in solids])

    files = {".stl": content, **extra}
    if part.name == HAND:
        files[".3mf"] = threemf.to_bytes(mesh, part.name.rsplit("/", 1)[-1], part.material, part.colour)
    target = stage / part.name
    target.parent.mkdir(parents=True, exist_ok=True)
    for ending, data in files.items():
        Path(f"{target}{ending}").write_bytes(data)
    step.write(Path(f"{target}.step"), target.name, solids)
    digests = {f"{part.name}{ending}": hashlib.sha256(data).hexdigest() for ending, data in files.items()}
    digests[f"{part.name}.step"] = hashlib.sha256(Path(f"{target}.step").read_bytes()).hexdigest()
    _forget(part)
    return Made(facts, volume, dict(sorted(digests.items())))


def _forget(part: Part) -> None:
    """Give back what the kernels remember; only the hand's fingers are made a second time."""
    from handgen.geometry import brep_kernel, mesh_kernel

    mesh_kernel.forget()
    if part.role != "exoskeleton":
        brep_kernel.forget()


def _compare(part: Part, facts: Facts, solids: list[cadquery.Shape]) -> float:
    """Volume of the B-rep, mm3, after holding it against the mesh kernel's.

    A blended skin has no B-rep: then STEP shows the part's unblended `bodies`, which are held
    against the mesh kernel's evaluation of the same trees.
    """
    from handgen.geometry.mesh_kernel import evaluate

    # Without a tolerance OCCT integrates a spline face in a few points, up to 1 % off.
    volume = sum(solid.Volume(INTEGRAL) for solid in solids)
    expected = facts.volume_mm3
    if blended(part.shape):
        expected = sum(evaluate(body.shape).volume() for body in part.bodies)
    if abs(volume - expected) > AGREEMENT * expected:
        raise GeometryError(
            part.name, part.path,
            f"mesh and B-rep disagree: {expected:.2f} and {volume:.2f} mm3")
    return volume


def blended(shape: object) -> bool:
    """Whether a tree holds a blended skin anywhere."""
    if isinstance(shape, csg.Field):
        return True
    if isinstance(shape, tuple):
        return any(map(blended, shape))
    return is_dataclass(shape) and any(blended(getattr(shape, f.name)) for f in fields(shape))
