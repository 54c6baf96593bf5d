"""The casting set-up of one actuator: the dimensions that its tooling parts share.

The mould stands tip down and is poured from the base (Figure 4.7, 4.10). In the actuator's frame:

    x = seat       the core's flange lies on the suspender's hub: this sets the core's depth
    x = top        rim of the pouring cup; the suspender's plate lies on it
    x = 0          the actuator's base: the edge where the cup begins, to be trimmed to
    x = length     the mould's floor: the outside of the actuator's tip
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from handgen.errors import GeometryError
from handgen.geometry import csg
from handgen.geometry.actuator import profile_of
from handgen.geometry.profile import ActuatorProfile
from handgen.parameters.finger import Thread
from handgen.parameters.model import Hand
from handgen.parameters.process import Casting, Seal

MARGIN = 1.0
"""How far cutters reach beyond what they cut, mm."""
CHAMFER = 2.0
"""On the long outer edges of the mould, mm: kind to hands and to rubber bands."""
PIN = 2.0
"""Radius of the mould's alignment pins, mm: the thinnest that do not shear off in PLA."""
LAND = 2.0
"""Least material around a pin's hole and around the pouring cup, mm."""
HUB_WALL = 2.0
"""Wall of the suspender's hub, mm."""
POUR_GAP = 3.5
"""Width of the gates between the suspender's hub and its ring, mm: takes a syringe's tip."""
LEAST_TEXT = 2.5
"""Smallest capitals, mm, that a 0.35 mm nozzle prints legibly."""
SUNK = 0.4
"""How far a label's letters reach into the part, mm: no face of theirs coincides with one of its."""
SALIENCE = 2.0
"""How far a core's salience reaches into the mould's floor, mm (`casting.tip: filled afterwards`)."""

ALONG_X = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
"""Rotation that carries an outline drawn in (x, y) and its height z to (y, z) and x."""


@dataclass(frozen=True)
class Setup:
    """What the tooling of actuator `name` has in common; all lengths in mm."""

    hand: Hand
    name: str

    @cached_property
    def profile(self) -> ActuatorProfile:
        return profile_of(self.hand, self.name)

    @property
    def casting(self) -> Casting:
        return self.hand.casting

    @property
    def seal(self) -> Seal:
        return self.hand.seal

    @property
    def thread(self) -> Thread:
        return self.hand.thread_of(self.name)

    @property
    def path(self) -> str:
        return f"actuators.{self.name}"

    @property
    def code(self) -> str:
        """Short name for labels: I, M, R, L, T, O1, O2."""
        return self.name[0].upper() + (self.name[-1] if self.name[-1].isdigit() else "")

    @property
    def length(self) -> float:
        return self.profile.length

    @property
    def base(self) -> float:
        """The cavity's radius at the actuator's base, its widest place."""
        return self.profile.outer(0.0)

    @property
    def top(self) -> float:
        return -self.casting.pour_height

    @property
    def height(self) -> float:
        """Of the mould halves, along x."""
        return self.length - self.top

    @property
    def seat(self) -> float:
        """Top of the suspender's hub; the longer the hub, the straighter the core hangs."""
        return self.top - max(8.0, 1.5 * self.shank)

    @property
    def shank(self) -> float:
        """Radius of both cores in the hub: the wound large core must pass through it."""
        large = self.profile.large_core(0.0)
        return large + max(self.profile.thread(0.0) - large, self.thread.diameter)

    @property
    def bore(self) -> float:
        """Radius of the hub's bore."""
        return self.shank + self.casting.core_fit

    @property
    def hub(self) -> float:
        """Outside radius of the hub."""
        return self.bore + HUB_WALL

    @property
    def cup(self) -> float:
        """Radius of the pouring cup's rim: leaves the gates open all around the hub."""
        return max(self.hub + POUR_GAP, self.base + LAND)

    @property
    def half_width(self) -> float:
        """Of the mould along y; the pins stand in the split beside the cavity."""
        pins = 2 * (LAND + PIN + self.casting.mould_fit)
        return max(self.base + max(self.casting.mould_wall, pins), self.cup + LAND)

    @property
    def half_depth(self) -> float:
        """Of the mould along z, to which it opens."""
        return max(self.base + self.casting.mould_wall, self.cup + LAND)

    @property
    def skirt(self) -> float:
        """How far suspender and base reach over the mould halves."""
        return min(8.0, 0.25 * self.height)

    @property
    def text(self) -> float:
        """Capitals of labels on suspender and base."""
        return min(5.0, 0.6 * self.skirt)

    @property
    def salience(self) -> float:
        """Radius of the cores' salience at the tip; 0: the cores hang free."""
        if self.casting.tip == "cast":
            return 0.0
        core = self.profile.casting_core
        return min(1.5, 0.5 * core(core.end))

    def outline(self, grown: float = 0.0, half: bool = False) -> csg.Path:
        """The mould's cross-section in (y, z), grown outwards all around; half: only z <= 0."""
        y, z = self.half_width + grown, self.half_depth + grown
        c = CHAMFER + grown * (2.0 - math.sqrt(2.0))
        lower = [(-y, -z + c), (-y + c, -z), (y - c, -z), (y, -z + c)]
        if half:
            return csg.Path.polygon([(-y, 0.0), *lower, (y, 0.0)])
        return csg.Path.polygon([*lower, *((v, -w) for v, w in reversed(lower))])

    def prism(self, x0: float, x1: float, grown: float = 0.0, half: bool = False) -> csg.Shape:
        """The mould's cross-section from x0 to x1."""
        return csg.Extrude(self.outline(grown, half), x1 - x0).placed(ALONG_X, (x0, 0.0, 0.0))

    def label(self, text: str, size: float, at: tuple[float, float, float], *,
              across: bool = False) -> csg.Shape | None:
        """Letters on a face whose outward normal is +y, centred on `at`: along x, or upright
        (`across`) when the mould stands on its base.

        None where labels are switched off or would not be legible.
        """
        height = self.casting.label_height
        if height <= 0.0 or size < LEAST_TEXT:
            return None
        # Columns: the letters' right, up and out.
        turn = ((0, -1, 0), (0, 0, 1), (-1, 0, 0)) if across else ((1, 0, 0), (0, 0, 1), (0, -1, 0))
        x, y, z = at
        return csg.Text(text, size, height + SUNK).placed(turn, (x, y - SUNK, z))

    def error(self, part: str, path: str, message: str) -> GeometryError:
        """`part` is the role of the part that cannot be made, `path` the parameter to change."""
        return GeometryError(f"tooling/{self.name}/{part}", path, message)


def joined(body: csg.Shape, *additions: csg.Shape | None) -> csg.Shape:
    """`body` with those additions that exist."""
    present = tuple(a for a in additions if a is not None)
    return csg.Union((body, *present)) if present else body
