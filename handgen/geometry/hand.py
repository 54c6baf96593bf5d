"""The hand's exoskeleton as one printable solid (Section 4.2.1).

Blended skin first, exact cutters after it, the exact fingers last: so a finger has its own
diameters wherever the skin does not blend into it, and no cutter can nick a neighbour.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handgen.errors import GeometryError
from handgen.geometry import csg, finger
from handgen.geometry.bay import junctions, roofs
from handgen.geometry.hand_walls import check
from handgen.geometry.palm import (
    MARGIN,
    PART,
    channels,
    core,
    covers,
    finger_placement,
    first_slot,
    fullness,
    row,
    seat,
)
from handgen.geometry.part import Body, Part
from handgen.geometry.skin import Limb, Skin, fitted_loft
from handgen.geometry.thumb import Hinge
from handgen.parameters.model import Hand

FAR = 300.0
"""Beyond every hand, mm."""
RIM = 2.2
"""Radius of the blend that rounds the rims of the hinge's gap, mm; it takes a quarter off an edge."""
CLEARING = (0.8, 30.0)
"""How far around a finger, and along it from its first slot, its neighbours' skin is cleared, mm."""


def hand_part(hand: Hand) -> Part:
    """The exoskeleton of the whole hand; a left hand is the right one's mirror image.

    Raises:
        GeometryError: there is no palm, or fingers, walls or hinge do not go together.
    """
    if hand.palm is None:
        raise GeometryError(PART, "palm", "a hand needs a palm")
    hinge = Hinge(hand) if hand.opposition else None
    solids = core(hand) + roofs(hand) + fullness(hand) + (hinge.limbs() if hinge else [])
    skin = Skin(tuple(solids), hand.palm.blend)
    check(hand, skin, hinge)
    if hinge:
        skin = replace(skin, openings=(hinge.opening,), rim=RIM)
    shape = _assembled(hand, csg.Field(skin, hand.palm.resolution), hinge)
    plain = Body("hand", _assembled(hand, _unblended(hand, hinge), hinge), finger.COLOUR)
    return Part(PART, "exoskeleton", hand.printing.hand.material, shape, finger.COLOUR, "palm",
                bodies=(plain,))


def _unblended(hand: Hand, hinge: Hinge | None) -> csg.Shape:
    """The body for STEP: lofts through the skin's sections, a plain cover on channels and seats."""
    palm = Limb(tuple(core(hand) + roofs(hand) + fullness(hand)), hand.palm.blend)
    # As far as the roots stand on average.
    front = float(np.mean([getattr(hand.fingers, n).placement.root[0] for n in row(hand)]))
    stations = np.linspace(-3.0, front, 6).tolist()
    solids = [fitted_loft(palm, csg.rotation("x", 0.0), (0.0, 0.0, 0.0), stations)]
    solids += [c.shape for c in covers(hand)]
    if hinge:
        solids += hinge.unblended()
    return csg.Union(tuple(solids))


def _assembled(hand: Hand, body: csg.Shape, hinge: Hinge | None) -> csg.Shape:
    """`body` with all that is cut from it, and the exact fingers."""
    wrist = csg.box((-FAR, -FAR, -FAR), (0.0, FAR, FAR))
    cuts = [wrist, *junctions(hand)]
    cuts += [h.shape for h in channels(hand)]
    cuts += [seat(hand, n, hand.seal.collar_length + 2 * MARGIN).shape for n in row(hand)]
    cuts += [_clearing(hand, n) for n in hand.fingers.present()]
    if hinge:
        body = (body - hinge.gap) + hinge.sheet
        cuts += [h.shape for h in hinge.holes()]
    body = csg.Difference(body, tuple(cuts))
    fingers = [
        finger.shape(f, hand.exoskeleton.joint_fillet).placed(*finger_placement(hand, n))
        for n, f in hand.fingers.present().items()
    ]
    whole = csg.Union((body, *fingers))
    return whole.mirrored("y") if hand.side == "left" else whole


def _clearing(hand: Hand, name: str) -> csg.Shape:
    """Where no skin may be: around a finger from just before its first slot."""
    f = getattr(hand.fingers, name)
    start = first_slot(f) - MARGIN
    around = csg.cylinder(f.base_outer_diameter / 2 + CLEARING[0], start, start + CLEARING[1])
    return around.placed(*finger_placement(hand, name))
