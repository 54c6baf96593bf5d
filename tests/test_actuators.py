"""The cast actuators, measured on the mesh that is exported (Table A.2)."""

import io
import itertools
import math

import numpy as np
import pytest
import trimesh

from handgen.errors import GeometryError
from handgen.geometry.actuator import (
    actuator,
    adaptations,
    thread_length,
    thread_path,
    thread_turns,
)
from handgen.geometry.mesh_kernel import evaluate, printable
from handgen.geometry.tooling import tooling
from handgen.parameters.load import load
from handgen.parameters.model import FINGERS, OPPOSITION
from tests.conftest import PARAMS
from tests.probe import assert_printable, section_radii, walls_along

SHIPPED = [(file, name) for file in sorted(PARAMS.glob("*.yaml"))
           for name in load(file).hand.actuators.present()]
JUST = 0.3
"""Where a caliper's jaw sits beside an edge, mm."""


def changed(model, **values):
    """A copy of a parameter model with other values; a dotted key goes deeper (a__b)."""
    for key, value in values.items():
        first, _, rest = key.partition("__")
        value = changed(getattr(model, first), **{rest: value}) if rest else value
        model = model.model_copy(update={first: value})
    return model


@pytest.fixture(scope="module", params=SHIPPED, ids=lambda p: f"{p[0].stem}-{p[1]}")
def cast(request):
    """(hand, name, the actuator's STL as it is written)"""
    file, name = request.param
    hand = load(file).hand
    stl = actuator(hand, name).mesh.export(file_type="stl")
    return hand, name, trimesh.load(io.BytesIO(stl), file_type="stl")


def thinned_from(hand, name):
    """x from which this actuator's layers are adapted; its whole length where they are not."""
    found = {a.path: a.used["thinned_from_x"] for a in adaptations(hand)}
    return found.get(f"actuators.{name}.layers", getattr(hand.actuators, name).outer_length)


def test_table_a2(cast):
    """Length and diameters, whole wall and tip."""
    hand, name, mesh = cast
    asked, layers = getattr(hand.actuators, name), hand.layers_of(name)
    assert_printable(mesh)
    assert mesh.bounds[:, 0] == pytest.approx([0.0, asked.outer_length], abs=0.1)
    inside, outside = 2 * section_radii(mesh, JUST)
    assert outside == pytest.approx(asked.base_outer_diameter, abs=0.1)
    assert outside - inside == pytest.approx(2 * layers.stack, abs=0.1)
    tip = 2 * section_radii(mesh, asked.outer_length - JUST)
    assert tip == pytest.approx([asked.tip_outer_diameter], abs=0.1)
    # A rod pushed down the chamber stops at the tip.
    chamber, end = walls_along(mesh, (0.0, 0.03, 0.02), (1, 0, 0))
    assert end - chamber == pytest.approx(layers.tip, abs=0.1)


def test_layers_are_as_thick_as_the_table_says(cast):
    hand, name, _ = cast
    layers, part = hand.layers_of(name), actuator(hand, name)
    bodies = {b.name: printable(evaluate(b.shape)) for b in part.bodies}
    chamber = getattr(hand.actuators, name).outer_length - layers.tip - 1.0  # its tip is rounded
    end = min(thinned_from(hand, name), chamber)
    for x in np.linspace(JUST, end - JUST, 4):
        for body, asked in (("external_layer", layers.external), ("thread_layer", layers.thread),
                            ("internal_layer", layers.internal)):
            assert np.ptp(section_radii(bodies[body], x)) == pytest.approx(asked, abs=0.1)


def test_layers_fill_the_actuator_and_nothing_twice(cast):
    hand, name, mesh = cast
    solids = [evaluate(b.shape) for b in actuator(hand, name).bodies]
    assert sum(s.volume() for s in solids) == pytest.approx(mesh.volume, rel=1e-3)
    for a, b in itertools.combinations(solids, 2):
        assert (a ^ b).volume() < 1e-3


def test_mesh_and_brep_are_the_same_actuator(cast):
    hand, name, mesh = cast
    solids = actuator(hand, name).solids()
    assert [n for n, _, _ in solids] == ["external_layer", "thread_layer", "internal_layer"]
    assert all(s.isValid() and len(s.Solids()) == 1 for _, s, _ in solids)
    assert sum(s.Volume() for _, s, _ in solids) == pytest.approx(mesh.volume, rel=5e-3)


