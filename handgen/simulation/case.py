"""What is simulated and what comes out: plain data, so that cases can be cached, sent and solved anywhere.

Frame of every vector: the finger's, x from the root plane to the fingertip, y across, z dorsal; mm, N,
MPa, tonne, s, rad.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from handgen.geometry.profile import ActuatorProfile, FingerProfile
from handgen.materials.law import Law

Kind = Literal["assembly", "exoskeleton", "actuator"]
STANDARD_GRAVITY = 9806.65
"""mm/s2."""
TOUCHING = 1e-6
"""mm; surfaces that overlap by less only touch."""
HEXAHEDRON, QUADRATIC_HEXAHEDRON = 12, 25
"""VTK's numbers for the cells of 8 and of 20 nodes."""


@dataclass(frozen=True)
class Substance:
    """A nearly incompressible material: isochoric `law`, `bulk` modulus MPa, `density` tonne/mm3."""

    law: Law
    bulk: float
    density: float


@dataclass(frozen=True)
class Winding:
    """The thread in an actuator's wall; `depth`: how far its centre lies outside the large core, mm."""

    pitch: float
    diameter: float
    young: float
    depth: float
    start: float
    """x of the first turn, mm (`thread.held_back`)."""
    end: float
    """x of the last turn, mm (the large core's end less `thread.held_back`)."""
    bulge: float = 0.0
    """mm/MPa: how much further than its turns the wall moves out, on average, under what they hold back."""
    compressive: float = 0.02
    """Stiffness under compression as a share of that under tension: a bedded thread buckles."""


@dataclass(frozen=True)
class Contact:
    """Between actuator and bore."""

    friction: float = 0.0
    """Coulomb's coefficient, along the axis."""
    bonded: bool = False
    """The actuator sticks wherever it touches at rest: no model of a hand, kept for comparison."""
    clearance: float = 0.0
    """mm by which the bore, for the actuator alone, is wider all around."""


@dataclass(frozen=True)
class Case:
    """One finger, or a part of it, under a row of loads.

    Points: with `part` "exoskeleton" one for each of `tip_loads`; else one for each of `pressures`, all
    under the one tip load (or none).
    """

    part: Kind
    finger: FingerProfile | None
    fillet: float
    """Wanted radius in the slots' corners, mm (`exoskeleton.joint_fillet`)."""
    actuator: ActuatorProfile | None
    winding: Winding | None
    """None: an actuator without thread (it balloons)."""
    tpu: Substance | None
    silicone: Substance | None
    held: float
    """Length, mm, over which plug and collar hold the actuator's base."""
    contact: Contact = Contact()
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """mm/s2; palm down (0, 0, -STANDARD_GRAVITY). A component along y is not allowed: half model."""
    pressures: tuple[float, ...] = (0.0,)
    """MPa, in the order applied: rising, unless unloading is asked for."""
    tip_loads: tuple[float, ...] = (0.0,)
    """N, a weight that hangs on the fingertip; it pulls along gravity, or palmar without gravity."""
    obstacle: float | None = None
    """A rigid plane so many mm below the palm side (z = -R(0) - obstacle)."""
    base_compliance: float = 0.0
    """rad/(N mm): how far the finger's root turns in its clamp."""
    offset: float = 0.0
    """mm by which the actuator's core and thread lie nearer to its back than in the middle."""
    edges_left: float = 0.0
    """Share of the distance at rest of a slot's palmar edges at which it is closed."""
    softening: tuple[float, ...] = ()
    """Share of the silicone's stiffness that is lost at each of `pressures`; empty: none."""
    curl_taken: float = 1.0
    """Share of the finger's rest curl that the actuator, cast straight, is free of stress in."""
    root_angle: float = 0.0
    """rad by which the finger, at its root, hangs below the palm's plane, in which x runs."""
    refine: int = 0
    """0: the standard mesh; every step halves the elements' edges, about."""

    @property
    def curl_strains(self) -> float:
        """Share of the rest curl that strains the actuator; 0 where there is no curl."""
        curled = self.part == "assembly" and any(joint.rest_angle for joint in self.finger.finger.joints)
        return 1.0 - self.curl_taken if curled else 0.0

    @cached_property
    def tight(self) -> float:
        """mm by which the bore, where it is narrowest, is narrower than its actuator; 0: nowhere."""
        if self.part != "assembly" or self.contact.bonded:
            return 0.0
        x = np.linspace(self.held, min(self.actuator.length, self.finger.finger.inner_length), 101)
        over = float((self.actuator.outer(x) - self.finger.bore(x)).max()) - self.contact.clearance
        return over if over > TOUCHING else 0.0

    @property
    def extended(self) -> tuple[str, ...]:
        """Names of what goes beyond the plain finger, which a solver may not know."""
        return tuple(name for name, there in (
            ("play in the bore", self.contact.clearance != 0.0),
            ("a bulge between the thread's turns", self.winding is not None and self.winding.bulge != 0.0),
            ("a base that gives", self.base_compliance != 0.0),
            ("an actuator off its centre", self.offset != 0.0),
            ("joints that close", self.edges_left != 0.0), ("silicone that remembers", bool(self.softening)),
            ("an actuator that a rest curl strains", self.curl_strains != 0.0),
            ("a root that hangs", self.root_angle != 0.0),
        ) if there)


@dataclass(frozen=True)
class Grid:
    """A mesh as it was drawn: `nodes` (n, 3) mm, `cells` (m, 8 or 20) in VTK's order; half, y >= 0."""

    nodes: np.ndarray
    cells: np.ndarray

    @property
    def cell_type(self) -> int:
        return HEXAHEDRON if self.cells.shape[1] == 8 else QUADRATIC_HEXAHEDRON


@dataclass(frozen=True)
class State:
    """The finger under one load; without a converged solution only the load and `note` are known."""

    pressure: float
    """MPa."""
    tip_load: float
    """N."""
    converged: bool
    tip_drop: float | None = None
    """Lowest point of the tip below the plane of the palm's bottom surface (z = -R(0)), mm."""
    bend_angle: float | None = None
    """Rotation of the tip against the straight axis, rad, flexion positive."""
    elongation: float | None = None
    """Growth of the actuator's centre line, mm: for a free one the axial travel of its tip."""
    tip_force: float | None = None
    """Force on the obstacle, N, both halves together."""
    max_stretch: float | None = None
    """Largest principal stretch in any element's centre."""
    bend_error: float | None = None
    """How far off the bend may be by the solver's own account, rad; None: it gives none."""
    residual: float | None = None
    """Largest out-of-balance force over the largest of the acting ones."""
    note: str = ""
    """What a user must know of this point, e.g. that the finger jumped ("folds at 68 kPa")."""
    positions: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Body ("exoskeleton", "actuator") -> nodes (n, 3), mm."""
    stretch: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Body -> largest principal stretch of every cell (m,)."""


@dataclass(frozen=True)
class Curve:
    """All points of a case, in the order asked for."""

    states: tuple[State, ...]
    grids: Mapping[str, Grid]
    reached: float
    """Largest pressure, MPa (tip load, N, for the bare exoskeleton), up to which every point converged."""
    folds: tuple[float, ...]
    """Pressures, MPa, at which the finger jumped from one branch to another."""
    unknowns: int
    factorisations: int
    wall: float
    """Seconds."""
    stopped: str = ""
    """Why it went no further; empty where every point converged."""
