"""A finger as a chain: the arrays that its balance is made of, and where its bones stand.

State q: the joints' turns beyond rest (n), rad, their strips' growth (n), mm, and the actuator's thrust at
its base, N. Functions of q take a batch (B, 2n + 1).
"""

from __future__ import annotations

import math

import numpy as np

from handgen.geometry.strip import strip_sections
from handgen.materials.states import PLANAR, UNIAXIAL, nominal_stress
from handgen.simulation.case import Case
from handgen.simulation.observe import TIP

FIBRES = 5
"""Gauss points through a strip."""
SECTIONS = 12
"""Places along a slot at which the strip is measured."""
STATIONS = 40
"""Along the actuator."""
BONE_SECTIONS = 60
REACH = 0.5
"""Of the bending of a chamber into the bones beside its slot, in outside radii."""
STRAINS = np.linspace(-0.6, 1.5, 421)
STRETCHES = np.linspace(0.4, 4.0, 721)
"""Where the laws are tabulated."""
FLAT = 1e-4
"""rad; arcs that turn less are taken for flat."""
PENALTY = 2.0
"""N/mm of each point that is pushed into the plane."""
ROUNDED = 0.3
"""mm over which a point begins to push."""
TOUCHING = 25
"""Points of a bone that may meet it."""
TIP_PALMAR = 4
"""Of the last one's before its rounded tip."""


