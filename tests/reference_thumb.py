"""Finite-element reference of the thumb's hinge: tetrahedra, large rotations (NGSolve).

Half of the gap and one of two actuators, by symmetry: x across the gap from its middle, y along the
fold from between the actuators, z dorsal from their axes. The sheet with its fillet, a silicone tube of
two layers with inextensible hoops on the circle where they meet, a stiff wall that both are tied to.
Quadratic displacements, linear pressures inside each tetrahedron; the air works on the chamber's wall
as -p V. Nothing here knows beams, neutral axes or thrusts. Units mm, MPa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

WALL = 4.0
"""Thickness of the stiff wall, mm."""
STIFF = 30.0
"""Its shear modulus, MPa: twenty times the sheet's; 200 moves the angle by 0.02 %."""
HOOP = 50.0
"""Stiffness of the hoops, N/mm: they stretch by half a per cent."""
BULK = 100.0
"""Bulk over shear modulus of the silicone; 500 moves the angle by 1 %."""
STEPS = (0.3, 0.7, 1.0)
"""Shares of the pressure at which equilibrium is found."""
HOLD = 1e-6
"""Spring that holds the free height, N/mm^5."""


@dataclass(frozen=True)
class Thumb:
    """The hinge that is modelled; the adult hand's by default."""

    thickness: float
    length: float = 24.0
    chamber: float = 24.0
    width: float = 26.0
    spacing: float = 15.0
    top: float = -6.5
    fillet: float = 1.5
    inside: float = 2.5
    thread: float = 4.075
    outside: float = 6.0
    pressure: float = 0.06
    young: float = 4.41
    poisson: float = 0.49
    mu: float = 0.0827 / 1.75


def angle(thumb: Thumb, size: float) -> float:
    """Turn of the far wall about the fold, deg, with tetrahedra of about `size` mm."""
    import ngsolve as ng

    mesh = _mesh(thumb, size)
    with ng.TaskManager():
        displacement = _solve(thumb, mesh)
    x = thumb.length / 2 + WALL - 0.1
    high, low = (displacement(mesh(x, 0.5, z)) for z in (-2.0, -7.0))
    return 2 * math.degrees(math.atan2(high[0] - low[0], 5.0 + high[2] - low[2]))


def _mesh(t: Thumb, size: float):
    import ngsolve as ng
    from netgen import occ

    half, bottom, v = t.length / 2, t.top - t.thickness, t.spacing / 2
    sheet = occ.Box((0, 0, bottom), (half, t.width / 2, t.top))
    corner = occ.Box((half - t.fillet, 0, t.top - 0.01), (half, t.width / 2, t.top + t.fillet))
    sheet += corner - occ.Cylinder(occ.Pnt(half - t.fillet, -1, t.top + t.fillet), occ.Y, t.fillet, t.width)

    def tube(outside: float, inside: float):
        bore, body = (occ.Cylinder(occ.Pnt(0, v, 0), occ.X, r, t.chamber / 2) for r in (inside, outside))
        return body - bore

    wall = occ.Box((half, 0, bottom), (half + WALL, max(t.width / 2, v + t.outside), t.outside))
    solids = [(sheet, "sheet"), (wall, "wall"), (tube(t.outside, t.thread), "silicone"),
              (tube(t.thread, t.inside), "silicone")]
    if t.chamber < t.length:
        plug = occ.Cylinder(occ.Pnt(t.chamber / 2, v, 0), occ.X, t.outside, (t.length - t.chamber) / 2)
        solids.append((plug, "wall"))
    for solid, name in solids:
        solid.mat(name).maxh = size
    glued = occ.Glue([solid for solid, _ in solids])
    for face in glued.faces:
        face.name = _face_name(t, face) or "other"
    mesh = ng.Mesh(occ.OCCGeometry(glued).GenerateMesh(maxh=1.5 * size, curvaturesafety=1.2, grading=0.5))
    mesh.Curve(2)
    return mesh


