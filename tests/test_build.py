"""The build as a user meets it: a folder that is complete, repeatable, owned, and never half new."""

import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import trimesh

from handgen.builder import build
from handgen.builder.pool import Workers
from handgen.builder.store import Store
from handgen.errors import EngineError, GeometryError, InputError
from handgen.geometry.catalogue import catalogue, select

PARAMS = Path(__file__).parent.parent / "params"
SMALL = PARAMS / "thesis_finger.yaml"
TOOLS = ("mould_a", "mould_b", "mould_base", "core_large", "core_small", "suspender", "plug", "collar")
RUN = "import sys; from handgen.builder import build; build(sys.argv[1], out=sys.argv[2], parts=sys.argv[3:])"


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The prototype of Section 4.1, built once; tests work on copies."""
    out = tmp_path_factory.mktemp("built") / "hand"
    return build(SMALL, out=out)


@pytest.fixture
def copy(built, tmp_path):
    out = tmp_path / "hand"
    shutil.copytree(built["out"], out)
    return out


def tree(folder):
    """Every file below `folder` with its content's hash."""
    folder = Path(folder)
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest()
            for p in folder.rglob("*") if p.is_file()}


def seen(files):
    """Without hidden files: locks."""
    return {path: sha for path, sha in files.items() if not path.startswith(".")}


def variant(tmp_path, text, name="variant.yaml"):
    path = tmp_path / name
    path.write_text(f"extends: {SMALL}\n{text}")
    return path


def test_contract_tree(built):
    parts = ["exoskeleton/index", "actuators/index", *(f"tooling/index/{tool}" for tool in TOOLS)]
    expected = {f"{part}.{ending}" for part in parts for ending in ("stl", "step")}
    expected |= {"actuators/index_thread.csv", "manifest.json", "checks.json", "previews/fingers.png",
                 "previews/actuators.png", "previews/tooling_index.png"}
    assert set(tree(built["out"])) == expected
    assert [row["name"] for row in built["manifest"]["parts"]] == parts


def test_manifest_tells_the_truth(built):
    out = Path(built["out"])
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest == built["manifest"]
    assert manifest["schema"] == "handgen.manifest/1" and manifest["verified"] is True
    on_disk = tree(out)
    del on_disk["manifest.json"], on_disk["checks.json"]
    assert manifest["files"] == on_disk
    for row in manifest["parts"]:
        mesh = trimesh.load(out / row["files"]["stl"])
        assert row["sha256"] == on_disk[row["files"]["stl"]]
        assert row["watertight"] is True and mesh.is_watertight and mesh.body_count == 1
        assert row["volume_mm3"] == pytest.approx(mesh.volume, rel=1e-6)
        assert row["area_mm2"] == pytest.approx(mesh.area, rel=1e-6)
        assert row["bbox_mm"] == [pytest.approx(corner, abs=1e-4) for corner in mesh.bounds.tolist()]
        assert row["step_volume_mm3"] == pytest.approx(mesh.volume, rel=0.005)


def test_nothing_in_the_folder_names_machine_or_time(built):
    out = Path(built["out"])
    for path in out.rglob("*"):
        if path.suffix in (".json", ".step", ".csv"):
            text = path.read_text()
            assert str(out.parent) not in text and time.strftime("%Y-%m-%d") not in text, path


def test_thread_csv(built):
    header, *rows = (Path(built["out"]) / "actuators/index_thread.csv").read_text().splitlines()
    assert header == "x,y,z,turn"
    first, last = ([float(v) for v in rows[i].split(",")] for i in (0, -1))
    assert first[3] == 0.0 and last[3] > 20.0 and last[0] > first[0]


def test_identical_in_another_process_and_order(built, tmp_path):
    code = RUN.replace("parts=sys.argv[3:]", "workers=1")
    subprocess.run([sys.executable, "-c", code, SMALL, tmp_path / "hand"], check=True,
                   env={**os.environ, "PYTHONHASHSEED": "7"})
    assert tree(tmp_path / "hand") == tree(built["out"])


