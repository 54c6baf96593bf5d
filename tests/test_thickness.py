"""The thickness gauge against walls of closed form, on meshes as they are exported."""

import gc
import math
import weakref

import numpy as np
import pytest

from handgen.geometry import csg
from handgen.geometry import finger as fingers
from handgen.geometry.hand import hand_part
from handgen.geometry.mesh_kernel import evaluate, printable, triangles
from handgen.geometry.profile import FingerProfile
from handgen.geometry.thickness import Gauge, gauge_of
from handgen.geometry.tooling import tooling

ACCURACY = 0.02
"""mm, the bar of the wall rule."""


def gauge(shape: csg.Shape) -> Gauge:
    return Gauge(printable(evaluate(shape)))


def block(x, y, z):
    return csg.box((0, -y / 2, -z / 2), (x, y / 2, z / 2))


def eccentric(outer, wall, shift):
    """A tube whose bore is `shift` off its axis; `wall` where it is thinnest."""
    bore = csg.cylinder(outer - shift - wall, -1, 31).moved(y=0.6 * shift, z=0.8 * shift)
    return csg.cylinder(outer, 0, 30) - bore, wall


def shell(outer, inner, length=30.0):
    """A tapered shell; its least wall is that of two segments in the meridian."""
    path = csg.Path.polygon([(0, inner[0]), (0, outer[0]), (length, outer[1]), (length, inner[1])])
    lines = [np.array([(0, r[0]), (length, r[1])], float) for r in (outer, inner)]
    gaps = [from_segment(p, b) for a, b in (lines, lines[::-1]) for p in a]
    return csg.Revolve(path), min(gaps)


def from_segment(point, segment):
    a, along = segment[0], segment[1] - segment[0]
    share = np.clip((point - a) @ along / (along @ along), 0, 1)
    return float(np.linalg.norm(a + share * along - point))


def bored(wall, radius, height=12.0):
    """A block with a bore beside its upper face."""
    return block(20, 16, height) - csg.cylinder(radius, -1, 21).moved(z=height / 2 - radius - wall), wall


def crossing(wall, one, two):
    """Two bores that cross at a right angle: thin in one point only."""
    first = csg.cylinder(one, -1, 31).moved(z=-one - wall / 2)
    second = csg.cylinder(two, -20, 20).turned("z", 90).moved(x=13, z=two + wall / 2)
    return block(30, 30, 36) - first - second, wall


def blind(wall, radius):
    """A blind bore with a flat end under the face x = 0."""
    return block(20, 24, 24) - csg.cylinder(radius, wall, 21).moved(y=2), wall


def ball_end(wall, radius):
    """A blind bore with a ball's end under the face x = 0: thin in one point only."""
    path = csg.Path((wall, 0.0), ()).quarter((wall, radius), (wall + radius, radius))
    return block(20, 24, 24) - csg.Revolve(path.line((21, radius), (21, 0))).moved(y=2), wall


def notched(wall, thickness=4.0):
    """A plate with a notch of 90 degrees: the wall ends in a sharp edge."""
    size = 6.0
    tool = csg.box((-1, -size / 2, -size / 2), (21, size / 2, size / 2)).turned("x", 45)
    return block(20, 16, thickness) - tool.moved(z=size / math.sqrt(2) - thickness / 2 + wall), wall


def rim(wall):
    """A blind bore whose end's rim looks at a face that slopes by 45 degrees."""
    slope = csg.box((0, -30, -30), (30, 30, 30)).turned("y", -45).moved(x=20)
    # The rim's nearest point is (x, 0, 4); the sloping face runs through x - z = 20 - ... at 45.
    body = csg.box((0, -8, -8), (40, 8, 8)) - slope
    return body - csg.cylinder(4.0, -1, 16 - wall * math.sqrt(2)), wall


SOLIDS = {
    **{f"eccentric tube {w}": eccentric(r, w, s)
       for r, w, s in ((5, 0.4, 0.5), (10, 0.8, 1.6), (9, 1.5, 0.2), (12, 2.5, 1.0), (16, 4.0, 3.0))},
    **{f"tapered shell {o} {i}": shell(o, i)
       for o, i in (((8, 6), (7.6, 4)), ((10, 7), (8, 6.2)), ((12, 12), (10.5, 9.5)), ((10, 5), (8, 3)),
                    ((9, 14), (5, 11.5)), ((6, 6), (2, 1)))},
    **{f"offset bore {w}": bored(w, r) for w, r in ((0.4, 3), (0.7, 1), (1.2, 4), (2.0, 3), (4.0, 2))},
    **{f"crossing bores {w}": crossing(w, a, b) for w, a, b in ((0.5, 2, 4), (1.0, 1.5, 1.5), (3.0, 4, 4))},
    **{f"blind bore {w}": blind(w, r) for w, r in ((0.4, 1.0), (1.5, 3.0), (3.0, 5.0))},
    **{f"ball end {w}": ball_end(w, r) for w, r in ((0.4, 1.0), (0.8, 3.0), (2.0, 4.0))},
    **{f"notch {w}": notched(w) for w in (0.4, 1.0, 2.0)},
    **{f"rim {w}": rim(w) for w in (0.5, 1.0, 2.0)},
}


