"""What single fields cannot say: how the parameters of a hand must fit each other.

Each relation is a small function that yields Faults. Relations are checked on all pieces of a
file that could be read, even when others are bad, so that a user sees everything at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

from pydantic import ValidationError

from handgen.parameters import derive
from handgen.parameters.fault import Fault, Path, nearest
from handgen.parameters.finger import Actuator, Finger, Joint, Layers, Thread
from handgen.parameters.model import FINGERS, OPPOSITION, Hand
from handgen.parameters.palm import Opposition, Palm
from handgen.parameters.process import ROLES, Casting, PrintProcess, Seal
from handgen.parameters.quantity import Model

LEAST_TIP = 1.0
"""Solid tip of an exoskeleton, mm: a few layers close it."""
LEAST_WALL = 0.4
"""Thinnest wall that a 0.35 mm nozzle closes, mm; the rule `wall.minimum` asks for more."""
END_RING = 1.0
"""Closed ring between a slot and the finger's root or the end of its bore, mm."""
LEAST_PHALANX = 2.0
"""Closed length between two slots, mm: less tears."""
MOST_CURL = 180.0
"""Sum of a finger's rest angles, deg: beyond it the tip is printed into the palm."""
THINNEST_LAYER = 0.3
"""Thinnest layer of silicone that fills, mm; also the least that `layers` accepts."""
LENGTH_TOLERANCE = 0.5
"""How well the hand's length must follow from its middle finger, mm."""
ROUNDING = 1e-6

Piece = TypeVar("Piece", bound=Model)


@dataclass(frozen=True)
class Pieces:
    """What of a hand could be read; None where a piece is absent or bad."""

    fingers: dict[str, Finger | None] | None = None
    actuators: dict[str, Actuator | None] | None = None
    layers: Layers | None = None
    thread: Thread | None = None
    casting: Casting | None = None
    seal: Seal | None = None
    palm: Palm | None = None
    opposition: Opposition | None = None
    processes: dict[str, PrintProcess | None] | None = None
    present: frozenset[str] = frozenset()
    """Which of palm and opposition the file gives, good or bad."""

    @classmethod
    def of(cls, hand: Hand) -> Pieces:
        """All pieces of a hand whose fields are all valid."""
        return cls(
            fingers=hand.fingers.present(),
            actuators=hand.actuators.present(),
            layers=hand.layers,
            thread=hand.thread,
            casting=hand.casting,
            seal=hand.seal,
            palm=hand.palm,
            opposition=hand.opposition,
            processes={name: getattr(hand.printing, name) for name in ROLES},
            present=frozenset(name for name in ("palm", "opposition") if getattr(hand, name)),
        )

    @classmethod
    def salvage(cls, data: dict) -> Pieces:
        """All pieces of the raw `data` that are valid by themselves."""
        return cls(
            fingers=_pieces(Finger, data.get("fingers"), FINGERS),
            actuators=_pieces(Actuator, data.get("actuators"), FINGERS + OPPOSITION),
            layers=_piece(Layers, data.get("layers")),
            thread=_piece(Thread, data.get("thread")),
            casting=_piece(Casting, data.get("casting")),
            seal=_piece(Seal, data.get("seal", {})),
            palm=_piece(Palm, data.get("palm")),
            opposition=_piece(Opposition, data.get("opposition")),
            processes=_pieces(PrintProcess, data.get("printing"), tuple(ROLES)),
            present=frozenset(name for name in ("palm", "opposition") if data.get(name) is not None),
        )


def _piece(model: type[Piece], raw: Any) -> Piece | None:
    try:
        return model.model_validate(raw)
    except ValidationError:
        return None


def _pieces(model: type[Piece], raw: Any, names: tuple[str, ...]) -> dict[str, Piece | None] | None:
    if not isinstance(raw, dict):
        return None
    return {name: _piece(model, raw[name]) for name in names if raw.get(name) is not None}


