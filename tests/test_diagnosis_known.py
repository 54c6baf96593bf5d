"""The study beside an effect that is known to be missing, on a few worlds by seed."""

from __future__ import annotations

import pytest

from handgen.discrepancy.verdict import verdict
from tests.benchmarks import diagnosis_known as known
from tests.benchmarks.diagnosis_draws import Draw, hidden
from tests.benchmarks.diagnosis_table import FORCED
from tests.worlds.effects import EFFECTS

SEEDS = range(600, 604)
"""Neither those of the figures nor those that were looked at."""


@pytest.fixture(scope="module")
def judge() -> known.Judge:
    return known.Judge(*known.SHIPPED)


def said(judge, *names: str, seed: int):
    draw = Draw("effect", (known.KNOWN, *names), seed, ids=known.GIVEN)
    return verdict(judge.scored(hidden(draw, judge.plain, draw.ids)))


def test_the_library_has_own_weight_on_and_all_else_beside_it(judge):
    simulation = known.simulation(1, lambda line: None)
    assert set(judge.library.on) == {known.KNOWN} and judge.library.on == simulation.on
    assert [test.id for test in judge.library.tests] == [test.id for test in simulation.tests]
    assert set(judge.library.responses) == set(EFFECTS) - {known.KNOWN, *FORCED}
    assert set(judge.kept.opens) == set(judge.library.responses)
    assert (judge.library.baseline != judge.plain.baseline).any()


@pytest.mark.parametrize("seed", SEEDS)
def test_own_weight_alone_is_named_and_nothing_beside_it(judge, seed):
    found = said(judge, seed=seed)
    assert (found.word, found.effects) == ("named", (known.KNOWN,))


def test_a_curl_is_named_beside_own_weight(judge):
    found = [said(judge, "rest_curl", seed=seed) for seed in SEEDS]
    named = [one for one in found if one.word == "pair"]
    assert named and all(one.effects == (known.KNOWN, "rest_curl") for one in named)


def test_the_table_counts_what_is_named_beside_own_weight():
    def row(kind, word, effects, hidden, candidates=()):
        return {"kind": kind, "word": word, "effects": effects, "hidden": hidden, "candidates": candidates}

    own, curl = "own_weight", "rest_curl"
    text = known.table([
        row("nothing", "named", [own], [own], ["own_weight"]),
        row("nothing", "pair", [own, curl], [own], ["own_weight+rest_curl"]),
        row("effect", "pair", [own, curl], [own, curl], ["own_weight+rest_curl"]),
        row("effect", "pair", [own, curl], [own, "mullins"], ["own_weight+rest_curl"]),
        row("outside", "outside", [], [own, "cold_day"])])
    lines = [" ".join(line.split()) for line in text.splitlines()]
    assert lines[2].startswith("something beside it is named 50.0 %") and lines[2].endswith("1 of 2)")
    assert lines[3].startswith("... and is right 0.0 %") and lines[5].endswith("1 of 2)")
    assert lines[9].startswith("... and is right no draw") and lines[10].endswith("1 of 1)")
    assert lines[14].startswith("... and is right 50.0 %") and lines[14].endswith("1 of 2)")
