"""Defects planted at random into good parts and definitions, and what must be found of each.

`plant(kind, rng)` draws one; `KINDS` says how many of a hundred are of each kind, and which rules
may name it. Sizes are those that spoil a hand: walls that leave less than the process closes,
holes wider than a line, cores bent by more than the layer they leave room for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from handgen import checks
from handgen.checks.voids import voids
from handgen.geometry import csg, palm
from handgen.geometry.actuator import actuator
from handgen.geometry.finger import exoskeleton
from handgen.geometry.hand import hand_part
from handgen.geometry.mesh_kernel import Triangles, evaluate, triangles
from handgen.geometry.part import Part
from handgen.geometry.profile import FingerProfile
from handgen.geometry.surface import Surface
from handgen.geometry.thumb import Hinge
from handgen.geometry.tooling import tooling
from handgen.parameters.load import load
from handgen.parameters.model import FINGERS, Hand
from tests.strategies import PARAMS
from tests.variant import changed, named

HAND = "exoskeleton/hand"
NEAR = 3.0
"""mm: a defect is found where it is."""


@dataclass(frozen=True)
class Defect:
    """A hand with one defect: where it is (None: in the definition), and who may name it."""

    kind: str
    rules: tuple[str, ...]
    hand: Hand
    parts: dict[str, Part]
    part: str
    place: np.ndarray | None
    says: str


@cache
def good() -> Hand:
    return load(PARAMS / "adult.yaml").hand


@cache
def pieces(name: str) -> dict[str, Part]:
    """The good parts that belong to one finger."""
    return named([exoskeleton(good(), name), actuator(good(), name), *tooling(good(), name)])


@cache
def body() -> Part:
    return hand_part(good())


@cache
def surface(name: str) -> Surface:
    part = body() if name == HAND else pieces(name.split("/")[1])[name]
    return Surface(*part.triangles)


def meshed(part: Part, mesh: Triangles) -> Part:
    """`part` with a mesh that its tree does not give."""
    copy = replace(part)
    copy.__dict__["triangles"] = mesh
    return copy


def sharp(vertices: np.ndarray, faces: np.ndarray) -> Triangles:
    return Triangles(np.asarray(vertices, np.float32), faces)


# Places


def wall(name: str, rng: np.random.Generator, low: float, high: float
         ) -> tuple[np.ndarray, np.ndarray, float]:
    """(place, outward normal, thickness) on a part where a plain wall is low to high mm thick."""
    skin = surface(name)
    points, faces = skin.samples(2.0)
    normals = skin.normals[faces]
    thickness, _, parallel = skin.shoot(points, -normals)
    plain = (thickness > low) & (thickness < high) & (parallel > 0.97)
    # Plain all round: nothing within reach ends or turns away.
    for _ in range(300):
        k = rng.choice(np.flatnonzero(plain))
        across = np.linalg.svd(normals[k][None])[2][1:]
        ring = points[k] + 1.8 * np.array([np.cos(a) * across[0] + np.sin(a) * across[1]
                                           for a in np.linspace(0, 2 * np.pi, 8, endpoint=False)])
        above = skin.sight(ring + 0.9 * normals[k], np.tile(-normals[k], (8, 1)))
        through, _, _ = skin.shoot(ring - 0.5 * thickness[k] * normals[k], np.tile(-normals[k], (8, 1)))
        if (above < 1.8).all() and (np.abs(through - 0.5 * thickness[k]) < 0.8 * thickness[k]).all():
            return points[k], normals[k], float(thickness[k])
    raise AssertionError(f"no plain wall of {low} to {high} mm on {name}")


def drilled(part: Part, place: np.ndarray, normal: np.ndarray, radius: float, depth: float) -> Part:
    """`part` with a flat hole, `depth` mm deep, where `normal` points out of it."""
    rows = palm.facing(-normal)
    drill = csg.cylinder(radius, -0.6, depth).placed(rows, place)
    return meshed(part, triangles(evaluate(part.shape) - evaluate(drill)))


# Kinds


def thin_wall(rng):
    """A pocket cut into a finger's wall, from outside or inside."""
    name = rng.choice(FINGERS)
    part = f"exoskeleton/{name}"
    place, normal, thick = wall(part, rng, 1.6, 5.0)
    left = rng.uniform(0.15, 0.5)
    spoilt = drilled(pieces(name)[part], place, normal, rng.uniform(0.8, 1.8), thick - left)
    return {part: spoilt}, part, place - normal * (thick - left / 2), f"{left:.2f} mm left of {thick:.2f}"


