"""The hand's exoskeleton, measured on the mesh that is printed: by sections, rods and booleans."""

import numpy as np
import pytest
import trimesh
from hypothesis import Phase, given, settings
from manifold3d import Manifold, Mesh

from handgen.checks.fff import overhang
from handgen.checks.limits import standard
from handgen.errors import GeometryError
from handgen.export import stl
from handgen.geometry import csg, finger, hand_walls, measure, palm
from handgen.geometry.bay import junctions
from handgen.geometry.hand import hand_part
from handgen.geometry.mesh_kernel import evaluate
from handgen.geometry.profile import FingerProfile
from handgen.geometry.skin import Block, Common, Skin
from handgen.geometry.thumb import Hinge
from handgen.parameters.load import load
from handgen.parameters.model import Hand
from tests import strategies
from tests.conftest import PARAMS

FINGERS = ("index", "middle", "ring", "little", "thumb")
CAD_VOLUME = 111.2e3
"""Eq. 5.1: the source's own hand, mm3."""


def solid(mesh: trimesh.Trimesh) -> Manifold:
    return Manifold(Mesh(np.array(mesh.vertices, np.float32), np.array(mesh.faces, np.uint32)))


def variant(hand: Hand, **changes) -> Hand:
    """The hand with values at dotted paths (`__` for the dot) replaced."""
    data = hand.model_dump(by_alias=True)
    for path, value in changes.items():
        *way, last = path.split("__")
        node = data
        for key in way:
            node = node[key]
        node[last] = value
    return Hand.model_validate(data)


@pytest.fixture(scope="module")
def part(adult):
    return hand_part(adult)


@pytest.fixture(scope="module")
def body(part):
    return solid(part.mesh)


@pytest.fixture(scope="module")
def thesis():
    return load(PARAMS / "thesis_hand.yaml").hand


@pytest.fixture(scope="module")
def thesis_body(thesis):
    return solid(hand_part(thesis).mesh)


def test_one_body_of_195_mm_that_fits_the_printer(adult, part):
    content = stl.to_bytes(part.mesh)
    facts = measure.measure(measure.read_stl(content))
    assert facts.faults() == []
    (low, high) = np.array(facts.bbox_mm)
    assert low[0] == pytest.approx(0.0, abs=1e-6)
    assert high[0] == pytest.approx(195.0, abs=0.05)
    assert np.all(high - low < adult.printing.build_volume)
    assert 130 < high[1] - low[1] < 180 and 30 < high[2] - low[2] < 55
    assert facts.volume_mm3 == pytest.approx(CAD_VOLUME, rel=0.1)
    assert len(content) < 10e6


def test_wrist_is_a_flat_ring_with_a_mouth_for_two_fingers_each(part):
    ring = part.mesh.section(plane_origin=(0.05, 0, 0), plane_normal=(1, 0, 0))
    first, second, whole = sorted(abs(_area(loop[:, 1:])) for loop in ring.discrete)
    assert first > 300 and second > 340 and whole - first - second > 300


@pytest.mark.parametrize("which", ["adult", "thesis"])
def test_roofs_of_the_bays_carry_themselves_while_they_are_printed(which, request):
    """Across each hollow the ceiling climbs to one ridge of at most 10 mm; nothing hangs between."""
    mesh = hand_part(request.getfixturevalue(which)).mesh
    wide = 0
    for x in np.arange(1.3, 60.0, 4.0):
        loops = [loop[:, 1:] for loop in mesh.section((1, 0, 0), (x, 0, 0)).discrete]
        whole = max(loops, key=lambda loop: abs(_area(loop)))
        for hollow in (h for h in loops if h is not whole and abs(_area(h)) > 260):
            y = np.linspace(*hollow[:, 0].min() + np.array((0.02, 0.98)) * np.ptp(hollow[:, 0]), 400)
            z = _ceiling(hollow, y)
            if x < 30:
                climbed = np.minimum(np.maximum.accumulate(z), np.maximum.accumulate(z[::-1])[::-1])
                assert (climbed - z).max() < 0.1, x
                flat = abs(np.gradient(z, y)) < np.tan(np.radians(20.0))
                assert flat.mean() * np.ptp(y) < 10.0, x
                wide += np.ptp(y) > 20
    assert wide >= 10


