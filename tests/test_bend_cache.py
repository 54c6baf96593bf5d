"""The cache: another curve for every number that matters, none that is broken, whatever stops a run."""

import dataclasses
import json
import os
import random
import signal
import time

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

import handgen
from handgen.bending import cache, solvers
from handgen.bending.request import request
from tests import bend_stub
from tests.bend_case import ADULT_FILE, process
from tests.strategies import PARAMS, write

SOLVER = solvers.Solver("stub", bend_stub.simulate, "1")
PRESSURES = ["--solver", "stub", "--pressures", "0:60:10"]


def key(case):
    return cache.key(case, SOLVER)


def numbers(value, path=()):
    """Key paths of all numbers in a case, as deep as they lie."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from numbers(getattr(value, field.name), (*path, field.name))
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:
            yield from numbers(getattr(value, name), (*path, name))
    elif isinstance(value, (list, tuple)):
        for i, item in enumerate(value):
            yield from numbers(item, (*path, i))
    elif isinstance(value, (bool, int, float)):
        yield path


def at(value, path):
    for name in path:
        value = value[name] if isinstance(name, int) else getattr(value, name)
    return value


def changed(value, path, new):
    """`value` with `new` at `path`."""
    if not path:
        return new
    name, *rest = path
    if isinstance(name, int):
        return type(value)(changed(v, rest, new) if i == name else v for i, v in enumerate(value))
    inner = changed(getattr(value, name), rest, new)
    if dataclasses.is_dataclass(value):
        return dataclasses.replace(value, **{name: inner})
    return value.model_copy(update={name: inner})


@pytest.fixture(scope="module")
def cases():
    asked = {"pressures": "0:60:20", "obstacle": 40, "tip_loads": 0.1, "model": "literature"}
    found = [request(ADULT_FILE, **asked).case, request(ADULT_FILE, finger="little", model="thesis").case]
    return [(case, list(numbers(case))) for case in found]


@given(data=st.data())
def test_every_number_of_a_case_changes_its_key(cases, data):
    """Joints, radii, layers, materials, winding, contact, loads: by as little as one part in 1e12."""
    case, paths = data.draw(st.sampled_from(cases))
    path = data.draw(st.sampled_from(paths))
    value = at(case, path)
    if isinstance(value, bool):
        new = not value
    elif isinstance(value, int):
        new = value + data.draw(st.integers(1, 5))
    else:
        new = value + data.draw(st.sampled_from([1e-12, -1e-3, 1.0])) * max(1.0, abs(value))
    assert key(changed(case, path, new)) != key(case)
    assert key(changed(case, path, value)) == key(case)


def test_the_numbers_that_matter_are_among_them(cases):
    _, paths = cases[0]
    words = {".".join(map(str, path)) for path in paths}
    assert len(paths) > 60
    for word in ("finger.finger.joints.0.palmar_arc", "actuator.actuator.base_outer_diameter",
                 "winding.pitch", "silicone.law.constants.0", "tpu.density", "held", "contact.friction",
                 "contact.bonded", "gravity.2", "pressures.3", "tip_loads.0", "obstacle", "refine", "fillet"):
        assert word in words


def test_what_is_left_out_is_not_what_is_zero(cases):
    case, _ = cases[0]
    for name in ("obstacle", "winding", "tpu"):
        assert key(dataclasses.replace(case, **{name: None})) != key(case)
    assert key(dataclasses.replace(case, obstacle=0.0)) != key(dataclasses.replace(case, obstacle=None))


@pytest.mark.parametrize("path", ["fingers.index.outer_length", "fingers.index.joints.1.position",
                                  "actuators.index.tip_outer_diameter", "layers.internal", "thread.diameter",
                                  "seal.plug_length", "exoskeleton.joint_fillet"])
def test_a_parameter_of_the_finger_asks_for_another_curve(path, tmp_path):
    data = yaml.safe_load((PARAMS / "adult.yaml").read_text(encoding="utf-8"))
    before = key(request(str(write(data, tmp_path))).case)
    node, (*keys, last) = data, path.split(".")
    for name in keys:
        node = node[int(name)] if name.isdecimal() else node.setdefault(name, {})
    node[last] = {"seal.plug_length": 14.0, "exoskeleton.joint_fillet": 0.7}.get(path) or node[last] * 0.99
    assert key(request(str(write(data, tmp_path))).case) != before


def test_names_words_and_other_fingers_do_not_matter(tmp_path):
    (tmp_path / "same.yaml").write_text(
        f"schema: handgen.hand/1\nextends: {ADULT_FILE}\nname: renamed\ndescription: the same finger\n"
        "fingers: {ring: {outer_length: 101}}\n")
    assert key(request(str(tmp_path / "same.yaml")).case) == key(request(ADULT_FILE).case)


def test_the_solver_and_its_version_matter(cases):
    case, _ = cases[0]
    others = [dataclasses.replace(SOLVER, name="other"), dataclasses.replace(SOLVER, version="2")]
    assert len({cache.key(case, solver) for solver in (SOLVER, *others)}) == 3


def test_a_case_that_is_no_plain_data_is_refused():
    with pytest.raises(TypeError, match="plain data"):
        cache.canonical({"a": object()})


# What is stored


def same(one, other):
    """Whether two curves are equal in every number and array."""
    plain = [dataclasses.replace(c, grids={}, states=tuple(
        dataclasses.replace(s, positions={}, stretch={}) for s in c.states)) for c in (one, other)]
    arrays = [[*[a for g in c.grids.values() for a in (g.nodes, g.cells)],
               *[a for s in c.states for a in (*s.positions.values(), *s.stretch.values())]]
              for c in (one, other)]
    return plain[0] == plain[1] and all(np.array_equal(a, b) and a.dtype == b.dtype
                                        for a, b in zip(*arrays, strict=True))


def test_a_curve_comes_back_as_it_was(stub, monkeypatch):
    monkeypatch.setenv("STUB_STOPS_AT", "45")
    first = handgen.bend(ADULT_FILE, solver="stub", pressures="0:60:20")
    again = handgen.bend(ADULT_FILE, solver="stub", pressures="0:60:20")
    assert not first.cached and again.cached and same(first.curve, again.curve)
    assert {k: v for k, v in first.document.items() if k != "cached"} == {
        k: v for k, v in again.document.items() if k != "cached"}


def test_no_cache_neither_reads_nor_writes(stub):
    handgen.bend(ADULT_FILE, solver="stub", pressures=[0], keep=False)
    assert not stub.exists()
    handgen.bend(ADULT_FILE, solver="stub", pressures=[0])
    assert not handgen.bend(ADULT_FILE, solver="stub", pressures=[0], keep=False).cached


def harm(file, how):
    data = file.read_bytes()
    if how == "empty":
        file.write_bytes(b"")
    elif how == "half":
        file.write_bytes(data[:len(data) // 2])
    elif how == "other":
        file.write_bytes(b"PK\x03\x04 not an archive")
    elif how == "folder":
        file.unlink()
        file.mkdir()
    elif how == "foreign":
        with np.load(file) as stored:
            arrays = dict(stored)
        text = json.loads(arrays["json"].tobytes())
        arrays["json"] = np.frombuffer(json.dumps(text | {"key": "0" * 64}).encode(), np.uint8)
        with file.open("wb") as out:
            np.savez(out, **arrays)


@pytest.mark.parametrize("how", ["empty", "half", "other", "folder", "foreign"])
def test_a_damaged_entry_is_solved_anew(how, stub):
    first = handgen.bend(ADULT_FILE, solver="stub", pressures=[0, 10])
    [file] = (stub / "bend").iterdir()
    harm(file, how)
    again = handgen.bend(ADULT_FILE, solver="stub", pressures=[0, 10])
    assert not again.cached and same(first.curve, again.curve)
    assert how == "folder" or handgen.bend(ADULT_FILE, solver="stub", pressures=[0, 10]).cached


@given(data=st.data())
def test_a_flipped_byte_gives_the_curve_or_a_new_one(entry, data):
    """Never another curve: the archive has checksums, and what they do not cover changes nothing."""
    file, whole, wanted = entry
    place = data.draw(st.integers(0, len(whole) - 1))
    broken = bytearray(whole)
    broken[place] ^= data.draw(st.integers(1, 255))
    file.write_bytes(bytes(broken))
    found = cache.read(file.stem)
    assert found is None or same(found, wanted)


@pytest.fixture(scope="module")
def entry(tmp_path_factory):
    """(file, its bytes, its curve) of a stored curve."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HANDGEN_CACHE", str(tmp_path_factory.mktemp("cache")))
        case = request(ADULT_FILE, pressures=[0, 10]).case
        curve = bend_stub.simulate(case)
        cache.write("some", curve)
        file = cache.folder() / "bend" / "some.npz"
        yield file, file.read_bytes(), curve