def check(pieces: Pieces) -> Iterator[Fault]:
    """All relations on all pieces that could be read."""
    fingers, actuators = pieces.fingers or {}, pieces.actuators or {}
    for name, finger in fingers.items():
        if finger is not None:
            for relation in (lengths, walls, narrowing, joints_inside, joints_apart, joint_names, curl):
                yield from relation(finger, ("fingers", name))
            yield from stations(finger.taper, ("fingers", name, "taper"))
    for name, actuator in actuators.items():
        if actuator is not None:
            yield from _actuator(pieces, name, actuator, fingers.get(name))
    yield from hand_length(pieces.palm, fingers.get("middle"))
    if pieces.fingers is not None and pieces.actuators is not None:
        yield from pairing(fingers, actuators)
        yield from opposed(pieces, fingers, actuators)
    if pieces.casting is not None:
        yield from casting(pieces.casting)
    for name, process in (pieces.processes or {}).items():
        if process is not None:
            yield from roles(process, name)


# A finger's exoskeleton


def lengths(finger: Finger, at: Path) -> Iterator[Fault]:
    limit = finger.outer_length - LEAST_TIP
    if finger.inner_length > limit + ROUNDING:
        yield Fault((*at, "inner_length"),
                    f"leaves no closed tip: the finger is {finger.outer_length:g} mm long",
                    finger.inner_length, f"at most {limit:g} mm (outer_length - {LEAST_TIP:g})")


def walls(finger: Finger, at: Path) -> Iterator[Fault]:
    """Between base and tip both diameters follow the same taper, so both ends speak for all."""
    for end in ("base", "tip"):
        outside, bore = getattr(finger, f"{end}_outer_diameter"), getattr(finger, f"{end}_bore_diameter")
        wall = (outside - bore) / 2
        if wall < LEAST_WALL - ROUNDING:
            yield Fault((*at, f"{end}_bore_diameter"), f"leaves a wall of {wall:g} mm at the {end}", bore,
                        f"at most {outside - 2 * LEAST_WALL:g} mm, with {end}_outer_diameter {outside:g}")


def narrowing(piece: Finger | Actuator, at: Path) -> Iterator[Fault]:
    """Nothing widens towards the tip: it could be neither demoulded nor slid in."""
    for what in ("outer_diameter", "bore_diameter"):
        base, tip = getattr(piece, f"base_{what}", None), getattr(piece, f"tip_{what}", None)
        if base is not None and tip is not None and tip > base + ROUNDING:
            yield Fault((*at, f"tip_{what}"), "is wider than the base", tip,
                        f"at most {base:g} mm (base_{what})")


def stations(taper: list[list[float]], at: Path) -> Iterator[Fault]:
    if taper[0] != [0.0, 0.0]:
        yield Fault((*at, 0), "the taper must start at the base", taper[0], "[0, 0]")
    if taper[-1] != [1.0, 1.0]:
        yield Fault((*at, len(taper) - 1), "the taper must end at the tip", taper[-1], "[1, 1]")
    for i, (a, b) in enumerate(pairwise(taper), start=1):
        if b[0] <= a[0]:
            yield Fault((*at, i, 0), "stations must follow each other along the axis", b[0],
                        f"more than {a[0]:g}")
        if b[1] < a[1]:
            yield Fault((*at, i, 1), "a finger only narrows towards its tip", b[1], f"at least {a[1]:g}")


def slot(joint: Joint) -> tuple[float, float]:
    """Start and end of a joint's slot along the axis, mm."""
    return joint.position - joint.slot_length / 2, joint.position + joint.slot_length / 2


