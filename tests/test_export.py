"""What is written, read back by other programs' readers."""

import itertools
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from handgen.builder import jobs
from handgen.errors import GeometryError
from handgen.export import glb, manifest, preview, step, stl, threemf
from handgen.geometry import csg
from handgen.geometry.measure import measure, read_stl
from handgen.geometry.part import Body, Part

RED, BLUE = (0.8, 0.1, 0.2), (0.1, 0.3, 0.9)


def part(shape, **more):
    return Part("tooling/x/block", "block", "PLA", shape, RED, "seal.plug_length", **more)


def facts(mesh):
    return measure(np.asarray(mesh.vertices, np.float32)[mesh.faces])


# The mesh


@pytest.mark.parametrize("mesh", [
    trimesh.creation.icosphere(subdivisions=3, radius=7.0),
    trimesh.creation.annulus(3.0, 8.0, 20.0).apply_translation((400.0, -300.0, 7.0)),
])
def test_measure_agrees_with_trimesh(mesh):
    found = facts(mesh)
    assert found.volume_mm3 == pytest.approx(mesh.volume, rel=1e-5)
    assert found.area_mm2 == pytest.approx(mesh.area, rel=1e-5)
    assert np.allclose(found.bbox_mm, mesh.bounds, atol=1e-4)
    assert found.watertight and found.faults() == []


def test_measure_finds_every_fault():
    sound = trimesh.creation.box((4, 5, 6))
    v, f = sound.vertices, sound.faces
    missing = trimesh.Trimesh(v, f[1:], process=False)
    flipped = trimesh.Trimesh(v, np.vstack([f[:1, ::-1], f[1:]]), process=False)
    inside_out = trimesh.Trimesh(v, f[:, ::-1], process=False)
    two = trimesh.util.concatenate([sound, sound.copy().apply_translation((9, 0, 0))])
    twice = trimesh.Trimesh(v, np.vstack([f, f]), process=False)
    collapsed = trimesh.Trimesh(v, np.vstack([f, [[0, 1, 1]]]), process=False)
    needle = trimesh.Trimesh(np.vstack([v, (v[f[0, 0]] + v[f[0, 1]]) / 2]),
                             np.vstack([f, [[f[0, 0], f[0, 1], 8]]]), process=False)
    touching = trimesh.util.concatenate([sound, sound.copy().apply_translation((4, 5, 0))])
    assert facts(sound).faults() == []
    for mesh, words in ((missing, "3 edges"), (flipped, "edges have no partner"), (inside_out, "inside out"),
                        (two, "2 bodies"), (twice, "edges have no partner"), (collapsed, "without area"),
                        (needle, "without area"), (touching, "edges have no partner")):
        assert any(words in fault for fault in facts(mesh).faults()), words


def test_cut_short_stl_is_not_read():
    content = stl.to_bytes(trimesh.creation.box((1, 2, 3)))
    with pytest.raises(ValueError, match="binary STL"):
        read_stl(content[:-1])


def test_stl_reads_back(tmp_path):
    mesh = part(csg.box((0, 0, 0), (10, 20, 30)) - csg.cylinder(3, -1, 11)).mesh
    (tmp_path / "a.stl").write_bytes(stl.to_bytes(mesh))
    read = trimesh.load(tmp_path / "a.stl")
    assert read.is_watertight and read.volume == pytest.approx(mesh.volume, rel=1e-9)
    corners = (tmp_path / "a.stl").read_bytes()[84:].__len__() // 50
    assert corners == len(mesh.faces)
    assert not (tmp_path / "a.stl").read_bytes().startswith(b"solid")
    stored = np.frombuffer((tmp_path / "a.stl").read_bytes()[84:], "V50").view("u1").reshape(-1, 50)
    normals = stored[:, :12].copy().view("<f4")
    assert np.allclose(normals, mesh.face_normals, atol=1e-5)


# 3MF


