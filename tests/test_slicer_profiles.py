"""Profiles as files: one source of truth, and what each slicer's words must say."""

import configparser
import io
import json
import zipfile

import pytest

from handgen import cli
from handgen.errors import EngineError
from handgen.slicing import cura, engines, gcode, profile_files, prusaslicer
from handgen.slicing.definitions import RESOURCES, Definitions
from handgen.slicing.printer import HEPHESTOS
from handgen.slicing.profile import profile, profiles
from tests.conftest import PARAMS
from tests.sliced import needs_slicers

COMMITTED = PARAMS.parent / profile_files.FOLDER
MADE_WITH = "4.13.0"
"""Cura whose formulas stand in the files for CuraEngine."""


# One source of truth


def test_committed_profiles_are_those_of_the_adult_hand(adult):
    for path, content in profile_files.contents(adult).items():
        assert (COMMITTED / path).read_bytes() == content, f"{path}: run `make profiles`"


@needs_slicers
def test_committed_settings_of_the_engine_are_those_of_the_adult_hand(adult):
    if engines.version(engines.CURA) != MADE_WITH:
        pytest.skip(f"the formulas are Cura {MADE_WITH}'s")
    files = profile_files.engine_contents(adult)
    for path, content in files.items():
        assert (COMMITTED / path).read_bytes() == content, f"{path}: run `make profiles`"


@needs_slicers
def test_no_profile_lies_there_that_nothing_writes(adult):
    written = {*profile_files.contents(adult), *profile_files.engine_contents(adult), "README.md"}
    assert {str(p.relative_to(COMMITTED)) for p in COMMITTED.rglob("*") if p.is_file()} == written


@needs_slicers
def test_profiles_are_written_where_asked(tmp_path, capsys):
    assert cli.main(["profiles", str(PARAMS / "adult.yaml"), "--out", str(tmp_path), "--json"]) == 0
    files = json.loads(capsys.readouterr().out)["files"]
    assert len(files) == len(set(files)) == sum(p.is_file() for p in tmp_path.rglob("*"))


# Table B.1 and its notes


def test_the_profiles_are_table_b1_with_its_notes(adult):
    found = {one.name: one for one in profiles(adult)}
    rows = {name: (one.process.material, one.process.nozzle_temperature, one.process.nozzle_size,
                   one.process.speed, one.process.infill_pattern, one.process.infill_density,
                   one.process.layer_height, one.adhesion, one.process.flow, one.support,
                   one.process.retraction, one.process.heated_bed) for name, one in found.items()}
    pla = ("PLA", 210, 0.35, 40, "grid", 20, 0.2)
    assert rows == {
        "finger": ("Filaflex 82A", 235, 0.35, 30, "concentric", 100, 0.2, "brim", 105, "none", False, None),
        "hand": ("Ninjaflex", 240, 0.35, 20, "concentric", 100, 0.1, "none", 105, "touching build plate",
                 False, None),
        "tooling-raft": (*pla, "raft", 100, "none", True, None),
        "tooling-raft-support": (*pla, "raft", 100, "touching build plate", True, None),
        "tooling-brim": (*pla, "brim", 100, "none", True, None),
    }
    notes = {role: profile(adult.printing, "tooling", role).name for role in (
        "mould_a", "mould_b", "mould_base", "core_large", "core_small", "suspender", "plug", "collar")}
    assert list(notes.values()) == ["tooling-raft"] * 3 + ["tooling-raft-support"] * 2 + ["tooling-brim"] * 3


# PrusaSlicer's words


def test_prusaslicers_threshold_counts_from_the_horizontal(adult):
    hand = profile(adult.printing, "hand", "exoskeleton")
    assert prusaslicer.presets(hand, HEPHESTOS).print["support_material_threshold"] == 20
    assert cura.settings(hand)["support_angle"] == 70


