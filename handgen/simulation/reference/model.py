"""A case as energies on a mesh: what is drawn, what holds it, what acts on it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from handgen.geometry.finger import Axis
from handgen.simulation.case import Case, Substance
from handgen.simulation.reference import physics, slotted, tube
from handgen.simulation.reference.curved import Quadratic
from handgen.simulation.reference.drawing import MIDDLE, mesh_of
from handgen.simulation.reference.sliding import Sliding

PENALTY = 1.0
"""N/mm3; of the springs that stand for a bond, as in the fast solver."""
HUNG = 3.0
"""Length of the tip, mm, whose elements share the hanging weight."""


class Model:
    """The equations of `case`: `form` on `space`, driven by `loads` (weight's share, pressure, tip load)."""

    def __init__(self, case: Case, division: tube.Division | None = None):
        import ngsolve as ng

        self.case, self.division = case, division or tube.Division().finer(case.refine)
        self.axis = Axis(case.finger, case.fillet) if case.part != "actuator" else None
        self.mesh, self.nodes, self.straight = self._mesh()
        self.drawn = self.straight if self.axis is None else self.axis.carry(self.straight)
        """(n, 3) places of `nodes.points` in the finger as it is made, mm; `straight`: with no rest angle."""
        along = self.nodes.field(self.straight)
        self.mesh.SetDeformation(self.nodes.field(self.drawn - self.nodes.points))
        self.loads = tuple(ng.Parameter(0.0) for _ in range(3))
        held = "|".join(name for name in (tube.HELD, slotted.ROOT) if name in self.mesh.GetBoundaries())
        moved = ng.VectorH1(self.mesh, order=2, dirichlet=held, dirichlety=f"{held}|{MIDDLE}")
        self.space = moved * ng.L2(self.mesh, order=0) * ng.VectorL2(self.mesh, order=0)
        self.form = ng.BilinearForm(self.space, symmetric=True, condense=True)
        for name, substance in ((tube.NAME, case.silicone), (slotted.NAME, case.tpu)):
            if name in self.mesh.GetMaterials():
                self._fill(name, substance)
        if self.axis is not None:
            self._hang()
        if case.part != "exoskeleton":
            self._blow(along)
        self.find: Callable[[object], None] | None = None
        """Pairs sliding surfaces as they lie in a state; None where nothing slides."""
        if case.part == "assembly" and case.contact.bonded:
            self._tie(along)
        elif case.part == "assembly":
            moved = self.space.TrialFunction()[0]
            self.find = Sliding(self.form, self.mesh, moved, along[0], case.finger).find

    def _mesh(self):
        """(mesh, its quadratic functions, (n, 3) their nodes in the straight finger)."""
        case, bodies, places = self.case, [], {}
        if case.part != "exoskeleton":
            depth, around = case.winding.depth if case.winding else 0.0, self.division.around
            bodies.append(tube.drawing(case.actuator, case.held, self.division))
            places[tube.NAME] = lambda points: tube.placed(case.actuator, depth, around, points)
        if case.part != "actuator":
            body, middles, curved = slotted.drawing(case.finger, case.fillet, case.refine)
            bodies.append(body)
            places[slotted.NAME] = lambda points: _bent(points, middles, curved)
        drawn = Quadratic(mesh_of(bodies))
        straight = np.empty_like(drawn.points)
        for name, place in places.items():
            mine = drawn.bodies == name
            straight[mine] = place(drawn.points[mine])
        # Corners where they belong, in a second mesh of the same elements: who looks for the nearest place
        # on another body does so before a mesh is deformed.
        mesh = mesh_of([replace(body, nodes=places[body.name](body.nodes)) for body in bodies])
        return mesh, Quadratic(mesh), straight

    def _fill(self, name: str, substance: Substance) -> None:
        """What body `name` stores and weighs."""
        import ngsolve as ng

        moved, mean, slope = self.space.TrialFunction()
        place = ng.CoefficientFunction((ng.x, ng.y, ng.z))
        centre = ng.GridFunction(ng.VectorL2(self.mesh, order=0))
        centre.Set(place)
        # Linear in space, not in the element's own coordinates: of full order on hexahedra too.
        level = mean + ng.InnerProduct(slope, place - centre)
        self.form += ng.Variation(physics.rubber(substance, ng.Id(3) + ng.Grad(moved), level) * ng.dx(name))
        if any(self.case.gravity):
            pull = ng.InnerProduct(ng.CoefficientFunction(self.case.gravity), moved)
            self.form += ng.Variation(-self.loads[0] * substance.density * pull * ng.dx(name))

    def _blow(self, straight) -> None:
        """Air in the chamber, thread around it; `straight`: the field of places in the straight finger."""
        import ngsolve as ng

        moved, case = self.space.TrialFunction()[0], self.case
        surface = ng.Id(3) + ng.Grad(moved).Trace()
        x, z, _ = self.axis.frame(case.held) if self.axis else (case.held, 0.0, 0.0)
        from_opening = ng.CoefficientFunction((ng.x - x, ng.y, ng.z - z)) + moved.Trace()
        self.form += ng.Variation(physics.air(self.loads[1], surface, from_opening) * ng.ds(tube.CHAMBER))
        if case.winding:
            self.form += ng.Variation(physics.thread(case.winding, surface, straight) * ng.ds(tube.WOUND))

    def _tie(self, straight) -> None:
        """Springs of PENALTY between the actuator's side and the bore where a bone closes it.

        Partners are the nearest places at rest. Closed tips stay apart: nothing pulls there.
        """
        import ngsolve as ng

        moved, finger = self.space.TrialFunction()[0], self.case.finger
        along, closed = straight[0], ng.CoefficientFunction(1.0)
        for joint in finger.finger.joints:
            past = along - joint.position
            closed = closed * ng.IfPos(past * past - (joint.slot_length / 2) ** 2, 1.0, 0.0)
        apart = moved - moved.Other()
        outside, bore = (self.mesh.Boundaries(name) for name in (tube.OUTSIDE, slotted.BORE))
        self._ties = ng.ContactBoundary(outside, bore)
        self._ties.AddEnergy(closed * PENALTY / 2 * ng.InnerProduct(apart, apart))
        still = ng.GridFunction(self.space)
        self._ties.Update(still.components[0], bf=self.form, intorder=4, maxdist=1.0)

    def _hang(self) -> None:
        """The weight on the tip: shared by the elements there so that it pulls at (length, 0, 0)."""
        import ngsolve as ng

        x, z, angle = self.axis.frame(self.case.finger.length)
        beyond = (ng.x - x) * math.cos(angle) - (ng.z - z) * math.sin(angle)
        above = (ng.x - x) * math.sin(angle) + (ng.z - z) * math.cos(angle)
        volume, first, second = (
            np.array(ng.Integrate(value, self.mesh, element_wise=True, order=6, definedon=self.mesh.Materials(
                slotted.NAME))) for value in (ng.CoefficientFunction(1.0), beyond, above))
        near = (volume > 0) & (first > -HUNG * volume)
        moments = np.stack([volume, first, second])[:, near]
        # Shares linear in place: as much as makes half the force, and no moment about that point.
        places = moments / moments[0]
        shares = np.zeros(len(volume))
        shares[near] = np.linalg.solve(moments @ places.T, [0.5, 0.0, 0.0]) @ places
        spread = ng.GridFunction(ng.L2(self.mesh, order=0))
        spread.vec.FV().NumPy()[:] = shares
        pull = np.array(self.case.gravity) if any(self.case.gravity) else np.array([0.0, 0.0, -1.0])
        down = ng.CoefficientFunction(tuple(pull / np.linalg.norm(pull)))
        moved = self.space.TrialFunction()[0]
        work = self.loads[2] * spread * ng.InnerProduct(down, moved)
        self.form += ng.Variation(-work * ng.dx(slotted.NAME))

    def upright(self, state) -> bool:
        """Whether no element is turned inside out, judged at its points of integration."""
        import ngsolve as ng

        volume = ng.Det(ng.Id(3) + ng.Grad(state.components[0]))
        return ng.Integrate(ng.IfPos(volume, 0.0, 1.0), self.mesh, order=4) == 0.0


def _bent(points: np.ndarray, middles: np.ndarray, curved: np.ndarray) -> np.ndarray:
    """Points of the straight-edged mesh, those in the middle of an edge moved onto the curved one."""
    away, nearest = cKDTree(middles).query(points)
    return np.where(away[:, None] < slotted.NEAR, curved[nearest], points)
