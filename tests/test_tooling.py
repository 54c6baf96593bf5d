"""The tooling as printed: does it cast the actuator, open, hold, seal (Figure 4.7)?

Everything is measured on the exported meshes; what a mould leaves open is cast by booleans.
"""

import itertools
import math
from functools import cached_property

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold, Mesh, OpType

from handgen.checks import walls
from handgen.checks.limits import standard
from handgen.errors import GeometryError
from handgen.geometry.actuator import actuator, thread_length
from handgen.geometry.csg import digest
from handgen.geometry.finger import exoskeleton
from handgen.geometry.mesh_kernel import evaluate
from handgen.geometry.tooling import ROLES, tooling
from handgen.parameters.load import load
from tests.conftest import PARAMS
from tests.probe import assert_printable, section_radii, walls_along
from tests.test_actuators import SHIPPED, changed

MOULD = ("mould_a", "mould_b", "mould_base")


def distinct(shipped):
    """Actuators whose tooling differs: a hand that differs in its palm only adds none."""
    found = {}
    for file, name in shipped:
        shapes = tuple(part.shape for part in tooling(load(file).hand, name))
        found.setdefault(digest(shapes), (file, name))
    return list(found.values())


class Workbench:
    """One actuator's parts, as solids made from the meshes that are exported."""

    def __init__(self, hand, name):
        self.hand, self.name = hand, name
        self.layers, self.length = hand.layers_of(name), getattr(hand.actuators, name).outer_length
        self.parts = {p.role: p for p in (*tooling(hand, name), actuator(hand, name))}
        self.solids = {}

    def __getitem__(self, role):
        if role not in self.solids:
            self.solids[role] = solid(self.parts[role].mesh)
        return self.solids[role]

    @cached_property
    def cavity(self):
        """What the closed mould leaves open below the fill line x = 0."""
        reach = getattr(self.hand.actuators, self.name).base_outer_diameter / 2 + 1.0
        room = Manifold.cylinder(self.length, reach).rotate((0, 90, 0))
        return room - self["mould_a"] - self["mould_b"] - self["mould_base"]

    @cached_property
    def first_pour(self):
        return self.cavity - self["core_large"]

    @cached_property
    def second_pour(self):
        return self.cavity - self.first_pour - self["core_small"]

    @property
    def filled(self):
        return self.hand.casting.tip == "filled afterwards"

    def hole(self, length):
        """Volume that the cores' salience keeps open over `length` of the tip (Section 4.1.2)."""
        return math.pi * section_radii(self.parts["core_small"].mesh, self.length - 1.0)[-1] ** 2 * length

    @property
    def filling(self):
        """Volume of the 2 mm that are added to the tip from inside."""
        core = self.parts["core_small"].mesh
        return math.pi * section_radii(core, self.length - self.layers.tip)[-1] ** 2 * 2.0


def solid(mesh):
    return Manifold(Mesh(np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32)))


def mesh_of(body):
    data = body.to_mesh()
    return trimesh.Trimesh(data.vert_properties[:, :3], data.tri_verts)


def middle_of(mesh, x):
    """Centre (y, z) of the widest outline in the section at x."""
    loops = mesh.section(plane_origin=(x, 0, 0), plane_normal=(1, 0, 0)).discrete
    loop = max(loops, key=lambda p: np.hypot(p[:, 1], p[:, 2]).max())
    return (loop[:, 1:].max(axis=0) + loop[:, 1:].min(axis=0)) / 2


@pytest.fixture(scope="module", params=distinct(SHIPPED), ids=lambda p: f"{p[0].stem}-{p[1]}")
def bench(request):
    file, name = request.param
    return Workbench(load(file).hand, name)


def test_eight_parts_printable(bench):
    parts = tooling(bench.hand, bench.name)
    assert [p.name for p in parts] == [f"tooling/{bench.name}/{role}" for role in ROLES]
    assert {p.material for p in parts} == {"PLA"}
    for part in parts:
        assert_printable(bench.parts[part.role].mesh)


def test_pours_are_the_layers(bench):
    """Cavity less large core = outer and thread layer; then the small core's gap = inner layer."""
    volume = {b.name: evaluate(b.shape).volume() for b in actuator(bench.hand, bench.name).bodies}
    first, second = bench.first_pour.volume(), bench.second_pour.volume()
    if bench.filled:
        first += bench.hole(bench.layers.external + bench.layers.thread)
        second += bench.hole(bench.layers.internal) + bench.filling
    assert first == pytest.approx(volume["external_layer"] + volume["thread_layer"], rel=2e-3)
    assert second == pytest.approx(volume["internal_layer"], rel=2e-3)


