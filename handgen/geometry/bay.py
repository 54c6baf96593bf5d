"""The bays: where two neighbouring channels run into one another towards the wrist.

The hand is printed lying on its palm, so a bay's roof must carry itself: nothing can be put under
it that could be taken out again. In cross-section it rises from the outer flanks of both channels
to a ridge that is narrow enough to be bridged. Towards the fingers it ends in a prow that climbs
from the wall between the two channels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from handgen.geometry import csg
from handgen.geometry.palm import MARGIN, Hole, channels
from handgen.geometry.skin import Cone, Limb
from handgen.parameters.model import Hand

SLOPE = math.radians(22.0)
"""Of a roof against the bed: Table B.1 supports what is flatter than 20 deg."""
PROW = math.radians(28.0)
"""Of a prow against the bed; beside its ridge it is flatter by a fifth."""
RIDGE = 9.0
"""Width of a roof's flat ridge, mm: most printers bridge 10 mm."""
BURIED = 0.02
"""How far a roof begins inside a channel's flank, mm: it must not stand off the round."""
FLOOR = 0.88
"""Depth of the floor between two channels, as a share of their radius: they part in no sharp edge."""
BEFORE = 10.0
"""How far roofs are covered beyond the wrist, mm; the wrist's plane cuts them off."""
THICK = 0.8
"""Skin over a ridge before it is blended with its neighbours, as a share of the palm's wall."""
Point = tuple[float, float]


@dataclass(frozen=True)
class Bay:
    """What is cleared between channel `a` (towards the thumb) and its neighbour `b`.

    It reaches as far as the wall left between the two would be thinner than `wall` mm.
    """

    a: Hole
    b: Hole
    wall: float

    def apart(self, x: float) -> float:
        """Distance of the two axes at x, mm."""
        return float(np.linalg.norm(self.a.at(x) - self.b.at(x)))

    @property
    def wanted(self) -> float:
        return self.a.radius + self.b.radius + self.wall

    @cached_property
    def widening(self) -> float:
        """By how much the axes part per mm of x."""
        x = min(self.a.end[0], self.b.end[0])
        return max((self.apart(x) - self.apart(0.0)) / x, 1e-9)

    @cached_property
    def stop(self) -> float:
        """x where the wall between the channels begins, mm."""
        return min(self.a.end[0], self.b.end[0], (self.wanted - self.apart(0.0)) / self.widening)

    @cached_property
    def foot(self) -> float:
        """Height of the prow's foot above the axes, mm.

        Wristward of it the wall gets thinner than `wall` up to sqrt(radius x widening x distance)
        above the axes; a prow from here stays above that.
        """
        return max(self.a.radius, self.b.radius) * self.widening / (4 * math.tan(PROW))

    @cached_property
    def prow(self) -> float:
        """x where the prow has climbed to the roof, mm; below 0: not before the wrist."""
        axis = (self.a.at(self.stop)[2] + self.b.at(self.stop)[2]) / 2
        climb = self.roof(self.stop)[1][1] - axis - self.foot
        return float(self.stop - climb / math.tan(PROW))

    def roof(self, x: float) -> tuple[Point, Point, Point, Point]:
        """(y, z) of the roof at x: on b's flank, both edges of the ridge, on a's flank."""
        (ya, za), (yb, zb) = (
            (h.at(x)[1] + side * (h.radius - BURIED) * math.sin(SLOPE),
             h.at(x)[2] + (h.radius - BURIED) * math.cos(SLOPE)) for h, side in ((self.a, 1), (self.b, -1)))
        rise = math.tan(SLOPE)
        highest = (za + zb + (ya - yb) * rise) / 2
        crown = max(h.at(x)[2] + h.radius for h in (self.a, self.b))
        # Below the crowns the ridge would hang between them.
        top = min(max(highest - RIDGE / 2 * rise, crown), highest)
        return (yb, zb), (yb + (top - zb) / rise, top), (ya - (top - za) / rise, top), (ya, za)

    def _section(self, x: float, roof: tuple[Point, ...]) -> csg.Section:
        floor = []
        for hole, side in ((self.a, -1), (self.b, 1)):
            inside = min(0.4 * hole.radius, 0.45 * self.apart(x))
            floor.append((hole.at(x)[1] + side * inside, hole.at(x)[2] - FLOOR * hole.radius))
        path = csg.Path.polygon([*floor, *roof])
        return csg.Section(path, ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), (float(x), 0.0, 0.0))

    @property
    def shape(self) -> csg.Shape:
        """From beyond the wrist to the wall between the channels."""
        foot = []
        for hole, side in ((self.b, 1), (self.a, -1)):
            _, y, z = hole.at(self.stop)
            foot += [(y + side * 0.4 * hole.radius, z), (y + side * 0.5 * hole.radius, z + self.foot)]
        end = self._section(self.stop, (foot[0], foot[1], foot[3], foot[2]))
        stations = [x for x in (-2 * MARGIN, self.prow) if x <= self.prow] if self.prow > 0 else [self.prow]
        return csg.Loft((*(self._section(x, self.roof(x)) for x in stations), end))

    @property
    def cover(self) -> Limb | None:
        """Skin over the ridge that runs out towards the fingers; None where the prow is all roof."""
        if self.prow <= 0.0:
            return None
        radius = min(self.a.radius, self.b.radius)
        over, way = THICK * self.wall, []
        for x, above in ((-BEFORE, over), (self.prow, over), (self.stop, -self.wall)):
            _, b, a, _ = self.roof(x)
            way.append((x, (a[0] + b[0]) / 2, a[1] + above - radius))
        return Limb(tuple(Cone(p, q, radius, radius) for p, q in pairwise(way)))


def bays(hand: Hand) -> list[Bay]:
    """One for every two neighbours that leave less than `palm.wall` between them at the wrist."""
    found = (Bay(a, b, hand.palm.wall) for a, b in pairwise(channels(hand)))
    return [bay for bay in found if bay.apart(0.0) < bay.wanted]


def junctions(hand: Hand) -> list[csg.Shape]:
    """What is cleared between neighbouring channels."""
    return [bay.shape for bay in bays(hand)]


def roofs(hand: Hand) -> list[Limb]:
    """The skin over all bays."""
    return [bay.cover for bay in bays(hand) if bay.cover]
