"""The diagnosis on a few worlds of another structure, by seed: the small part of the study
`tests.benchmarks.diagnosis`."""

from __future__ import annotations

import json

import numpy as np
import pytest

from handgen.discrepancy.library import Library
from handgen.discrepancy.verdict import verdict
from tests.benchmarks import diagnosis, diagnosis_close, diagnosis_library, diagnosis_table
from tests.benchmarks.diagnosis_draws import Draw, checked, hidden
from tests.worlds.effects import EFFECTS
from tests.worlds.outside import OUTSIDE

SEEDS = range(500, 504)
"""Neither those of the figures nor those that were looked at."""


@pytest.fixture(scope="module")
def library() -> Library:
    return Library.load(diagnosis_library.SHIPPED)


@pytest.fixture(scope="module")
def kept() -> diagnosis_close.Kept:
    return diagnosis_close.Kept.load(diagnosis_close.SHIPPED)


@pytest.fixture
def said(library, kept):
    def of(draw: Draw):
        found = hidden(draw, library, draw.ids)
        return verdict(diagnosis.scored(checked(library, found), kept, found.observed()))
    return of


def test_the_library_answers_the_study_s_tests_for_all_effects(library):
    asked = diagnosis_library.simulation(1, lambda line: None).tests
    assert {test.id for test in library.tests} == {test.id for test in asked}
    assert set(library.responses) == set(EFFECTS)


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_hidden_is_never_named(said, seed):
    assert said(Draw("none", (), seed, ids=diagnosis.GIVEN)).word not in diagnosis_table.NAMING


@pytest.mark.parametrize("name", OUTSIDE)
def test_what_no_effect_explains_is_never_named(said, name):
    found = said(Draw("outside", (name,), SEEDS[0], ids=diagnosis.GIVEN))
    assert found.word not in diagnosis_table.NAMING


@pytest.mark.parametrize("name", ["own_weight", "rest_curl", "asymmetric_winding"])
def test_what_moves_the_finger_far_is_mostly_named_and_never_something_else(said, name):
    """Effects that the source's three tests can tell from the others."""
    found = [said(Draw("single", (name,), seed, ids=diagnosis.GIVEN)) for seed in SEEDS]
    named = [one for one in found if one.word == "named"]
    assert named and all(one.effects == (name,) for one in named)
    assert all(name in one.effects for one in found if one.word == "pair")


def test_misread_constants_are_told_from_soft_silicone_by_the_data_sheet(said):
    """To every test of a finger they are one thing."""
    said_of = [(name, said(Draw("single", (name,), seed, ids=diagnosis.GIVEN)))
               for name in ("wrong_convention", "silicone_softening") for seed in SEEDS]
    assert any(one.effects == ("wrong_convention",) for _, one in said_of if one.word == "named")
    assert not any(one.word == "named" and one.effects != (name,) for name, one in said_of)


def test_a_stopped_study_goes_on_where_it_was(tmp_path):
    draws = [draw for draw in diagnosis.plan(500, 0.005) if draw.kind in ("none", "outside")]
    rows = tmp_path / "rows.jsonl"
    files = diagnosis_library.SHIPPED, diagnosis_close.SHIPPED
    diagnosis.study(draws[:2], *files, rows, 1)
    before = rows.read_text()
    diagnosis.study(draws[:3], *files, rows, 1)
    assert rows.read_text().startswith(before)
    found = [json.loads(line) for line in rows.read_text().splitlines()]
    assert {row["key"] for row in found} == {draw.key for draw in draws[:3]} and len(found) == 3


def test_the_plan_is_as_large_as_promised():
    draws = list(diagnosis.plan(diagnosis.FRESH))
    count = {kind: sum(draw.kind == kind for draw in draws) for kind in diagnosis.COUNT}
    assert count["none"] >= 200 and count["pair"] >= 100
    assert count["single"] >= 40 * len(EFFECTS) and count["outside"] >= 40 * 5
    assert len({draw.key for draw in draws}) == len(draws)