def test_unchanged_rebuild_loads_no_kernel(copy):
    before = {p: p.stat().st_ino for p in copy.rglob("*")}
    code = RUN + "\nassert not {'cadquery', 'manifold3d', 'trimesh', 'pyvista'} & set(sys.modules)"
    start = time.monotonic()
    subprocess.run([sys.executable, "-c", code, SMALL, copy], check=True)
    # Ten times what it takes: this fails when anything is made again, not when the machine is busy.
    assert time.monotonic() - start < 10.0
    assert {p: p.stat().st_ino for p in copy.rglob("*")} == before


def test_damage_is_mended_and_the_rest_reused(built, copy):
    kept = copy / "actuators/index.step"
    inode = kept.stat().st_ino
    (copy / "exoskeleton/index.stl").unlink()
    (copy / "exoskeleton/index.step").write_bytes(b"cut short")
    (copy / "previews/actuators.png").unlink()
    lines = []
    build(SMALL, out=copy, progress=lines.append)
    assert tree(copy) == tree(built["out"])
    assert kept.stat().st_ino == inode
    assert lines[0] == "unchanged: 9 parts"


def test_new_code_rebuilds(copy, monkeypatch):
    from handgen.builder import plan

    loaded = plan.plan(*_hand_and_parts())
    monkeypatch.setattr(plan, "salt", lambda: "an upgrade")
    assert all(a.key != b.key for a, b in zip(loaded, plan.plan(*_hand_and_parts()), strict=True))


def _hand_and_parts():
    from handgen.parameters.load import load

    hand = load(SMALL).hand
    return hand, catalogue(hand).values()


def test_one_part_keeps_what_is_still_right(copy, tmp_path):
    """A longer finger changes its exoskeleton alone; asked for another part, it is dropped as stale."""
    params = variant(tmp_path, "name: thesis_finger\nfingers: {index: {outer_length: 87}}\n")
    result = build(params, out=copy, parts=["plug"])
    names = [row["name"] for row in result["manifest"]["parts"]]
    assert "exoskeleton/index" not in names and not (copy / "exoskeleton").exists()
    assert len(names) == 9
    complete = build(params, out=copy)
    assert complete["manifest"]["parts"][0]["name"] == "exoskeleton/index"


def test_other_files_move_over(copy):
    (copy / "notes.txt").write_text("the cores stick")
    (copy / "bend/curve").mkdir(parents=True)
    (copy / "bend/curve/curve.csv").write_text("0,0\n")
    (copy / "tooling/mine.gcode").write_text("G1")
    (copy / "latest").symlink_to("bend/curve")
    (copy / "tooling/index/plug.stl").unlink()
    build(SMALL, out=copy, parts=["plug"])
    assert (copy / "notes.txt").read_text() == "the cores stick"
    assert (copy / "latest/curve.csv").read_text() == "0,0\n"
    assert (copy / "tooling/mine.gcode").exists() and (copy / "tooling/index/plug.stl").exists()
    assert [p.name for p in copy.parent.iterdir() if "building" in p.name] == []


@pytest.mark.parametrize("content", [
    {"thesis.docx": "mine"},
    {"manifest.json": '{"schema": "other/1"}'},
    {"manifest.json": '{"schema": "handgen.manifest/2"}'},
    {"manifest.json": "["},
])
def test_foreign_folder_is_refused(tmp_path, content):
    out = tmp_path / "mine"
    out.mkdir()
    for name, text in content.items():
        (out / name).write_text(text)
    before = tree(tmp_path)
    with pytest.raises(InputError, match="--out"):
        build(SMALL, out=out)
    assert tree(tmp_path) == before


def test_file_in_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "hand").write_text("a file")
    with pytest.raises(InputError, match="is a file"):
        build(SMALL, out=tmp_path / "hand")


