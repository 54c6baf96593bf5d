"""What a balanced state shows, as `handgen.simulation.case.State` states it."""

from __future__ import annotations

import numpy as np

from handgen.simulation.case import State
from handgen.simulation.reference import tube
from handgen.simulation.reference.balance import Balance
from handgen.simulation.reference.curved import CENTRES
from handgen.simulation.reference.model import Model

NEAR = 1e-6
"""mm."""


def state(model: Model, balance: Balance) -> State:
    """The State of `balance`, without fields: its mesh is not one that pictures are made of."""
    straight, bodies = model.placement.straight, model.nodes.bodies
    x = model.placement.drawn + model.nodes.values(balance.state.components[0])
    end = straight[:, 0] > model.case.actuator.length - NEAR
    base = model.case.finger.outer_radius(0.0) if model.case.finger else 0.0
    centre = end & (np.hypot(*straight[:, 1:].T) < NEAR) & (bodies == tube.NAME)
    _, pressure, load = balance.now
    return State(
        float(pressure), float(load), True, tip_drop=float(-x[end, 2].min()) - base, bend_angle=turned(straight[end], x[end]),
        elongation=float((x - model.placement.drawn)[centre, 0].mean()),
        max_stretch=largest_stretch(model, balance), residual=balance.residual())


def turned(straight: np.ndarray, moved: np.ndarray) -> float:
    """Flexion, rad, that brings points (n, 3) nearest to where they moved, in the plane of symmetry."""
    (x, z), (u, w) = ((p[:, [0, 2]] - p[:, [0, 2]].mean(axis=0)).T for p in (straight, moved))
    return float(np.arctan2((z * u - x * w).sum(), (x * u + z * w).sum()))


def largest_stretch(model: Model, balance: Balance) -> float:
    """Largest principal stretch in any element's centre."""
    import ngsolve as ng

    rules = {getattr(ng.ET, name): ng.IntegrationRule([centre], [1.0]) for name, centre in CENTRES.items()}
    gradient = ng.Id(3) + ng.Grad(balance.state.components[0])
    points = model.mesh.MapToAllElements(rules, ng.VOL)
    return float(np.linalg.norm(gradient(points).reshape(-1, 3, 3), ord=2, axis=(1, 2)).max())
