"""What a sweep file may not say, and what it means."""

import json
import math

import numpy as np
import pytest

from handgen import cli
from handgen.errors import InputError
from handgen.sweep import draw, plan, said
from handgen.sweep.load import prepare
from handgen.sweep.model import Axis
from handgen.sweep.plan import START_S
from handgen.sweep.store import Store
from handgen.sweep.variant import task
from tests.sweep_files import sweep_file


def refused(folder, **values):
    """Key path -> message of everything wrong."""
    with pytest.raises(InputError) as caught:
        prepare(sweep_file(folder, **{"solver": "solid", **values}))
    return {problem.path: problem for problem in caught.value.problems}


def test_everything_wrong_is_said_at_once(tmp_path, capsys):
    file = sweep_file(
        tmp_path, solver="sold", extra=1, objectives={"bend_angle_dg": "maximise"},
        constraints={"hinge_strain": {"min": 2, "max": 1}, "finger_g": {}},
        vary={"fingers.index.joints.*.slot_lenght": [8], "layers.internal": {"low": 2, "high": 1},
              "layers.external": [], "model.frction": [0.1]})
    assert cli.main(["sweep", str(file), "--json", "--out", str(tmp_path / "out")]) == 2
    errors = {e["path"]: e for e in json.loads(capsys.readouterr().out)["errors"]}
    assert set(errors) == {
        "solver", "extra", "objectives.bend_angle_dg", "constraints.hinge_strain", "constraints.finger_g",
        "vary.fingers.index.joints.*.slot_lenght", "vary.layers.internal.high",
        "vary.layers.external.choices", "vary.model.frction"}
    assert errors["vary.fingers.index.joints.*.slot_lenght"]["suggestion"] == (
        "fingers.index.joints.*.slot_length")
    assert errors["vary.model.frction"]["suggestion"] == "model.friction"
    assert errors["solver"]["suggestion"] == "solid"
    assert not (tmp_path / "out").exists()


def test_nothing_wrong_hides_what_else_is(tmp_path):
    """Neither what a sweep must have, nor axes that are no ranges, nor a base that is not there."""
    empty = {"low": 2, "high": 1}
    assert set(refused(tmp_path, name="a b", base="nothing.yaml", solver="sold", budget=0, keep="best",
                       vary={"layers.internal": empty, "layers.external": "1:2"})) == {
        "name", "base", "solver", "budget", "keep", "vary.layers.internal.high", "vary.layers.external"}
    assert set(refused(tmp_path, base=None, vary=None, solver="sold", objectives={"bend_angle_deg": "up"},
                       keep="best")) == {"base", "vary", "solver", "objectives.bend_angle_deg", "keep"}


@pytest.mark.parametrize(("values", "path", "words"), [
    ({"base": "nothing.yaml"}, "base", "no such file"),
    ({"base": "."}, "base", "directory"),
    ({"vary": {"layers.internal": [1, 1.0]}}, "vary.layers.internal", "same choice twice"),
    ({"vary": {"layers.internal": [1.4, math.nan]}}, "vary.layers.internal.choices", "finite"),
    ({"vary": {"name": ["a", "b"]}}, "vary.name", "no 'name'"),
    ({"vary": {"wide": {"choices": ["a"], "scales": ["layers.internal"]}}}, "vary.wide.choices", "no number"),
    ({"vary": {"wide": {"choices": [True], "adds": {"layers.internal": 1}}}}, "vary.wide.choices",
     "no number"),
    ({"vary": {"fingers.index.joints": [1], "fingers.index.joints.0.slot_length": [8]}},
     "vary.fingers.index.joints.0.slot_length", "set by 'fingers.index.joints' too"),
    ({"vary": {"layers.internal": {"distribution": "normal", "mean": 1.4, "sigma": 0.01, "low": 50,
                                   "steps": 3}}}, "vary.layers.internal.low", "leaves nothing"),
    ({"vary": {"layers.internal": {"distribution": "normal", "mean": 1.4, "sigma": 0.1, "step": 0.1}}},
     "vary.layers.internal.step", "normal"),
    ({"vary": {"layers.internal": {"low": 1, "high": 2, "steps": 3, "mode": 1.5}}},
     "vary.layers.internal.mode", "uniform"),
    ({"objectives": {"fingertip_force_N": "maximise"}}, "objectives.fingertip_force_N", "no `force`"),
    ({"vary": {"layers.internal": {"low": 1, "high": 2}}}, "vary.layers.internal", "how many values"),
    ({"vary": {"layers.internal": "1:2:3"}}, "vary.layers.internal.step", "longer than the range"),
    ({"vary": {"layers.internal": "one to two"}}, "vary.layers.internal", "neither a list nor a range"),
    ({"vary": {"layers.internal": [1, 1]}}, "vary.layers.internal", "same choice twice"),
    ({"vary": {"fingers.index.joints.7.slot_length": [8]}}, "vary.fingers.index.joints.7.slot_length", "'7'"),
    ({"vary": {"layers.internal": [1], "wide": {"choices": [1], "adds": {"layers.internal": 1}}}},
     "vary.wide", "set by 'layers.internal' too"),
    ({"vary": {"wide": {"choices": [1], "scales": ["printing.printer"]}}}, "vary.wide", "no number"),
    ({"method": "sobol"}, "budget", "how many variants"),
    ({"method": "optimise", "budget": 5, "objectives": None}, "objectives", "what is best"),
    ({"budget": 5}, "budget", "the grid has 6 variants"),
    ({"keep": "some"}, "keep", "how many"),
    ({"bend": {"finger": "toe"}}, "bend.finger", "none of this name"),
    ({"bend": {"pressures": [20, 10]}}, "bend.pressures", "does not rise"),
    ({"bend": {"orientation": "palm_dwn"}}, "bend.orientation", "none of this name"),
    ({"solver": "revolution", "bend": {"part": "actuator"}}, "bend.orientation", "off its axis"),
    ({"model": "literatur"}, "model", "no model of this name"),
    ({"vary": {"force.obstacle": [30, 40]}}, "vary.force.obstacle", "no `force`"),
])
def test_one_thing_wrong(values, path, words, tmp_path):
    found = refused(tmp_path, **values)
    assert set(found) == {path} and words in found[path].message