def _face_name(t: Thumb, face) -> str | None:
    low, high = face.bounding_box
    tall, long = high.z - low.z, high.x - low.x
    flat = long < 1e-6
    if flat and abs(low.x) < 1e-6:
        return "middle"
    if abs(high.y) < 1e-6:
        return "between"
    if abs(face.center.z) < 0.5 and tall < 2 * t.inside + 0.1:
        return "chamber" if long > 1 or abs(low.x - t.chamber / 2) < 1e-6 else None
    return "thread" if long > 1 and abs(tall - 2 * t.thread) < 0.05 else None


def _energy(t: Thumb, space, pressure):
    """Total potential energy of displacement u and volumetric pressure q."""
    import ngsolve as ng

    (u, q), _ = space.TnT()
    deformed = ng.Id(3) + ng.Grad(u)
    volume = ng.Det(deformed)

    def rubber(mu: float, bulk: float):
        first = ng.Trace(deformed.trans * deformed)
        return mu / 2 * (first - 3 - 2 * ng.log(volume)) + q * (volume - 1) - q * q / (2 * bulk)

    soft, hard = t.young / (2 * (1 + t.poisson)), t.young / (3 * (1 - 2 * t.poisson))
    y, z = ng.y - t.spacing / 2, ng.z
    radius = ng.sqrt(y * y + z * z)
    surface = ng.Id(3) + ng.Grad(u).Trace()
    hoop = surface * ng.CoefficientFunction((0, -z / radius, y / radius))
    place = ng.CoefficientFunction((ng.x, y, z)) + u
    area = ng.Cof(surface) * ng.specialcf.normal(3)
    form = ng.BilinearForm(space, symmetric=True, condense=True)
    form += ng.Variation(rubber(soft, hard) * ng.dx("sheet"))
    form += ng.Variation(rubber(t.mu, BULK * t.mu) * ng.dx("silicone"))
    form += ng.Variation(rubber(STIFF, 2 * STIFF) * ng.dx("wall"))
    form += ng.Variation(HOOP / 8 * (ng.InnerProduct(hoop, hoop) - 1) ** 2 * ng.ds("thread"))
    # The normal points out of the silicone, into the air: the sign of -p V turns.
    form += ng.Variation(pressure / 3 * ng.InnerProduct(area, place) * ng.ds("chamber"))
    form += ng.Variation(HOLD * u[2] * u[2] * ng.dx)
    return form


def _solve(t: Thumb, mesh):
    """Displacements at full pressure: Newton, each step starting on the secant of the last two."""
    import ngsolve as ng

    moved = ng.VectorH1(mesh, order=2, dirichletx="middle", dirichlety="between")
    space = moved * ng.L2(mesh, order=1)
    pressure, free = ng.Parameter(0.0), space.FreeDofs(True)
    form, state = _energy(t, space, pressure), ng.GridFunction(space)
    residual, step, here, last = (state.vec.CreateVector() for _ in range(4))
    last[:] = 0.0
    shares = (0.0, 0.0, *STEPS)
    for before, now, then in zip(shares, shares[1:], shares[2:], strict=False):
        pressure.Set(then * t.pressure)
        here.data = state.vec
        if now > before:
            state.vec.data = here + (then - now) / (now - before) * (here - last)
        last.data = here
        for _ in range(20):
            form.Apply(state.vec, residual)
            form.AssembleLinearization(state.vec)
            residual.data += form.harmonic_extension_trans * residual
            step.data = form.mat.Inverse(free, inverse="sparsecholesky") * residual
            left = abs(ng.InnerProduct(step, residual))
            step.data += form.harmonic_extension * step
            step.data += form.inner_solve * residual
            state.vec.data -= step
            if left < 1e-6:
                break
        else:
            raise ArithmeticError(f"no equilibrium at {then * t.pressure:g} MPa")
    return state.components[0]
