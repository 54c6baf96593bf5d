"""The two cores that leave the actuator's inside open (Figure 4.7 d, e).

The thread is wound on the large core and stays in the first pour; the small core then leaves room
for the internal layer inside it. Both hang in the suspender by the same shank. They are printed
standing on their knob, so that nothing overhangs.
"""

from __future__ import annotations

import math

import numpy as np

from handgen.geometry import csg
from handgen.geometry.actuator import POINTS_PER_TURN, along_core, core_end, thread_path
from handgen.geometry.casting import MARGIN, SALIENCE, Setup, joined
from handgen.geometry.profile import Curve

FLANGE = 3.0
"""Thickness of the flange that lies on the hub, mm."""
REACH = 2.5
"""How far the flange reaches beyond the shank, mm."""
GRIP = 14.0
"""Length of the grip above the flange, mm: two fingers and a thumb."""
SLOT = 0.8
"""Width and depth of the slot in the large core that leads the thread's end out and clamps it, mm."""


def large_core(setup: Setup, rings: bool = False) -> csg.Shape:
    """The core that the thread is wound on, in its place: flange on the suspender's hub.

    `rings`: one ring groove a turn instead of the thread's helical groove, because a helix along
    a taper fails in OCCT from about ten turns on.
    """
    cuts = [*_flats(setup), _thread_slot(setup)]
    if setup.thread.groove and not rings:
        cuts.append(_groove(setup))
    body = csg.Revolve(_meridian(setup, setup.profile.large_core, rings))
    return joined(csg.Difference(body, tuple(cuts)), _label(setup, "d"))


def small_core(setup: Setup) -> csg.Shape:
    """The core that leaves the air chamber, in its place."""
    body = csg.Revolve(_meridian(setup, setup.profile.casting_core))
    return joined(csg.Difference(body, _flats(setup)), _label(setup, "e"))




def _knob(setup: Setup) -> float:
    return setup.shank + REACH


def _meridian(setup: Setup, flank: Curve, rings: bool = False) -> csg.Path:
    """Knob, shank, cone down to the core's own radius, flank, rounded tip, salience if any."""
    knob, shank, radius = _knob(setup), setup.shank, flank(0.0)
    end = setup.seat - FLANGE - GRIP
    wide = 0.9 * setup.top
    narrow = min(wide + (shank - radius), 0.1 * setup.top)
    path = csg.Path((end, 0.0), ()).line((end, knob - 1.0), (end + 1.0, knob), (setup.seat, knob))
    path = path.line((setup.seat, shank), (wide, shank), (narrow, radius), (0.0, radius))
    if rings:
        path, flank = _ringed(setup, path)
    if not setup.salience:
        return along_core(path, flank)
    return _along_to_salience(path, flank, setup)


def _along_to_salience(path: csg.Path, flank: Curve, setup: Setup) -> csg.Path:
    """As `along_core`, the tip drawn out into the mould's floor (Section 4.1.2)."""
    straight, rounding = core_end(flank)
    radius, s, out = straight.pieces[-1].y1, setup.salience, setup.length + SALIENCE
    path = straight.append_to(path)
    path = path.quarter((flank.end, radius), (flank.end, radius - rounding))
    return path.line((flank.end, s), (out - s / 2, s), (out, s / 2), (out, 0.0))


def _flats(setup: Setup) -> tuple[csg.Shape, csg.Shape]:
    """What is cut off the knob's two sides: a grip to turn and pull by, and the label's face."""
    knob, flat = _knob(setup), _flat(setup)
    above, end = setup.seat - FLANGE, setup.seat - FLANGE - GRIP - MARGIN
    # The end under the flange slopes by 45 degrees: it prints without support.
    out = knob + MARGIN
    wedge = csg.Path.polygon(
        [(end, flat), (above - (knob - flat), flat), (above + out - knob, out), (end, out)])
    side = csg.Extrude(wedge, 2 * out).moved(z=-out)
    return side, side.turned("x", 180.0)


def _flat(setup: Setup) -> float:
    """Distance of the grip's flats from the axis."""
    return 0.62 * _knob(setup)


def _label(setup: Setup, letter: str) -> csg.Shape | None:
    slope = _knob(setup) - _flat(setup)
    room, width = GRIP - slope - 2.0, 2 * math.sqrt(_knob(setup)**2 - _flat(setup)**2)
    text = setup.code + letter
    size = min(4.0, 0.6 * width, room / len(text))
    x = setup.seat - FLANGE - slope - room / 2 - 0.5
    return setup.label(text, size, (x, _flat(setup), 0.0))


def _thread_slot(setup: Setup) -> csg.Shape:
    """From the cup along the shank and across the flange, on the side where the thread starts."""
    start, out = setup.seat - FLANGE - MARGIN, _knob(setup) + MARGIN
    return csg.box((start, -SLOT / 2, setup.shank - SLOT), (0.5 * setup.top, SLOT / 2, out))


def _groove(setup: Setup) -> csg.Shape:
    """The thread's path as a tube, half in the core, straight between every other of its points."""
    path = thread_path(setup.hand, setup.name)[::2, :3]
    # Drawn out so that the chords run as far outside the path as inside: within 0.01 mm of it.
    path[:, 1:] *= 1.0 + (4.0 * math.pi / POINTS_PER_TURN) ** 2 / 12.0
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    outward = np.c_[np.zeros(len(path)), path[:, 1:]]
    outward -= np.einsum("ij,ij->i", outward, tangent)[:, None] * tangent
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    frames = np.stack([outward, np.cross(tangent, outward), tangent], axis=2)
    circle = _circle(setup.thread.diameter / 2)
    return csg.Loft(tuple(
        csg.Section(circle, tuple(map(tuple, frame.tolist())), tuple(point))
        for frame, point in zip(frames, path.tolist(), strict=True)))


def _circle(radius: float) -> csg.Path:
    """A circle as eight straight sides, of the circle's area."""
    corners = np.pi * np.arange(8) / 4
    across = radius * math.sqrt(math.pi / (4 * math.sin(math.pi / 4)))
    return csg.Path.polygon(np.c_[across * np.cos(corners), across * np.sin(corners)].tolist())


def _ringed(setup: Setup, path: csg.Path) -> tuple[csg.Path, Curve]:
    """`path` along the large core with a triangular ring of the groove's cross-section per turn;
    and the flank beyond the last ring."""
    flank, thread, wide = setup.profile.large_core, setup.thread, setup.thread.diameter / 2
    deep = math.pi * wide / 2  # so that the triangle has the half circle's area
    turns = round((flank.end - 2 * thread.held_back) / thread.pitch)
    at = 0.0
    for x in (thread.held_back + thread.pitch * (np.arange(turns) + 0.5)).tolist():
        path = flank.between(at, x - wide).append_to(path)
        at = x + wide
        path = path.line((x, flank(x) - deep), (at, flank(at)))
    return path, flank.between(at, flank.end)