def test_axes_reach_hand_model_print_process_and_bend(tmp_path):
    file = sweep_file(tmp_path, solver="solid", vary={
        "fingers.index.joints.*.slot_length": [11], "model.materials.Ninjaflex.constants.c10": [0.5],
        "model.friction": [0.4], "printing.hand.layer_height": [0.2], "bend.pressure": [35],
        "wall": {"choices": [0.5], "adds": {"fingers.index.base_outer_diameter": 2,
                                            "fingers.index.tip_outer_diameter": 2}},
        "long": {"choices": [1.1], "scales": ["fingers.ring.outer_length"]}})
    prepared = prepare(file)
    one = task(prepared, next(draw.points(prepared.sweep)))
    index = one.hand["fingers"]["index"]
    assert [j["slot_length"] for j in index["joints"]] == [11, 11, 11]
    assert (index["base_outer_diameter"], index["tip_outer_diameter"]) == (21.0, 16.5)
    assert one.hand["fingers"]["ring"]["outer_length"] == pytest.approx(112.75)
    assert one.hand["printing"]["hand"]["layer_height"] == 0.2
    assert one.model["materials"]["Ninjaflex"]["constants"]["c10"] == 0.5
    assert one.model["friction"] == 0.4 and one.bend["pressure"] == 35
    # The base is not what was changed.
    assert prepared.base["fingers"]["index"]["base_outer_diameter"] == 20


def test_axes_that_add_to_one_number_add_up(tmp_path):
    wider, end = "fingers.index.base_bore_diameter", "fingers.index.base_outer_diameter"
    prepared = prepare(sweep_file(tmp_path, solver="solid", vary={
        "wall": {"choices": [0.5], "adds": {end: 2}}, "wide": {"choices": [2], "adds": {wider: 1, end: 1}}}))
    index = task(prepared, next(draw.points(prepared.sweep))).hand["fingers"]["index"]
    assert (index["base_outer_diameter"], index["base_bore_diameter"]) == (23.0, 18.0)
    assert refused(tmp_path, vary={
        "wall": {"choices": [0.5], "adds": {end: 2}}, "wide": {"choices": [2], "scales": [end]}})


def test_a_hash_knows_what_matters(tmp_path):
    def keys(**values):
        prepared = prepare(sweep_file(tmp_path, solver="solid", **values))
        return [task(prepared, point).key for point in draw.points(prepared.sweep)]

    plain = keys()
    assert len(set(plain)) == 6
    assert keys(name="other", description="words", objectives=None, seed=3) == plain
    assert not set(keys(bend={"pressures": [0, 30]})) & set(plain)
    assert not set(keys(rules="none")) & set(plain)
    assert not set(keys(model="literature")) & set(plain)
    # A whole number is a number as any other.
    slots = "fingers.index.joints.*.slot_length"
    assert keys(vary={slots: [8, 9]}) == keys(vary={slots: "8:9:1"})
    # A part of a sweep, in another order, is the same variants.
    part = {"layers.internal": [1.5], "fingers.index.joints.*.slot_length": [10, 8]}
    assert set(keys(vary=part)) < set(plain)


