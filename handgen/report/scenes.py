"""What stands where on the page: the hand, and each actuator amid its tooling; markers of findings."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from handgen.builder.survey import Survey
from handgen.geometry.assembly import BENT_EDGE, Seated, assembly
from handgen.geometry.finger import exoskeleton
from handgen.geometry.palm import finger_placement
from handgen.geometry.part import Part
from handgen.parameters.model import Hand
from handgen.report import explode, meshes
from handgen.report.buffers import Buffer

HAND = "exoskeleton/hand"
IDENTITY = np.eye(4)


@dataclass
class Node:
    """A part in a scene; `matrix` (4, 4) carries its mesh there, `apart` is its way when exploded, mm."""

    part: Part
    mesh: int
    matrix: np.ndarray
    apart: np.ndarray
    shown: bool = True

    def row(self) -> dict[str, Any]:
        return {"name": self.part.name, "material": self.part.material, "role": self.part.role,
                "colour": colour(self.part.colour), "mesh": self.mesh, "shown": self.shown,
                "matrix": self.matrix.T.ravel().round(6).tolist(), "apart": self.apart.round(2).tolist()}


@dataclass
class Scene:
    """Parts in one frame. `markers`: number of a finding in the report -> its place, mm."""

    name: str
    title: str
    nodes: list[Node] = field(default_factory=list)
    markers: dict[int, np.ndarray] = field(default_factory=dict)

    def row(self) -> dict[str, Any]:
        return {"name": self.name, "title": self.title, "nodes": [node.row() for node in self.nodes],
                "markers": [{"finding": number, "at": at.round(4).tolist()}
                            for number, at in self.markers.items()]}


class Stage:
    """The scenes of a surveyed design; meshes go into `buffer`, each once."""

    def __init__(self, survey: Survey, buffer: Buffer):
        self.survey, self.buffer = survey, buffer
        self.hand: Hand = survey.loaded.hand
        self.meshes: list[dict[str, Any]] = []
        self._plain: dict[str, int] = {}

    def scenes(self) -> list[Scene]:
        """The hand, where there is one, then every actuator amid its tooling."""
        listed = [self._hand()] if self.hand.palm else []
        listed += [self._tooling(name) for name in self.hand.actuators.present()]
        self._mark(listed)
        return listed

    def add(self, drawn: meshes.Drawn) -> int:
        self.meshes.append(drawn.packed(self.buffer))
        return len(self.meshes) - 1

    def _mesh(self, name: str) -> int:
        """The number of the part's mesh in its own frame."""
        if name not in self._plain:
            self._plain[name] = self.add(meshes.of_stl(self.survey.parts[name].stl))
        return self._plain[name]

    def _hand(self) -> Scene:
        scene = Scene("hand", "Hand")
        for seated in assembly(self.hand):
            apart = explode.in_hand(self.hand, seated)
            if seated.axis:
                scene.nodes.append(Node(seated.part, self._bent(seated), IDENTITY, apart))
            else:
                scene.nodes.append(Node(seated.part, self._mesh(seated.name), matrix(seated), apart))
        return scene

    def _bent(self, seated: Seated) -> int:
        """The mesh of a part that lies curled in its finger, in the hand's frame."""
        import trimesh

        vertices, faces = meshes.welded(self.survey.parts[seated.name].stl)
        vertices, faces = trimesh.remesh.subdivide_to_size(*meshes.coarse(vertices, faces), BENT_EDGE)
        vertices, faces = seated.carry(vertices), faces[:, ::-1] if seated.mirrored else faces
        return self.add(meshes.smooth(*meshes.coarse(vertices, faces)))

    def _tooling(self, name: str) -> Scene:
        """Everything that is made around one actuator, in the actuator's frame."""
        scene = Scene(name, name.replace("_", " ").capitalize() + ": mould and cores")
        finger = f"exoskeleton/{name}"
        for each in self.survey.parts.values():
            part = each.part
            if part.name in (finger, f"actuators/{name}") or part.name.startswith(f"tooling/{name}/"):
                scene.nodes.append(Node(part, self._mesh(part.name), IDENTITY,
                                        explode.in_mould(part, each.facts.bbox_mm), part.name != finger))
        return scene

    def _mark(self, scenes: list[Scene]) -> None:
        """Enter every finding that has a place into the first scene that shows its part."""
        for number, finding in enumerate(self.survey.report["findings"]):
            for scene in scenes if finding["where"] else ():
                place = self._place(scene, finding["part"], np.array(finding["where"], float))
                if place is not None:
                    scene.markers[number] = place
                    break

    def _place(self, scene: Scene, part: str, where: np.ndarray) -> np.ndarray | None:
        """`where` of the part's own frame in the scene's; None where the scene does not show the part."""
        if scene.name == "hand" and part != HAND:
            seated = self._carriers.get(part)
            return None if seated is None else seated.carry(where[None])[0]
        return where if any(node.part.name == part for node in scene.nodes) else None

    @cached_property
    def _carriers(self) -> dict[str, Seated]:
        """What brings a place of a part into the hand; a single finger's lies on the hand's finger."""
        fingers = (Seated(exoskeleton(self.hand, name), *finger_placement(self.hand, name),
                          mirrored=self.hand.side == "left") for name in self.hand.fingers.present())
        return {seated.name: seated for seated in (*assembly(self.hand), *fingers)}


def matrix(seated: Seated) -> np.ndarray:
    """(4, 4) that does what `seated.carry` does to a part that is not bent."""
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = np.array(seated.rotation), seated.origin
    if seated.mirrored:
        found = np.diag((1.0, -1.0, 1.0, 1.0)) @ found
    return found


def colour(rgb: tuple[float, float, float]) -> str:
    """sRGB of 0..1 as CSS writes it."""
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in rgb)
