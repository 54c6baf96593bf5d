"""Bad parameter files: every planted error is reported, exit 2, nothing is written, no traceback."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from handgen.cli import main
from tests.bad_files import FILES, SAID_IN_BASE, VARIANT

PARAMS = Path(__file__).parent.parent / "params"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    shutil.copy(PARAMS / "adult.yaml", tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def tree(folder: Path) -> dict[str, int]:
    return {str(p): p.stat().st_mtime_ns for p in folder.rglob("*")}


def refused(folder: Path, capsys, file: str = "bad.yaml") -> list[dict]:
    """The errors that `build --json` reports, after checking that it does nothing else."""
    before = tree(folder)
    code = main(["build", file, "--json"])
    out, err = capsys.readouterr()
    assert code == 2
    assert tree(folder) == before
    assert "Traceback" not in err
    report = json.loads(out)
    assert list(report) == ["errors"]
    for error in report["errors"]:
        assert list(error) == ["file", "path", "value", "message", "allowed", "suggestion"]
    return report["errors"]


@pytest.mark.parametrize("bad", FILES, ids=lambda bad: bad.name)
def test_each_planted_error_is_reported_and_no_other(bad, folder, capsys):
    content = bad.text if isinstance(bad.text, bytes) else bad.text.encode()
    (folder / "bad.yaml").write_bytes(content)
    start = time.process_time()
    errors = refused(folder, capsys)
    assert time.process_time() - start < 5
    assert {e["path"] for e in errors} == set(bad.errors)
    for error in errors:
        assert any(words in error["message"] for words in bad.errors[error["path"]].split("|"))
        assert error["file"] == ("adult.yaml" if bad.name in SAID_IN_BASE else "bad.yaml")


def test_there_are_forty_bad_files():
    assert len({bad.name for bad in FILES}) == len(FILES) >= 40


@pytest.mark.parametrize(
    ("bad", "path", "suggestion", "allowed"),
    [
        (
            "fingers: {index: {outer_lenght: 100}}",
            "fingers.index.outer_lenght",
            "outer_length",
            "one of outer_length",
        ),
        ("layers: {tip: 40}", "layers.tip", None, "1 to 15 mm"),
        ("side: lift", "side", "left", "'right' or 'left'"),
        ("extends: adlut.yaml", "extends", "adult.yaml", None),
        ("schema: handgen.hand/0", "schema", None, "'handgen.hand/1'"),
        (
            "printing: {tooling: {part_support: {mold_a: none}}}",
            "printing.tooling.part_support.mold_a",
            "mould_a",
            "one of mould_a",
        ),
        ("assumed: {fingers.*.taperr: x}", "assumed.fingers.*.taperr", "fingers.*.taper", "one of base"),
        (
            "fingers: {index: {placement: {root: [1, 2, 999]}}}",
            "fingers.index.placement.root[2]",
            None,
            "-400 to 400",
        ),
    ],
)
def test_an_error_says_what_is_allowed_and_meant(bad, path, suggestion, allowed, folder, capsys):
    (folder / "bad.yaml").write_text(bad if bad.startswith("extends") else VARIANT + bad)
    [error] = refused(folder, capsys)
    assert error["path"] == path
    assert error["suggestion"] == suggestion
    assert error["allowed"] is None if allowed is None else error["allowed"].startswith(allowed)


def test_missing_keys_of_a_whole_file_are_all_listed(folder, capsys):
    (folder / "bad.yaml").write_text("name: x\n")
    errors = refused(folder, capsys)
    assert {e["path"] for e in errors} == {
        "schema",
        "fingers",
        "actuators",
        "layers",
        "thread",
        "casting",
        "printing",
    }
    assert all("missing" in e["message"] for e in errors)


def test_errors_stand_in_the_file_and_line_that_says_them(folder, capsys):
    (folder / "base.yaml").write_text("extends: adult.yaml\n\nlayers:\n  tip: 40\nnam: x\n")
    (folder / "middle.yaml").write_text("extends: base.yaml\nlayers: {external: 70, internal: 70}\n")
    (folder / "bad.yaml").write_text("extends: middle.yaml\nname: 3\nlayers:\n  external: 80\n")
    errors = refused(folder, capsys)
    said = {e["path"]: (e["file"], e["message"].split(":")[0], e["value"]) for e in errors}
    assert said == {
        "name": ("bad.yaml", "line 2", 3),
        "layers.external": ("bad.yaml", "line 4", 80),
        "layers.internal": ("middle.yaml", "line 2", 70),
        "layers.tip": ("base.yaml", "line 4", 40),
        "nam": ("base.yaml", "line 5", "x"),
    }
    assert [e["file"] for e in errors] == ["bad.yaml", "bad.yaml", "middle.yaml", "base.yaml", "base.yaml"]


def test_an_incomplete_entry_of_a_replaced_list_stands_in_the_file_that_replaces_it(folder, capsys):
    (folder / "bad.yaml").write_text(
        VARIANT + "fingers: {index: {joints: [{name: A, position: 16, palmar_arc: 80}]}}\n"
    )
    [error] = refused(folder, capsys)
    assert (error["file"], error["path"]) == ("bad.yaml", "fingers.index.joints[0].slot_length")


def test_cycles_and_long_chains_are_refused(folder, capsys):
    for here, base in (("bad", "b"), ("b", "c"), ("c", "bad")):
        (folder / f"{here}.yaml").write_text(f"extends: {base}.yaml\n")
    [error] = refused(folder, capsys)
    assert (error["file"], error["path"]) == ("c.yaml", "extends")
    assert "bad.yaml -> b.yaml -> c.yaml -> bad.yaml" in error["message"]

    for i in range(20):
        (folder / f"{i}.yaml").write_text(f"extends: {i + 1}.yaml\n")
    [error] = refused(folder, capsys, "0.yaml")
    assert error["file"] == "15.yaml" and "too long" in error["message"]


def test_files_that_cannot_be_read(folder, capsys):
    [error] = refused(folder, capsys, "adlut.yaml")
    assert error["suggestion"] == "adult.yaml" and "no such file" in error["message"]
    [error] = refused(folder, capsys, ".")
    assert "directory" in error["message"]
    [error] = refused(folder, capsys, "x" * 300)
    assert error["file"] == "x" * 300
    if hasattr(os, "mkfifo"):
        os.mkfifo(folder / "pipe.yaml")
        [error] = refused(folder, capsys, "pipe.yaml")
        assert "no regular file" in error["message"]


def test_a_flood_of_errors_takes_no_flood_of_time(folder, capsys):
    (folder / "bad.yaml").write_text(VARIANT + "".join(f"key_{i}: 1\n" for i in range(20_000)))
    start = time.process_time()
    assert len(refused(folder, capsys)) == 20_000
    assert time.process_time() - start < 20


@pytest.mark.parametrize("name", ["many", "tag-runs-code", "10-MB-of-nesting", "deep-flow"])
def test_in_a_process_of_its_own(name, folder):
    bad = next(bad for bad in FILES if bad.name == name)
    (folder / "bad.yaml").write_text(bad.text)
    before = tree(folder)
    run = subprocess.run(
        [sys.executable, "-m", "handgen.cli", "build", "bad.yaml"], capture_output=True, text=True, timeout=60
    )
    assert run.returncode == 2
    assert run.stdout == ""
    assert "Traceback" not in run.stderr
    for path, words in bad.errors.items():
        assert path in run.stderr and words in run.stderr
    assert tree(folder) == before
