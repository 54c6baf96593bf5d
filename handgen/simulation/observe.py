"""What a state of the finger shows: drop, angle, elongation, force, stretch."""

from __future__ import annotations

import numpy as np

from handgen.simulation import element, shapes
from handgen.simulation.case import State
from handgen.simulation.solve import Point
from handgen.simulation.system import System

TIP = 5.0
"""mm before the end of the bore from which on the finger counts as its tip."""


def state(system: System, point: Point, note: str = "") -> State:
    """The State of a stable `point` of `system`."""
    x = system.positions(point.q)
    if system.base:
        x = system.base.carried(x, point.q)
    positions, stretch = {}, {}
    for name, mesh, first in (("actuator", system.actuator, 0),
                              ("exoskeleton", system.exoskeleton, system.first)):
        if mesh is not None:
            rows = slice(first, first + len(mesh.grid.nodes))
            positions[name] = x[rows].copy()
            stretch[name] = _stretch(system.unstrained[rows], mesh.grid.cells, positions[name])
    load = point.load
    force = None
    if system.case.obstacle is not None:
        force = 2.0 * system.pushed
    return State(
        load.pressure, load.tip, True,
        tip_drop=_drop(system, x), bend_angle=_angle(system, x, point.q), elongation=_elongation(system, x),
        tip_force=force, max_stretch=float(max(s.max() for s in stretch.values())), residual=point.residual,
        note=note, positions=positions, stretch=stretch)


def _stretch(nodes: np.ndarray, cells: np.ndarray, x: np.ndarray) -> np.ndarray:
    dn, _ = shapes.gradients(nodes, cells, np.zeros((1, 3)))
    return element.largest_stretch(x, cells, dn)


def _drop(system: System, x: np.ndarray) -> float:
    """Lowest point of the tip below z = -R(0), mm."""
    base = float(system.case.finger.outer(0.0)) if system.case.finger else 0.0
    if system.exoskeleton is not None:
        inner = system.case.finger.finger.inner_length
        tip = x[system.first:][system.exoskeleton.straight[:, 0] > inner - TIP]
    else:
        tip = x[system.actuator.face]
    return float(-tip[:, 2].min()) - base


def _angle(system: System, x: np.ndarray, q: np.ndarray) -> float:
    """Flexion of the tip, rad: that of the last bone, or of a free actuator's tip face."""
    if system.bones is not None:
        root = system.base.angle(q) if system.base else 0.0
        return float(root + system.bones.angle[-1] + system.bone_states(q)[-1, 2])
    across = x[system.actuator.back[-1]] - x[system.actuator.axis[-1]]
    return float(np.arctan2(across[0], across[2]))


def _elongation(system: System, x: np.ndarray) -> float | None:
    """Growth of the actuator's centre line; of a free one the travel of its tip along the axis, mm."""
    if system.actuator is None:
        return None
    if system.exoskeleton is None:
        tip = system.actuator.tip
        return float(x[tip, 0] - system.drawn[tip, 0])
    middle = (x[system.actuator.axis] + x[system.actuator.back]) / 2
    return float(np.linalg.norm(np.diff(middle, axis=0), axis=1).sum() - system.case.actuator.length)