def test_a_cache_that_cannot_be_written_costs_nothing_but_time(stub, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("HANDGEN_CACHE", str(tmp_path / "file"))
    for _ in range(2):
        assert not handgen.bend(ADULT_FILE, solver="stub", pressures=[0]).cached


def test_a_full_cache_forgets_what_was_not_used_for_longest(stub, monkeypatch):
    sizes = []
    for pressure in (1, 2, 3):
        handgen.bend(ADULT_FILE, solver="stub", pressures=[pressure])
        sizes.append(sum(f.stat().st_size for f in (stub / "bend").iterdir()))
        time.sleep(0.02)
    assert handgen.bend(ADULT_FILE, solver="stub", pressures=[1]).cached
    monkeypatch.setattr(cache, "LARGEST", sizes[1] + 10)
    handgen.bend(ADULT_FILE, solver="stub", pressures=[4])
    assert handgen.bend(ADULT_FILE, solver="stub", pressures=[1]).cached
    assert not handgen.bend(ADULT_FILE, solver="stub", pressures=[2]).cached


# Kills


def whole(out):
    """Whether the result folder is not there, or complete."""
    folder = out / "bend" / "index_assembly"
    if not folder.exists():
        return True
    data = json.loads((folder / "bend.json").read_text())
    states = {p.name for p in (folder / "states").iterdir()}
    return (len(states) == len(data["points"]) and (folder / "finger.stl").is_file()
            and (folder / "curve.csv").read_text().count("\n") == len(data["points"]) + 1)


@pytest.mark.parametrize("kills", [3, pytest.param(30, marks=pytest.mark.slow)])
def test_a_kill_at_any_moment_leaves_nothing_broken(kills, tmp_path):
    """Kills over all of a run, then one that is let go: it completes and tidies up."""
    started = time.monotonic()
    done = process(tmp_path, *PRESSURES, "--out", "first", "--quiet", STUB_SECONDS="0.05")
    assert done.wait(60) == 0, done.stderr.read()
    lasted = time.monotonic() - started
    for number, moment in enumerate(random.Random(4).sample(range(1000), kills)):
        # Another last pressure each time, so that nothing comes from the cache.
        arguments = ["--solver", "stub", "--pressures", f"0,10,20,30,40,50,{60 + number}"]
        killed = process(tmp_path, *arguments, "--out", "out", "--quiet", STUB_SECONDS="0.05")
        time.sleep(lasted * (0.3 + 0.75 * moment / 1000))
        killed.kill()
        killed.communicate()
        assert whole(tmp_path / "out")
        for file in (tmp_path / "cache" / "bend").glob("*.npz"):
            with pytest.MonkeyPatch.context() as patch:
                patch.setenv("HANDGEN_CACHE", str(tmp_path / "cache"))
                assert cache.read(file.stem) is not None
    last = process(tmp_path, *PRESSURES, "--out", "out", "--json", "--quiet")
    out, err = last.communicate(timeout=60)
    assert last.returncode == 0, err
    assert json.loads(out)["reached"] == 60 and whole(tmp_path / "out")
    assert [p.name for p in (tmp_path / "out" / "bend").iterdir()] == ["index_assembly"]


def test_ctrl_c_ends_cleanly_and_writes_nothing(tmp_path):
    stopped = process(tmp_path, *PRESSURES, "--out", "out", STUB_SECONDS="1")
    assert "0: 0.0 degrees" in stopped.stderr.readline()
    stopped.send_signal(signal.SIGINT)
    out, err = stopped.communicate(timeout=30)
    assert stopped.returncode == 130 and out == ""
    assert err.splitlines()[-1] == "interrupted" and "Traceback" not in err
    assert not (tmp_path / "out").exists() and not (tmp_path / "cache").exists()


def test_a_writer_that_is_alive_is_left_alone(stub, tmp_path):
    """Another process may write the same bend at the same time."""
    home = tmp_path / "out" / "bend"
    other = home / f".index_assembly.writing-{os.getppid()}"
    other.mkdir(parents=True)
    handgen.bend(ADULT_FILE, solver="stub", pressures=[0], out=tmp_path / "out")
    assert other.is_dir() and (home / "index_assembly" / "bend.json").is_file()