def test_the_thread_lies_on_the_large_core(cast):
    hand, name, _ = cast
    thread, path = hand.thread_of(name), thread_path(hand, name)
    core = next(p for p in tooling(hand, name) if p.role == "core_large").mesh
    for x, y, z, _ in path[:: len(path) // 7]:
        surface = section_radii(core, x)[-1]
        assert math.hypot(y, z) - surface == pytest.approx(thread.diameter / 2, abs=0.01)
    first, last = path[0], path[-1]
    assert first[0] == pytest.approx(thread.held_back)
    assert core.bounds[1][0] - last[0] >= thread.held_back - 1e-6
    assert np.diff(path[:, 0]) == pytest.approx(np.diff(path[:, 3]) * thread.pitch)
    # Right-handed: seen from the base it turns clockwise as it leaves, dorsal to little finger.
    angle = np.unwrap(np.arctan2(path[:, 2], path[:, 1]))
    assert (angle[-1] - angle[0]) / (2 * np.pi) == pytest.approx(last[3])


def test_thread_length_on_a_straight_core(adult):
    """On a cylinder the helix has a closed form."""
    turns, thread = thread_turns(adult, "opposition_1"), adult.thread
    layers = adult.layers
    radius = adult.actuators.opposition_1.base_outer_diameter / 2 - layers.external - layers.thread
    around = 2 * math.pi * (radius + thread.diameter / 2)
    assert turns == pytest.approx((36 - 2 - 2 * thread.held_back) / thread.pitch)
    expected = turns * math.hypot(around, thread.pitch)
    assert thread_length(adult, "opposition_1") == pytest.approx(expected, rel=5e-4)


def test_adaptations_state_what_table_a2_leaves(adult):
    found = {a.path: a for a in adaptations(adult)}
    assert set(found) == {"actuators.little.layers", "actuators.thumb.layers"}
    for name, room in (("little", -0.25), ("thumb", -1.0)):
        stated = found[f"actuators.{name}.layers"]
        assert stated.asked == {
            "external": 1.5, "thread": 0.5, "internal": 1.5, "core_tip_diameter": room}
        assert f"{room:g} mm" in stated.reason and stated.source == "Table A.2"
        # What it says is used is what is cast.
        mesh, given = actuator(adult, name).mesh, getattr(adult.actuators, name)
        inside, _ = 2 * section_radii(mesh, given.outer_length - adult.layers.tip - 1.2)
        assert inside == pytest.approx(stated.used["core_tip_diameter"], abs=0.02)
        x = stated.used["thinned_from_x"]
        before, after = (np.ptp(section_radii(mesh, at)) for at in (x - 1.0, x + 6.0))
        assert before == pytest.approx(adult.layers.stack, abs=0.02)
        assert after < adult.layers.stack - 0.1
        shares = [stated.used[k] / stated.asked[k] for k in ("external", "thread", "internal")]
        wall = sum(stated.used[k] for k in ("external", "thread", "internal"))
        assert shares == pytest.approx([shares[0]] * 3)
        assert 2 * wall + stated.used["core_tip_diameter"] == pytest.approx(given.tip_outer_diameter)


def test_the_prototype_needs_no_adaptation():
    assert adaptations(load(PARAMS / "thesis_finger.yaml").hand) == []


@pytest.mark.parametrize(("change", "path"), [
    ({"actuators__index__tip_outer_diameter": 3.0}, "actuators.index.tip_outer_diameter"),
    ({"actuators__index__tip_outer_diameter": 17.0}, "actuators.index.tip_outer_diameter"),
    ({"actuators__index__taper": [[0.0, 0.0], [0.3, 0.6], [0.6, 0.2], [1.0, 1.0]]}, "actuators.index.taper"),
    ({"actuators__index__outer_length": 7.5}, "layers.tip"),
    ({"casting__tip": "filled afterwards"}, "layers.tip"),
])
def test_what_cannot_be_cast_names_its_parameter(adult, change, path):
    with pytest.raises(GeometryError) as error:
        actuator(changed(adult, **change), "index")
    assert (error.value.part, error.value.path) == ("actuators/index", path)


@pytest.mark.parametrize(("change", "path"), [
    ({"thread__held_back": 50.0}, "thread.held_back"),
    ({"thread__held_back": 0.5}, "thread.held_back"),
    ({"thread__pitch": 0.1}, "thread.pitch"),
])
def test_what_cannot_be_wound_names_its_parameter(adult, change, path):
    with pytest.raises(GeometryError) as error:
        thread_path(changed(adult, **change), "index")
    assert error.value.path == path


def test_every_actuator_is_there(adult):
    assert tuple(adult.actuators.present()) == FINGERS + OPPOSITION
