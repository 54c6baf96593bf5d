"""References for an actuator's wall between two turns of its thread. Units mm, MPa.

`membrane`: the inner layer as an axisymmetric neo-Hookean membrane, as differential equations along its
meridian: no arc is assumed. `solid`: both layers, bonded, as a solid of revolution in finite elements.
"""

from __future__ import annotations

import math

import numpy as np

LOADS = np.linspace(0.1, 1.0, 12)
HOLD = 100.0
"""Stiffness with which the thread's cross-section is held, N/mm3."""


def membrane(pressure: float, gap: float, inside: float, thread: float, mu: float) -> float:
    """Height of the bulge, mm, of a layer from `inside` to the `thread`, without any sleeve."""
    from scipy.integrate import solve_bvp

    thickness, radius = thread - inside, (inside + thread) / 2

    def slopes(y, p):
        """d(x, r, inclination, stretch)/dS from balance along and across the meridian."""
        _, r, incline, m = y
        h = r / radius
        along = mu * thickness * (m / h - (m * h) ** -3.0)
        around = mu * thickness * (h / m - (m * h) ** -3.0)
        acting = p * (1 - thickness / (m * h) / (2 * r))
        dr = m * np.sin(incline)
        by_m = mu * thickness * (1 / h + 3 * m**-4.0 * h**-3)
        by_h = mu * thickness * (3 * m**-3.0 * h**-4 - m / h**2)
        dm = ((around - along) * dr / r - by_h * dr / radius) / by_m
        return np.array([m * np.cos(incline), dr, m * (around * np.cos(incline) / r - acting) / along, dm])

    def ends(left, right):
        return np.array([left[0], left[1] - radius, right[2], right[0] - gap / 2])

    s = np.linspace(0, gap / 2, 80)
    # Starts on a shallow arc and follows the pressure up.
    a = 0.4
    turn = a * (1 - 2 * s / gap)
    rho = gap / 2 / math.sin(a)
    y = np.array([gap / 2 - rho * np.sin(turn), radius + rho * (np.cos(turn) - math.cos(a)), turn,
                  np.full_like(s, a / math.sin(a))])
    for share in LOADS:
        found = solve_bvp(lambda _, y, p=share * pressure: slopes(y, p), ends, s, y, tol=1e-4, max_nodes=5000)
        if not found.success:
            raise ArithmeticError(found.message)
        s, y = found.x, found.y
    return float(y[1, -1] - radius)


def solid(pressure: float, pitch: float, diameter: float, inside: float, thread: float, outside: float,
          mu: float) -> float:
    """Growth of the thread's radius, mm, half-way between two turns; the wall keeps its length."""
    import ngsolve as ng
    from netgen import occ

    layers = [occ.Rectangle(pitch / 2, b - a).Face().Move((0, a, 0))
              for a, b in ((inside, thread), (thread, outside))]
    shape = occ.Glue(layers)
    for edge in shape.edges:
        if abs(edge.center.x) < 1e-9 or abs(edge.center.x - pitch / 2) < 1e-9:
            edge.name = "end"
        elif abs(edge.center.y - inside) < 1e-9:
            edge.name = "chamber"
    mesh = ng.Mesh(occ.OCCGeometry(shape, dim=2).GenerateMesh(maxh=min(0.5, pitch / 6)))
    moved = ng.VectorH1(mesh, order=3, dirichletx="end")
    space = moved * ng.L2(mesh, order=1)
    (u, q), _ = space.TnT()
    r, load = ng.y, ng.Parameter(0.0)
    plane, hoop = ng.Id(2) + ng.Grad(u), 1 + u[1] / ng.y
    volume = ng.Det(plane) * hoop
    first = ng.Trace(plane.trans * plane) + hoop * hoop
    energy = mu / 2 * (first - 3 - 2 * ng.log(volume)) + q * (volume - 1) - q * q / (600 * mu)
    held = ng.IfPos(diameter / 2 - ng.x, ng.exp(-(((r - thread) / (diameter / 2)) ** 2)), 0)
    form = ng.BilinearForm(space, symmetric=True)
    form += ng.Variation(2 * math.pi * r * energy * ng.dx)
    form += ng.Variation(2 * math.pi * r * HOLD * held * u[1] * u[1] * ng.dx(bonus_intorder=10))
    longer = 1 + ng.Grad(u).Trace()[0, 0]
    form += ng.Variation(-load * math.pi * (r + u[1]) ** 2 * longer * ng.ds("chamber"))
    state = ng.GridFunction(space)
    residual, step = state.vec.CreateVector(), state.vec.CreateVector()
    for share in np.linspace(0.05, 1, 20):
        load.Set(share * pressure)
        for _ in range(30):
            form.Apply(state.vec, residual)
            form.AssembleLinearization(state.vec)
            step.data = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky") * residual
            state.vec.data -= step
            if abs(ng.InnerProduct(step, residual)) < 1e-12:
                break
        else:
            raise ArithmeticError(f"no equilibrium at {share * pressure:g} MPa")
    return state.components[0](mesh(pitch / 2 - 1e-9, thread))[1]
