"""Loading parameter files: what is read, merged, hashed, assumed, and published as a schema."""

import json
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from hypothesis import given, settings

from handgen.errors import InputError
from handgen.geometry.profile import ActuatorProfile, FingerProfile
from handgen.parameters import derive
from handgen.parameters.load import load, merge
from handgen.parameters.schema import json_schema
from tests.strategies import ADULT, PARAMS, files, tapers, write

SHIPPED = sorted(PARAMS.glob("*.yaml"))


def text_file(folder: Path, text: str, name: str = "hand.yaml") -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def variant(folder: Path, text: str, base: str = "adult.yaml") -> Path:
    return text_file(folder, f"extends: {PARAMS / base}\n{text}")


# Shipped files


@pytest.mark.parametrize("file", SHIPPED, ids=lambda f: f.stem)
def test_shipped_files_load_under_their_own_name(file):
    loaded = load(file)
    assert loaded.hand.name == file.stem
    assert loaded.file == file
    assert len(loaded.sha256) == 64


TABLE_A1 = {
    "index": (102.5, 94.5, 20, 16, 15.5, 11.5),
    "middle": (112.5, 102.5, 20, 16, 15.5, 11.5),
    "ring": (102.5, 92.5, 20, 16, 15.5, 11.5),
    "little": (87.5, 77.5, 16, 12, 12.75, 7.75),
    "thumb": (70, 62.5, 20, 16, 15.5, 7),
}
TABLE_A2 = {
    "index": (94.5, 16, 11.5), "middle": (102.5, 16, 11.5), "ring": (92.5, 15, 10.5),
    "little": (77.5, 11, 6.75), "thumb": (62.5, 15, 6),
}


def test_the_adult_hand_carries_tables_a1_and_a2(adult):
    for name, row in TABLE_A1.items():
        f = getattr(adult.fingers, name)
        assert row == (f.outer_length, f.inner_length, f.base_outer_diameter, f.base_bore_diameter,
                       f.tip_outer_diameter, f.tip_bore_diameter)
    for name, row in TABLE_A2.items():
        a = getattr(adult.actuators, name)
        assert row == (a.outer_length, a.base_outer_diameter, a.tip_outer_diameter)
    layers = adult.layers
    assert (layers.external, layers.thread, layers.internal, layers.tip) == (1.5, 0.5, 1.5, 4)


def test_core_room_reproduces_what_the_tables_leave(adult):
    """Index and middle 4.5 mm, ring 3.5, little -0.25, thumb -1: what a 3.5 mm stack leaves at the tip."""
    room = {name: adult.layers_of(name).core_room(getattr(adult.actuators, name).tip_outer_diameter)
            for name in TABLE_A2}
    assert room == {"index": 4.5, "middle": 4.5, "ring": 3.5, "little": -0.25, "thumb": -1.0}


def test_adaptation_may_be_forbidden_where_nothing_needs_it(tmp_path):
    hand = load(variant(tmp_path, "actuators: {index: {adapt: false}, ring: {adapt: false}}\n")).hand
    assert hand.actuators.index.adapt is False


# Merging


def test_a_variant_is_three_lines(tmp_path):
    hand = load(variant(tmp_path, "name: long\nfingers: {index: {outer_length: 103}}\n")).hand
    assert hand.name == "long"
    assert hand.fingers.index.outer_length == 103
    assert hand.fingers.index.inner_length == 94.5
    assert hand.fingers.middle.outer_length == 112.5


def test_mappings_merge_lists_replace_null_removes():
    base = {"a": {"x": 1, "y": [1, 2]}, "b": {"z": 1}, "c": 3}
    assert merge(base, {"a": {"y": [3]}, "b": None, "c": {"d": 1}, "e": None}) == {
        "a": {"x": 1, "y": [3]}, "c": {"d": 1}, "e": None}
    assert base == {"a": {"x": 1, "y": [1, 2]}, "b": {"z": 1}, "c": 3}


def test_null_removes_what_is_optional(tmp_path):
    hand = load(variant(tmp_path, "opposition: null\npalm: null\nactuators: "
                                  "{opposition_1: null, opposition_2: null}\n")).hand
    assert hand.palm is None and hand.opposition is None
    assert list(hand.actuators.present()) == ["index", "middle", "ring", "little", "thumb"]


