"""What a bend writes and prints, against the contract and against rulers of other packages."""

import csv
import dataclasses
import json
import math
import shutil

import numpy as np
import pytest
import pyvista
import trimesh
from matplotlib import colormaps, image

import handgen
from handgen import cli
from handgen.bending import curl, figure, states
from handgen.errors import EngineError
from handgen.parameters.load import load
from handgen.simulation.case import Curve, Grid, State
from tests import bend_stub
from tests.bend_case import ADULT_FILE, command

KEYS = {"schema", "finger", "part", "orientation", "solver", "model", "points", "reached", "unknowns",
        "factorisations", "wall_s"}
POINT = {"pressure_kPa", "tip_load_N", "converged", "tip_drop_mm", "bend_angle_deg", "elongation_mm",
         "tip_force_N", "max_stretch"}
VALUES = POINT - {"pressure_kPa", "tip_load_N", "converged"}


def bend(capsys, tmp_path, *arguments):
    """(exit code, JSON, what people read, folder) of a bend by the stub."""
    out = tmp_path / "out"
    code, data, err = command(capsys, ADULT_FILE, "--solver", "stub", "--out", str(out), *arguments)
    return code, data, err, out / "bend" / f"{data['finger']}_{data['part']}"


@pytest.mark.parametrize("part", ["assembly", "exoskeleton", "actuator"])
def test_the_json_is_the_contracts(part, stub, tmp_path, capsys):
    loads = ["--tip-loads", "0,0.1"] if part == "exoskeleton" else ["--pressures", "0,30"]
    code, data, _, folder = bend(capsys, tmp_path, "--part", part, *loads)
    assert code == 0 and data["schema"] == "handgen.bend/1" and data.keys() >= KEYS
    assert all(point.keys() >= POINT for point in data["points"])
    bare = part == "exoskeleton"
    assert [p["tip_load_N" if bare else "pressure_kPa"] for p in data["points"]] == [0, 0.1 if bare else 30]
    assert data["reached"] == (0.1 if bare else 30) and data["reached_unit"] == ("N" if bare else "kPa")
    assert json.loads((folder / "bend.json").read_text()) == data


def test_pressures_come_back_as_they_were_asked_for(stub, tmp_path, capsys):
    _, data, _, _ = bend(capsys, tmp_path, "--pressures", "0", "0.9,12.3", "33.3", "70")
    assert [p["pressure_kPa"] for p in data["points"]] == [0, 0.9, 12.3, 33.3, 70]
    assert [p["bend_angle_deg"] for p in data["points"]] == pytest.approx(
        [math.degrees(0.02 * p) for p in (0, 0.9, 12.3, 33.3, 70)])