def test_a_plan_counts_what_is_known_and_what_it_takes(tmp_path):
    file, store = sweep_file(tmp_path, solver="solid"), Store(tmp_path / "store")
    prepared = prepare(file)
    store.write(task(prepared, next(draw.points(prepared.sweep))).key, {"status": "done", "wall_s": 2.0})
    found = plan(file, workers=2, store=store.folder)
    assert (found["variants"], found["known"], found["missing"]) == (6, 1, 5)
    assert found["seconds"] == START_S + 5.0 and found["base_breaks"] == []
    told = said.planned(found)
    assert "6 variants (grid, solid), 1 known, 5 to compute" in told and "2 workers: 8 s" in told


def test_a_plan_tells_what_becomes_of_those_it_tries(tmp_path):
    found = plan(sweep_file(tmp_path, solver="rod", vary={"layers.internal": [50]}), store=tmp_path / "store")
    assert found["seconds_each"] is None and "is invalid: layers.internal: too large" in said.planned(found)
    found = plan(sweep_file(tmp_path, solver="rod", vary={"thread.pitch": [6]}, bend={"pressures": [20]}),
                 store=tmp_path / "store")
    assert found["base_breaks"] == [] and "tried breaks thread.gap" in said.planned(found)


AXES = [
    Axis(low=2.0, high=5.0), Axis(low=1.0, high=100.0, distribution="loguniform"),
    Axis(distribution="normal", mean=1.0, sigma=0.2),
    Axis(distribution="normal", mean=1.0, sigma=1.0, low=0.5),
    Axis(low=0.0, high=4.0, mode=1.0, distribution="triangular"), Axis(choices=["a", "b", "c"])]


@pytest.mark.parametrize("axis", AXES)
def test_share_undoes_value(axis):
    for u in np.linspace(0.01, 0.99, 23):
        drawn = draw.value(axis, float(u))
        again = draw.share(axis, drawn)
        if axis.choices is None:
            assert again == pytest.approx(u, abs=1e-6)
        else:
            assert draw.value(axis, again) == drawn


def test_distributions_have_their_moments():
    u = (np.arange(20_000) + 0.5) / 20_000
    bell = np.array([draw.value(AXES[2], x) for x in u])
    assert bell.mean() == pytest.approx(1.0, abs=1e-4) and bell.std() == pytest.approx(0.2, rel=1e-2)
    slope = np.array([draw.value(AXES[4], x) for x in u])
    assert slope.mean() == pytest.approx(5 / 3, rel=1e-4)  # (low + mode + high)/3
    assert np.log([draw.value(AXES[1], x) for x in u]).mean() == pytest.approx(math.log(10), rel=1e-4)


@pytest.mark.parametrize("steps", [{"step": 0.5}, {"steps": 5}, {"steps": 5, "distribution": "loguniform"}])
def test_an_axis_with_steps_has_no_other_values(steps):
    axis = Axis(low=2.0, high=4.0, **steps)
    levels = draw.levels(axis)
    drawn = [draw.value(axis, (i + 0.5) / 100) for i in range(100)]
    assert len(levels) == 5 and drawn == sorted(levels * 20)


def test_grids_and_sobol_points(tmp_path):
    prepared = prepare(sweep_file(tmp_path, solver="solid", vary={
        "layers.internal": "1:2:0.25", "layers.external": {"low": 1, "high": 2, "steps": 3}}))
    points = list(draw.points(prepared.sweep))
    assert len(points) == draw.count(prepared.sweep) == 15
    assert [p["layers.external"] for p in points[:4]] == [1.0, 1.5, 2.0, 1.0]
    assert points[-1]["layers.internal"] == 2.0
    ranged = {"layers.internal": "1:2", "layers.external": {"low": 1, "high": 2}}
    few, many = ([*draw.points(prepare(sweep_file(
        tmp_path, solver="solid", method="sobol", budget=n, vary=ranged)).sweep)] for n in (100, 3000))
    assert many[:100] == few and len(many) == 3000
    u = np.array([[p["layers.internal"], p["layers.external"]] for p in many[:2048]])
    # A Sobol sequence puts equally many points into equal parts.
    assert set(np.histogram(u[:, 0], 64, (1, 2))[0]) == {32}
    assert set(np.histogram2d(u[:, 0], u[:, 1], 8, [[1, 2], [1, 2]])[0].ravel()) == {32}
