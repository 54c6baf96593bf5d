"""The search: it finds what is known to be best, keeps to bounds, and goes on where it was cut off."""

import sqlite3

import pandas as pd
import pytest

from handgen.parameters.load import load
from handgen.sweep import optimise as search
from handgen.sweep.best import ranked
from handgen.sweep.load import prepare
from tests.sweep_files import finished, process, sweep_file

AXES = {"layers.internal": {"low": 1.0, "high": 2.0},
        "layers.external": {"low": 1.0, "high": 2.0, "steps": 5}, "layers.tip": [4, 5]}


class Closed:
    """Computes rows in closed form; `cut` ends it like Ctrl-C at its so many-th row."""

    def __init__(self, cut=None):
        self.store, self.rows, self.cut = self, {}, cut

    def compute(self, tasks, said="", total=None):
        for one in tasks:
            if len(self.rows) == self.cut:
                raise KeyboardInterrupt
            layers = one.hand["layers"]
            x, y = layers["internal"], layers["external"]
            self.rows[one.key] = (
                {"status": "invalid", "reason": "thick"} if x > 1.9 else
                {"status": "done", "rules_passed": float(layers["tip"] == 5), "hinge_strain": x,
                 "bend_angle_deg": x + 0.1 * y, "finger_g": x + y})

    def read(self, key):
        return self.rows.get(key)


def prepared(folder, **values):
    return prepare(sweep_file(folder, **{
        "solver": "solid", "method": "optimise", "budget": 48, "vary": AXES,
        "constraints": {"hinge_strain": {"max": 1.6}}, **values}))


def found(one, runner, folder):
    """Rows in the search's order."""
    values = search.optimise(one, runner, folder)
    keys = [search.task(one, v).key for v in values]
    return [{"variant": i, **v, **runner.read(k)} for i, (v, k) in enumerate(zip(values, keys, strict=True))]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """(values, folder) of a search."""
    folder = tmp_path_factory.mktemp("search")
    return search.optimise(prepared(folder), Closed(), folder), folder


def test_the_best_within_rules_and_bounds_is_found(tmp_path):
    one = prepared(tmp_path)
    rows = found(one, Closed(), tmp_path)
    best = ranked(one.sweep, rows)[0]
    # 1.6 + 0.1 * 2 with a tip of 5: beyond lie broken bounds, broken rules and invalid hands.
    assert best["bend_angle_deg"] == pytest.approx(1.8, abs=0.05) and best["layers.tip"] == 5
    assert len(rows) == 48 and {row["layers.external"] for row in rows} <= {1.0, 1.25, 1.5, 1.75, 2.0}
    learnt = [row for row in rows[16:] if row.get("rules_passed") and row["hinge_strain"] <= 1.6]
    assert len(learnt) > 20  # of 32; evenly drawn ones would be 10
    assert sqlite3.connect(tmp_path / search.STUDY).execute("select count(*) from trials").fetchone() == (48,)


def test_two_objectives_are_both_pursued(tmp_path):
    one = prepared(tmp_path, objectives={"bend_angle_deg": "maximise", "finger_g": "minimise"})
    rows = found(one, Closed(), tmp_path)
    kept = [row for row in rows if row.get("rules_passed") and row["hinge_strain"] <= 1.6]
    assert max(row["bend_angle_deg"] for row in kept) > 1.7 and min(row["finger_g"] for row in kept) < 2.1


@pytest.mark.parametrize("cut", [5, 40])
def test_a_search_cut_off_goes_on_as_if_it_had_not_been(cut, undisturbed, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        search.optimise(prepared(tmp_path), Closed(cut), tmp_path)
    assert search.optimise(prepared(tmp_path), Closed(), tmp_path) == undisturbed[0]


def test_a_search_cut_off_while_it_draws(undisturbed, tmp_path, monkeypatch):
    suggest, count = search._suggest, []

    def torn(*arguments):
        count.append(1)
        if len(count) == 3 * 20 + 2:
            raise KeyboardInterrupt
        suggest(*arguments)

    monkeypatch.setattr(search, "_suggest", torn)
    with pytest.raises(KeyboardInterrupt):
        search.optimise(prepared(tmp_path), Closed(), tmp_path)
    monkeypatch.setattr(search, "_suggest", suggest)
    assert search.optimise(prepared(tmp_path), Closed(), tmp_path) == undisturbed[0]


def test_another_question_is_another_study(undisturbed):
    first, folder = undisturbed
    assert search.optimise(prepared(folder, seed=1), Closed(), folder) != first
    assert search.optimise(prepared(folder), Closed(), folder) == first


def test_from_file_to_confirmed_and_kept(tmp_path):
    file = sweep_file(tmp_path, method="optimise", budget=16, keep="best 1", confirm={
        "best": 2, "solver": "stub", "rules": "definition"}, vary={
            "fingers.index.joints.*.slot_length": "9:12", "bend.pressure": "10:40"}, bend={})
    code, result = finished(process(tmp_path, file, "--out", "out", "--workers", "1"), seconds=400)
    assert code == 0 and result["variants"] == 16 and len(result["confirmed"]) == 2
    table = pd.read_parquet(tmp_path / "out" / "results.parquet")
    best = table.loc[table["bend_angle_deg"].idxmax()]
    kept = load(tmp_path / "out" / "best" / "small_1.yaml").hand
    slot = "fingers.index.joints.*.slot_length"
    assert [j.slot_length for j in kept.fingers.index.joints] == pytest.approx([best[slot]] * 3)
    assert (tmp_path / "out" / "best" / "small_1" / "exoskeleton" / "index.stl").is_file()