def thin_tool(rng):
    """A pocket cut into a mould half's wall."""
    name = rng.choice(FINGERS)
    part = f"tooling/{name}/{rng.choice(['mould_a', 'mould_b'])}"
    place, normal, thick = wall(part, rng, 2.0, 12.0)
    left = rng.uniform(0.15, 0.5)
    spoilt = drilled(pieces(name)[part], place, normal, rng.uniform(1.0, 2.0), thick - left)
    return {part: spoilt}, part, place - normal * (thick - left / 2), f"{left:.2f} mm left of {thick:.2f}"


def shifted_bore(rng):
    """A phalanx whose bore runs beside its axis."""
    name = rng.choice(FINGERS)
    part, finger = f"exoskeleton/{name}", getattr(good().fingers, name)
    ends = [0.0, *(j.position + j.slot_length / 2 for j in finger.joints)]
    starts = [*(j.position - j.slot_length / 2 for j in finger.joints), finger.inner_length]
    k = rng.integers(len(ends))
    low, high = ends[k] + 0.5, starts[k] - 0.5
    profile, x = FingerProfile(finger), (low + high) / 2
    bore, out = float(profile.bore(np.array(low))), float(profile.outer(np.array(high)))
    left = rng.uniform(0.15, 0.45)
    turn = rng.uniform(0, 2 * np.pi)
    aside = out - float(profile.bore(np.array(high))) - left
    off = aside * np.array([0.0, math.cos(turn), math.sin(turn)])
    cutter = csg.cone(bore, float(profile.bore(np.array(high))), low, high).moved(*off)
    spoilt = meshed(pieces(name)[part], triangles(evaluate(pieces(name)[part].shape) - evaluate(cutter)))
    line = np.array([[x0, (out - left / 2) * math.cos(turn), (out - left / 2) * math.sin(turn)]
                     for x0 in np.linspace(low, high, 30)])
    return {part: spoilt}, part, line, f"bore {aside:.2f} mm aside around x = {x:.0f}"


@cache
def bored() -> tuple[np.ndarray, np.ndarray]:
    """Where the bores of the hand have a wall: (points, directions out of the bore)."""
    known = [v.wall() for v in voids(good())]
    origins, directions, distances = (np.concatenate([w[k] for w in known]) for k in range(3))
    there = abs(surface(HAND).sight(origins, directions) - distances) < 0.02
    return (origins + distances[:, None] * directions)[there], directions[there]


def sunk(rng: np.random.Generator, radius: float, left: float) -> tuple[Part, np.ndarray]:
    """(the hand with a flat hole from outside to `left` mm before a bore, the middle of what is left)."""
    points, directions = bored()
    k = rng.integers(len(points))
    drill = csg.cylinder(radius, left, 60.0).placed(palm.facing(directions[k]), points[k])
    spoilt = meshed(body(), triangles(evaluate(body().shape) - evaluate(drill)))
    return spoilt, points[k] + max(left, 0.0) / 2 * directions[k]


def punched_hand(rng):
    """A hole from a bore of the hand to the open."""
    radius = rng.uniform(0.6, 1.5)
    spoilt, place = sunk(rng, radius, -0.5)
    return {HAND: spoilt}, HAND, place, f"a hole of {2 * radius:.1f} mm"


def pocket_into_bore(rng):
    """A pocket cut near to a bore or channel of the hand: thin wall between them, or into it."""
    left = rng.uniform(-1.2, 0.5)
    spoilt, place = sunk(rng, rng.uniform(1.5, 3.0), left)
    return {HAND: spoilt}, HAND, place, f"{left:.2f} mm left"


def punched_finger(rng):
    """A hole through a finger's wall into its bore."""
    name = rng.choice(FINGERS)
    part = f"exoskeleton/{name}"
    place, normal, thick = wall(part, rng, 1.6, 5.0)
    radius = rng.uniform(0.6, 1.5)
    spoilt = drilled(pieces(name)[part], place, normal, radius, thick + 0.6)
    # The nearer rim may be either end of the hole.
    ends = place - normal * np.linspace(0, thick, 8)[:, None]
    return {part: spoilt}, part, ends, f"a hole of {2 * radius:.1f} mm"