def joints_inside(finger: Finger, at: Path) -> Iterator[Fault]:
    for i, joint in enumerate(finger.joints):
        half, end = joint.slot_length / 2, finger.inner_length - END_RING
        if slot(joint)[0] < END_RING - ROUNDING or slot(joint)[1] > end + ROUNDING:
            allowed = (f"{END_RING + half:g} to {end - half:g} mm for a slot of {joint.slot_length:g} mm"
                       if END_RING + half <= end - half else "a shorter slot")
            yield Fault((*at, "joints", i, "position"),
                        f"the slot of {joint.name} would reach from {slot(joint)[0]:g} to "
                        f"{slot(joint)[1]:g} mm, out of the bore (0 to {finger.inner_length:g})",
                        joint.position, allowed)


def joints_apart(finger: Finger, at: Path) -> Iterator[Fault]:
    for i, (a, b) in enumerate(pairwise(finger.joints), start=1):
        if slot(b)[0] - slot(a)[1] < LEAST_PHALANX - ROUNDING:
            limit = slot(a)[1] + LEAST_PHALANX + b.slot_length / 2
            yield Fault((*at, "joints", i, "position"),
                        f"the slot of {b.name} must lie beyond that of {a.name}, "
                        f"with {LEAST_PHALANX:g} mm closed between",
                        b.position, f"at least {limit:g} mm")


def joint_names(finger: Finger, at: Path) -> Iterator[Fault]:
    seen: set[str] = set()
    for i, joint in enumerate(finger.joints):
        if joint.name in seen:
            yield Fault((*at, "joints", i, "name"), "another joint of this finger has this name", joint.name,
                        "a name of its own")
        seen.add(joint.name)


def curl(finger: Finger, at: Path) -> Iterator[Fault]:
    total = sum(joint.rest_angle for joint in finger.joints)
    if total > MOST_CURL + ROUNDING:
        yield Fault((*at, "joints"), "the rest angles add up to too much", total,
                    f"at most {MOST_CURL:g} deg in sum")
    for i, joint in enumerate(finger.joints):
        if derive.palmar_fold(finger, joint) < derive.LEAST_FOLD - ROUNDING:
            room = math.degrees(2 * (joint.slot_length - derive.LEAST_FOLD) / finger.base_outer_diameter)
            yield Fault((*at, "joints", i, "rest_angle"),
                        f"bends the strip of {joint.name} into itself: its palmar side needs"
                        f" {derive.LEAST_FOLD:g} mm of the slot's {joint.slot_length:g} mm",
                        joint.rest_angle, f"at most {max(room, 0.0):.4g} deg, or a longer slot")


# An actuator


def _actuator(pieces: Pieces, name: str, actuator: Actuator, finger: Finger | None) -> Iterator[Fault]:
    at: Path = ("actuators", name)
    yield from narrowing(actuator, at)
    bad_taper = list(stations(actuator.taper, (*at, "taper"))) if actuator.taper else []
    yield from bad_taper
    if finger is not None and not bad_taper and not list(stations(finger.taper, ())):
        yield from fits_bore(actuator, finger, at)
    layers = actuator.layers or pieces.layers
    thread = actuator.thread or pieces.thread
    if layers is None:
        return
    layers_at: Path = (*at, "layers") if actuator.layers else ("layers",)
    thread_at: Path = (*at, "thread") if actuator.thread else ("thread",)
    yield from tip_layer(actuator, layers, layers_at, name)
    if thread:
        yield from winding(actuator, layers, thread, thread_at, name)
    no_core = []
    if pieces.casting:
        least = pieces.casting.minimum_core_tip_diameter
        no_core = list(core_at_base(actuator, layers, least, layers_at, name))
        yield from no_core
        if not no_core:
            yield from core_at_tip(actuator, layers, thread, least, name)
    if pieces.seal and not no_core:
        yield from plug(actuator, layers, pieces.seal, name)