def test_the_flat_file_is_flat_and_the_bundle_is_in_sections(adult):
    hand = profile(adult.printing, "hand", "exoskeleton")
    assert not any(line.startswith("[") for line in prusaslicer.flat(hand, HEPHESTOS).splitlines())
    bundle = configparser.ConfigParser(interpolation=None)
    bundle.read_string((COMMITTED / profile_files.BUNDLE).read_text())
    kinds = [name.split(":")[0] for name in bundle.sections()]
    assert [kinds.count(kind) for kind in ("print", "filament", "printer", "presets")] == [5, 3, 2, 1]
    first = bundle["presets"]
    assert all(f"{kind}:{first[kind]}" in bundle for kind in ("print", "filament", "printer"))
    # What a window loads as three presets is what the command line loads as one file.
    names = f"print:{hand.title}", "filament:handgen Ninjaflex", "printer:handgen BQ Hephestos 2 0.35 mm"
    whole = {key: value for name in names for key, value in bundle[name].items()}
    lines = (line.partition(" = ") for line in prusaslicer.flat(hand, HEPHESTOS).splitlines())
    assert whole == {key: value for key, _, value in lines}


@needs_slicers
def test_prusaslicer_knows_every_key(adult, tmp_path):
    import subprocess

    saved = tmp_path / "saved.ini"
    for one in profiles(adult):
        file = tmp_path / f"{one.name}.ini"
        file.write_text(prusaslicer.flat(one, HEPHESTOS))
        subprocess.run(["prusa-slicer", "--load", str(file), "--save", str(saved)], check=True,
                       capture_output=True)
        kept = dict(line.split(" = ", 1) for line in saved.read_text().splitlines() if " = " in line)
        asked = dict(line.split(" = ", 1) for line in file.read_text().splitlines())
        assert asked.keys() <= kept.keys()


# Cura's words


def test_a_cura_profile_is_a_zip_of_settings(adult):
    hand = profile(adult.printing, "hand", "exoskeleton")
    with zipfile.ZipFile(io.BytesIO(cura.curaprofile(hand))) as archive:
        parts = [configparser.ConfigParser(interpolation=None) for _ in archive.namelist()]
        for part, name in zip(parts, archive.namelist(), strict=True):
            part.read_string(archive.read(name).decode())
    machine, extruder = parts
    assert machine["values"]["layer_height"] == "0.1" and extruder["metadata"]["position"] == "0"
    merged = {**machine["values"], **extruder["values"]}
    assert merged == {key: str(value) for key, value in cura.settings(hand).items()}


@needs_slicers
def test_cura_knows_every_setting_and_its_place_and_range(adult):
    known = Definitions(HEPHESTOS.definition, HEPHESTOS.extruder).settings
    for one in profiles(adult):
        for key, value in cura.settings(one).items():
            facts = known[key]
            assert (key in cura.GLOBAL) == (facts.get("settable_per_extruder") is False), key
            if facts["type"] == "enum":
                assert value in facts["options"], key


# The formulas


def _definitions(folder, settings, overrides=()):
    (folder / "definitions").mkdir(parents=True)
    (folder / "extruders").mkdir()
    base = {"settings": {"speed": {"type": "category", "children": settings}}}
    (folder / "definitions" / "base.def.json").write_text(json.dumps(base))
    (folder / "definitions" / "machine.def.json").write_text(
        json.dumps({"inherits": "base", "overrides": dict(overrides)}))
    (folder / "extruders" / "tool.def.json").write_text(json.dumps(
        {"settings": {"machine_nozzle_size": {"type": "float", "default_value": 0.4}}}))
    return Definitions("machine", "tool", folder)


def test_what_a_formula_names_follows(tmp_path):
    found = _definitions(tmp_path, {
        "speed_print": {"type": "float", "default_value": 60, "children": {
            "speed_wall": {"type": "float", "default_value": 30, "value": "speed_print / 2", "children": {
                "speed_wall_x": {"type": "float", "default_value": 60, "value": "speed_wall * 2"}}}}},
        "line": {"type": "float", "default_value": 0.4,
                 "value": "max(extruderValues('machine_nozzle_size')) if speed_print < 50 else math.pi"},
        "fixed": {"type": "float", "default_value": 1},
    }, {"fixed": {"value": "resolveOrValue('speed_wall') + int(defaultExtruderPosition())"}})
    assert found.resolve({"speed_print": 20}) == {
        "speed_print": 20, "speed_wall": 10, "speed_wall_x": 20, "line": 0.4, "fixed": 10,
        "machine_nozzle_size": 0.4}
    assert found.resolve({"speed_wall": 7})["speed_wall_x"] == 14
    with pytest.raises(EngineError, match="knows no speed_wal"):
        found.resolve({"speed_wal": 3})