def test_what_is_cast_is_the_actuator(bench):
    cast, wanted = bench.cavity - bench["core_small"], bench["actuator"]
    assert (cast - wanted).volume() < 1.0
    missing = wanted - cast
    if bench.filled:
        # Only at the tip something is missing: the salience's hole and the 2 mm that are filled.
        chamber = bench.length - bench.layers.tip - 1.0  # its end is rounded
        assert missing.trim_by_plane((-1, 0, 0), -chamber).volume() < 1.0
        assert missing.volume() == pytest.approx(bench.filling + bench.hole(bench.layers.tip - 2), rel=0.03)
    else:
        assert missing.volume() < 1.0


def test_tip_between_core_and_floor(bench):
    """Core tip to mould floor: the whole tip for the small core, the first pour for the large."""
    floor = walls_along(bench.parts["mould_base"].mesh, (bench.length - 3.0, 2.2, 0.02), (1, 0, 0))[0]
    floor += bench.length - 3.0
    assert floor == pytest.approx(bench.length, abs=1e-3)
    fill = bench.hand.casting.tip_fill if bench.filled else 0.0
    for core, asked in (("core_small", bench.layers.tip - fill),
                        ("core_large", bench.layers.external + bench.layers.thread)):
        body = bench[core] - Manifold.cylinder(100, 1.7).rotate((0, 90, 0)) if bench.filled else bench[core]
        assert floor - mesh_of(body).bounds[1][0] == pytest.approx(asked, abs=0.1)


def test_layers_are_even_all_around(bench):
    """Cores centred within 0.05 mm; layers as asked where they are not adapted."""
    cavity = mesh_of(bench.cavity)
    large, small = bench.parts["core_large"].mesh, bench.parts["core_small"].mesh
    for x in np.linspace(0.5, bench.length - bench.layers.tip - 1.5, 4):
        for core in (large, small):
            assert middle_of(core, x) == pytest.approx(middle_of(cavity, x), abs=0.05)
        radii = [section_radii(m, x)[-1] for m in (cavity, large, small)]
        gaps = -np.diff(radii)
        asked = np.array([bench.layers.external + bench.layers.thread, bench.layers.internal])
        thinned = radii[2] < bench.hand.casting.minimum_core_tip_diameter / 2 + 0.01
        if thinned:
            assert gaps / gaps.sum() == pytest.approx(asked / asked.sum(), abs=0.02)
        else:
            assert gaps == pytest.approx(asked, abs=0.1)


def test_the_suspender_holds_both_cores(bench):
    """A core is stopped by the hub in depth, and sideways after `core_fit`; the mould likewise."""
    hub, fit = bench["suspender"], bench.hand.casting.core_fit
    for core in ("core_large", "core_small"):
        free = bench[core]
        assert (free ^ hub).volume() < 1e-3
        assert (free.translate((0.05, 0, 0)) ^ hub).volume() > 0.5
        for direction in ((0, 1, 0), (0, 0, 1), (0, -0.6, 0.8)):
            move = np.array(direction)
            assert (free.translate(0.8 * fit * move) ^ hub).volume() < 1e-3
            assert (free.translate((fit + 0.1) * move) ^ hub).volume() > 0.05
    fit = bench.hand.casting.mould_fit
    for half, move in (("mould_a", (0, 0, -1)), ("mould_b", (0, 0, 1)), ("mould_a", (0, 1, 0))):
        for cap in ("suspender", "mould_base"):
            assert (bench[half].translate((fit + 0.1) * np.array(move)) ^ bench[cap]).volume() > 0.05


def test_cores_go_in_from_above(bench):
    """With the suspender in place each core, thread and all, can be drawn out through its hub."""
    thread = bench.hand.thread_of(bench.name).diameter
    bore = section_radii(bench.parts["suspender"].mesh, bench.parts["suspender"].mesh.bounds[0][0] + 1.0)[0]
    large = section_radii(bench.parts["core_large"].mesh, 0.01)[-1]
    assert large + thread <= bore
    for lift in np.linspace(2, bench.length, 7):
        for core in ("core_large", "core_small"):
            assert (bench[core].translate((-lift, 0, 0)) ^ bench["suspender"]).volume() < 1e-3