@pytest.mark.parametrize("name", SOLIDS)
def test_least_wall(name):
    shape, wall = SOLIDS[name]
    found = gauge(shape).least()
    assert found.thickness == pytest.approx(wall, abs=ACCURACY)
    assert math.dist(found.point, found.opposite) == pytest.approx(found.thickness)


def wedge(degrees):
    half = math.radians(degrees / 2)
    outline = csg.Path.polygon([(0, 0), (16, -16 * math.tan(half)), (16, 16 * math.tan(half))])
    return csg.Extrude(outline, 20)


def lettered(raised):
    """A block with letters of three sizes, raised by 0.6 mm or sunk as deep."""
    plate, low = csg.box((-30, -12, -10), (30, 12, 0)), -0.2 if raised else -0.6
    words = [csg.Text("LB2 mould_a", size, 0.8 if raised else 2).moved(y=y, z=low)
             for size, y in ((5, 6), (3.5, -1), (2.5, -7))]
    return csg.Union((plate, *words)) if raised else csg.Difference(plate, tuple(words))


def chamfered(cut):
    return csg.Loft(tuple(
        csg.Section(csg.Path.polygon([(-w, -w), (w, -w), (w, w), (-w, w)]),
                    ((0, 0, 1), (1, 0, 0), (0, 1, 0)), (x, 0, 0))
        for x, w in ((0, 8 - cut), (cut, 8), (20, 8), (20 + 2 * cut, 8 - cut))))


SHARP = {
    **{f"wedge of {a} degrees": wedge(a) for a in (30, 45, 60, 90, 120)},
    **{f"cone of {a} degrees": csg.cone(0, 8, 0, 8 / math.tan(math.radians(a / 2))) for a in (30, 60, 90)},
    **{f"chamfer {c}": chamfered(c) for c in (0.3, 1.0, 4.0)},
    "raised letters": lettered(True),
    "sunk letters": lettered(False),
    "slot with a sharp edge": block(20, 16, 12) - csg.box((8, -20, 2), (10, 20, 20)).turned("y", 20),
    "stairs": csg.Union(tuple(csg.box((2 * i, -8, -8), (20, 8, 0.5 * i)) for i in range(8))),
    "prism": csg.Extrude(csg.Path.polygon([(0, 0), (16, 0), (8, 14)]), 9),
    "finely faceted ball": csg.Revolve(
        csg.Path((-6, 0), ()).quarter((-6, 6), (0, 6)).quarter((6, 6), (6, 0))),
}


@pytest.mark.parametrize("name", SHARP)
@pytest.mark.parametrize("limit", [0.7, 1.2, 2.0])
def test_nothing_found_at_sharp_edges(name, limit):
    assert gauge(SHARP[name]).thin_spots(limit) == []


def test_feather_edge_is_found():
    """Below 20 degrees an edge cannot be printed: the spot runs along all of it."""
    spots = gauge(wedge(10)).thin_spots(0.7)
    assert len(spots) == 1 and spots[0].thickness < 0.1
    assert spots[0].area == pytest.approx(20 * 0.35 / math.tan(math.radians(5)), rel=0.1)


@pytest.mark.parametrize("limit", [0.4, 1.2, 4.0])
def test_threshold(limit):
    for wall, found in ((limit - 0.01, 1), (limit, 0), (limit + 0.01, 0)):
        for shape in (block(20, 16, wall), csg.cylinder(6 + wall, 0, 20) - csg.cylinder(6, -1, 21)):
            assert len(gauge(shape).thin_spots(limit)) == found


def test_areas():
    """Two dimples in a plate of 3 mm: where each is, and how large."""
    plate = block(60, 30, 3)
    for x, radius in ((15, 0.6), (40, 4)):
        plate -= csg.cylinder(radius, 0, 9).turned("y", -90).moved(x=x, y=5, z=-0.7)
    small, large = sorted(gauge(plate).thin_spots(1.0), key=lambda s: s.area)
    for spot, x, radius in ((small, 15, 0.6), (large, 40, 4)):
        assert spot.thickness == pytest.approx(0.8, abs=1e-3)
        assert spot.area == pytest.approx(math.pi * radius**2, rel=0.25)
        assert math.hypot(spot.middle[0] - x, spot.middle[1] - 5) <= radius
        assert spot.middle[2] == pytest.approx(-1.1, abs=1e-3)


@pytest.mark.parametrize("radius, wall", [(0.6, 0.35), (0.6, 0.55), (0.8, 0.5)])
def test_ball_ended_pit(radius, wall):
    """As small a pit as is found: below it the surface faces no flat ground."""
    shape, _ = ball_end(wall, radius)
    spots = gauge(shape).thin_spots(0.7)
    assert len(spots) == 1 and spots[0].thickness == pytest.approx(wall, abs=ACCURACY)