def test_3mf_is_one_clean_object_in_millimetres(tmp_path):
    import lib3mf

    mesh = part(csg.cylinder(5, 0, 12) - csg.cylinder(2, -1, 13)).mesh
    content = threemf.to_bytes(mesh, 'a <hand> & "co"', "Ninja & flex", RED)
    assert content == threemf.to_bytes(mesh, 'a <hand> & "co"', "Ninja & flex", RED)
    (tmp_path / "a.3mf").write_bytes(content)
    wrapper = lib3mf.get_wrapper() if hasattr(lib3mf, "get_wrapper") else lib3mf.Wrapper()
    model = wrapper.CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "a.3mf"))
    assert reader.GetWarningCount() == 0
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    objects, items = model.GetMeshObjects(), model.GetBuildItems()
    assert objects.Count() == items.Count() == 1
    objects.MoveNext()
    body = objects.GetCurrentMeshObject()
    assert body.GetName() == 'a <hand> & "co"'
    assert body.IsManifoldAndOriented() and body.IsValid()
    points = np.array([list(v.Coordinates) for v in body.GetVertices()])
    faces = np.array([list(t.Indices) for t in body.GetTriangleIndices()])
    assert np.array_equal(points.astype(np.float32), mesh.vertices.astype(np.float32))
    assert np.array_equal(faces, mesh.faces)


# GLB


def test_glb_has_named_coloured_nodes_in_metres(tmp_path):
    ball, box = trimesh.creation.icosphere(radius=20.0), trimesh.creation.box((10, 20, 60))
    content = glb.to_bytes("hand", [("ball", ball.vertices, ball.faces, RED),
                                    ("box", box.vertices, box.faces, BLUE)])
    (tmp_path / "a.glb").write_bytes(content)
    scene = trimesh.load(tmp_path / "a.glb")
    assert set(scene.graph.nodes_geometry) == {"ball", "box"}
    # z dorsal is up, and up is y in glTF.
    assert np.allclose(scene.bounds[1] - scene.bounds[0], (0.04, 0.06, 0.04), atol=1e-3)
    placed = scene.geometry["ball"].copy().apply_transform(scene.graph.get("ball")[0])
    assert placed.volume == pytest.approx(ball.volume * 1e-9, rel=1e-5)
    colour = scene.geometry["box"].visual.material.baseColorFactor[:3] / 255
    assert np.allclose(colour, [((c + 0.055) / 1.055) ** 2.4 for c in BLUE], atol=0.003)


# STEP


def bodies():
    return part(csg.box((0, 0, 0), (1, 2, 3)), bodies=(
        Body("shell", csg.box((0, 0, 0), (10, 10, 10)), RED),
        Body("core", csg.cylinder(2, 20, 30), BLUE),
        Body("cap", csg.box((0, 0, 20), (3, 3, 23)), RED),
    )).solids()


def test_step_reads_back_with_names_colours_and_volumes(tmp_path):
    import cadquery

    step.write(tmp_path / "a.step", "assembled", bodies())
    read = cadquery.Assembly.importStep(str(tmp_path / "a.step"))
    assert read.name == "assembled"
    assert [child.name for child in read.children] == ["shell", "core", "cap"]
    for child, colour in zip(read.children, (RED, BLUE, RED), strict=True):
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
        shown = child.color.toTuple()[:3]
        assert np.allclose(shown, colour, atol=0.01) or np.allclose(shown, linear, atol=0.01)
    volumes = [child.obj.Volume() for child in read.children]
    assert volumes == pytest.approx([1000.0, np.pi * 40, 27.0], rel=1e-6)


def test_step_of_one_body_carries_its_name(tmp_path):
    import cadquery

    step.write(tmp_path / "a.step", "plug", bodies()[1:2])
    text = (tmp_path / "a.step").read_text()
    assert text.count("PRODUCT(") == 1 and "PRODUCT('core','core'" in text and ".MILLI.,.METRE." in text
    assert text.count("STYLED_ITEM(") == 1
    assert cadquery.importers.importStep(str(tmp_path / "a.step")).val().Volume() == pytest.approx(np.pi * 40)