def test_there_is_a_way_in_for_silicone_and_out_for_air(bench):
    """Three gates around the hub, 3 mm wide, open above and leading down to the cavity's floor."""
    suspender = bench.parts["suspender"].mesh
    above = suspender.bounds[0][0]
    loops = suspender.section(plane_origin=(above + 1.0, 0, 0), plane_normal=(1, 0, 0)).discrete
    gates = [p for p in loops if not all(p[:, 1:].min(axis=0) < 0) or not all(p[:, 1:].max(axis=0) > 0)]
    assert len(gates) == 3
    reach = [np.hypot(*gate[:, 1:].T) for gate in gates]
    assert all(np.ptp(r) > 3.0 for r in reach)
    rim = max(section_radii(bench.parts["mould_a"].mesh, bench.parts["mould_a"].mesh.bounds[0][0] + 0.01))
    assert rim > max(r.max() for r in reach)
    height = bench.length - above + 1.0
    room = Manifold.cylinder(height, max(r.max() for r in reach)).rotate((0, 90, 0))
    room = room.translate((above - 1.0, 0, 0))
    for role in (*MOULD, "suspender", "core_large"):
        room -= bench[role]
    way = max(room.decompose(), key=lambda body: body.volume())
    assert mesh_of(way).bounds[:, 0] == pytest.approx([above - 1.0, bench.length], abs=0.01)


def test_the_mould_opens_without_undercut(bench):
    """Drawn apart along the split's normal, no half catches on the casting or on the other half."""
    # Sections across the pull only widen towards the split.
    for role, side in (("mould_a", -1), ("mould_b", 1)):
        pulled = [bench[role].translate((0, 0, side * step)) for step in (0.01, 0.1, 1.0, 4.0, 9.0, 20.0)]
        other = bench["mould_b" if role == "mould_a" else "mould_a"]
        for half in pulled:
            assert (half ^ bench["actuator"]).volume() < 1e-3
            assert (half ^ other).volume() < 1e-3


def test_halves_meet_one_way_only(bench):
    """Turned end for end, the pins miss their holes."""
    middle = bench.parts["mould_a"].mesh.bounds[:, 0].mean()
    turned = bench["mould_a"].translate((-middle, 0, 0)).rotate((0, 0, 180)).translate((middle, 0, 0))
    assert (turned ^ bench["mould_b"]).volume() > 20.0
    slipped = bench["mould_a"].translate((bench.hand.casting.mould_fit + 0.1, 0, 0))
    assert (slipped ^ bench["mould_b"]).volume() > 0.1


def overlaps(bodies):
    return {(a, b): (bodies[a] ^ bodies[b]).volume() for a, b in itertools.combinations(bodies, 2)}


@pytest.mark.parametrize("core", ["core_large", "core_small"])
def test_nothing_overlaps_in_the_casting_setup(bench, core):
    assert max(overlaps({r: bench[r] for r in (*MOULD, "suspender", core)}).values()) < 1.0


def test_nothing_overlaps_in_the_sealed_actuator(bench):
    """The plug presses into the silicone by its squeeze, which is what seals it; nothing else meets.

    A finger printed with a rest curl is straightened to take the actuator.
    """
    bodies = {r: bench[r] for r in ("actuator", "plug", "collar")}
    finger = getattr(bench.hand.fingers, bench.name, None)
    if finger:
        straight = finger.model_copy(
            update={"joints": [j.model_copy(update={"rest_angle": 0.0}) for j in finger.joints]})
        hand = changed(bench.hand, **{f"fingers__{bench.name}": straight})
        bodies["exoskeleton"] = solid(exoskeleton(hand, bench.name).mesh)
    found = overlaps(bodies)
    pressed = found.pop(("actuator", "plug"))
    assert max(found.values()) < 1.0
    seal = bench.hand.seal
    channel = section_radii(bench.parts["actuator"].mesh, seal.plug_length / 2)[0]
    around = math.pi * ((channel + seal.plug_squeeze) ** 2 - channel**2) * seal.plug_length
    assert pressed == pytest.approx(around, rel=0.1)


def test_plug_and_collar_fit_tube_and_bore(bench):
    seal = bench.hand.seal
    plug, collar = bench.parts["plug"].mesh, bench.parts["collar"].mesh
    assert plug.bounds[1][0] == pytest.approx(seal.plug_length, abs=1e-3)
    assert collar.bounds[:, 0] == pytest.approx([-seal.collar_length, 0.0], abs=1e-3)
    for x in (plug.bounds[0][0] + 1.0, -1.0, 1.0, seal.plug_length - 1.0):
        hole = section_radii(plug, x)[0]
        assert 2 * hole == pytest.approx(seal.tube_outer_diameter + 2 * seal.tube_fit, abs=0.02)
    inside, outside = section_radii(collar, -1.0)
    assert inside - section_radii(plug, -1.0)[-1] == pytest.approx(seal.glue_gap, abs=0.01)
    finger = getattr(bench.hand.fingers, bench.name, None)
    if finger:
        bore = section_radii(exoskeleton(bench.hand, bench.name).mesh, 0.3)[0]
    else:
        bore = section_radii(bench.parts["actuator"].mesh, 0.3)[-1] + bench.hand.opposition.clearance
    assert bore - outside == pytest.approx(seal.collar_fit, abs=0.02)
    # The flange behind holds the collar against the silicone and still passes the bore.
    flange = section_radii(plug, plug.bounds[0][0] + 1.0)[-1]
    assert inside + 0.3 < flange < outside