def test_intervals_are_wilson_s():
    """Brown, Cai and DasGupta, Statistical Science 16 (2001) 101-133: n = 10, none and half of them."""
    assert diagnosis_table.wilson(0, 10) == pytest.approx((0.0, 0.2775), abs=2e-4)
    assert diagnosis_table.wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=2e-4)
    inside = [low <= 0.9 <= high for low, high in
              (diagnosis_table.wilson(k, 50) for k in np.random.default_rng(0).binomial(50, 0.9, 4000))]
    assert np.mean(inside) == pytest.approx(0.95, abs=0.025)


@pytest.mark.parametrize("named, as_one", [("base_compliance", True), ("own_weight", False)])
def test_a_name_for_what_was_struck_off_is_counted_apart_where_both_were_one_class(named, as_one):
    row = {"effects": [named], "hidden": ["contact_angle"],
           "whole": [["contact_angle", "base_compliance", "outside"], ["own_weight"]]}
    assert diagnosis_table.reported_as_one(row) is as_one


def test_an_interplay_is_that_of_the_nearest_sizes_of_either_sign(tmp_path, library, kept):
    """A file keeps all to single precision."""
    kept.save(tmp_path / "close.npz")
    two = "rest_curl", "asymmetric_winding"
    for one in (kept, diagnosis_close.Kept.load(tmp_path / "close.npz")):
        for near in kept.twos[two]:
            sizes = {"angle": near.sizes[0] + 1.0}, {"offset": 1.05 * near.sizes[1]}
            found = one.together(library, {two: sizes}).interplays[two]
            assert found.excess == pytest.approx(near.interplay.excess, rel=1e-6, nan_ok=True)
        found = one.localised(library, {"wrong_convention": {"misread": 1.0}}).responses["wrong_convention"]
        assert found.local and np.linalg.eigvalsh(found.structural).min() > -1e-9
    signs = {tuple(np.sign(near.sizes)) for near in kept.twos[two]}
    assert signs == {(1.0, -1.0), (1.0, 1.0)} and len(kept.twos[two]) == 4


def test_the_study_judges_as_a_diagnosis_does(library, kept, monkeypatch):
    """The likeliest pairs, and misread constants, go through `closely`."""
    asked = []
    monkeypatch.setattr(diagnosis_close.Kept, "together",
                        lambda self, library, pairs, own=diagnosis_close.Kept.together:
                        asked.append(set(pairs)) or own(self, library, pairs))
    draw = Draw("pair", ("rest_curl", "asymmetric_winding"), SEEDS[0], ids=diagnosis.GIVEN)
    found = hidden(draw, library, draw.ids)
    scores = diagnosis.scored(library, kept, found.observed())
    assert asked and set().union(*asked) <= set(scores.problem.library.interplays)
    responses = scores.problem.library.responses
    assert [name for name, one in responses.items() if one.local] == ["wrong_convention"]


def test_the_study_asks_which_way_a_winding_lies(library, kept):
    """By the three tests it is named and its side is open; the free actuator's bend tells."""
    draw = Draw("single", ("asymmetric_winding",), SEEDS[0], ids=diagnosis.GIVEN)
    found = hidden(draw, library, draw.ids)
    judged = checked(library, found)
    scores = diagnosis.scored(judged, kept, found.observed())
    first = diagnosis.said(scores)
    assert first["effects"] == ("asymmetric_winding",) and first["sides"] == {"asymmetric_winding": 0.0}
    after = diagnosis.ask(draw, judged, kept, "best", scores)
    assert after["tests"] == ["ask-actuator-bend-angle-weightless-loading"]
    row = {"sizes": found.sizes, **after}
    assert row["sides"]["asymmetric_winding"] * found.sizes[0] > 0 and diagnosis_table.right_way(row)
    assert not diagnosis_table.right_way(row | {"sizes": [-found.sizes[0]]})