def test_formulas_that_cannot_be_worked_out_are_named(tmp_path):
    circle = _definitions(tmp_path / "a", {"a": {"type": "float", "value": "b"},
                                           "b": {"type": "float", "value": "a"}})
    with pytest.raises(EngineError, match="a -> b -> a"):
        circle.resolve({})
    wrong = _definitions(tmp_path / "b", {"a": {"type": "float", "value": "open('/etc/passwd')"}})
    with pytest.raises(EngineError, match="formula for a"):
        wrong.resolve({})
    with pytest.raises(EngineError, match=r"none\.def\.json is missing.*apt install cura"):
        Definitions("none", "tool", tmp_path / "a")


@needs_slicers
def test_cura_itself_would_print_walls_slower(adult):
    """Its definitions halve the speed of walls; the profiles have one speed, as the table does."""
    known = Definitions(HEPHESTOS.definition, HEPHESTOS.extruder, RESOURCES)
    assert known.resolve({"speed_print": 20})["speed_wall_0"] == 10
    hand = profile(adult.printing, "hand", "exoskeleton")
    resolved = cura.resolved(hand, HEPHESTOS)
    speeds = {key: resolved[key] for key in resolved if key.startswith("speed_") and "travel" not in key}
    own = {"speed_z_hop", "speed_slowdown_layers", "speed_equalize_flow_enabled", "speed_equalize_flow_max"}
    assert {key for key, value in speeds.items() if value != 20} <= own


# Reading G-code

GCODE = """;FLAVOR:Marlin
M104 S210
M190 S0
M109 S210
G28 ; home
G90
M82
G92 E0
;LAYER:0
;TYPE:SKIRT
G0 F7200 X10 Y10 Z0.2
G1 F2400 X20 Y10 E1
G1 F1500 E-1
;TYPE:WALL-OUTER
G0 F7200 X0 Y0 ; a way
G1 F1500 E1
G1 F1200 X3 Y4 E1.5
G1 X3 Y4 E1.6
G92 E0
G1 X6 Y8 E0.5
M83
;TYPE:FILL
G1 X6 Y9 E0.25
G91
G1 X1 Z0.2 E0.25
G90
M104 S0
"""


def test_gcode_is_read_line_by_line(tmp_path):
    file = tmp_path / "a.gcode"
    file.write_text(GCODE)
    path = gcode.read(file)
    assert path.kind.tolist() == [gcode.ADHESION, gcode.OUTER, gcode.OUTER, gcode.INFILL, gcode.INFILL]
    assert path.length == pytest.approx([10, 5, 5, 1, 1])
    assert path.filament == pytest.approx([1, 0.5, 0.5, 0.25, 0.25])
    assert path.feed == pytest.approx([40, 20, 20, 20, 20])
    assert path.z.tolist() == [0.2, 0.2, 0.2, 0.2, 0.4] and path.heights.tolist() == [0.2, 0.4]
    assert path.retractions.tolist() == [2.0]
    assert path.pushed == pytest.approx(1 - 2 + 2 + 0.6 + 0.5 + 0.5)
    assert (path.nozzle, path.bed) == ({210.0}, set())


def test_gcode_of_another_kind_is_refused(tmp_path):
    file = tmp_path / "a.gcode"
    file.write_text("G28\nG1 X1\n")
    with pytest.raises(EngineError, match="draws nothing"):
        gcode.read(file)
    file.write_text(";TYPE:WIPE-TOWER\n")
    with pytest.raises(EngineError, match="unknown type 'WIPE-TOWER'"):
        gcode.read(file)