@pytest.mark.parametrize(("file", "name"), [("adult", "little"), ("thesis_finger", "index")])
def test_mesh_and_brep_are_the_same_tooling(file, name):
    for part in tooling(load(PARAMS / f"{file}.yaml").hand, name):
        assert part.solid.isValid() and len(part.solid.Solids()) == 1
        assert part.mesh.volume == pytest.approx(part.solid.Volume(), rel=5e-3)


def test_labels_stand_where_they_hurt_nobody(bench):
    """Every part but plug and collar, which are too small, carries raised letters outside of all fits."""
    height = bench.hand.casting.label_height
    plain = Workbench(changed(bench.hand, casting__label_height=0.0), bench.name)
    for role in ROLES:
        added = [b for b in (bench[role] - plain[role]).decompose() if b.volume() > 0.02]
        if role in ("plug", "collar"):
            assert not added
            continue
        letters = Manifold.batch_boolean(added, OpType.Add)
        size = np.ptp(np.reshape(letters.bounding_box(), (2, 3)), axis=0)
        assert sorted(size)[0] == pytest.approx(height, abs=0.01)
        assert sorted(size)[1] > 2.4
        assert (plain[role] - bench[role]).volume() < 1e-3
        up = np.array(bench.parts[role].up)
        bed = (np.asarray(bench.parts[role].mesh.vertices) @ up).min()
        assert (mesh_of(letters).vertices @ up).min() > bed + 0.5
        around = letters.translate((0, 0.3, 0)) + letters
        for other in set(ROLES) - {role, "plug", "collar"}:
            assert (around ^ plain[other]).volume() == 0.0
        assert (letters ^ bench.cavity).volume() == 0.0


@pytest.mark.parametrize("name", ["ring", "little", "thumb", "opposition_1"])
def test_small_moulds_have_walls_that_can_be_handled(adult, name):
    """A pin's hole, the groove for a rubber band beside it and the cavity leave 1.2 mm to one another."""
    halves = {p.name: p for p in tooling(adult, name) if p.role in ("mould_a", "mould_b")}
    assert not walls.minimum(adult, halves, standard()).findings


@pytest.mark.parametrize("thread", [0.4, 0.5])
def test_groove_follows_the_thread(adult, thread):
    """Half the thread's cross-section along its path, in the mesh and, as rings, in the B-rep."""
    grooved = changed(adult, thread__groove=True, thread__diameter=thread)
    part = next(p for p in tooling(grooved, "opposition_1") if p.role == "core_large")
    plain = next(p for p in tooling(adult, "opposition_1") if p.role == "core_large")
    assert_printable(part.mesh)
    removed = thread_length(grooved, "opposition_1") * math.pi * thread**2 / 8
    assert plain.mesh.volume - part.mesh.volume == pytest.approx(removed, rel=0.06)
    assert plain.solid.Volume() - part.solid.Volume() == pytest.approx(removed, rel=0.06)
    # One turn further on there is a groove again; half a turn on, on that side, there is none.
    pitch, core = adult.thread.pitch, 4.0
    for x, depth in ((2.0 + 4 * pitch, thread / 2), (2.0 + 4.5 * pitch, 0.0)):
        surface = 10.0 - walls_along(part.mesh, (x, 0.001, 10.0), (0, 0, -1))[0]
        assert core - surface == pytest.approx(depth, abs=0.03)


@pytest.mark.parametrize(("change", "part", "path"), [
    ({"seal__plug_length": 95.0}, "plug", "seal.plug_length"),
    ({"seal__tube_outer_diameter": 9.0}, "plug", "seal.tube_outer_diameter"),
    ({"layers__external": 0.3, "layers__thread": 0.1, "layers__internal": 0.3}, "collar", "layers"),
    ({"fingers__index__base_bore_diameter": 8.0}, "collar", "layers"),
])
def test_what_cannot_be_tooled_names_its_parameter(adult, change, part, path):
    with pytest.raises(GeometryError) as error:
        tooling(changed(adult, **change), "index")
    assert (error.value.part, error.value.path) == (f"tooling/index/{part}", path)


def test_trees_need_no_geometry_engine():
    import subprocess
    import sys

    code = ("import sys; from handgen.parameters.load import load;"
            "from handgen.geometry.tooling import tooling;"
            f"hand = load(r'{PARAMS / 'adult.yaml'}').hand; tooling(hand, 'index')[0].key;"
            "assert not {'cadquery', 'manifold3d', 'trimesh', 'matplotlib', 'shapely'} & set(sys.modules)")
    subprocess.run([sys.executable, "-c", code], check=True)
