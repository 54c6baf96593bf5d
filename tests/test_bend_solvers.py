"""Solvers of other packages: found by entry point, called, judged, and blamed by name."""

import ast
import dataclasses
import json
import math
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

import handgen
from handgen.bending import opposition, solvers
from handgen.errors import EngineError
from handgen.mechanics import hinge
from handgen.simulation.case import Curve
from tests import bend_stub
from tests.bend_case import ADULT_FILE, command, process


def returning(monkeypatch, change):
    """The stub, its curve passed through `change`."""
    monkeypatch.setattr(bend_stub, "simulate", lambda case, progress=None, old=bend_stub.simulate: change(
        old(case, progress)))


def state_changed(number, **values):
    def change(curve: Curve) -> Curve:
        states = list(curve.states)
        states[number] = dataclasses.replace(states[number], **values)
        return dataclasses.replace(curve, states=tuple(states))
    return change


def test_an_installed_package_brings_a_solver(tmp_path):
    done = process(tmp_path, "--solver", "stub", "--pressures", "0:40:20", "--json", "--quiet")
    out, err = done.communicate(timeout=60)
    assert done.returncode == 0, err
    data = json.loads(out)
    assert data["solver"] == "stub" and err == ""
    assert [p["tip_drop_mm"] for p in data["points"]] == pytest.approx([0, 20, 40])


@pytest.mark.parametrize("name", ["solid", "stub"])
def test_a_name_that_is_taken_twice_is_nobodys(name, stub, monkeypatch, capsys):
    entries = [bend_stub.ENTRY, EntryPoint(name, "elsewhere:simulate", solvers.GROUP)]
    monkeypatch.setattr(solvers, "entry_points", lambda group: entries)
    code, data, _ = command(capsys, ADULT_FILE)
    assert code == 3 and "registered twice" in data["errors"][0]["message"]


@pytest.mark.parametrize(("value", "words"), [
    ("no.such.package:simulate", "ModuleNotFoundError"), ("tests.bend_stub:nothing", "AttributeError"),
    ("tests.bend_stub:GROUP.nothing", "AttributeError")])
def test_a_solver_that_cannot_be_loaded(value, words, stub, monkeypatch, capsys, tmp_path):
    entry = EntryPoint("broken", value, solvers.GROUP)
    monkeypatch.setattr(solvers, "entry_points", lambda group: [entry])
    code, data, _ = command(capsys, ADULT_FILE, "--solver", "broken", "--out", str(tmp_path / "out"))
    message = data["errors"][0]["message"]
    assert code == 3 and "'broken' cannot be loaded" in message and words in message
    assert not (tmp_path / "out").exists()


def test_a_solver_whose_module_fails_in_its_own_way(stub, monkeypatch, tmp_path):
    (tmp_path / "failing_solver.py").write_text("raise RuntimeError('no licence')")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(solvers, "entry_points",
                        lambda group: [EntryPoint("failing", "failing_solver:simulate", solvers.GROUP)])
    with pytest.raises(EngineError, match="'failing' cannot be loaded: RuntimeError: no licence"):
        handgen.bend(ADULT_FILE, solver="failing")


def test_a_solver_that_fails_is_named(stub, monkeypatch, tmp_path):
    def failing(curve):
        raise FloatingPointError("overflow")

    returning(monkeypatch, failing)
    with pytest.raises(EngineError, match="'stub' failed: FloatingPointError: overflow"):
        handgen.bend(ADULT_FILE, solver="stub", out=tmp_path / "out")
    assert not (tmp_path / "out").exists() and not stub.exists()


@pytest.mark.parametrize(("change", "words"), [
    (lambda curve: [1, 2, 3], "returned no curve but list"),
    (lambda curve: dataclasses.replace(curve, states=curve.states[:-1]), "did not return the points"),
    (lambda curve: dataclasses.replace(curve, states=curve.states[::-1]), "did not return the points"),
    (state_changed(1, pressure=0.021), "did not return the points"),
    (state_changed(1, tip_load=0.1), "did not return the points"),
    (state_changed(2, tip_drop=math.nan), "no finite numbers, at 40 kPa"),
    (state_changed(2, positions={"actuator": np.full((12, 3), math.inf)}), "no finite numbers, at 40 kPa"),
])
def test_what_is_no_answer_is_not_passed_on(change, words, stub, monkeypatch):
    returning(monkeypatch, change)
    with pytest.raises(EngineError, match=words):
        handgen.bend(ADULT_FILE, solver="stub", pressures="0:40:20")
    assert not stub.exists()


def test_a_solver_that_was_changed_is_another_one(stub, monkeypatch, tmp_path):
    """Its results are not taken from the cache of what it was before."""
    code = "def simulate(case, progress):\n    return None\n"
    file = tmp_path / "own_solver.py"
    file.write_text(code)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(solvers, "entry_points",
                        lambda group: [EntryPoint("own", "own_solver:simulate", solvers.GROUP)])
    before = solvers.solver("own").version
    assert solvers.solver("own").version == before
    file.write_text(code + "# better\n")
    assert solvers.solver("own").version != before


def test_the_own_solvers_version_covers_what_they_import():
    """A change of what a curve depends on makes the cache forget; what only names fields may be left out."""
    root = Path(handgen.__file__).parent
    covered = {file for name in solvers.SOURCES for path in [root / name]
               for file in (path.rglob("*.py") if path.is_dir() else [path])}
    nodes = [node for file in (root / "simulation").rglob("*.py")
             for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))]
    names = {node.module for node in nodes
             if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("handgen.")}
    plain = {"handgen.errors", "handgen.parameters.finger"}
    found = {root.joinpath(*name.split(".")[1:]) for name in names - plain}
    assert {path.with_suffix(".py") for path in found if path.with_suffix(".py").is_file()} <= covered
    assert Path(opposition.__file__) in covered and Path(hinge.__file__) in covered