class Chain:
    """`case`, measured."""

    def __init__(self, case: Case):
        self.case, self.profile, self.cast = case, case.finger, case.actuator
        self.joint_list = case.finger.finger.joints
        self.joints = len(self.joint_list)
        self.unknowns = 2 * self.joints + 1
        self._strips()
        self._actuator()
        self._bending()
        self._bones()

    # Measures

    def _strips(self) -> None:
        case = self.case
        measured = []
        for j in self.joint_list:
            x = j.position + j.slot_length * ((np.arange(SECTIONS) + 0.5) / SECTIONS - 0.5)
            area, centroid, second, _, _ = strip_sections(self.profile, j, case.fillet, x)
            # In a row their compliances add up.
            measured.append((1 / np.mean(1 / area), np.mean(centroid), 1 / np.mean(1 / second)))
        self.area, self.lever, self.second = np.array(measured).T
        self.slot = np.array([j.slot_length for j in self.joint_list])
        self.position = np.array([j.position for j in self.joint_list])
        self.rest = np.radians([j.rest_angle for j in self.joint_list])
        self.bore = self.profile.bore(self.position)
        self.wall = self.profile.outer(self.position) - self.bore
        self.arc = np.radians([j.palmar_arc for j in self.joint_list])
        self.strip_length = self.slot - self.lever * self.rest
        ends = np.r_[0.0, self.position + self.slot / 2]
        begins = np.r_[self.position - self.slot / 2, self.profile.finger.inner_length]
        bones = begins - ends
        # Into the last bone no bending reaches: its closed tip keeps it round.
        self.beside = np.stack([bones[:-1], np.r_[bones[1:-1], 0.0]], -1)
        place, weight = np.polynomial.legendre.leggauss(FIBRES)
        # A rectangle of the same area and second moment.
        self.height = np.sqrt(12 * self.second / self.area)
        self.fibre = place * self.height[:, None] / 2
        self.fibre_area = weight / 2 * self.area[:, None]
        self.strip_stress = nominal_stress(case.tpu.law, UNIAXIAL, 1 + STRAINS)

    def _actuator(self) -> None:
        case, cast = self.case, self.cast
        edges = np.linspace(case.held, cast.small_core_end, STATIONS + 1)
        self.x, self.dx = (edges[1:] + edges[:-1]) / 2, edges[1] - edges[0]
        outside, inside = cast.outer(self.x), cast.small_core(self.x)
        thread = cast.large_core(self.x) + case.winding.depth
        self.wall_area = math.pi * (outside**2 - inside**2)
        self.pressed = math.pi * thread**2
        self.silicone_stress = nominal_stress(case.silicone.law, PLANAR, STRETCHES)
        self.silicone_slope = np.gradient(self.silicone_stress, STRETCHES)
        self.passed = np.searchsorted(self.position, self.x)
        self.at = np.clip(np.searchsorted(self.x, self.position), 0, STATIONS - 1)
        self.outside = outside[self.at]
        self.around = self.position[:, None] + np.linspace(-1.0, 1.0, 2 * SECTIONS + 1) * (
            self.slot / 2 + REACH * self.outside)[:, None]
        self.free = case.finger.finger.inner_length - cast.length

    def _bending(self) -> None:
        """Length over second moment of the actuator's bent part at each joint, 1/mm3, solid tip and all."""
        cast, x = self.cast, np.clip(self.around, 0.0, self.cast.length)
        inside = np.where(x < cast.small_core_end, cast.small_core(np.minimum(x, cast.small_core_end)), 0.0)
        second = math.pi / 4 * (cast.outer(x) ** 4 - inside**4)
        self.bend_length = self.slot + 2 * REACH * self.outside
        self.flexible = self.bend_length * (1 / second).mean(1)

    def _bones(self) -> None:
        """Ends, masses (half of each joint's goes to either neighbour), centres, points that may touch."""
        case, f = self.case, self.profile.finger
        self.start = np.r_[0.0, self.position + self.slot / 2]
        self.end = np.r_[self.position - self.slot / 2, f.outer_length]
        share = (np.arange(BONE_SECTIONS) + 0.5) / BONE_SECTIONS
        x = self.start[:, None] + (self.end - self.start)[:, None] * share
        weight = self._mass_per_length(x) * ((self.end - self.start) / BONE_SECTIONS)[:, None]
        mass, first = weight.sum(1), (weight * x).sum(1)
        silicone = case.silicone.density * self.wall_area[self.at]
        joint = (case.tpu.density * self.area + silicone) * self.slot / 2
        mass[:-1] += joint
        first[:-1] += joint * self.end[:-1]
        mass[1:] += joint
        first[1:] += joint * self.start[1:]
        self.mass, self.centre = mass, first / mass
        share = np.linspace(0.0, 1.0, TOUCHING)
        self.touch = self.start[:, None] + (self.end - self.start)[:, None] * share
        # The rounded tip is where a finger meets the plane; bent past 90 degrees it stands on its back.
        palm = TIP_PALMAR
        around = np.linspace(0.0, np.pi, TOUCHING - palm)
        self.touch[-1] = np.r_[np.linspace(f.inner_length - TIP, f.inner_length, palm, endpoint=False),
                               f.inner_length + (f.outer_length - f.inner_length) * np.sin(around)]
        self.touch_radius = self.profile.outer_radius(self.touch)
        self.touch_radius[-1, palm:] *= np.sign(np.cos(around))

    def _mass_per_length(self, x: np.ndarray) -> np.ndarray:
        """Of exoskeleton and actuator, tonne/mm."""
        cast, profile = self.cast, self.profile
        printed = profile.outer_radius(x) ** 2 - profile.bore_radius(x) ** 2
        air = np.where(x < cast.small_core_end, cast.small_core(np.minimum(x, cast.small_core_end)), 0.0)
        silicone = np.where(x < cast.length, cast.outer(np.minimum(x, cast.length)) ** 2 - air**2, 0.0)
        return math.pi * (self.case.tpu.density * printed + self.case.silicone.density * silicone)

    # Places

    def frames(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(z, flexion) of every bone's start (B, n + 1): joints are arcs of their strips' centroids."""
        bend, chord, lever = self.rest + q[:, :self.joints], self._chords(q)[0], self.lever
        angle = np.concatenate([np.zeros((len(q), 1)), np.cumsum(bend, 1)], 1)
        here, there = angle[:, :-1], angle[:, 1:]
        fall = (-(self.end - self.start)[:-1] * np.sin(here) - chord * np.sin(here + bend / 2)
                + lever * (np.cos(there) - np.cos(here)))
        return np.concatenate([np.zeros((len(q), 1)), np.cumsum(fall, 1)], 1), angle

    def _chords(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Chords of the joints' arcs, mm, and their slopes along turn and growth (B, n)."""
        bend = self.rest + q[:, :self.joints]
        length, shorter = self.strip_length + q[:, self.joints:2 * self.joints], np.sinc(bend / (2 * np.pi))
        small = np.abs(bend) < FLAT
        slope = np.where(small, -bend / 12, (np.cos(bend / 2) - shorter) / np.where(small, 1.0, bend))
        return length * shorter, length * slope, shorter

    def heights(self, frames, along: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """z (B, n + 1, k) of points `along` (n + 1, k) their bones at `radius` palmar of the axis."""
        z, angle = frames
        u = along - self.start[:, None]
        return z[..., None] - np.sin(angle)[..., None] * u - np.cos(angle)[..., None] * radius

    def forces(self, q: np.ndarray, share: float) -> np.ndarray:
        """Moments at the joints and pulls at their strips (B, 2n), N mm and N, as slopes of an energy.

        Of `share` of own weight, of the tip's weight, and of the plane.
        """
        frames, n = self.frames(q), self.joints
        angle = frames[1]
        sine, cosine = np.sin(angle), np.cos(angle)
        # What pulls on every bone, N, and turns it about its start, N mm.
        pull = -share * self.case.gravity[2] * self.mass * np.ones((len(q), 1))
        turn = -pull * cosine * (self.centre - self.start)
        if self.case.tip_loads[0]:
            # It pulls along gravity, or palmar without gravity.
            hung = (-1.0 if self.case.gravity[2] > 0 else 1.0) * share * self.case.tip_loads[0]
            pull[:, -1] += hung
            turn[:, -1] -= hung * cosine[:, -1] * (self.end - self.start)[-1]
        if self.case.obstacle is not None:
            sunk, slope = self._sunk(frames)
            push = -PENALTY * sunk * slope
            pull = pull + push.sum(-1)
            turn = turn + (push * (sine[..., None] * self.touch_radius - cosine[..., None] * (
                self.touch - self.start[:, None]))).sum(-1)
        # A joint carries all that lies beyond it.
        carried = _beyond(pull)
        bend, (chord, chord_turn, chord_growth) = self.rest + q[:, :n], self._chords(q)
        middle, there = angle[:, :-1] + bend / 2, sine[:, 1:]
        turn[:, :-1] += carried * (self.lever * (sine[:, :-1] - there) - chord * np.cos(middle)
                                   - (self.end - self.start)[:-1] * cosine[:, :-1])
        moment = _beyond(turn) - carried * (
            chord_turn * np.sin(middle) + chord * np.cos(middle) / 2 + self.lever * there)
        return np.concatenate([moment, -carried * chord_growth * np.sin(middle)], 1)

    def _sunk(self, frames) -> tuple[np.ndarray, np.ndarray]:
        """How far points lie below the plane, mm, and its slope: rounded, or Newton's method sticks."""
        level = -float(self.profile.outer(0.0)) - self.case.obstacle
        below = level - self.heights(frames, self.touch, self.touch_radius)
        size = np.sqrt(below**2 + ROUNDED**2)
        return (below + size) / 2, (1 + below / size) / 2

    def pushed(self, q: np.ndarray) -> float:
        """Force on the plane, N."""
        sunk, slope = self._sunk(self.frames(q[None]))
        return float(PENALTY * (sunk * slope).sum())

    def drop(self, q: np.ndarray) -> float:
        """Lowest point of the tip below z = -R(0), mm, as `observe` has it."""
        z, angle = (part[0, -1] for part in self.frames(q[None]))
        f = self.profile.finger
        x = np.linspace(f.inner_length - TIP, f.outer_length, 60)
        radius = self.profile.outer_radius(x)
        u = x - self.start[-1]
        lowest = min((z - np.sin(angle) * u - np.cos(angle) * side * radius).min() for side in (-1.0, 1.0))
        return float(-lowest - self.profile.outer(0.0))


def _beyond(values: np.ndarray) -> np.ndarray:
    """Sums over the bones beyond each joint (B, n)."""
    return np.cumsum(values[:, :0:-1], 1)[:, ::-1]
