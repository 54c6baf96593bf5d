"""`handgen measure`: closed forms, every way in which an STL can be wrong, and the verb's exit codes."""

import json
import math

import numpy as np
import pytest
import trimesh
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import handgen
from handgen import cli
from handgen.checks.mesh_report import measure_stl
from handgen.errors import InputError
from handgen.export import stl
from handgen.geometry import csg
from handgen.geometry.mesh_kernel import CHORD, evaluate, printable, triangles
from tests.conftest import PARAMS

ACCURACY = 0.02
"""mm, the bar of wall measurement."""


def box(*size, at=(0, 0, 0)):
    made = trimesh.creation.box(size)
    made.apply_translation(at)
    return made


def turned(mesh):
    mesh.invert()
    return mesh


@pytest.fixture
def report(tmp_path):
    """The report on a trimesh, written as `kind`."""

    def measured(mesh, kind="stl"):
        content = mesh.export(file_type=kind)
        path = tmp_path / "some.stl"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        found = measure_stl(path)
        json.dumps(found, allow_nan=False)
        return found

    return measured


def of_shape(shape, path):
    path.write_bytes(stl.to_bytes(triangles(evaluate(shape))))
    return measure_stl(path)


# Closed forms


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_box(report, kind):
    found = report(box(10, 20, 30, at=(5, 0, 0)), kind)
    assert found["passed"] and found["watertight"] and found["triangles"] == 12
    assert found["format"] == ("binary" if kind == "stl" else "text")
    assert found["bbox_mm"] == [[0, -10, -15], [10, 10, 15]] and found["size_mm"] == [10, 20, 30]
    assert found["volume_mm3"] == pytest.approx(6000) and found["area_mm2"] == pytest.approx(2200)
    walls = found["thickness"]
    assert walls["least_mm"] == pytest.approx(10.0)
    # By area, two faces each: 600 mm2 are 10 mm apart, 300 are 20 mm and 200 are 30 mm.
    assert [walls["percentiles_mm"][p] for p in ("1", "50", "75", "95")] == pytest.approx([10, 10, 20, 30])
    assert walls["histogram"][-1]["area_mm2"] == pytest.approx(2200, rel=1e-3)


@pytest.mark.parametrize("wall", [0.5, 2.0])
def test_tube(tmp_path, wall):
    found = of_shape(csg.cylinder(6 + wall, 0, 20) - csg.cylinder(6, -1, 21), tmp_path / "tube.stl")
    inside, outside = 6.0, 6.0 + wall
    ring = math.pi * (outside**2 - inside**2)
    assert found["passed"] and (found["bodies"], found["voids"]) == (1, 0)
    assert found["volume_mm3"] == pytest.approx(20 * ring, rel=4 * CHORD / wall)
    assert found["area_mm2"] == pytest.approx(40 * math.pi * (inside + outside) + 2 * ring, rel=0.01)
    walls = found["thickness"]
    assert walls["least_mm"] == pytest.approx(wall, abs=ACCURACY)
    assert math.hypot(*walls["at"][1:]) == pytest.approx((inside + outside) / 2, abs=0.05)
    assert walls["percentiles_mm"]["50"] == pytest.approx(wall, abs=ACCURACY)
    # The walls of the tube in their class, its two ends facing one another in the last.
    full = [row for row in walls["histogram"] if row["area_mm2"] > 1.0]
    assert len(full) == 2
    assert all(row["from_mm"] <= size < row["to_mm"] for row, size in zip(full, (wall, 20), strict=True))
    assert full[0]["area_mm2"] == pytest.approx(40 * math.pi * (inside + outside), rel=0.05)


def test_sphere_shell(report):
    shell = trimesh.creation.icosphere(5, 10) + turned(trimesh.creation.icosphere(5, 8.5))
    found = report(shell)
    assert found["passed"] and (found["bodies"], found["voids"], found["inside_out"]) == (1, 1, 0)
    assert found["volume_mm3"] == pytest.approx(4 / 3 * math.pi * (1000 - 8.5**3), rel=0.005)
    assert found["thickness"]["least_mm"] == pytest.approx(1.5, abs=ACCURACY)
    assert found["thickness"]["percentiles_mm"]["95"] == pytest.approx(1.5, abs=ACCURACY)
    assert np.linalg.norm(found["thickness"]["at"]) == pytest.approx(9.25, abs=0.05)


@pytest.mark.parametrize("scale", [1e-30, 1e-3, 1.0, 100.0, 1e30])
def test_any_size(report, scale):
    """The gauge is set on a copy that is neither too small nor too large for it."""
    mesh = box(10, 10, 30) + turned(box(9, 9, 29))
    mesh.apply_scale(scale)
    found = report(mesh)
    assert found["thickness"]["least_mm"] == pytest.approx(0.5 * scale, rel=1e-3)
    assert found["volume_mm3"] == pytest.approx((3000 - 81 * 29) * scale**3, rel=1e-5)
    assert any("metres" in hint for hint in found["hints"]) == (scale < 0.01)