def test_extends_is_relative_to_the_file_that_says_it(tmp_path, monkeypatch):
    (tmp_path / "deep").mkdir()
    text_file(tmp_path, f"extends: {PARAMS / 'adult.yaml'}\nname: base\nlayers: {{tip: 5}}\n", "base.yaml")
    text_file(tmp_path / "deep", "extends: ../base.yaml\nname: top\n", "top.yaml")
    monkeypatch.chdir("/")
    hand = load(tmp_path / "deep" / "top.yaml").hand
    assert (hand.name, hand.layers.tip) == ("top", 5)


def test_scalars_follow_yaml_1_2(tmp_path):
    """PyYAML's own YAML 1.1 would read 010 as eight, 1e1 as a text and `on` as true."""
    hand = load(variant(tmp_path, "description: on\ncasting: {mixing_time: 010, pour_height: 1e1}\n")).hand
    assert (hand.description, hand.casting.mixing_time, hand.casting.pour_height) == ("on", 10, 10)


# Hash


def backwards(node):
    """The same data with the keys of every mapping in the opposite order."""
    return {k: backwards(v) for k, v in reversed(node.items())} if isinstance(node, dict) else node


def test_the_same_parameters_have_the_same_hash_in_any_layout(tmp_path):
    whole = load(PARAMS / "adult.yaml").sha256
    (tmp_path / "flow.yaml").write_text(json.dumps(backwards(ADULT)), encoding="utf-8")
    assert load(tmp_path / "flow.yaml").sha256 == whole
    assert load(variant(tmp_path, "")).sha256 == whole
    assert load(variant(tmp_path, "layers: {tip: 4.0}\nseal: {glue_gap: 0.1}\n")).sha256 == whole


@pytest.mark.parametrize("change", [
    "layers: {tip: 4.001}", "side: left", "seal: {glue_gap: 0.11}", "exoskeleton: {joint_fillet: 1.4}",
    "fingers: {index: {placement: {root: [78.001, 31.5, 0]}}}"])
def test_any_other_parameter_has_another_hash(change, tmp_path):
    assert load(variant(tmp_path, change)).sha256 != load(PARAMS / "adult.yaml").sha256


# Assumptions


def reasons(file: Path) -> dict[str, tuple]:
    entries = load(file).assumptions
    assert all(set(e) == {"path", "value", "reason"} and e["reason"] for e in entries)
    assert len({e["path"] for e in entries}) == len(entries)
    return {e["path"]: (e["value"], e["reason"]) for e in entries}


def test_defaults_that_no_source_gives_are_assumptions_until_a_file_gives_them(tmp_path):
    assert reasons(PARAMS / "adult.yaml")["seal.glue_gap"] == (0.1, "thin cyanoacrylate film")
    assert "seal.glue_gap" not in reasons(variant(tmp_path, "seal: {glue_gap: 0.1}\n"))
    # A default that the source does give is none.
    assert "casting.adhesive" not in reasons(PARAMS / "adult.yaml")
    assert "fingers.index.outer_length" not in reasons(PARAMS / "adult.yaml")


def test_patterns_speak_for_all_values_below(tmp_path):
    found = reasons(variant(tmp_path, """
assumed:
  fingers.*.joints.*.palmar_arc: every arc
  fingers.index.joints[1]: this one
  fingers.*.joints.*: less than this one
  fingers.thumb.placement.root: measured by eye
  fingers.*.joints: all of them
"""))
    assert found["fingers.thumb.joints[1].position"] == (
        ADULT["fingers"]["thumb"]["joints"][1]["position"], "less than this one")
    assert found["fingers.index.joints[1].position"][1] == "this one"
    assert found["fingers.index.joints[1].palmar_arc"][1] == "every arc"
    assert found["fingers.thumb.placement.root"] == (ADULT["fingers"]["thumb"]["placement"]["root"],
                                                     "measured by eye")


def test_a_variant_need_not_repeat_what_its_base_assumed_of_removed_parts(tmp_path):
    gone = "palm: null\nopposition: null\nactuators: {opposition_1: null, opposition_2: null}\n"
    found = reasons(variant(tmp_path, gone))
    assert not any(path.startswith(("palm", "opposition", "actuators.opposition")) for path in found)
    with pytest.raises(InputError, match="matches nothing"):
        load(variant(tmp_path, gone + "assumed: {palm.sections: why}\n"))


# Random files


@given(files(), files(fingers_only=True))
@settings(max_examples=25)
def test_random_files_are_valid(tmp_path_factory, whole, fingers):
    folder = tmp_path_factory.mktemp("random")
    assert load(write(whole, folder)).hand.palm is not None
    assert load(write(fingers, folder)).hand.palm is None


