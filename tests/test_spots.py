"""Pictures of findings: the mark is where the place is, the place is in view, every finding has one."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from handgen.builder import build, check, spotted
from handgen.builder.plan import Planned
from handgen.export import spots
from handgen.geometry import csg
from handgen.geometry.part import Part
from handgen.geometry.surface import Surface
from tests.strategies import PARAMS

SMALL = PARAMS / "thesis_finger.yaml"
GREY = (0.7, 0.7, 0.7)
CAPTION = spots.Caption("error", "error  wall.minimum  exoskeleton/bar", ("a wall",))


def bar():
    """100 x 20 x 10 mm about the origin."""
    mesh = trimesh.creation.box((100.0, 20.0, 10.0))
    return mesh.vertices, mesh.faces, GREY


def marked(path: Path, places, part=None):
    """Pixels of the mark's colour, (n, 2) x and y, below the caption of a picture."""
    spots.draw(path, part or bar(), places, "0.5 mm", CAPTION)
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    top = pixels.shape[0] - spots.HIGH
    rows, columns = np.nonzero((pixels[top:, :, 0] - pixels[top:, :, 1:].max(axis=2)) > 120)
    return np.c_[columns, rows]


def halves(mark):
    return mark[mark[:, 0] < spots.SPLIT], mark[mark[:, 0] >= spots.SPLIT]


def test_the_mark_is_where_the_place_is(tmp_path):
    """The bar fills its half to spots.FILLED; a place at 40 of 50 mm is that far from its middle."""
    one, two = (halves(marked(tmp_path / f"{x}.png", [(x, 0.0, 5.0)]))[0] for x in (-40.0, 40.0))
    apart = abs(np.median(one[:, 0]) - np.median(two[:, 0]))
    assert apart == pytest.approx(0.8 * spots.FILLED * spots.SPLIT, rel=0.15)
    for x in (-40.0, 40.0):
        _, right = halves(marked(tmp_path / f"{x}.png", [(x, 0.0, 5.0)]))
        middle = ((spots.SPLIT + 1000) / 2, spots.HIGH / 2)
        assert np.allclose((right.min(axis=0) + right.max(axis=0)) / 2, middle, atol=2.0)


def test_other_places_are_ringed_in_the_whole_part_only(tmp_path):
    place, other = (-40.0, 0.0, 5.0), (40.0, 0.0, 5.0)
    alone, both = (halves(marked(tmp_path / f"{len(p)}.png", p)) for p in ([place], [place, other]))
    assert len(both[0]) > 1.05 * len(alone[0]) and len(both[1]) == len(alone[1])


def test_without_a_place_nothing_is_marked(tmp_path):
    assert len(marked(tmp_path / "a.png", [])) == 0
    assert Image.open(tmp_path / "a.png").size[0] == 1000


def test_same_bytes_every_time(tmp_path):
    for name in "ab":
        marked(tmp_path / f"{name}.png", [(1.0, 2.0, 5.0)])
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_an_open_mesh_is_shown_too(tmp_path):
    vertices, faces, colour = bar()
    assert len(marked(tmp_path / "a.png", [(0.0, 0.0, 5.0)], (vertices, faces[1:], colour))) > 0


@pytest.mark.parametrize("place", [(50, 0, 0), (-50, 0, 0), (0, 10, 0), (0, -10, 0), (0, 0, 5), (0, 0, -5)])
def test_no_face_is_looked_at_from_behind(place):
    vertices, faces, _ = bar()
    surface = Surface(vertices, faces)
    towards = spots.side(surface, np.array(place, float)).axes()[2]
    outside = np.array(place, float) + 0.01 * np.sign(place)
    assert spots.covers(surface, outside, towards[None]) == 0


def test_covers_counts_walls():
    """From the middle of a box in a box, a viewer has two walls before him."""
    outer = trimesh.creation.box((10, 10, 10))
    inner = trimesh.creation.box((6, 6, 6))
    inner.invert()
    both = trimesh.util.concatenate([outer, inner])
    found = spots.covers(Surface(both.vertices, both.faces), np.zeros(3), np.eye(3))
    assert found.tolist() == [2, 2, 2]


def test_the_slice_shows_the_thickness_of_the_wall():
    """It looks along the wall, so that the wall's normal lies in the picture."""
    tube = trimesh.creation.annulus(8.0, 10.0, 60.0, sections=64)
    surface = Surface(tube.vertices, tube.faces)
    for angle in np.linspace(0.1, 6.0, 7):
        normal = np.array([np.cos(angle), np.sin(angle), 0.0])
        towards = spots.across(surface, 9.9 * normal).axes()[2]
        assert abs(towards @ normal) < 0.06 and abs(towards[2]) > 0.99
    slope = trimesh.transformations.rotation_matrix(0.5, (0, 1, 0))
    plank = trimesh.creation.box((100.0, 20.0, 10.0), slope)
    surface, normal = Surface(plank.vertices, plank.faces), slope[:3, 2]
    assert abs(spots.across(surface, 5.0 * normal).axes()[2] @ normal) < 1e-9