def test_far_from_the_origin(report):
    found = report(box(10, 20, 30, at=(1000, -2000, 500)))
    assert found["volume_mm3"] == pytest.approx(6000, rel=1e-4)
    assert np.abs(np.array(found["thickness"]["at"]) - (1000, -2000, 500)).max() < 15


def test_a_printed_finger_is_what_the_manifest_says(tmp_path, adult):
    from handgen.geometry.finger import exoskeleton

    part = exoskeleton(adult, "little")
    path = tmp_path / "little.stl"
    path.write_bytes(stl.to_bytes(part.triangles))
    found = handgen.measure_stl(path)
    assert found["passed"] and found["volume_mm3"] == pytest.approx(evaluate(part.shape).volume(), rel=1e-4)
    assert found["thickness"]["least_mm"] == pytest.approx(2.0, abs=ACCURACY)


# Not sound


def test_open(report):
    mesh = box(10, 20, 30)
    mesh.faces = mesh.faces[1:]
    found = report(mesh)
    assert not found["passed"] and not found["watertight"]
    assert found["edges"] == {"open": 3, "crowded": 0, "flipped": 0}
    assert found["volume_mm3"] is found["thickness"] is None and "3 edges" in found["thickness_missing"]
    assert any(np.allclose(found["fault_at"], np.mean(ends, axis=0)) for ends in mesh.vertices[mesh.edges])


def test_one_triangle_turned(report):
    mesh = box(10, 20, 30)
    mesh.faces[4] = mesh.faces[4][::-1]
    found = report(mesh)
    assert not found["passed"] and found["edges"] == {"open": 0, "crowded": 0, "flipped": 3}


def test_touching_along_an_edge(report):
    found = report(box(10, 20, 30) + box(10, 20, 30, at=(10, 20, 0)))
    assert not found["passed"] and found["edges"] == {"open": 0, "crowded": 1, "flipped": 0}
    assert found["fault_at"] == pytest.approx([5, 10, 0])
    assert found["bodies"] == 2 and "touch" in found["hints"][0]
    assert found["volume_mm3"] == pytest.approx(12000) and found["thickness"]["least_mm"] == pytest.approx(10)


@pytest.mark.parametrize(("mesh", "bodies", "voids", "inside_out", "volume", "least"), [
    (turned(box(10, 20, 30)), 1, 0, 1, 6000, 10),
    (box(10, 20, 30) + turned(box(8, 8, 8, at=(30, 0, 0))), 2, 0, 1, 6512, 8),
    (box(10, 20, 30) + turned(box(8, 8, 8)), 1, 1, 0, 5488, 1),
    (box(10, 20, 30) + turned(box(8, 8, 8)) + turned(box(2, 2, 2)), 2, 1, 1, 5496, 1),
    (box(10, 20, 30) + turned(box(8, 8, 8)) + box(2, 2, 2), 2, 1, 0, 5496, 1),
    (box(10, 20, 30) + box(4, 4, 4, at=(20, 0, 0)), 2, 0, 0, 6064, 4),
])
def test_shells(report, mesh, bodies, voids, inside_out, volume, least):
    found = report(mesh)
    assert (found["bodies"], found["voids"], found["inside_out"]) == (bodies, voids, inside_out)
    assert found["volume_mm3"] == pytest.approx(volume) and found["passed"] == (not inside_out)
    assert len(found["hints"]) == bool(inside_out)
    assert found["thickness"]["least_mm"] == pytest.approx(least)


@pytest.mark.parametrize(("vertices", "faces", "says"), [
    ([[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2], [0, 2, 1]], "flat"),
    ([[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]], "not closed"),
    ([[0, 0, 0], [9, 0, 0]], [[0, 0, 1]], "without area"),
])
def test_nothing_enclosed(report, vertices, faces, says):
    found = report(trimesh.Trimesh(vertices, faces, process=False))
    assert not found["passed"] and found["volume_mm3"] is None and says in found["thickness_missing"]