def test_broken_rule_writes_nothing_printable(built, copy, tmp_path):
    tiny = variant(tmp_path, "printing: {build_volume: [60, 60, 60]}\n")
    before = tree(copy)
    result = build(tiny, out=copy)
    assert not result["passed"] and result["manifest"] == {}
    after = tree(copy)
    shown = {path for path in after if path.startswith("checks/previews/")}
    assert shown and after.pop("checks/checks.json")
    assert seen({p: sha for p, sha in after.items() if p not in shown}) == seen(before)
    broken = {f["part"]: f for f in result["checks"]["findings"] if f["severity"] == "error"}
    assert broken["exoskeleton/index"]["rule"] == "print.build-volume"
    assert broken["exoskeleton/index"]["measured"] == pytest.approx(86.0 - 60.0, abs=0.01)
    assert "tooling/index/plug" not in broken and "actuators/index" not in broken
    fresh = build(tiny, out=tmp_path / "fresh", parts=["exoskeleton"])
    assert not fresh["passed"] and set(seen(tree(tmp_path / "fresh"))) == {
        "checks/checks.json", "checks/previews/01_print.build-volume_exoskeleton_index.png"}
    wide = variant(tmp_path, "printing: {build_volume: [200, 200, 200]}\n")
    assert build(wide, out=tmp_path / "fresh", parts=["mould_base"])["passed"]
    assert not [p for p in tree(tmp_path / "fresh") if "checks/" in p or p.startswith(".")]


def test_no_verify_writes_and_says_so(tmp_path):
    tiny = variant(tmp_path, "printing: {build_volume: [30, 30, 30]}\n")
    result = build(tiny, out=tmp_path / "hand", parts=["mould_base"], verify=False)
    assert not result["passed"]
    assert json.loads((tmp_path / "hand/manifest.json").read_text())["verified"] is False
    assert json.loads((tmp_path / "hand/checks.json").read_text())["passed"] is False
    assert (tmp_path / "hand/tooling/index/mould_base.stl").exists()


@pytest.mark.parametrize(("patterns", "count"), [
    (["index"], 10), (["index*"], 10), (["tooling/*"], 8), (["tooling/index/"], 8), (["mould_?"], 2),
    (["exoskeleton/index"], 1), (["actuators", "plug"], 2), (None, 10),
])
def test_selection(patterns, count):
    _, parts = _hand_and_parts()
    assert len(select([p.name for p in parts], patterns)) == count


def test_unknown_part_names_the_nearest(tmp_path):
    with pytest.raises(InputError) as caught:
        build(SMALL, out=tmp_path / "hand", parts=["indx", "plug", "mold_a"])
    assert [p.suggestion for p in caught.value.problems] == ["index", "mould_a"]
    assert "tooling/index/mould_b" in caught.value.problems[0].allowed
    assert list(tmp_path.iterdir()) == []


def _results(tmp_path, *groups):
    with open(tmp_path / "lock", "w") as lock, Workers(1, lock.fileno()) as pool:
        for group in groups:
            pool.add(group)
        return list(pool.results())


def test_killed_worker_names_its_part_and_the_others_go_on(tmp_path):
    results = _results(tmp_path, [("exoskeleton/index", os.abort, ()), ("after", abs, (-3,))],
                       [("plug", abs, (-4,))])
    assert results[1:] == [("after", 3), ("plug", 4)]
    name, error = results[0]
    assert name == "exoskeleton/index" and isinstance(error, EngineError)
    assert "exoskeleton/index" in str(error) and "signal 6" in str(error)


def test_an_interrupt_at_the_terminal_is_not_the_workers(tmp_path):
    """It goes to the whole group of the terminal's command; the command ends its workers itself."""
    [(_, group)] = _results(tmp_path, [("its group", os.getpgrp, ())])
    assert group != os.getpgrp()


def test_worker_brings_errors_home(tmp_path):
    (_, refused), (_, failed), (_, missing) = _results(
        tmp_path, [("plug", _refuse, ()), ("collar", divmod, (1, 0)), ("hand", _without_library, ())])
    assert isinstance(refused, GeometryError)
    assert (refused.part, refused.path, refused.message) == ("plug", "seal.plug_length", "too long")
    assert isinstance(failed, EngineError) and "ZeroDivisionError" in str(failed) and "collar" in str(failed)
    assert isinstance(missing, EngineError) and "apt install libgl1" in str(missing)


def _without_library():
    raise ImportError("libGL.so.1: cannot open shared object file: No such file or directory")


def _refuse():
    raise GeometryError("plug", "seal.plug_length", "too long")


def test_failed_part_leaves_the_old_build(built, copy, tmp_path, monkeypatch):
    """A part that cannot be made: nothing changes, no staging folder stays."""
    from handgen.builder import jobs

    monkeypatch.setattr(jobs, "mesh", _refuse_part)
    (copy / "exoskeleton/index.stl").write_bytes(b"damaged")
    before = tree(copy)
    with pytest.raises(GeometryError):
        build(SMALL, out=copy)
    assert tree(copy) == before
    assert not list(copy.parent.glob(".*building*"))


