"""The finger's exoskeleton: rigid bones, each side of a slot a deformable band, between them the strip.

Elements of 20 nodes fill the whole half finger (pictures want it, and so does its weight), but only those
between the middles of two bones deform where it matters: in the strip and within BAND of its slot. What
lies beyond moves with its bone as a rigid body of three unknowns in the plane of symmetry. Where a bone is
shorter than two bands only its middle is rigid. The strip's edges follow the slot's rounded corners.

A joint's rest angle is drawn in: nodes are those of the straight finger carried along its curled axis
(`geometry.finger.Axis`), free of stress there.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from handgen.geometry.finger import Axis
from handgen.geometry.profile import FingerProfile
from handgen.simulation.case import Grid

BAND = 12.0
"""Length of the deformable part of a bone beside a slot, mm; with 6 a bare finger is 5 % too stiff,
beyond 12 nothing changes."""
RIGID = 1.0
"""Least length of a bone's rigid part, mm, but in bones so short that ..."""
LEAST_BAND = 0.25
"""... their bands would be shorter than this share of them: slivers."""
BONE_EDGE = 6.0
"""Length of elements along a rigid part, mm: they are only weighed and drawn."""
STRIP_AROUND, REST_AROUND = 3, 4
"""Elements around half the strip, and around the rest of the half circle."""
NEVER = -1
"""Body of a node that is free; the first bone is body 0 and stands still."""
DOME = (0.3, 0.55, 0.75, 0.9, 0.98)
"""Stations of the rounded tip, as shares of its length; the last leaves a small flat, drawn only."""


@dataclass(frozen=True)
class Bones:
    """Rigid bodies 0, 1, ...; the first is held. Their frames are the straight finger's, carried."""

    start: np.ndarray
    """(b,) x of the straight finger, mm, where each begins: the end of the slot before; the first at 0."""
    end: np.ndarray
    """(b,) where the next slot begins; the last at the end of the bore."""
    pivot: np.ndarray
    """(b,) x of a point of the axis that turns with the body."""
    origin: np.ndarray
    """(b, 2) where that point stands at rest, (x, z) mm."""
    angle: np.ndarray
    """(b,) flexion at rest, rad."""

    def carried(self, body: int, points: np.ndarray, state: np.ndarray | None = None) -> np.ndarray:
        """Points (n, 3) of the straight finger, moved with `body`; `state` (b, 3): dx, dz, flexion more."""
        dx, dz, turn = (0.0, 0.0, 0.0) if state is None else state[body]
        angle = self.angle[body] + turn
        c, s = math.cos(angle), math.sin(angle)
        x, z = points[:, 0] - self.pivot[body], points[:, 2]
        return np.stack([self.origin[body, 0] + dx + c * x + s * z, points[:, 1],
                         self.origin[body, 1] + dz - s * x + c * z], -1)


@dataclass(frozen=True)
class ExoskeletonMesh:
    grid: Grid
    straight: np.ndarray
    """(n, 3) the same nodes in the straight finger."""
    body: np.ndarray
    """(n,) body that carries each node, NEVER where it is free."""
    bones: Bones
    mass_points: np.ndarray
    """(b, 3) straight place of each body's centre of mass beyond the deformable elements, mm."""
    volumes: np.ndarray
    """(b,) half volume of that, mm3."""


def exoskeleton_mesh(profile: FingerProfile, fillet: float, refine: int,
                     root: float = 0.0) -> ExoskeletonMesh:
    """Mesh of `profile` with corners of the wanted radius `fillet`, mm; it hangs by `root`, rad."""
    return _Finger(profile, fillet, refine, root).mesh()