@given(files(fingers_only=True))
@settings(max_examples=25)
def test_what_loads_fits_by_the_curves_that_geometry_reads(tmp_path_factory, data):
    """Walls, slots and the actuator's room, sampled on the profile itself."""
    hand = load(write(data, tmp_path_factory.mktemp("random"))).hand
    for name, finger in hand.fingers.present().items():
        profile = FingerProfile(finger)
        x = np.linspace(0, finger.inner_length, 300)
        assert (profile.outer_radius(x) - profile.bore_radius(x)).min() >= 0.4
        actuator = getattr(hand.actuators, name)
        inside = ActuatorProfile(actuator, hand.layers_of(name), hand.casting.minimum_core_tip_diameter,
                                 derive.stations(actuator, finger))
        along = np.linspace(0, actuator.outer_length, 300)
        assert (profile.bore_radius(along) - inside.outer(along)).min() >= -1e-6
        slots = [(j.position - j.slot_length / 2, j.position + j.slot_length / 2) for j in finger.joints]
        assert slots[0][0] >= 1 - 1e-6 and slots[-1][1] <= finger.inner_length - 1 + 1e-6
        assert all(b[0] - a[1] >= 2 - 1e-6 for a, b in pairwise(slots))


@given(tapers())
def test_the_taper_passes_its_stations_and_never_widens(stations):
    curve = derive.monotone(100.0, 10.0, 6.0, stations)
    for place, share in stations:
        assert derive.value_at(curve, 100 * place) == pytest.approx(10 - 4 * share, abs=1e-9)
    values = [derive.value_at(curve, x / 2) for x in range(201)]
    assert all(b <= a + 1e-9 for a, b in pairwise(values))
    assert derive.value_at(curve, 0.01) == pytest.approx(10, abs=1e-3)


# Schema


@pytest.fixture(scope="module")
def validator():
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("file", SHIPPED, ids=lambda f: f.stem)
def test_shipped_files_follow_the_schema(file, validator):
    validator.validate(yaml.safe_load(file.read_text(encoding="utf-8")))


@given(files())
@settings(max_examples=5)
def test_random_files_follow_the_schema(validator, data):
    validator.validate(data)


@pytest.mark.parametrize(("data", "valid"), [
    ({"extends": "adult.yaml"}, True),
    ({"extends": "adult.yaml", "name": "x", "fingers": {"index": {"outer_length": 100}}}, True),
    ({"extends": "adult.yaml", "palm": None, "seal": {"glue_gap": None}}, True),
    ({"extends": "adult.yaml", "printing": {"tooling": {"part_support": {"plug": None}}}}, True),
    ({"extends": "adult.yaml", "fingers": {"index": {"joints": [{"name": "A"}]}}}, False),
    ({"extends": "adult.yaml", "layers": {"tip": 40}}, False),
    ({"extends": "adult.yaml", "layers": {"tpi": 4}}, False),
    ({"extends": 3}, False),
    ({"name": "x"}, False),
    ({**ADULT, "layers": {"tip": 4}}, False),
    ({**ADULT, "layers": None}, False),
    ({**ADULT, "schema": "handgen.hand/2"}, False),
])
def test_the_schema_knows_whole_files_from_variants(data, valid, validator):
    assert validator.is_valid(data) is valid


def test_every_number_of_the_schema_has_a_meaning_and_bounds(validator):
    numbers = [(name, key, p) for name, definition in validator.schema["$defs"].items()
               for key, p in definition.get("properties", {}).items() if p.get("type") == "number"]
    assert len(numbers) > 60
    for name, key, number in numbers:
        assert number["description"] and number["unit"], (name, key)
        assert number["minimum"] < number["maximum"], (name, key)


# Cost


def test_loading_is_quick_and_needs_no_numpy():
    """Of a quarter of a second Python, YAML and pydantic take 0.16 s; what is left is for the hand.

    Processor time, best of five, because other tests run beside it.
    """
    code = ("import sys, time, yaml, pydantic.fields\n"
            "class First(pydantic.BaseModel): x: float\n"
            "start = time.process_time()\n"
            "from handgen.parameters.load import load\n"
            f"load({str(PARAMS / 'adult.yaml')!r})\n"
            "print(time.process_time() - start, 'numpy' in sys.modules)")
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
            for _ in range(5)]
    assert all(run.split()[1] == "False" for run in runs)
    assert min(float(run.split()[0]) for run in runs) < 0.09