def test_one_gauge_a_mesh_for_as_long_as_the_mesh_lives():
    one, two = (triangles(evaluate(block(20, 16, wall))) for wall in (1.0, 2.0))
    assert gauge_of(one) is gauge_of(one) is not gauge_of(two)
    assert gauge_of(two).least().thickness == pytest.approx(2.0)
    kept = weakref.ref(gauge_of(one))
    del one
    gc.collect()
    assert kept() is None and gauge_of(two).least().thickness == pytest.approx(2.0)


def test_histogram_weighs_by_area():
    counts = gauge(block(40, 30, 2)).histogram(np.array([0, 1.9, 2.1, 29, 31, 39, 41]))
    assert counts == pytest.approx([0, 2400, 0, 160, 0, 120], rel=0.05)


@pytest.fixture(scope="module")
def index(adult):
    """The index finger's exoskeleton: walls of 2 mm."""
    return fingers.exoskeleton(adult, "index")


def test_shipped_finger(index):
    found = Gauge(index.mesh)
    assert found.thin_spots(1.9) == []
    assert found.least().thickness == pytest.approx(2.0, abs=ACCURACY)


@pytest.mark.parametrize("seed", range(6))
def test_planted_dent(index, adult, seed):
    """A ball pressed into the bore at a random place leaves 0.4-0.6 mm: found there and measured."""
    rng = np.random.default_rng(seed)
    profile = FingerProfile(adult.fingers.index)
    x, turn = rng.choice([4.0, 30.0, 40.0, 69.0, 91.0]), rng.uniform(0, 2 * math.pi)
    radius, wall = rng.uniform(0.8, 3), rng.uniform(0.4, 0.6)
    reach = profile.outer_radius(x) - wall - radius
    at = np.array([x, reach * math.sin(turn), reach * math.cos(turn)])
    ball = csg.Revolve(csg.Path((-radius, 0), ()).quarter((-radius, radius), (0, radius))
                       .quarter((radius, radius), (radius, 0)))
    spots = gauge(index.shape - ball.moved(*at)).thin_spots(0.7)
    assert len(spots) == 1
    assert spots[0].thickness == pytest.approx(wall, abs=ACCURACY)
    assert np.linalg.norm(np.subtract(spots[0].middle, at)) < radius + 1.0


@pytest.mark.parametrize("seed", range(4))
def test_planted_shift(adult, seed):
    """A bore half a millimetre off its axis: the wall is thin on that side, all along it."""
    rng = np.random.default_rng(seed)
    turn = rng.uniform(0, 2 * math.pi)
    shifted = csg.Revolve(csg.Path.polygon([(-1, 0), (60, 0), (60, 8), (-1, 8)]))
    tube = csg.cylinder(10, 0, 50) - shifted.moved(y=0.5 * math.sin(turn), z=0.5 * math.cos(turn))
    spots = gauge(tube).thin_spots(1.6)
    assert len(spots) == 1
    assert spots[0].thickness == pytest.approx(1.5, abs=ACCURACY)
    _, y, z = spots[0].middle
    assert math.hypot(y - 9.25 * math.sin(turn), z - 9.25 * math.cos(turn)) < 3.0


@pytest.mark.parametrize(("which", "below"), [("hand", 2.5), ("finger and tooling", 2.5)])
def test_thinnest_places_confirmed_by_sections(adult, which, below):
    """The thinnest places of real parts, measured a second time in a plane section through them."""
    parts = ([hand_part(adult)] if which == "hand"
             else [fingers.exoskeleton(adult, "little"), *tooling(adult, "little")])
    meshes = {part.name: part.mesh for part in parts}
    spots = sorted(((spot, name) for name, mesh in meshes.items() for spot in Gauge(mesh).thin_spots(below)),
                   key=lambda found: found[0].thickness)[:10]
    assert len(spots) == 10
    for spot, name in spots:
        along = np.subtract(spot.opposite, spot.point) / spot.thickness
        across = np.cross(along, np.eye(3)[np.argmin(abs(along))])
        section = meshes[name].section(plane_origin=spot.middle, plane_normal=across)
        lines = section.vertices[np.vstack([e.nodes for e in section.entities])]
        # To either side of the place, because an edge may lie in it; beyond it may lie the open air.
        aside = 1e-3 * np.cross(along, across) / np.linalg.norm(across)
        passed = [crossings(lines, spot.middle + sign * aside, along) for sign in (-1, 1)]
        walls = [p[p > 0].min() - p[p < 0].max() for p in passed if p.min(initial=0) < 0 < p.max(initial=0)]
        assert np.mean(walls) == pytest.approx(spot.thickness, abs=ACCURACY / 2)


def crossings(lines, origin, direction):
    """Where the line through `origin` along `direction` passes line segments (n, 2, 3) of its plane."""
    start, along = lines[:, 0] - origin, lines[:, 1] - lines[:, 0]
    normal = np.cross(direction, np.cross(along, direction))
    square = np.einsum("ij,ij->i", along, normal)
    share = -np.einsum("ij,ij->i", start, normal) / np.maximum(square, 1e-12)
    hit = (square > 1e-12) & (share >= 0) & (share <= 1)
    return ((start + share[:, None] * along) @ direction)[hit]