def test_the_csv_says_what_the_json_says(stub, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("STUB_STOPS_AT", "50")
    _, data, _, folder = bend(capsys, tmp_path, "--pressures", "0:90:30")
    rows = list(csv.DictReader((folder / "curve.csv").open(newline="")))
    assert len(rows) == 4
    for row, point in zip(rows, data["points"], strict=True):
        assert row["converged"] == str(int(point["converged"]))
        for key in POINT - {"converged"}:
            assert row[key] == ("" if point[key] is None else str(point[key]))


def test_a_state_is_the_shape_for_paraview(stub, tmp_path, capsys):
    """Nodes as drawn and their displacement; stretch and body of every cell; the load as time."""
    _, _, _, folder = bend(capsys, tmp_path, "--pressures", "5,100")
    found = handgen.bend(ADULT_FILE, solver="stub", pressures=[5, 100])
    series = pyvista.get_reader(str(folder / "states.pvd"))
    assert series.time_values == [5, 100]
    assert sorted(p.name for p in (folder / "states").iterdir()) == ["005kPa.vtu", "100kPa.vtu"]
    for state, value in zip(found.curve.states, series.time_values, strict=True):
        series.set_active_time_value(value)
        grid = series.read()[0]
        names = list(grid.field_data["bodies"])
        assert names == ["actuator", "exoskeleton"]
        warped = grid.warp_by_vector("displacement").points
        assert warped == pytest.approx(np.vstack([state.positions[name] for name in names]), abs=1e-4)
        assert grid.points == pytest.approx(np.vstack([found.curve.grids[name].nodes for name in names]))
        for number, name in enumerate(names):
            mine = grid.cell_data["stretch"][grid.cell_data["body"] == number]
            assert mine == pytest.approx(state.stretch[name])


def test_the_stl_is_the_last_shape_both_halves(stub, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("STUB_STOPS_AT", "60")
    code, _, _, folder = bend(capsys, tmp_path, "--pressures", "0,60,90")
    assert code == 3
    mesh = trimesh.load(folder / "finger.stl")
    assert mesh.is_watertight and mesh.is_winding_consistent and mesh.body_count == 2
    state = handgen.bend(ADULT_FILE, solver="stub", pressures=[0, 60]).curve.states[-1]
    nodes = np.vstack(list(state.positions.values()))
    whole = np.vstack([nodes, nodes * (1, -1, 1)])
    assert mesh.bounds == pytest.approx(np.array([whole.min(axis=0), whole.max(axis=0)]), abs=0.01)
    quadratic = sum(2 * _volume(bend_stub.bent(grid, 0.02 * 60), grid.cells)
                    for grid in (bend_stub.box(94.5, -3, 3), bend_stub.box(102.5, -8, -6)))
    assert mesh.volume == pytest.approx(quadratic, rel=0.01)


def _volume(nodes, cells):
    """Of hexahedra with plane faces or nearly so, by six tetrahedra each."""
    tetrahedra = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    total = 0.0
    for a, b, c, d in tetrahedra:
        p = nodes[cells[:, a]]
        total += np.einsum("ij,ij->", np.cross(nodes[cells[:, b]] - p, nodes[cells[:, c]] - p),
                           nodes[cells[:, d]] - p) / 6
    return total


def test_pieces_of_a_body_that_only_touch_become_one(stub, tmp_path):
    low, high = bend_stub.box(10.0, -3.0, 0.0), bend_stub.box(10.0, -2.0, 0.0)
    nodes = np.vstack([low.nodes, high.nodes + np.array((0.0, 0.0, 2.0))])
    grid = Grid(nodes, np.vstack([low.cells, high.cells + len(low.nodes)]))
    state = State(0.0, 0.0, True, positions={"exoskeleton": nodes}, stretch={"exoskeleton": np.ones(4)})
    curve = Curve((state,), {"exoskeleton": grid}, 0.0, (), 0, 0, 0.0)
    states.write_stl(curve, tmp_path / "both.stl")
    mesh = trimesh.load(tmp_path / "both.stl")
    assert mesh.is_watertight and mesh.body_count == 1
    assert mesh.volume == pytest.approx(2 * 10 * (3 * 3 + 2 * 2), rel=1e-3)


# The table


def test_the_table_has_a_line_a_point_and_says_where_the_files_are(stub, tmp_path, capsys):
    assert cli.main(["bend", ADULT_FILE, "--solver", "stub", "--pressures", "0:80:40", "--out",
                     str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    lines = err.splitlines()
    start = next(i for i, line in enumerate(lines) if "bend, deg" in line)
    assert lines[start].split() == ["kPa", "drop,", "mm", "bend,", "deg", "longer,", "mm", "stretch"]
    assert [line.split()[:5] for line in lines[start + 1:start + 4]] == [
        ["0", "0.0", "0.0", "0.0", "1.00"], ["40", "40.0", "45.8", "4.0", "1.80"],
        ["80", "80.0", "91.7", "8.0", "2.60"]]
    assert "strained 160 %" in lines[start + 3] and "strained" not in lines[start + 2]
    assert str(tmp_path / "bend" / "index_assembly") in lines[-1] and "reached 80 kPa" in lines[-1]
    assert all(line == line.rstrip() for line in lines)


@pytest.mark.parametrize(("arguments", "heads"), [
    (["--pressures", "0", "--obstacle", "40"], ["kPa", "force,"]),
    (["--pressures", "0", "--tip-loads", "0.1"], ["kPa", "weight,"]),
    (["--part", "exoskeleton", "--tip-loads", "0"], ["weight,"]),
])
def test_the_table_shows_what_was_asked_for_even_where_it_is_zero(arguments, heads, stub, tmp_path, capsys):
    assert cli.main(["bend", ADULT_FILE, "--solver", "stub", "--out", str(tmp_path), *arguments]) == 0
    head = next(line for line in capsys.readouterr().err.splitlines() if "bend, deg" in line)
    assert {"kPa", "weight,", "force,"} & set(head.split()) == set(heads)


def test_quiet_says_nothing(stub, tmp_path, capsys):
    assert cli.main(["bend", ADULT_FILE, "--solver", "stub", "--pressures", "0,10", "--out", str(tmp_path),
                     "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


# Beyond what the law was fitted on


def test_strain_beyond_the_laws_data_is_flagged_on_the_point(stub, tmp_path, capsys):
    """ecoflex-00-50-neo-hookean: 0 to 100 %; the stub's stretch is 1 + kPa / 50."""
    _, data, _, _ = bend(capsys, tmp_path, "--pressures", "0,49,51", "--model", "literature")
    flags = [point["flags"] for point in data["points"]]
    assert flags[0] == flags[1] == []
    assert len(flags[2]) == 1 and "actuator" in flags[2][0] and "100 %" in flags[2][0]
    assert "102 %" in flags[2][0]


def test_without_stretches_of_its_bodies_any_body_may_be_the_one(stub, monkeypatch):
    old = bend_stub.simulate

    def bare(case, progress=None):
        curve = old(case)
        return dataclasses.replace(curve, grids={}, states=tuple(
            dataclasses.replace(s, stretch={}, positions={}) for s in curve.states))

    monkeypatch.setattr(bend_stub, "simulate", bare)
    [point] = handgen.bend(ADULT_FILE, solver="stub", pressures="60", model="literature").document["points"]
    assert [flag.split()[0] for flag in point["flags"]] == ["actuator"]


# An incomplete curve


def test_an_incomplete_curve_exits_3_and_keeps_what_was_found(stub, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("STUB_STOPS_AT", "45")
    code, data, err, folder = bend(capsys, tmp_path, "--pressures", "0:80:20")
    assert code == 3 and data["reached"] == 40 and "45" in data["stopped"]
    assert "reached 40 kPa: nothing was found beyond 45" in err
    assert [p["converged"] for p in data["points"]] == [True, True, True, False, False]
    assert [p["pressure_kPa"] for p in data["points"]] == [0, 20, 40, 60, 80]
    for point in data["points"]:
        assert all((point[key] is None) == (not point["converged"]) for key in VALUES - {"tip_force_N"})
    assert "nothing was found" in data["points"][3]["note"]
    assert {p.name for p in (folder / "states").iterdir()} == {"000kPa.vtu", "020kPa.vtu", "040kPa.vtu"}
    assert (folder / "curve.png").is_file() and (folder / "curl.png").is_file()


def test_the_words_for_it_stand_once(stub, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("STUB_STOPS_AT", "5")
    for quiet in ([], ["--quiet"]):
        assert cli.main(["bend", ADULT_FILE, "--solver", "stub", "--pressures", "0,10", "--out",
                         str(tmp_path), *quiet]) == 3
        assert capsys.readouterr().err.count("reached 0 kPa") == 1


def test_no_point_at_all(stub, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("STUB_STOPS_AT", "-1")
    code, data, err, folder = bend(capsys, tmp_path, "--pressures", "0,10")
    assert code == 3 and "reached no point" in err
    assert all(point[key] is None for point in data["points"] for key in VALUES)
    assert {p.name for p in folder.iterdir()} == {"bend.json", "curve.csv"}


# Pictures


def test_the_picture_is_coloured_by_one_scale_that_its_bar_shows(stub, tmp_path, capsys):
    """Where the actuator is stretched most it has the colour of the bar's right end."""
    _, _, _, folder = bend(capsys, tmp_path, "--pressures", "0,50,100")
    picture = image.imread(folder / "curl.png")[:, :, :3]
    high = len(picture)
    bar = picture[high - 40:high - 10, 240:760]
    saturated = bar.max(axis=2) - bar.min(axis=2) > 0.1
    assert saturated.mean() > 0.2
    rows, columns = np.nonzero(saturated)
    right = bar[rows, columns][columns > columns.max() - 8].mean(axis=0)
    assert right == pytest.approx(np.array(colormaps[curl.COLOURS](1.0)[:3]), abs=0.1)


def test_the_picture_shows_the_obstacle(stub, tmp_path, capsys):
    """A dark line as wide as the only finger; its top 3 mm above the axis, the palm side 10 mm below."""
    _, _, _, folder = bend(capsys, tmp_path, "--pressures", "0", "--obstacle", "60")
    dark = image.imread(folder / "curl.png")[:-170, :, :3].max(axis=2) < 0.3
    rows = np.nonzero(dark.mean(axis=1) > 0.8)[0]
    below = rows[-1] - np.nonzero(dark.any(axis=1))[0][0]
    scale = dark[rows[-1]].sum() / 102.5
    assert below / scale == pytest.approx(3 + 10 + 60, rel=0.02)


def test_a_machine_that_cannot_draw_loses_only_the_picture(stub, tmp_path, capsys, monkeypatch):
    def blind(*arguments):
        raise EngineError("no OpenGL to draw with")

    monkeypatch.setattr(curl, "draw", blind)
    code, _, err, folder = bend(capsys, tmp_path, "--pressures", "0,10")
    assert code == 0 and "picture of the curling finger is left out" in err
    assert not (folder / "curl.png").exists() and (folder / "curve.png").is_file()


# The folder


def test_a_new_bend_takes_the_place_of_the_old(stub, tmp_path, capsys):
    bend(capsys, tmp_path, "--pressures", "0,10,20")
    _, _, _, folder = bend(capsys, tmp_path, "--pressures", "0,30")
    assert sorted(p.name for p in (folder / "states").iterdir()) == ["000kPa.vtu", "030kPa.vtu"]
    assert [p.name for p in folder.parent.iterdir()] == [folder.name]


def test_what_killed_runs_left_is_cleared(stub, tmp_path, capsys):
    """A run killed between two renames left the old folder aside, another one half a folder."""
    _, data, _, folder = bend(capsys, tmp_path, "--pressures", "0,10")
    folder.rename(folder.with_name(f".{folder.name}.previous"))
    (folder.with_name(f".{folder.name}.writing-999999999") / "states").mkdir(parents=True)
    shutil.rmtree(folder, ignore_errors=True)
    _, again, _, _ = bend(capsys, tmp_path, "--pressures", "0,10")
    assert again["cached"] and again["points"] == data["points"]
    assert [p.name for p in folder.parent.iterdir()] == [folder.name]


def test_a_folder_that_was_laid_aside_comes_back_if_the_next_run_fails(stub, tmp_path, capsys, monkeypatch):
    _, _, _, folder = bend(capsys, tmp_path, "--pressures", "0,10")
    folder.rename(folder.with_name(f".{folder.name}.previous"))

    def full(path, document):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(figure, "draw", full)
    assert cli.main(["bend", ADULT_FILE, "--solver", "stub", "--out", str(tmp_path / "out")]) == 3
    assert json.loads((folder / "bend.json").read_text())["reached"] == 10
    assert [p.name for p in folder.parent.iterdir()] == [folder.name]


def test_a_notebook_writes_only_where_it_is_told(stub, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = handgen.bend(ADULT_FILE, solver="stub", pressures=[0, 10], finger="middle")
    assert found.complete and found.document["finger"] == "middle"
    assert found.curve.states[1].positions["actuator"].shape == (12, 3)
    assert not (tmp_path / "outputs").exists()
    told = []
    handgen.bend(ADULT_FILE, solver="stub", pressures=[0, 10], out="here", progress=told.append, keep=False)
    assert (tmp_path / "here" / "bend" / "index_assembly" / "bend.json").is_file()
    assert len(told) == 2


def test_a_hand_that_is_loaded_already_bends_like_its_file(stub):
    file = handgen.bend(ADULT_FILE, solver="stub", pressures=[0, 10])
    loaded = handgen.bend(load(ADULT_FILE), solver="stub", pressures="0:10:10")
    assert loaded.cached and loaded.request.case == file.request.case