def fits_bore(actuator: Actuator, finger: Finger, at: Path) -> Iterator[Fault]:
    if actuator.outer_length > finger.inner_length + ROUNDING:
        yield Fault((*at, "outer_length"), "is longer than the bore it slides into", actuator.outer_length,
                    f"at most {finger.inner_length:g} mm (inner_length of the finger)")
    ends = [(e, getattr(actuator, f"{e}_outer_diameter"), getattr(finger, f"{e}_bore_diameter"))
            for e in ("base", "tip")]
    wide = [(e, outside, bore) for e, outside, bore in ends if outside > bore + ROUNDING]
    for end, outside, bore in wide:
        yield Fault((*at, f"{end}_outer_diameter"), f"is wider than the bore at its {end}", outside,
                    f"at most {bore:g} mm ({end}_bore_diameter of the finger)")
    x, outside, bore = derive.tightest(actuator, finger)
    if not wide and outside > bore + ROUNDING:
        yield Fault((*at, "taper") if actuator.taper else (*at, "outer_length"),
                    f"the actuator is wider than its bore {x:.1f} mm from the base, though both ends fit",
                    round(outside, 3), f"at most {bore:.3f} mm there")


def tip_layer(actuator: Actuator, layers: Layers, at: Path, name: str) -> Iterator[Fault]:
    if layers.tip >= actuator.outer_length:
        yield Fault((*at, "tip"), f"fills the whole actuator {name}", layers.tip,
                    f"less than {actuator.outer_length:g} mm (its outer_length)")


def winding(actuator: Actuator, layers: Layers, thread: Thread, at: Path, name: str) -> Iterator[Fault]:
    if thread.diameter > layers.thread + ROUNDING:
        yield Fault((*at, "diameter"), f"does not fit the room drawn for the thread of {name}",
                    thread.diameter, f"at most {layers.thread:g} mm (layers.thread)")
    if thread.pitch <= thread.diameter:
        yield Fault((*at, "pitch"), f"the turns of {name} would lie on each other", thread.pitch,
                    f"more than {thread.diameter:g} mm (thread.diameter)")
    room = actuator.outer_length - layers.tip - 2 * thread.held_back
    if layers.tip < actuator.outer_length and room < thread.pitch:
        yield Fault((*at, "held_back"), f"leaves {room:g} mm for the thread of {name}, less than one turn",
                    thread.held_back, f"at most {(room - thread.pitch) / 2 + thread.held_back:g} mm")


def core_at_base(
    actuator: Actuator, layers: Layers, least: float, at: Path, name: str
) -> Iterator[Fault]:
    core = layers.core_room(actuator.base_outer_diameter)
    if core < least - ROUNDING:
        most = (actuator.base_outer_diameter - least) / 2
        yield Fault(at, f"the layers leave a small core of {core:g} mm at the base of {name}", layers.stack,
                    f"at most {most:g} mm in sum, for a core of {least:g} mm")


def core_at_tip(
    actuator: Actuator, layers: Layers, thread: Thread | None, least: float, name: str
) -> Iterator[Fault]:
    """Where layers may adapt they are thinned at the tip, but still pour and hold the thread.

    Where they may not, the rule `actuator.layers` fails, and nothing is made of them.
    """
    at: Path = ("actuators", name, "tip_outer_diameter")
    core = layers.core_room(actuator.tip_outer_diameter)
    if core >= least - ROUNDING or not actuator.adapt:
        return
    needed = max(THINNEST_LAYER / min(layers.external, layers.internal),
                 min(thread.diameter / layers.thread, 1.0) if thread else 0.0)
    if derive.thinning(actuator, layers, least) < needed - ROUNDING:
        yield Fault(at, "leaves too little at the tip for core, thread and layers, however thin",
                    actuator.tip_outer_diameter, f"at least {least + 2 * needed * layers.stack:.4g} mm")


