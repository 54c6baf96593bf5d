"""A case as energies on a mesh: what is drawn, what holds it, what acts on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handgen.simulation.case import Case
from handgen.simulation.reference import physics, tube
from handgen.simulation.reference.curved import Quadratic
from handgen.simulation.reference.drawing import MIDDLE, mesh_of


@dataclass(frozen=True)
class Placement:
    """Where the nodes of the straight-edged mesh lie, each (n, 3) mm."""

    straight: np.ndarray
    """In the straight finger."""
    drawn: np.ndarray
    """In the finger as it is made, its rest angles drawn in."""


class Model:
    """The equations of `case`: `form` on `space`, driven by `loads` (weight's share, pressure, tip load)."""

    def __init__(self, case: Case):
        import ngsolve as ng

        self.case = case
        division = tube.Division().finer(case.refine)
        self.mesh, _ = mesh_of([tube.drawing(case.actuator, case.held, division)])
        self.nodes = Quadratic(self.mesh)
        depth = case.winding.depth if case.winding else 0.0
        at = tube.placed(case.actuator, depth, division.around, self.nodes.points)
        self.placement = Placement(at, at)
        self._straight = self.nodes.field(self.placement.straight)
        self.mesh.SetDeformation(self.nodes.field(self.placement.drawn - self.nodes.points))
        self.loads = tuple(ng.Parameter(0.0) for _ in range(3))
        moved = ng.VectorH1(self.mesh, order=2, dirichlet=tube.HELD, dirichlety=f"{tube.HELD}|{MIDDLE}")
        self.space = moved * ng.L2(self.mesh, order=0) * ng.VectorL2(self.mesh, order=0)
        self.form = self._energy()

    def _energy(self):
        import ngsolve as ng

        case = self.case
        moved, mean, slope = self.space.TrialFunction()
        place = ng.CoefficientFunction((ng.x, ng.y, ng.z))
        centre = ng.GridFunction(ng.VectorL2(self.mesh, order=0))
        centre.Set(place)
        # Linear in space, not in the element's own coordinates: of full order on hexahedra too.
        level = mean + ng.InnerProduct(slope, place - centre)
        inside, surface = ng.Id(3) + ng.Grad(moved), ng.Id(3) + ng.Grad(moved).Trace()
        weight, pressure, _ = self.loads
        form = ng.BilinearForm(self.space, symmetric=True, condense=True)
        silicone = case.silicone
        form += ng.Variation(physics.rubber(silicone, inside, level) * ng.dx(tube.NAME))
        if any(case.gravity):
            pull = ng.InnerProduct(ng.CoefficientFunction(case.gravity), moved)
            form += ng.Variation(-weight * silicone.density * pull * ng.dx(tube.NAME))
        from_opening = place - ng.CoefficientFunction((case.held, 0.0, 0.0)) + moved.Trace()
        form += ng.Variation(physics.air(pressure, surface, from_opening) * ng.ds(tube.CHAMBER))
        if case.winding:
            form += ng.Variation(physics.thread(case.winding, surface, self._straight) * ng.ds(tube.WOUND))
        return form

    def upright(self, state) -> bool:
        """Whether no element is turned inside out, judged at its points of integration."""
        import ngsolve as ng

        volume = ng.Det(ng.Id(3) + ng.Grad(state.components[0]))
        return ng.Integrate(ng.IfPos(volume, 0.0, 1.0), self.mesh, order=4) == 0.0