def _refuse_part(part, stage, extra):
    (stage / "half.stl").parent.mkdir(parents=True, exist_ok=True)
    (stage / "half.stl").write_bytes(b"half")
    raise GeometryError(part.name, part.path, "cannot be made")


def test_pictures_are_left_out_without_opengl(tmp_path, monkeypatch):
    """VTK falls back to OSMesa where there is no EGL; that library is not there either."""
    if shutil.which("ldconfig") and "libOSMesa" in subprocess.run(
            ["ldconfig", "-p"], capture_output=True, text=True).stdout:
        pytest.skip("this machine can draw with OSMesa")
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    result = build(SMALL, out=tmp_path / "hand", parts=["plug"])
    assert result["passed"] and not (tmp_path / "hand/previews").exists()
    [warning] = result["manifest"]["warnings"]
    assert "libegl1" in warning and "previews" in warning


# Kills


def _fake(store, content):
    """A build of one file, by the store alone."""
    with store.locked(lambda: None):
        store.write({"part.stl": content, "manifest.json": b'{"schema": "handgen.manifest/1"}'})
        store.carry_over({"part.stl", "manifest.json"})
        store.commit()


def test_without_exchange_a_kill_between_the_renames_is_mended(tmp_path, monkeypatch):
    from handgen.builder import store as module

    out = tmp_path / "hand"
    _fake(Store(out), b"old")
    monkeypatch.setattr(module, "_exchange", lambda one, other: False)
    rename = Path.rename

    def die_on_second(path, target):
        if path.name == "hand":
            return rename(path, target)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "rename", die_on_second)
    with pytest.raises(KeyboardInterrupt):
        _fake(Store(out), b"new")
    assert not out.exists()
    monkeypatch.setattr(Path, "rename", rename)
    with Store(out).locked(lambda: None):
        assert (out / "part.stl").read_bytes() == b"old"
    _fake(Store(out), b"new")
    assert (out / "part.stl").read_bytes() == b"new"
    assert sorted(p.name for p in tmp_path.iterdir()) == [".hand.lock", "hand"]


def test_second_build_waits_for_the_first(tmp_path):
    out = tmp_path / "hand"
    code = ("import sys, time; from pathlib import Path; from handgen.builder.store import Store\n"
            "with Store(Path(sys.argv[1])).locked(lambda: None):\n"
            "    print('held', flush=True); time.sleep(1.0)")
    holder = subprocess.Popen([sys.executable, "-c", code, out], stdout=subprocess.PIPE, text=True)
    assert holder.stdout.readline() == "held\n"
    waits = []
    with Store(out).locked(lambda: waits.append(holder.poll())):
        assert waits == [None] and holder.wait() == 0


def _kill_rounds(copy, tmp_path, rounds):
    """Alternate between two designs, kill each build at a random moment; the folder stays whole."""
    long = variant(tmp_path, "seal: {plug_length: 9}\n", "long.yaml")
    parts = ["plug", "collar"]
    reference = {}
    for params in (SMALL, long):
        start = time.monotonic()
        build(params, out=copy, parts=parts, workers=1)
        reference[params], last = tree(copy), time.monotonic() - start
    chance = random.Random(20)
    for i in range(rounds):
        params = (SMALL, long)[i % 2]
        (copy / "tooling/index/collar.stl").unlink()
        damaged = tree(copy)
        process = subprocess.Popen([sys.executable, "-c", RUN, params, copy, *parts])
        time.sleep(chance.uniform(0.1, 1.2 * last))
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert tree(copy) in (damaged, reference[params])
        build(params, out=copy, parts=parts, workers=1)
        assert tree(copy) == reference[params]
        assert [p.name for p in copy.parent.iterdir() if "building" in p.name] == []


def test_kill_leaves_old_or_new(copy, tmp_path):
    _kill_rounds(copy, tmp_path, 3)


@pytest.mark.slow
def test_twenty_kills_leave_old_or_new(copy, tmp_path):
    _kill_rounds(copy, tmp_path, 20)