def plug(actuator: Actuator, layers: Layers, seal: Seal, name: str) -> Iterator[Fault]:
    depth = actuator.outer_length - layers.tip
    if 0 < depth <= seal.plug_length:
        yield Fault(("seal", "plug_length"), f"reaches the tip of actuator {name}", seal.plug_length,
                    f"less than {depth:g} mm")
    channel = layers.core_room(actuator.base_outer_diameter)
    hole = seal.tube_outer_diameter + 2 * seal.tube_fit
    if channel > 0 and (channel - hole) / 2 < LEAST_WALL - ROUNDING:
        yield Fault(("seal", "tube_outer_diameter"),
                    f"leaves a wall of {(channel - hole) / 2:g} mm in the plug of {name}, "
                    f"whose channel is {channel:g} mm wide", seal.tube_outer_diameter,
                    f"at most {channel - 2 * LEAST_WALL - 2 * seal.tube_fit:g} mm")


# The hand


def pairing(fingers: dict, actuators: dict) -> Iterator[Fault]:
    for name in fingers:
        if name not in actuators:
            yield Fault(("actuators", name), f"missing: finger {name} has no actuator")
    for name in actuators:
        if name in FINGERS and name not in fingers:
            yield Fault(("fingers", name), f"missing: actuator {name} has no finger")
    if not fingers:
        yield Fault(("fingers",), "has no finger", allowed="at least one of " + ", ".join(FINGERS))


def opposed(pieces: Pieces, fingers: dict, actuators: dict) -> Iterator[Fault]:
    """The hinge and its two actuators come together, on a palm with a thumb."""
    if "opposition" not in pieces.present:
        for name in OPPOSITION:
            if name in actuators:
                yield Fault(("actuators", name), "stands without the `opposition` hinge that it moves")
        return
    for name in OPPOSITION:
        if name not in actuators:
            yield Fault(("actuators", name), "missing: the `opposition` hinge needs both actuators")
    if "palm" not in pieces.present:
        yield Fault(("opposition",), "needs a `palm` to stand on")
    if "thumb" not in fingers:
        yield Fault(("opposition",), "needs a `thumb` to move")
    pair = [actuators.get(name) for name in OPPOSITION]
    if pieces.opposition and all(pair):
        least = sum(a.base_outer_diameter for a in pair) / 2 + 2 * pieces.opposition.clearance
        if pieces.opposition.spacing < least - ROUNDING:
            yield Fault(("opposition", "spacing"), "the two actuators would overlap",
                        pieces.opposition.spacing, f"at least {least:g} mm")


def hand_length(palm: Palm | None, middle: Finger | None) -> Iterator[Fault]:
    if palm is None or palm.length is None or middle is None:
        return
    length = middle.placement.root[0] + middle.outer_length
    if abs(length - palm.length) > LENGTH_TOLERANCE + ROUNDING:
        yield Fault(("palm", "length"), "is not where the middle finger ends "
                    f"(root x {middle.placement.root[0]:g} + outer_length {middle.outer_length:g} mm)",
                    palm.length, f"{length:g} mm within {LENGTH_TOLERANCE:g}")


def casting(given: Casting) -> Iterator[Fault]:
    least, pot_life = given.mixing_time + given.settling_time + given.pour_time, given.silicone.pot_life
    if pot_life < least - ROUNDING:
        yield Fault(("casting", "silicone", "pot_life"), "is over before the first mould is full", pot_life,
                    f"at least {least:g} min (mixing_time + settling_time + pour_time)")
    if given.cure_temperature < given.minimum_cure_temperature - ROUNDING:
        yield Fault(("casting", "cure_temperature"), "is colder than the silicone cures",
                    given.cure_temperature,
                    f"at least {given.minimum_cure_temperature:g} degC (minimum_cure_temperature)")


def roles(process: PrintProcess, name: str) -> Iterator[Fault]:
    for what in ("part_adhesion", "part_support"):
        for role in getattr(process, what):
            if role not in ROLES[name]:
                yield Fault(("printing", name, what, role), f"no part printed as `{name}` has this role",
                            role, "one of " + ", ".join(ROLES[name]), nearest(role, ROLES[name]))