def pocket_into_neighbour(rng):
    """A socket of the opposition cut beside its place: thin wall to its neighbour, or into it."""
    hinge = Hinge(good())
    one, two = (hinge.bases(), hinge.tips())[rng.integers(2)]
    if rng.integers(2):
        one, two = two, one
    line = np.subtract(two.start, one.start)
    gap = np.linalg.norm(line) - one.radius - two.radius
    left = rng.uniform(-1.2, 0.7)
    along = line / np.linalg.norm(line)
    cutter = one.shape.moved(*((gap - left) * along))
    spoilt = meshed(body(), triangles(evaluate(body().shape) - evaluate(cutter)))
    axis = np.subtract(one.end, one.start)
    middle = np.array(two.start) - along * (two.radius + max(left, 0.0) / 2)
    return ({HAND: spoilt}, HAND, middle + np.linspace(0, 1, 30)[:, None] * axis,
            f"{one.name} {left:.2f} mm from {two.name}")


def open_mesh(rng):
    """Triangles missing."""
    name = rng.choice(FINGERS)
    part = rng.choice([n for n in pieces(name)])
    vertices, faces = pieces(name)[part].triangles
    middles = vertices[faces].mean(axis=1)
    k = rng.integers(len(faces))
    gone = np.argsort(np.linalg.norm(middles - middles[k], axis=1))[: rng.integers(1, 4)]
    spoilt = meshed(pieces(name)[part], sharp(vertices, np.delete(faces, gone, axis=0)))
    corners = vertices[faces[gone]].reshape(-1, 3)
    return {part: spoilt}, part, np.vstack([corners, corners.mean(axis=0)]), f"{len(gone)} triangles"


def floating_sliver(rng):
    """A crumb that hangs on nothing."""
    name = rng.choice(FINGERS)
    part = rng.choice([n for n in pieces(name) if not n.startswith("actuators")])
    vertices, faces = pieces(name)[part].triangles
    size = rng.uniform(0.3, 2.0, 3)
    k = rng.integers(len(vertices))
    place = vertices[k] + np.array([0.0, 0.0, np.ptp(vertices[:, 2]) + 5.0])
    crumb = triangles(evaluate(csg.box(place - size / 2, place + size / 2)))
    both = sharp(np.vstack([vertices, crumb.vertices]), np.vstack([faces, crumb.faces + len(vertices)]))
    says = "a crumb of " + " x ".join(f"{s:.1f}" for s in size)
    return {part: meshed(pieces(name)[part], both)}, part, place, says


def thin_fin(rng):
    """A fin thinner than a line that stands on a finger."""
    name = rng.choice(FINGERS)
    part = f"exoskeleton/{name}"
    place, normal, _ = wall(part, rng, 1.6, 5.0)
    if np.hypot(*place[1:]) < np.hypot(*(place + normal)[1:]):
        thick, long, high = rng.uniform(0.1, 0.25), rng.uniform(3, 6), rng.uniform(2, 4)
        fin = csg.box((-0.5, -long / 2, -thick / 2), (high, long / 2, thick / 2))
        fin = fin.placed(palm.facing(normal), place)
        spoilt = meshed(pieces(name)[part], triangles(evaluate(pieces(name)[part].shape) + evaluate(fin)))
        heights = place + normal * np.linspace(0.0, high, 12)[:, None]
        side = np.array(palm.facing(normal))[:, 1]
        grid = (heights[:, None] + side * np.linspace(-long / 2, long / 2, 12)[:, None]).reshape(-1, 3)
        return {part: spoilt}, part, grid, f"a fin of {thick:.2f} mm"
    return thin_fin(rng)


def bent_core(rng):
    """A core bent to one side, most at its tip."""
    name = rng.choice(FINGERS)
    part = f"tooling/{name}/{rng.choice(['core_large', 'core_small'])}"
    vertices, faces = pieces(name)[part].triangles
    length = float(vertices[:, 0].max())
    off, turn = rng.uniform(1.6, 3.5), rng.uniform(0, 2 * np.pi)
    share = np.clip(vertices[:, :1] / length, 0.0, None) ** 2
    bent = vertices + share * off * np.array([0.0, math.cos(turn), math.sin(turn)])
    parts = pieces(name) | {part: meshed(pieces(name)[part], sharp(bent, faces))}
    tip = bent[bent[:, 0] > length - 15.0]
    return parts, part, np.vstack([tip, tip * (1, 0, 0)]), f"{off:.1f} mm at its tip"