def _ceiling(loop, y):
    """Highest z of a closed loop (n, 2) at each of `y`."""
    (y0, z0), (y1, z1) = loop[:-1].T[:, :, None], loop[1:].T[:, :, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where((y0 - y) * (y1 - y) <= 0, z0 + (z1 - z0) * (y - y0) / (y1 - y0), -np.inf)
    return np.nanmax(z, axis=0)


@pytest.mark.parametrize("which", ["adult", "thesis"])
def test_support_that_is_needed_stands_on_the_bed(which, request):
    hand = request.getfixturevalue(which)
    made = hand_part(hand)
    assert overhang(hand, {made.name: made}, standard()).status == "pass"


def _area(loop):
    x, y = loop.T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize("name", FINGERS)
def test_finger_has_its_own_diameters_in_place(adult, part, name):
    f = getattr(adult.fingers, name)
    profile = FingerProfile(f)
    rows, origin = palm.finger_placement(adult, name)
    vertices = (part.mesh.vertices - origin) @ np.array(rows)
    straight = trimesh.Trimesh(vertices, part.mesh.faces, process=False)
    last = f.joints[-1]
    behind, before = f.joints[0].position + f.joints[0].slot_length / 2, f.joints[1].position
    for x in (0.5, (behind + before) / 2, last.position + last.slot_length / 2 + 2, f.inner_length - 0.2):
        lines = trimesh.intersections.mesh_plane(straight, (1, 0, 0), (x, 0, 0))
        radius = np.linalg.norm(lines[:, :, 1:], axis=2).ravel()
        assert radius.min() == pytest.approx(profile.bore(x), abs=0.05)
        if x > 1:
            own = radius[radius < f.base_outer_diameter / 2 + 0.5]
            assert own.max() == pytest.approx(profile.outer(x), abs=0.05)
    near = np.hypot(vertices[:, 1], vertices[:, 2]) < f.base_outer_diameter / 2
    assert vertices[near, 0].max() == pytest.approx(f.outer_length, abs=0.05)


@pytest.mark.parametrize("name", FINGERS)
def test_nothing_is_cut_from_a_finger_and_nothing_grows_into_it(adult, body, name):
    f = getattr(adult.fingers, name)
    place = palm.finger_placement(adult, name)
    alone = finger.shape(f, adult.exoskeleton.joint_fillet).placed(*place)
    assert (evaluate(alone) - body).volume() < 0.5
    beyond = csg.cylinder(f.base_outer_diameter / 2 + 0.5, palm.first_slot(f) - 0.2, f.outer_length + 1)
    grown = (body ^ evaluate(beyond.placed(*place))) - evaluate(alone)
    assert grown.volume() < 0.5


def test_actuators_slide_from_the_wrist_into_their_bores(adult, body):
    for name, channel in zip(palm.row(adult), palm.channels(adult), strict=True):
        f = getattr(adult.fingers, name)
        rod = csg.cylinder(f.base_bore_diameter / 2 + 0.02, -adult.seal.collar_length, 0.0)
        narrow = csg.cylinder(f.tip_bore_diameter / 2 - 0.02, -1.0, f.inner_length - 0.02)
        place = palm.finger_placement(adult, name)
        for shape in ((rod + narrow).placed(*place), channel.shape):
            assert (evaluate(shape) ^ body).volume() < 0.05, name
        # The wrist's mouth takes the actuator's whole girth.
        assert channel.start[0] < 0 and 2 * channel.radius > f.base_bore_diameter


def test_thumb_actuator_goes_in_through_the_gap(adult, body):
    f, hinge = adult.fingers.thumb, Hinge(adult)
    place = palm.finger_placement(adult, "thumb")
    # 40 mm behind the root it stands free of the palm: clear of sheet, ball and palm all the way.
    base = csg.cylinder(f.base_bore_diameter / 2 + 0.02, -adult.seal.collar_length - 2, 0.0)
    narrow = csg.cylinder(f.tip_bore_diameter / 2 - 0.02, -1.0, f.inner_length - 0.02)
    assert (evaluate((base + narrow).placed(*place)) ^ body).volume() < 0.05
    assert hinge.local(palm.on_axis(adult, "thumb", -20.0))[0] < hinge.o.free_length


def _in_hinge(hinge, low, high):
    """A box in the hinge's frame."""
    return evaluate(csg.box(low, high).placed(hinge.rotation, hinge.origin))


def _holes(hand):
    hinge = Hinge(hand)
    seats = [palm.seat(hand, n, hand.seal.collar_length) for n in palm.row(hand)]
    return [*palm.channels(hand), *seats, *hinge.holes()]


@pytest.mark.parametrize("which", ["adult", "thesis"])
def test_no_hole_breaks_out(which, request):
    """Within 1.4 mm of every hole there is material, another hole that it meets, or the gap."""
    hand = request.getfixturevalue(which)
    printed = request.getfixturevalue("body" if which == "adult" else "thesis_body")
    hinge = Hinge(hand)
    holes = _holes(hand)
    far, length = 200.0, hinge.o.free_length
    behind = _in_hinge(hinge, (-far, -far, -far), (-0.05, far, far))
    past = _in_hinge(hinge, (length + 0.05, -far, -far), (far, far, far))
    inside = evaluate(csg.box((0.05, -far, -far), (far, far, far)))
    beside_gap = behind + past
    voids = evaluate(csg.Union((*(h.shape for h in holes), *junctions(hand), hinge.gap)))
    slots = [csg.cylinder(30.0, palm.first_slot(f) - 0.05, 60.0).placed(*palm.finger_placement(hand, n))
             for n, f in hand.fingers.present().items()]
    for hole in holes:
        if hole.name == "thumb tube":  # it opens where the palm's side stands back from the gap
            continue
        wide = csg.cylinder(hole.radius + 1.4, 0.0, hole.length + (1.4 if "tip" in hole.name else 0.0))
        wide = wide.placed(palm.facing(np.subtract(hole.end, hole.start) / hole.length), hole.start)
        around = evaluate(csg.Difference(wide, tuple(slots))) ^ inside
        if "thumb" in hole.name or "opposition" in hole.name:
            around = around ^ beside_gap
        assert (around - printed - voids).volume() < 0.02, hole.name


@pytest.mark.parametrize("which", ["adult", "thesis"])
def test_pockets_are_walled_off_from_bores_and_channels(which, request):
    hand = request.getfixturevalue(which)
    hinge = Hinge(hand)
    bases, tips = ([evaluate(h.shape) for h in holes] for holes in (hinge.bases(), hinge.tips()))
    bay = evaluate(csg.Union((*(c.shape for c in palm.channels(hand)), *junctions(hand))))
    beyond = _in_hinge(hinge, (hinge.o.free_length, -80, -80), (80, 80, 80))
    bore = evaluate(hinge.thumb_bore().shape) ^ beyond
    assert bases[0].min_gap(bases[1], 20.0) >= 1.4
    assert tips[0].min_gap(tips[1], 20.0) >= 1.4
    for base in bases:
        assert base.min_gap(bay, 20.0) >= 1.4
    for tip in tips:
        assert (tip ^ beyond).min_gap(bore, 20.0) >= 1.4


def test_tubes_lead_from_every_pocket_into_the_bay(adult, body):
    hinge = Hinge(adult)
    bay = evaluate(csg.Union((*(c.shape for c in palm.channels(adult)), *junctions(adult))))
    for tube in hinge.tubes():
        rod = evaluate(csg.cylinder(adult.seal.tube_outer_diameter / 2, 0.0, tube.length).placed(
            palm.facing(np.subtract(tube.end, tube.start) / tube.length), tube.start))
        assert (rod ^ body).volume() < 0.01, tube.name
        assert (rod ^ bay).volume() > 1.0, tube.name


@pytest.mark.parametrize("which, thickness", [("adult", 2.0), ("thesis", 8.0)])
def test_sheet_is_as_thick_as_asked_and_alone_joins_thumb_and_palm(which, thickness, request):
    hand = request.getfixturevalue(which)
    printed = request.getfixturevalue("body" if which == "adult" else "thesis_body")
    hinge, o = Hinge(hand), hand.opposition
    needle = evaluate(csg.cylinder(0.1, -60.0, 60.0).turned("y", -90))
    for u in (3.0, o.free_length / 2, o.free_length - 3.0):
        for v in (-o.sheet_width / 2 + 0.5, 0.0, o.sheet_width / 2 - 0.5):
            through = needle.translate(hinge.point(u, v, 0.0)) ^ printed
            low, high = through.bounding_box()[2], through.bounding_box()[5]
            assert high - low == pytest.approx(thickness, abs=0.02)
            assert through.volume() == pytest.approx(needle.volume() * thickness / 120.0, rel=0.02)
    half, length = o.sheet_width / 2, o.free_length
    middle = _in_hinge(hinge, (length / 2 - 0.1, -half - 1, -40), (length / 2 + 0.1, half + 1, 40))
    parts = (printed - middle).decompose()
    assert len(parts) == 2 and min(p.volume() for p in parts) > 15e3
    fillet = o.sheet_fillet + 0.05
    free = _in_hinge(hinge, (0.05, -half, hinge.top + fillet), (length - 0.05, half, 60))
    assert (free ^ printed).volume() < 0.01


def test_left_hand_is_the_mirror_image(adult, body):
    left = solid(hand_part(variant(adult, side="left")).mesh)
    back = left.mirror((0, 1, 0))
    assert (back - body).volume() + (body - back).volume() < 1.0
    assert left.bounding_box()[1] == pytest.approx(-body.bounding_box()[4], abs=1e-3)


def test_volume_does_not_hang_on_the_grid(adult, body):
    fine = hand_part(variant(adult, palm__resolution=0.5)).mesh.volume
    assert body.volume() == pytest.approx(fine, rel=5e-3)


def test_brep_is_one_valid_solid_near_the_printed_one(part):
    printed = part.mesh
    brep = part.solid
    assert brep.isValid() and len(brep.Solids()) == 1
    own = evaluate(part.bodies[0].shape)
    # The same tree in the other kernel: straight instead of smooth lofts, nothing else.
    assert own.volume() == pytest.approx(brep.Volume(), rel=0.03)
    # What it leaves out, the blends, is a twentieth of the hand.
    assert brep.Volume() == pytest.approx(printed.volume, rel=0.06)
    box = brep.BoundingBox()
    assert box.xmin == pytest.approx(0.0, abs=0.01) and box.xmax == pytest.approx(195.0, abs=0.05)
    assert np.allclose((box.ymin, box.ymax), printed.bounds[:, 1], atol=2.0)


@pytest.mark.parametrize("changes, path", [
    ({"fingers__ring__placement__root": [79.0, -9.0, 0.0]}, "fingers.ring.placement.root"),
    ({"fingers__index__placement__splay": -6.0}, "fingers.middle.placement.splay"),
    ({"fingers__middle__base_bore_diameter": 19.4, "fingers__ring__base_bore_diameter": 19.4,
      "fingers__ring__placement__root": [79.0, -11.4, 0.0]}, "fingers.ring.placement.root"),
    ({"palm__mouth": 16.0}, "palm.mouth"),
    ({"opposition__origin": [34.0, 36.0, -16.5]}, "opposition.origin"),
    ({"opposition__origin": [34.0, 43.0, -15.0]}, "opposition.origin"),
    ({"opposition__tip_socket": 25.0}, "opposition.free_length"),
    ({"fingers__thumb__placement__splay": -20.0}, "fingers.thumb.placement.splay"),
    ({"fingers__thumb__placement__root": [40.0, 55.0, -1.5]}, "fingers.thumb.placement.root"),
    ({"fingers__thumb__placement__root": [52.5, 72.5, -8.0]}, "opposition.free_length"),
])
def test_a_hand_that_would_not_hold_is_refused_by_name(adult, changes, path):
    with pytest.raises(GeometryError) as refused:
        hand_part(variant(adult, **changes))
    assert refused.value.path == path


def test_walls_are_judged_as_thick_as_they_are(adult):
    """The check's own ruler against two holes whose wall is known."""
    a = palm.Hole("a", "", (0.0, 0.0, 0.0), (20.0, 0.0, 0.0), 3.0)
    b = palm.Hole("b", "", (0.0, 8.5, 0.0), (20.0, 8.5, 0.0), 4.0)
    assert hand_walls._between(a, b) == pytest.approx(1.5, abs=0.02)
    c = palm.Hole("c", "", (22.0, 0.0, 0.0), (30.0, 0.0, 0.0), 4.0)
    assert hand_walls._between(a, c) == pytest.approx(2.0, abs=1e-6)


def test_an_openings_rim_is_rounded_and_its_walls_are_not():
    still = csg.rotation("x", 0.0)
    block = Block(still, (0.0, 0.0, 0.0), (-20.0, -20.0, -20.0), (20.0, 20.0, 0.0), 1.0)
    half = Common((Block(still, (0.0, 0.0, 0.0), (0.0, -40.0, -40.0), (40.0, 40.0, 40.0), 1.0),
                   Block(still, (0.0, 0.0, 0.0), (-40.0, -40.0, -40.0), (40.0, 40.0, 40.0), 1.0)))
    skin = Skin((block,), 1.0, (half,), 2.0)
    edge, face, top = (0.0, 0.0, 0.0), (-1.0, 0.0, -8.0), (-8.0, 0.0, -1.0)
    assert skin.distance(np.array([edge, face, top])) == pytest.approx([2.0 / 4, -1.0, -1.0], abs=1e-5)
    values, origin = skin.sample(0.5)
    at = np.array([(10, 20, 30), (39, 41, 42), (41, 60, 40)])
    assert values[tuple(at.T)] == pytest.approx(skin.distance(origin + 0.5 * at), abs=1e-4)


def test_hand_without_opposition_has_a_thumb_that_only_bends(adult):
    data = adult.model_dump(by_alias=True)
    data["opposition"] = None
    for name in ("opposition_1", "opposition_2"):
        del data["actuators"][name]
    data["fingers"]["thumb"]["placement"] = {"root": [50.0, 58.0, 0.0], "splay": 35.0}
    # Five channels leave no room for walls in the mouth: they run into one another as before.
    plain = hand_part(Hand.model_validate(data)).mesh
    assert plain.is_watertight and plain.body_count == 1


def study(folder, count):
    """Share of `count` random hands that could be built; all others are refused by name."""
    built = []

    @settings(max_examples=count, phases=[Phase.generate])
    @given(strategies.files())
    def every_hand(data):
        try:
            mesh = hand_part(load(strategies.write(data, folder)).hand).mesh
        except GeometryError as error:
            assert error.path.split(".")[0] in Hand.model_fields
            built.append(False)
            return
        assert measure.measure(measure.read_stl(stl.to_bytes(mesh))).faults() == []
        built.append(True)

    every_hand()
    return sum(built) / count


def test_five_random_hands(tmp_path):
    study(tmp_path, 5)


@pytest.mark.slow
def test_two_hundred_random_hands(tmp_path):
    assert study(tmp_path, 200) > 0.05