# Every finding


def found(number, severity="error", part="exoskeleton/bar", where=(1.0, 2.0, 3.0), rule="wall.minimum"):
    return {"rule": rule, "severity": severity, "part": part, "measured": number, "limit": 1.0, "unit": "mm",
            "where": list(where) if where else None, "message": f"no {number}", "fix": "mend", "source": "us"}


def planned(*names):
    return [Planned(Part(name, "exoskeleton", "TPU", csg.box((0, 0, 0), (1, 1, 1)), GREY, ""), "key", {})
            for name in names]


def test_errors_first_and_numbered_as_in_the_report():
    findings = [found(1, "info"), found(2, "warning"), found(3), found(4, part="not/made"), found(5)]
    files = [view.file for view in spotted.views({"findings": findings}, planned("exoskeleton/bar"))]
    assert files == [f"previews/{n:02d}_wall.minimum_exoskeleton_bar.png" for n in (3, 5, 2)]


def test_places_of_the_same_rule_in_the_same_part_are_shown_with_it():
    findings = [found(1, where=(1, 1, 1)), found(2, where=(2, 2, 2)), found(3, rule="print.overhang"),
                found(4, where=None), found(5, "info", where=(5, 5, 5))]
    places = [view.make.args[1] for view in spotted.views({"findings": findings}, planned("exoskeleton/bar"))]
    assert places == [((1, 1, 1), (2, 2, 2)), ((2, 2, 2), (1, 1, 1)), ((1.0, 2.0, 3.0),), ()]


def test_a_part_that_is_wrong_all_over_has_an_end():
    many = {"findings": [found(n) for n in range(3 * spotted.MOST)]}
    assert len(spotted.views(many, planned("exoskeleton/bar"))) == spotted.MOST


def test_the_key_sees_place_words_and_part():
    (one,) = planned("exoskeleton/bar")
    keys = {spotted.views({"findings": [f]}, [p])[0].key
            for f, p in ((found(1), one), (found(2), one), (found(1, where=(9, 9, 9)), one),
                         (found(1), Planned(one.part, "other", {})))}
    assert len(keys) == 4


def variant(tmp_path, text):
    path = tmp_path / "variant.yaml"
    path.write_text(f"schema: handgen.hand/1\nextends: {SMALL}\n{text}")
    return path


def pictured(findings):
    """Names that the pictures of a report must have."""
    return {f"{i:02d}_{f['rule']}_{f['part'].replace('/', '_')}.png"
            for i, f in enumerate(findings, 1) if f["severity"] in ("error", "warning")}


def test_check_pictures_every_finding(tmp_path):
    """And a later check takes away what is no longer found."""
    path = variant(tmp_path, "name: tiny\nprinting: {build_volume: [60, 60, 60]}\n")
    result = check(path, out=tmp_path / "out")
    shown = {p.name for p in (tmp_path / "out/checks/previews").iterdir()}
    assert shown == pictured(result["checks"]["findings"]) and len(shown) >= 5
    check(SMALL, out=tmp_path / "out")
    assert not {p.name for p in (tmp_path / "out").rglob("*print.build-volume*")}


def test_check_without_opengl_still_reports(tmp_path, monkeypatch):
    monkeypatch.setattr(spotted, "_drawn", _cannot_draw)
    said = []
    path = variant(tmp_path, "name: tiny\nprinting: {build_volume: [60, 60, 60]}\n")
    result = check(path, out=tmp_path / "out", progress=said.append)
    assert not result["passed"] and json.loads((tmp_path / "out/checks/checks.json").read_text())
    assert not list(tmp_path.rglob("*.png"))
    assert any("warning" in line and "libegl1" in line for line in said)


def _cannot_draw(*arguments):
    from handgen.errors import EngineError

    raise EngineError("no OpenGL to draw with")


def test_a_build_that_passes_pictures_its_warnings(tmp_path):
    """They belong to the build: listed, kept while nothing changes, gone with their finding."""
    thick = "actuators: {index: {outer_length: 75}}\n"
    path = variant(tmp_path, thick)
    out = tmp_path / "out"
    result = build(path, out=out, parts=["exoskeleton", "actuators"])
    assert result["passed"]
    names = pictured(result["checks"]["findings"])
    assert names == {p.name for p in (out / "previews/findings").iterdir()} != set()
    assert {f"previews/findings/{n}" for n in names} <= set(result["manifest"]["files"])
    before = {p: p.stat().st_mtime_ns for p in out.rglob("*.png")}
    assert build(path, out=out, parts=["exoskeleton", "actuators"]) == result
    assert before == {p: p.stat().st_mtime_ns for p in out.rglob("*.png")}
    path.write_text(path.read_text().replace(thick, ""))
    again = build(path, out=out, parts=["exoskeleton", "actuators"])
    gone = names - pictured(again["checks"]["findings"])
    assert gone and not any((out / "previews/findings" / n).exists() for n in gone)
