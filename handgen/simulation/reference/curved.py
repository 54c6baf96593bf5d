"""Elements of second order: fields by their values at corners and middles, as NGSolve's functions."""

from __future__ import annotations

from itertools import product

import numpy as np

HALVES = (0.0, 0.5, 1.0)
TRIANGLE = tuple((a, b) for a, b in product(HALVES, HALVES) if a + b <= 1)
NODES = {
    "HEX": tuple(product(HALVES, repeat=3)),
    "PRISM": tuple((*point, c) for point, c in product(TRIANGLE, HALVES)),
    "TET": tuple(point for point in product(HALVES, repeat=3) if sum(point) <= 1),
}
"""Corners and middles in NGSolve's reference elements: as many as quadratic shape functions."""
CENTRES = {"HEX": (0.5, 0.5, 0.5), "PRISM": (1 / 3, 1 / 3, 0.5), "TET": (0.25, 0.25, 0.25)}


class Quadratic:
    """The quadratic functions on a mesh, seen from the nodes of its elements; made before it is deformed."""

    def __init__(self, mesh):
        import ngsolve as ng

        self.mesh, self.space = mesh, ng.H1(mesh, order=2)
        self._elements, points, bodies = [], [], []
        for element in (ng.ElementId(ng.VOL, i) for i in range(mesh.ne)):
            nodes = NODES[mesh[element].type.name]
            function, chart = self.space.GetFE(element), mesh.GetTrafo(element)
            shape = np.array([function.CalcShape(*node) for node in nodes])
            own = slice(len(points), len(points) + len(nodes))
            self._elements.append((own, list(self.space.GetDofNrs(element)), shape))
            for node in nodes:
                # The chart's point must not outlive what it was asked from.
                place = chart(*node)
                points.append(tuple(place.point))
            bodies += [mesh[element].mat] * len(nodes)
        self.points = np.array(points)
        """(n, 3) nodes of all elements one after the other, straight-edged; shared ones come again."""
        self.bodies = np.array(bodies)
        """(n,) the body of each."""

    def field(self, values: np.ndarray):
        """The continuous vector function with `values` (n, 3) at `points`."""
        import ngsolve as ng

        found = np.zeros((self.space.ndof, 3))
        for own, dofs, shape in self._elements:
            found[dofs] = np.linalg.solve(shape, values[own])
        made = ng.GridFunction(ng.VectorH1(self.mesh, order=2))
        for component, column in zip(made.components, found.T, strict=True):
            component.vec.FV().NumPy()[:] = column
        return made

    def values(self, function) -> np.ndarray:
        """(n, 3) values at `points` of a quadratic vector `function`."""
        coefficients = np.stack([component.vec.FV().NumPy() for component in function.components], -1)
        return np.vstack([shape @ coefficients[dofs] for _, dofs, shape in self._elements])