class _Finger:
    def __init__(self, profile: FingerProfile, fillet: float, refine: int, root: float):
        self.profile, self.axis, self.fine = profile, Axis(profile, fillet, root), 2**refine
        self.joints = profile.finger.joints
        self.slots = [(j.position - j.slot_length / 2, j.position + j.slot_length / 2) for j in self.joints]
        self.corner = [profile.fillet(j, fillet) for j in self.joints]
        self.bones = self._bones()
        self.rigid = self._rigid()

    def _bones(self) -> Bones:
        start = np.array([0.0] + [b for _, b in self.slots])
        end = np.array([a for a, _ in self.slots] + [self.profile.finger.inner_length])
        frames = np.array([self.axis.frame(x) for x in start])
        return Bones(start, end, start, frames[:, :2], frames[:, 2])

    def _rigid(self) -> list[tuple[float, float]]:
        """(from, to) of the rigid part of every bone; the first reaches back to the root, the last on."""
        parts = []
        for i, (a, b) in enumerate(zip(self.bones.start, self.bones.end, strict=True)):
            first, last = i == 0, i == len(self.slots)
            band = min(BAND, max((b - a - RIGID) / (2 - first - last), LEAST_BAND * (b - a)))
            parts.append((a if first else a + band, b if last else b - band))
        return parts

    def stations(self) -> list[float]:
        """x of the elements' ends along the finger."""
        found = [self.rigid[0][0]]
        for i, (a, b) in enumerate(self.slots):
            self._bone(found, self.rigid[i][1])
            found += list(np.linspace(self.rigid[i][1], a, 2 * self.fine + 1)[1:])
            r = self.corner[i]
            marks = [a, a + r, b - r, b] if r > 0 else [a, b]
            for j, (p, q) in enumerate(itertools.pairwise(marks)):
                pieces = (2 if j == 1 or r == 0 else 1) * self.fine
                found += list(np.linspace(p, q, pieces + 1)[1:])
            found += list(np.linspace(b, self.rigid[i + 1][0], 2 * self.fine + 1)[1:])
        self._bone(found, self.rigid[-1][1])
        return found

    def _bone(self, found: list[float], end: float) -> None:
        length = end - found[-1]
        if length > 1e-9:
            found += list(np.linspace(found[-1], end, max(1, round(length / BONE_EDGE)) + 1)[1:])

    def edge(self, x: float) -> float:
        """Angle of the strip's edge from the palmar side at x, rad, wider in its rounded corners.

        Within the bands the same line of the mesh runs back to the strip's own angle; on bones without a
        slot nearby it is the next joint's.
        """
        wide = []
        for joint, (a, b), r in zip(self.joints, self.slots, self.corner, strict=True):
            half = math.radians(joint.palmar_arc / 2)
            outside = max(a - x, x - b, 0.0)
            inside = min(max(min(x - a, b - x), 0.0), r) if r > 0 else 0.0
            more = r - math.sqrt(max(r * r - (r - inside) ** 2, 0.0)) if outside == 0.0 else r
            if r > 0:
                half += more * max(0.0, 1.0 - outside / BAND) / self.profile.bore_radius((a + b) / 2)
            wide.append((outside, half))
        wide.sort()
        near, half = wide[0]
        if len(wide) > 1 and near > 0:
            other, further = wide[1]
            half = (half * other + further * near) / (near + other)
        return min(half, 0.9 * math.pi)

    def mesh(self) -> ExoskeletonMesh:
        ends = self.stations()
        x = np.empty(2 * len(ends) - 1)
        x[::2], x[1::2] = ends, (np.array(ends)[1:] + np.array(ends)[:-1]) / 2
        places = 2 * (STRIP_AROUND + REST_AROUND) * self.fine + 1
        strip = 2 * STRIP_AROUND * self.fine
        angle = np.empty((len(x), places))
        for i, at in enumerate(x):
            edge = self.edge(float(at))
            angle[i, :strip + 1] = np.linspace(0.0, edge, strip + 1)
            angle[i, strip:] = np.linspace(edge, math.pi, places - strip)
        layers = 2 * self.fine + 1
        share = np.linspace(0.0, 1.0, layers)
        radius = (1 - share) * self.profile.bore(x)[:, None] + share * self.profile.outer(x)[:, None]
        y = np.sin(angle)
        y[:, -1] = 0.0
        straight = np.stack(np.broadcast_arrays(
            x[:, None, None], radius[:, :, None] * y[:, None, :],
            -radius[:, :, None] * np.cos(angle)[:, None, :]), -1)
        cells, _ = self._cells(len(ends) - 1, layers, places, np.array(ends))
        dome_nodes, dome_cells = self._dome(straight[-1], x[-1], straight.size // 3)
        straight = np.vstack([straight.reshape(-1, 3), dome_nodes])
        body = self._carriers(straight)
        used, cells = np.unique(np.vstack([cells, dome_cells]), return_inverse=True)
        cells = cells.reshape(-1, 20)
        straight, body = straight[used], body[used]
        centres, volumes = self._masses()
        return ExoskeletonMesh(Grid(self._carry(straight, body), cells), straight, body, self.bones,
                               centres, volumes)

    def _cells(self, along: int, layers: int, places: int, ends: np.ndarray):
        """Elements of 20 nodes out of the doubled grid, without those in the slots."""
        i, j, k = np.meshgrid(2 * np.arange(along), 2 * np.arange((layers - 1) // 2),
                              2 * np.arange((places - 1) // 2), indexing="ij")
        middle = (ends[1:] + ends[:-1]) / 2
        open_there = np.zeros(along, bool)
        for a, b in self.slots:
            open_there |= (middle > a) & (middle < b)
        kept = ~(open_there[i // 2] & (k >= 2 * STRIP_AROUND * self.fine))
        i, j, k = i[kept], j[kept], k[kept]
        at = [((i + a) * layers + j + b) * places + k + c for a, b, c in CORNERS_AND_EDGES]
        return np.stack(at, -1), i

    def _dome(self, last: np.ndarray, x0: float, first: int):
        """Nodes and cells of the rounded tip, a cap that closes on itself; for pictures and weight only."""
        f = self.profile.finger
        length = f.outer_length - f.inner_length
        stations = np.array([0.0, *DOME])
        stations = np.sort(np.concatenate([stations, (stations[1:] + stations[:-1]) / 2]))
        scale = np.sqrt(1.0 - stations**2)
        x = x0 + length * stations
        layers, places = last.shape[:2]
        # A skin as thick as the wall, drawn solid towards the axis.
        shares = np.linspace(0.05, 1.0, layers)
        outside = last[-1]
        nodes = np.stack(np.broadcast_arrays(
            x[:, None, None],
            scale[:, None, None] * shares[None, :, None] * outside[None, None, :, 1],
            scale[:, None, None] * shares[None, :, None] * outside[None, None, :, 2]), -1)
        i, j, k = np.meshgrid(2 * np.arange(len(DOME)), 2 * np.arange((layers - 1) // 2),
                              2 * np.arange((places - 1) // 2), indexing="ij")
        at = [first + ((i + a) * layers + j + b) * places + k + c for a, b, c in CORNERS_AND_EDGES]
        return nodes.reshape(-1, 3), np.stack(at, -1).reshape(-1, 20)

    def _carriers(self, straight: np.ndarray) -> np.ndarray:
        body = np.full(len(straight), NEVER)
        for i, (a, b) in enumerate(self.rigid):
            last = i == len(self.slots)
            inside = (straight[:, 0] >= a - 1e-9) & ((straight[:, 0] <= b + 1e-9) | last)
            body[inside] = i
        return body

    def _carry(self, straight: np.ndarray, body: np.ndarray) -> np.ndarray:
        """Free nodes along the curled axis, carried ones with their body; the two agree on bones."""
        return self.axis.carry(straight)

    def _masses(self):
        """Centre and half volume of each body, by sections (dome included)."""
        centres, volumes = [], []
        for i, (a, b) in enumerate(self.rigid):
            end = self.profile.length if i == len(self.slots) else b
            edges = np.linspace(a, end, 201)
            x = (edges[1:] + edges[:-1]) / 2
            bore = self.profile.bore_radius(x)
            area = math.pi / 2 * (self.profile.outer_radius(x) ** 2 - bore**2)
            volume = (area * np.diff(edges)).sum()
            # The half's own centre stands off the plane of symmetry, where it makes no moment.
            centres.append((0.0 if volume == 0 else (area * x * np.diff(edges)).sum() / volume, 0.0, 0.0))
            volumes.append(volume)
        return np.array(centres), np.array(volumes)


CORNERS_AND_EDGES = (
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1))
"""Places of a 20-node element's nodes in its 3 x 3 x 3 grid, in VTK's order."""


def palmar(profile: FingerProfile, bones: Bones) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 3) of the bones' palmar outside, straight, their bones, and the area of each, mm2.

    The rounded tip has a back too: what is bent past 90 degrees stands on it.
    """
    points, bodies = [], []
    for b, (start, end) in enumerate(zip(bones.start, bones.end, strict=True)):
        last = b == len(bones.start) - 1
        stop = profile.length if last else end
        x = np.linspace(start, stop, max(2, round((stop - start) / 0.5)) + 1)
        if last:
            # Evenly along the rounded tip's arc, not along x.
            dome = profile.finger.inner_length + (profile.length - profile.finger.inner_length) * np.sin(
                np.linspace(0, np.pi / 2, 31))
            x = np.concatenate([x[x < dome[0] - 0.25], dome])
        radius = profile.outer_radius(x)
        if last:
            back = dome[-2::-1]
            x, radius = np.concatenate([x, back]), np.concatenate([radius, -profile.outer_radius(back)])
        points.append(np.stack([x, 0 * x, -radius], -1))
        bodies.append(np.full(len(x), b))
    found = np.vstack(points)
    return found, np.concatenate(bodies), np.ones(len(found))
