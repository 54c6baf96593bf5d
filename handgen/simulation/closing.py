"""Slots that close: the palmar edges of two bones meet, with something between them.

The edges are the points of the outside's palmar line where a slot begins and ends, moved with their bones.
Their distance costs the energy of `contact.onset` as soon as less is left than what lies between them: the
crease of the strip, rests of support. Few as they are, they need no compiled loop.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from handgen.simulation.contact import PENALTY, SOFT, onset

if TYPE_CHECKING:
    from handgen.simulation.case import Case
    from handgen.simulation.exoskeleton import Bones


class Closing:
    """What happens between neighbouring bones of `case` when their slot closes."""

    def __init__(self, case: Case, bones: Bones):
        finger = case.finger
        self.bones = bones
        self.edges = [(np.array([bones.end[b], -finger.outer_radius(bones.end[b])]),
                       np.array([bones.start[b + 1], -finger.outer_radius(bones.start[b + 1])]))
                      for b in range(len(bones.start) - 1)]
        """(x, z) of the edges before and behind each slot, in the straight finger."""
        rest = np.zeros((len(bones.start), 3))
        self.between = [case.edges_left * float(np.linalg.norm(
            self._moved(b + 1, behind, rest)[0] - self._moved(b, before, rest)[0]))
            for b, (before, behind) in enumerate(self.edges)]
        """mm; distance at which each slot is closed."""
        self.area = [np.radians(joint.palmar_arc) / 2 * finger.outer_radius(joint.position)
                     * (finger.outer_radius(joint.position) - finger.bore_radius(joint.position))
                     for joint in finger.finger.joints]
        """mm2 of half the strip's section, which is what meets."""

    def groups(self, body_dofs: np.ndarray) -> np.ndarray:
        """(slots, 6) unknowns of the two bones."""
        return np.hstack([body_dofs[:-1], body_dofs[1:]])

    def add(self, states: np.ndarray, dofs: np.ndarray, place: np.ndarray, force: np.ndarray,
            matrix: np.ndarray) -> float:
        """Add forces and tangent at the bones' `states` (b, 3); returns the energy."""
        energy = 0.0
        for slot, (before, behind) in enumerate(self.edges):
            (a, slope_a, curve_a), (b, slope_b, curve_b) = (
                self._moved(slot, before, states), self._moved(slot + 1, behind, states))
            apart = b - a
            distance = float(np.linalg.norm(apart))
            value, w1, w2 = onset(distance - self.between[slot], PENALTY * self.area[slot], SOFT)
            if w2 == 0.0:
                continue
            energy += value
            n = apart / distance
            slope = np.hstack([-slope_a, slope_b])  # of the distance vector, (2, 6)
            along = n @ slope
            dyad = np.outer(along, along)
            tangent = w2 * dyad + w1 / distance * (slope.T @ slope - dyad)
            tangent[2, 2] -= w1 * n @ curve_a
            tangent[5, 5] += w1 * n @ curve_b
            for i in range(6):
                if dofs[slot, i] < 0:
                    continue
                force[dofs[slot, i]] += w1 * along[i]
                for j in range(6):
                    if place[slot, i, j] >= 0:
                        matrix[place[slot, i, j]] += tangent[i, j]
        return energy

    def _moved(self, body: int, point: np.ndarray, states: np.ndarray):
        """(place, slopes (2, 3), second derivative with the turn) of a straight (x, z) on `body`."""
        bones, angle = self.bones, self.bones.angle[body] + states[body, 2]
        c, s = np.cos(angle), np.sin(angle)
        u, w = point[0] - bones.pivot[body], point[1]
        turned = np.array([c * u + s * w, -s * u + c * w])
        slope = np.array([[1.0, 0.0, -s * u + c * w], [0.0, 1.0, -c * u - s * w]])
        return bones.origin[body] + states[body, :2] + turned, slope, -turned
