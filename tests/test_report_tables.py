"""The page's tables and files: dimensions as measured, times, what was adapted and assumed, downloads."""

import csv
import html
import io
import json
from dataclasses import replace

import numpy as np
import pytest
import yaml

from handgen.builder import jobs
from handgen.builder.survey import Survey, Surveyed
from handgen.export import stl
from handgen.geometry.actuator import adaptations
from handgen.geometry.catalogue import catalogue
from handgen.geometry.measure import measure, read_stl
from handgen.geometry.mesh_kernel import Triangles
from handgen.parameters.load import load
from handgen.report import dimensions, downloads, making, sections
from handgen.slicing import files
from handgen.slicing.slice import asked_key
from tests.small_report import report
from tests.strategies import PARAMS

HAND = "exoskeleton/hand"
PARTS = ("exoskeleton/index", "exoskeleton/thumb", "actuators/index", "actuators/little", "actuators/thumb")
TABLE = {  # Tables A.1 and A.2
    "exoskeleton/index": (102.5, 94.5, 20, 16, 15.5, 11.5), "exoskeleton/thumb": (70, 62.5, 20, 16, 15.5, 7),
    "actuators/index": (94.5, 16, 11.5, 3.5, 4), "actuators/little": (77.5, 11, 6.75, 3.5, 4),
    "actuators/thumb": (62.5, 15, 6, 3.5, 4)}


def surveyed(loaded, names, stage):
    listed, parts = catalogue(loaded.hand), {}
    for name in names:
        jobs.mesh(listed[name], stage, {})
        path = stage / f"{name}.stl"
        parts[name] = Surveyed(listed[name], path, measure(read_stl(path.read_bytes())))
    return Survey(loaded, parts, report([]), None, {name: listed[name].key for name in names})


@pytest.fixture(scope="module")
def adult(tmp_path_factory):
    return surveyed(load(PARAMS / "adult.yaml"), PARTS, tmp_path_factory.mktemp("adult"))


def measured(survey, name):
    part, kind, of = survey.parts[name], *name.split("/")
    hand = survey.loaded.hand
    if kind == "actuators":
        return dimensions.measured_actuator(part)
    return dimensions.measured_finger(part, getattr(hand.fingers, of), hand.exoskeleton.joint_fillet)


@pytest.mark.parametrize("name", PARTS)
def test_dimensions_as_built_are_those_of_the_source(adult, name):
    assert tuple(measured(adult, name).values()) == pytest.approx(TABLE[name], abs=0.02)


def test_a_curled_finger_measures_as_along_its_axis(tmp_path):
    survey = surveyed(load(PARAMS / "thesis_hand.yaml"), PARTS[:1], tmp_path)
    assert tuple(measured(survey, PARTS[0]).values()) == pytest.approx(TABLE[PARTS[0]], abs=0.02)


def test_a_finger_on_its_own_stands_beside_the_prototype(tmp_path):
    """Section 4.1.1 tells another finger than Table A.1's index."""
    survey = surveyed(load(PARAMS / "thesis_finger.yaml"), ("exoskeleton/index", "actuators/index"), tmp_path)
    found = dimensions.dimensions(survey)
    assert {each.where for each in found} == {"Section 4.1.1"}
    assert {each.name for each in found if each.source is None} == {"wall", "tip"}
    assert all(each.measured == pytest.approx(each.source, abs=0.02) for each in found if each.source)


def test_dimensions_are_the_meshes_and_not_the_definitions(adult, tmp_path):
    """Of a mesh that was blown up by 1 % all are 1 % larger."""
    part = adult.parts["actuators/index"]
    vertices, faces = jobs.welded(part.stl)
    path = tmp_path / "larger.stl"
    path.write_bytes(stl.to_bytes(Triangles(np.float32(1.01 * vertices), faces)))
    found = dimensions.measured_actuator(replace(part, stl=path))
    assert tuple(found.values()) == pytest.approx([1.01 * v for v in TABLE["actuators/index"]], abs=0.02)


def row(**values):
    return dimensions.Dimension(**{"what": "actuators/index", "name": "wall", "measured": 3.5, "asked": 3.5,
                                   "source": 3.5, "where": "Table A.2"} | values)


@pytest.mark.parametrize(("values", "marked", "words"), [
    ({}, False, "source 3.5<"), ({"measured": 3.2}, True, "source 3.5, asked 3.5<"),
    ({"measured": 3.0, "asked": 3.0}, True, "source 3.5<"), ({"source": None}, False, "source &ndash;<")])
def test_what_leaves_source_or_request_is_marked(values, marked, words):
    shown = sections.dimensions([row(**values)])
    assert ('class="warning"' in shown) is marked
    assert words in shown


def test_everything_adapted_and_assumed_is_told(adult):
    shown = html.unescape(sections.adapted(adult))
    for each in adaptations(adult.loaded.hand):
        assert each.path in shown and each.reason in shown
    assert adult.loaded.assumptions
    for each in adult.loaded.assumptions:
        assert f"{each['path']} = {each['value']}" in shown and each["reason"] in shown


def test_downloads_hold_what_they_say(adult, tmp_path):
    found = downloads.downloads(adult, {}, [row()])
    assert found["file"]["text"] == (PARAMS / "adult.yaml").read_text(encoding="utf-8")
    assert json.loads(found["checks"]["text"]) == adult.report
    [line] = csv.DictReader(io.StringIO(found["dimensions"]["text"]))
    assert (line["part"], line["measured_mm"], line["source_mm"]) == ("actuators/index", "3.5", "3.5")
    parts = list(csv.DictReader(io.StringIO(found["parts"]["text"])))
    assert [line["part"] for line in parts] == list(PARTS)
    assert float(parts[0]["volume_mm3"]) == pytest.approx(adult.parts[PARTS[0]].facts.volume_mm3, abs=0.01)


def test_the_whole_file_is_the_same_hand(adult, tmp_path):
    found = downloads.downloads(adult, {}, [])["whole"]
    path = tmp_path / found["name"]
    path.write_text(found["text"], encoding="utf-8")
    assert "extends" not in yaml.safe_load(found["text"])
    assert load(path).sha256 == adult.loaded.sha256


def test_times_of_a_slicer_stand_beside_the_sources_while_they_hold(adult, tmp_path):
    hand = adult.loaded.hand
    part = catalogue(hand)[HAND]
    whole = replace(adult, parts={HAND: replace(adult.parts[PARTS[0]], part=part)})
    key = asked_key(hand, part)
    line = {"part": HAND, "slicer": "cura", "gcode": "x", "sha256": "s", "key": "k",
            "print_time_s": 3600 * 47.25, "filament_g": 123.4, "layers": 5}
    assert making.UNSLICED in making.section(whole, tmp_path).replace("&#x27;", "'")
    for asked, known in ((key, True), ("of other parameters", False)):
        files.Slices(tmp_path).write([line | {"asked": asked}])
        shown = making.section(whole, tmp_path)
        assert ("47.2" in shown and "123.4" in shown) is known
