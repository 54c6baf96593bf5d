"""Dimensions as built, measured on the meshes, beside what was asked for and what the source's tables say.

Nothing here is read from the definition but the place where to measure: lengths and diameters are those of
the triangles that go to the printer.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np
import yaml

from handgen.builder.jobs import welded
from handgen.builder.survey import Survey, Surveyed
from handgen.checks.sections import Triangles
from handgen.geometry.finger import Axis
from handgen.geometry.profile import FingerProfile

NEAR = 0.02
"""mm inside an end at which a section is taken."""
BEYOND_MOUTH = 0.5
"""mm from the axis within which a wall counts as met by it."""
WORDS = {"outer_length": "outer length", "inner_length": "inner length",
         "base_outer_diameter": "outer diameter, base", "base_bore_diameter": "bore, base",
         "tip_outer_diameter": "outer diameter, tip", "tip_bore_diameter": "bore, tip",
         "wall": "layers at the base", "tip": "closed tip"}


@dataclass(frozen=True)
class Dimension:
    """One dimension of one part, mm; `source` None where the source does not give it."""

    what: str
    name: str
    """Key of WORDS."""
    measured: float
    asked: float
    source: float | None
    where: str

    def row(self) -> dict[str, Any]:
        return {"part": self.what, "dimension": WORDS[self.name], "measured_mm": round(self.measured, 3),
                "asked_mm": self.asked, "source_mm": self.source, "where": self.where}


@functools.cache
def source() -> dict[str, Any]:
    """`source.yaml`: the source's tables and numbers."""
    return yaml.safe_load(resources.files(__package__).joinpath("source.yaml").read_text(encoding="utf-8"))


def dimensions(survey: Survey) -> list[Dimension]:
    """All, in the order of Tables A.1 and A.2; those of a finger on its own beside the prototype's."""
    hand = survey.loaded.hand
    return [*(d for name in hand.fingers.present() for d in _finger(survey, name)),
            *(d for name in hand.actuators.present() for d in _actuator(survey, name))]


def _tables(survey: Survey) -> dict[str, Any]:
    return source() if survey.loaded.hand.palm else source()["prototype"]


def _finger(survey: Survey, name: str) -> Iterator[Dimension]:
    part = survey.parts[f"exoskeleton/{name}"]
    finger = getattr(survey.loaded.hand.fingers, name)
    table = _tables(survey)["exoskeleton"]
    known = dict(zip(table["columns"], table["rows"].get(name, ()), strict=False))
    for key, value in measured_finger(part, finger, survey.loaded.hand.exoskeleton.joint_fillet).items():
        yield Dimension(part.part.name, key, value, getattr(finger, key), known.get(key), table["table"])


def measured_finger(part: Surveyed, finger, fillet: float) -> dict[str, float]:
    """Lengths and diameters of a finger's exoskeleton, mm; those of a curled one along its axis."""
    mesh = Triangles.of(_mesh(part))
    # Beyond its last joint a curled finger is straight in the frame that its axis has there.
    last = finger.inner_length - NEAR
    x, z, angle = Axis(FingerProfile(finger), fillet).frame(last)
    c, s = np.cos(angle), np.sin(angle)
    tip = mesh.seen_from(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)), (x, 0.0, z))
    walls = [place for place in _along_axis(tip) if place > -finger.tip_bore_diameter]
    return {
        "outer_length": last + float(tip.vertices[:, 0].max()),
        "inner_length": last + min(walls),
        "base_outer_diameter": _outside(mesh, NEAR), "base_bore_diameter": _inside(mesh, NEAR),
        "tip_outer_diameter": _outside(tip, 0.0), "tip_bore_diameter": _inside(tip, 0.0),
    }


def _actuator(survey: Survey, name: str) -> Iterator[Dimension]:
    part = survey.parts[f"actuators/{name}"]
    hand = survey.loaded.hand
    actuator, layers = getattr(hand.actuators, name), hand.layers_of(name)
    table = _tables(survey)["actuators"]
    given = table["rows"].get(name, ())
    known = dict(zip(table["columns"], given, strict=False))
    asked = {key: getattr(actuator, key) for key in table["columns"]}
    asked |= {"wall": layers.stack, "tip": layers.tip}
    known |= {key: source()[key] for key in ("wall", "tip")} if given and hand.palm else {}
    for key, value in measured_actuator(part).items():
        yield Dimension(part.part.name, key, value, asked[key], known.get(key), table["table"])


def measured_actuator(part: Surveyed) -> dict[str, float]:
    """Length, diameters, wall at the base and closed tip of an actuator, mm."""
    mesh = Triangles.of(_mesh(part))
    length = float(mesh.vertices[:, 0].max())
    base = _outside(mesh, NEAR)
    return {
        "outer_length": length - float(mesh.vertices[:, 0].min()),
        "base_outer_diameter": base, "tip_outer_diameter": _outside(mesh, length - NEAR),
        "wall": (base - _inside(mesh, NEAR)) / 2, "tip": length - min(_along_axis(mesh)),
    }


def _mesh(part: Surveyed):
    from handgen.geometry.mesh_kernel import Triangles as Mesh

    return Mesh(*welded(part.stl))


def _outside(mesh: Triangles, x: float) -> float:
    """Diameter of the section at x: twice the largest distance of its outside from the axis."""
    return 2.0 * float(mesh.section(0, x).facing(True).radii().max())


def _inside(mesh: Triangles, x: float) -> float:
    """Diameter of the bore at x, as `_outside`: corners of a circle drawn in chords lie on it."""
    return 2.0 * float(mesh.section(0, x).facing(False).radii().max())


def _along_axis(mesh: Triangles) -> list[float]:
    """Where the axis passes through a surface, mm along it."""
    cut = mesh.section(2, 1e-4)
    across = (cut.start[:, 1] > 0) != (cut.end[:, 1] > 0)
    start, end = cut.start[across], cut.end[across]
    share = start[:, 1] / (start[:, 1] - end[:, 1])
    return (start[:, 0] + share * (end[:, 0] - start[:, 0])).tolist()