def test_step_is_the_same_in_any_order_and_process(tmp_path):
    """OCCT counts assemblies per process and orders colours by address; neither may show."""
    code = ("import sys; from pathlib import Path; from handgen.export import step\n"
            "from tests.test_export import bodies\n"
            "for i in range(int(sys.argv[2])): step.write(Path(sys.argv[1]), 'other', bodies())\n"
            "step.write(Path(sys.argv[1]), 'assembled', bodies())")
    written = set()
    for count in (0, 3):
        path = tmp_path / f"{count}.step"
        subprocess.run([sys.executable, "-c", code, path, str(count)], check=True)
        written.add(path.read_bytes())
    step.write(tmp_path / "here.step", "assembled", bodies())
    written.add((tmp_path / "here.step").read_bytes())
    assert len(written) == 1


# A part's files


def made(block, stage, extra=None):
    meshed = jobs.mesh(block, stage, extra or {})
    return meshed, jobs.solid(block, stage, meshed)


def test_disagreeing_kernels_write_nothing(tmp_path):
    """A B-rep that is 1 % off is refused, and the message says where to look."""
    box = csg.box((0, 0, 0), (10, 10, 10))
    wrong = part(box, bodies=(Body("block", csg.box((0, 0, 0), (10, 10, 10.1)), RED),))
    with pytest.raises(GeometryError, match=r"disagree: 1000\.00 and 1010\.00") as caught:
        made(wrong, tmp_path)
    assert (caught.value.part, caught.value.path) == ("tooling/x/block", "seal.plug_length")
    assert not list(tmp_path.rglob("*.step"))


def test_a_part_in_two_pieces_is_refused(tmp_path):
    apart = part(csg.box((0, 0, 0), (1, 1, 1)) + csg.box((2, 0, 0), (3, 1, 1)))
    with pytest.raises(GeometryError, match="2 bodies"):
        made(apart, tmp_path)
    assert not list(tmp_path.rglob("*.step"))


def test_make_reports_what_it_wrote(tmp_path):
    meshed, solid = made(part(csg.box((0, 0, 0), (1, 2, 3))), tmp_path, {"_thread.csv": b"x\n"})
    files = meshed.files | solid.files
    assert set(files) == {f"tooling/x/block{e}" for e in (".stl", ".step", "_thread.csv")}
    assert solid.volume_mm3 == pytest.approx(6.0)
    row = manifest.entry(part(csg.box((0, 0, 0), (1, 2, 3))), "key", meshed.facts, 6.0, files)
    assert row["files"] == {"stl": "tooling/x/block.stl", "step": "tooling/x/block.step",
                            "thread": "tooling/x/block_thread.csv"}
    assert row["bbox_mm"] == [[0, 0, 0], [1, 2, 3]] and row["volume_mm3"] == pytest.approx(6.0)


def test_part_keys_see_every_change():
    one = part(csg.box((0, 0, 0), (1, 2, 3)))
    others = [replace(one, up=(1.0, 0.0, 0.0)), replace(one, material="TPU"), replace(one, colour=BLUE),
              replace(one, shape=csg.box((0, 0, 0), (1, 2, 3.001)))]
    keys = [p.key for p in (one, *others)]
    assert all(a != b for a, b in itertools.combinations(keys, 2))


# Previews


def test_preview_shows_its_cells(tmp_path):
    from PIL import Image

    ball = trimesh.creation.icosphere(subdivisions=3, radius=10.0)
    cells = [preview.Cell("red", ((ball.vertices, ball.faces, RED),)),
             preview.Cell("blue", ((ball.vertices + np.array([500, 0, 0]), ball.faces, BLUE),))]
    camera = preview.Camera((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for name in ("a", "b"):
        preview.draw(tmp_path / f"{name}.png", cells, camera, 2)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    pixels = np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).astype(int)
    left, right = np.array_split(pixels, 2, axis=1)
    reddish = (pixels[..., 0] - pixels[..., 2] > 60).sum() / left[..., 0].size
    for half, channel, other in ((left, 0, 2), (right, 2, 0)):
        coloured = (half[..., channel] - half[..., other] > 60).mean()
        assert 0.3 < coloured < 0.8
    assert reddish == pytest.approx((left[..., 0] - left[..., 2] > 60).mean(), abs=0.01)
    assert (pixels[:8] == 255).all() and (pixels[-56:-26] < 120).all(axis=2).any()