def test_no_wall_in_a_corner(report):
    corner = trimesh.Trimesh([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]],
                             [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    found = report(corner)
    assert found["passed"] and found["thickness"] is None and "face" in found["thickness_missing"]


def test_collapsed_triangles_are_counted_and_close_nothing(report):
    mesh = box(10, 20, 30)
    collapsed = trimesh.Trimesh(mesh.vertices, np.vstack([mesh.faces, [[0, 0, 1]]]), process=False)
    found = report(collapsed)
    assert found["passed"] and found["degenerate_triangles"] == 1 and found["triangles"] == 13


# No STL

BINARY = box(10, 20, 30).export(file_type="stl")
TEXT = box(10, 20, 30).export(file_type="stl_ascii").encode()


@pytest.mark.parametrize(("content", "says"), [
    (b"", "empty"),
    (BINARY[:84].replace(BINARY[80:84], bytes(4)), "no triangles"),
    (b"solid\nendsolid\n", "no triangles"),
    (BINARY[:-7], "12 triangles, 684 bytes"),
    (BINARY + b"more", "688"),
    (BINARY[:40], "40 bytes"),
    (TEXT[:-30], "endsolid"),
    (TEXT[:-300] + b"\nendsolid", "facets"),
    (TEXT.replace(b"vertex ", b"vertex x", 1), "no number"),
    (TEXT.replace(b"vertex ", b"vertex nan 1 1\n#", 1), "triangle 1"),
    (TEXT.replace(b"vertex ", b"vertex 1e99 1 1\n#", 1), "finite"),
    (BINARY[:84 + 62] + b"\x00\x00\xc0\x7f" + BINARY[84 + 66:], "triangle 2"),
    (b"schema: handgen.hand/1\n" * 9, "promises"),
    (b"solid" + BINARY[5:-1], "promises"),
])
def test_what_is_no_stl_is_refused(tmp_path, content, says):
    path = tmp_path / "some.stl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=says) as caught:
        measure_stl(path)
    assert [p.file for p in caught.value.problems] == [str(path)]


def test_a_binary_header_may_say_solid(tmp_path):
    path = tmp_path / "some.stl"
    path.write_bytes(b"solid made by another program".ljust(80) + BINARY[80:])
    assert measure_stl(path)["format"] == "binary"


def test_text_as_others_write_it(tmp_path):
    path = tmp_path / "some.stl"
    path.write_bytes(b"\xef\xbb\xbf\r\n" + TEXT.replace(b"\n", b"\r\n\t").upper())
    assert measure_stl(path)["volume_mm3"] == pytest.approx(6000)


def test_missing_file_and_folder(tmp_path):
    for path in (tmp_path / "none.stl", tmp_path):
        with pytest.raises(InputError, match="no"):
            measure_stl(path)


@settings(max_examples=120, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(st.sampled_from([BINARY, TEXT]),
       st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=6), st.integers(0, 10**6))
def test_a_damaged_file_is_measured_or_refused(tmp_path_factory, content, changes, cut):
    damaged = bytearray(content)
    for place, byte in changes:
        damaged[place % len(damaged)] = byte
    path = tmp_path_factory.getbasetemp() / "damaged.stl"
    path.write_bytes(damaged[: len(damaged) - (cut % len(damaged) if cut % 5 == 0 else 0)])
    try:
        json.dumps(measure_stl(path), allow_nan=False)
    except InputError as error:
        assert len(error.problems) == 1


# The verb


def test_the_verb(tmp_path, capsys):
    sound, holed, none = (tmp_path / f"{name}.stl" for name in ("sound", "holed", "none"))
    sound.write_bytes(BINARY)
    mesh = box(10, 20, 30)
    mesh.faces = mesh.faces[2:]
    holed.write_bytes(mesh.export(file_type="stl"))
    for path, code in ((sound, 0), (holed, 1), (none, 2)):
        assert cli.main(["measure", str(path), "--json"]) == code
        shown = capsys.readouterr()
        assert shown.err == ""
        result = json.loads(shown.out)
        assert result == measure_stl(path) if code < 2 else result["errors"][0]["file"] == str(path)
    assert {p.name for p in tmp_path.iterdir()} == {"sound.stl", "holed.stl"}


def test_the_verb_for_people(tmp_path, capsys):
    path = tmp_path / "sound.stl"
    path.write_bytes(BINARY)
    assert cli.main(["measure", str(path), "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr()
    assert shown.out == ""
    assert all(words in shown.err for words in
               ("10.00 x 20.00 x 30.00 mm", "6000 mm3", "yes", "10 mm at", "is sound"))
    assert json.loads((tmp_path / "out/measure.json").read_text()) == measure_stl(path)
    path.write_bytes(turned(box(1, 1, 1)).export(file_type="stl"))
    assert cli.main(["measure", str(path)]) == 1
    err = capsys.readouterr().err
    assert all(words in err for words in ("inside out", "metres", "is not sound"))


def test_a_wrong_file_is_no_parameter_file(capsys):
    assert cli.main(["measure", str(PARAMS / "adult.yaml"), "--json"]) == 2
    assert "STL" in json.loads(capsys.readouterr().out)["errors"][0]["message"]


def test_the_mesh_that_is_exported_is_closed(tmp_path):
    """What the kernel calls printable, `measure` calls sound."""
    shape = csg.box((0, 0, 0), (20, 16, 12)) - csg.cylinder(3, -1, 21).moved(y=8, z=6)
    path = tmp_path / "block.stl"
    path.write_bytes(stl.to_bytes(printable(evaluate(shape))))
    found = measure_stl(path)
    assert found["passed"] and found["degenerate_triangles"] == 0
    assert found["thickness"]["least_mm"] == pytest.approx(3.0, abs=ACCURACY)