def pitch(rng):
    """The thread wound twice as close, or three times as wide."""
    name, factor = rng.choice(FINGERS), rng.choice([0.5, 3.0])
    wound = good().thread_of(name)
    thread = wound.model_copy(update={"pitch": wound.pitch * factor})
    hand = changed(good(), **{f"actuators__{name}__thread": thread})
    return hand, {f"actuators/{name}": actuator(hand, name)}, f"actuators/{name}", f"pitch x {factor}"


def thick_thread(rng):
    name, factor = rng.choice(FINGERS), rng.uniform(1.1, 2.0)
    layer = good().layers_of(name).thread
    thread = good().thread_of(name).model_copy(update={"diameter": layer * factor})
    hand = changed(good(), **{f"actuators__{name}__thread": thread})
    return hand, pieces(name), f"actuators/{name}", f"thread {layer * factor:.2f} mm in {layer:.2f}"


def wide_actuator(rng):
    name, more = rng.choice(FINGERS), rng.uniform(0.1, 2.0)
    wide = getattr(good().actuators, name).base_outer_diameter
    bore = getattr(good().fingers, name).base_bore_diameter
    hand = changed(good(), **{f"actuators__{name}__base_outer_diameter": max(wide, bore) + more})
    return hand, pieces(name), f"actuators/{name}", f"{more:.2f} mm too wide"


def wrong_length(rng):
    name, more = rng.choice(FINGERS), rng.choice([rng.uniform(0.5, 6.0), -rng.uniform(1.5, 10.0)])
    long = getattr(good().fingers, name).inner_length
    hand = changed(good(), **{f"actuators__{name}__outer_length": long + more})
    return hand, pieces(name), f"actuators/{name}", f"{more:+.1f} mm long"


Plant = Callable[[np.random.Generator], tuple]
KINDS: dict[str, tuple[int, Plant, tuple[str, ...]]] = {
    "wall thinned, finger": (16, thin_wall, ("wall.minimum", "print.line-width")),
    "wall thinned, mould": (8, thin_tool, ("wall.minimum", "print.line-width")),
    "bore shifted": (8, shifted_bore, ("wall.minimum", "print.line-width", "bore.breakthrough")),
    "hole punched, hand": (10, punched_hand, ("bore.breakthrough",)),
    "hole punched, finger": (8, punched_finger, ("bore.breakthrough",)),
    "pocket into its neighbour": (3, pocket_into_neighbour, ("wall.between-bores", "bore.breakthrough")),
    "pocket into a bore": (3, pocket_into_bore, ("wall.minimum", "print.line-width", "bore.breakthrough")),
    "mesh open": (8, open_mesh, ("solid.watertight",)),
    "sliver left, floating": (6, floating_sliver, ("solid.watertight",)),
    "sliver left, fin": (6, thin_fin, ("wall.minimum", "print.line-width")),
    "core bent": (8, bent_core, ("suspender.centring", "core.demould")),
    "thread pitch": (8, pitch, ("thread.gap",)),
    "thread too thick": (3, thick_thread, ("thread.layer",)),
    "actuator too wide": (3, wide_actuator, ("actuator.clearance",)),
    "actuator too long or short": (2, wrong_length, ("actuator.length",)),
}


def plant(kind: str, rng: np.random.Generator) -> Defect:
    """One random defect of a kind."""
    _, make, rules = KINDS[kind]
    first, *rest = make(rng)
    if isinstance(first, Hand):
        parts, part, says = rest
        return Defect(kind, rules, first, parts, part, None, says)
    part, place, says = rest
    return Defect(kind, rules, good(), first, part, np.atleast_2d(place), says)


@cache
def before(names: tuple[str, ...]) -> tuple[dict, ...]:
    """What the rules say of the good parts."""
    own = {HAND: body()} if HAND in names else pieces(names[0].split("/")[1])
    return tuple(checks.judge(good(), {n: own[n] for n in names})["findings"])


def named_by(defect: Defect) -> list[dict]:
    """Findings above `info` that name the defect: right rule, part and place, not there before."""
    found = checks.judge(defect.hand, defect.parts)["findings"]
    known = before(tuple(defect.parts))
    return [f for f in found
            if f["severity"] != "info" and f["rule"] in defect.rules and f["part"] == defect.part
            and not any(_same(f, g) for g in known) and (defect.place is None or _near(f, defect.place))]


def _near(finding: dict, places: np.ndarray) -> bool:
    where = finding["where"]
    return where is not None and bool(np.linalg.norm(places - where, axis=1).min() <= NEAR)


def _same(one: dict, other: dict) -> bool:
    keys = ("rule", "part", "severity", "measured", "where")
    return all(one[k] == other[k] for k in keys)
