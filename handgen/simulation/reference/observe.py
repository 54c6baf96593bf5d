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
TIP = 5.0
"""mm before the end of the bore from which on the finger counts as its tip."""


def state(model: Model, balance: Balance) -> State:
    """The State of `balance`, without fields: its mesh is not one that pictures are made of."""
    case, straight = model.case, model.straight
    moved = model.drawn + model.nodes.values(balance.state.components[0])
    mine = model.nodes.bodies == tube.NAME
    if case.part == "actuator":
        tip = straight[:, 0] > case.actuator.length - NEAR
    else:
        tip = ~mine & (straight[:, 0] > case.finger.finger.inner_length - TIP)
    base = case.finger.outer_radius(0.0) if case.finger else 0.0
    _, pressure, load = balance.now
    return State(
        float(pressure), float(load), True, tip_drop=float(-moved[tip, 2].min()) - base,
        bend_angle=turned(straight[tip], moved[tip]), elongation=_elongation(model, moved, mine),
        max_stretch=largest_stretch(model, balance), residual=balance.residual())


def _elongation(model: Model, moved: np.ndarray, mine: np.ndarray) -> float | None:
    """Of a free actuator the travel of its tip along the axis, in a finger the growth of its centre line."""
    straight = model.straight
    if model.case.part == "exoskeleton":
        return None
    if model.case.part == "actuator":
        centre = (straight[:, 0] > model.case.actuator.length - NEAR) & (np.hypot(*straight[:, 1:].T) < NEAR)
        return float((moved - model.drawn)[centre, 0].mean())
    x, y, z = straight.T
    side = mine & (np.abs(y) < NEAR) & (np.hypot(y, z) > model.case.actuator.outer(x) - NEAR)
    lines = []
    for sign in (-1, 1):
        line = np.flatnonzero(side & (sign * z > 0))
        _, first = np.unique(np.round(x[line], 6), return_index=True)
        lines.append(moved[line[first]])
    grown = np.linalg.norm(np.diff((lines[0] + lines[1]) / 2, axis=0), axis=1).sum()
    return float(grown - (model.case.actuator.length - model.case.held))


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
