"""Something unknown over the load of a kind of test, or over what is read, in all tests that read it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handgen.discrepancy import document, outside
from handgen.discrepancy.library import Response
from handgen.discrepancy.problem import Problem
from handgen.discrepancy.score import score
from handgen.discrepancy.verdict import verdict
from tests.small_library import MORE, TESTS, library, readings

LENGTHS = ("tip_drop", "elongation")


def scaled():
    """The small library with a scale of lengths, up to 15 % off, and the curl."""
    lib = library((*TESTS, *MORE))
    lengths = np.array([test.quantity in LENGTHS for test in lib.tests])[lib.owner]
    size = np.linspace(0.85, 1.15, 7)
    rows = np.where(lengths, np.outer(size, lib.baseline), lib.baseline)
    scale = Response("scale", ("factor",), (size,), (np.exp(-((size - 1) / 0.06) ** 2 / 2),), rows)
    return replace(lib, responses={"scale": scale, "curl": lib.responses["curl"]})


def drawn_out(lib, by, eye=50.0):
    """What a camera at one height reads: drops far below it too large."""
    drops = np.array([test.quantity == "tip_drop" for test in lib.tests])[lib.owner]
    away = (lib.baseline - eye) / 40
    return lib.baseline + np.where(drops, by * away * np.abs(away), 0.0)


@pytest.mark.parametrize("by", [6.0, -6.0])
def test_a_reading_that_is_drawn_out_at_one_end_is_no_scale_error(by, monkeypatch):
    """All lengths too long by the same share is a scale; the long ones only, in two tests alike, is none."""
    lib = scaled()
    seen = readings(lib, drawn_out(lib, by))
    found = score(lib, seen)
    assert verdict(found).word == "ambiguous" and "outside" in verdict(found).candidates
    assert verdict(score(lib, readings(lib, drawn_out(lib, 1.5 * by)))).word == "outside"
    monkeypatch.setattr(outside, "OF_READING", 1e-12)
    assert (verdict(score(lib, seen)).word, verdict(score(lib, seen)).effects) == ("named", ("scale",))


def test_a_scale_that_is_off_is_still_named():
    lib = scaled()
    off = lib.responses["scale"].predictions[-1]
    said = verdict(score(lib, readings(lib, off)))
    assert (said.word, said.effects) == ("named", ("scale",))


def test_a_distorted_reading_is_learned_in_one_test_for_another():
    """`up`, not read yet, drops as far as the finger does: it will read as wrongly."""
    lib = scaled()
    problem = Problem.of(lib, readings(lib, drawn_out(lib, 12.0)))
    _, learned = outside.log_evidence(problem, lib.baseline)
    up, wrong = lib.points("up"), (drawn_out(lib, 12.0) - lib.baseline)
    assert learned[up][-1] == pytest.approx(wrong[up][-1], abs=3.0) and wrong[up][-1] > 5
    assert learned[lib.points("angle")] == pytest.approx(0.0, abs=0.5)


def test_it_is_told_whether_the_reading_or_the_finger_is_off():
    lib = scaled()
    bumped = lib.baseline + np.where(lib.owner == 2, 8.0 * np.sin(np.pi * lib.loads / 60), 0.0)
    shares = [outside.share_of_reading(Problem.of(lib, readings(lib, seen)), lib.baseline)
              for seen in (drawn_out(lib, 12.0), bumped)]
    assert shares[0] > 0.9 and shares[1] < 0.05
    scores = score(lib, readings(lib, drawn_out(lib, 12.0)))
    found = SimpleNamespace(scores=scores, verdict=verdict(scores), problem=scores.problem)
    share = document._in_reading(found)
    (flag,) = document._unknown(share)
    assert share > 0.9 and flag.startswith("unknown: rather in the reading")
    with_known = Problem.of(lib, readings(lib, bumped))
    denied = SimpleNamespace(scores=replace(scores, problem=with_known), verdict=found.verdict,
                             problem=scores.problem)
    assert document._in_reading(denied) == share
    found.verdict = replace(found.verdict, word="none")
    assert document._in_reading(found) is None
    assert not document._unknown(None) and not document._unknown(0.3)
    scores = score(lib, readings(lib, bumped))
    found = SimpleNamespace(scores=scores, verdict=verdict(scores), problem=scores.problem)
    assert found.verdict.word == "outside" and document._in_reading(found) < 0.1


def test_a_quantity_has_a_process_of_its_own_where_two_kinds_read_it():
    lib = scaled()
    rows = np.arange(lib.size)

    def readings_of(*ids):
        problem = Problem.of(lib, readings(lib, lib.baseline, ids=ids))
        return outside.processes(problem, rows, rows, 1.0)

    kinds, read = readings_of("weights", "free")
    assert (len(kinds), len(read)) == (2, 0)
    kinds, (drops,) = readings_of("weights", "free", "finger")
    assert len(kinds) == 3
    of_drops = np.array([test.quantity == "tip_drop" for test in lib.tests])[lib.owner]
    assert ((drops > 0) == np.outer(of_drops, of_drops)).all()
    a, b = lib.points("weights")[-1], lib.points("finger")[-1]
    assert lib.baseline[a] == pytest.approx(lib.baseline[b]) and drops[a, b] == pytest.approx(drops[a, a])


def test_what_is_read_above_the_palm_is_not_what_is_read_below_it():
    lib = scaled()
    up = lib.points("up")
    lib = replace(lib, baseline=np.where(lib.owner == lib.owner[up[0]], -lib.baseline, lib.baseline))
    problem, rows = Problem.of(lib, readings(lib, lib.baseline)), np.arange(lib.size)
    _, (drops,) = outside.processes(problem, rows, rows, 0.35)
    below = lib.points("finger")[-1]
    assert lib.baseline[up[-1]] == pytest.approx(-lib.baseline[below])
    assert drops[up[-1], below] < 1e-3 * drops[below, below]


@pytest.mark.parametrize(("kinds", "quantities"), [(1, 0), (3, 0), (3, 1), (4, 2), (6, 1)])
def test_what_is_unknown_is_somewhere(kinds, quantities):
    rows = outside.amplitudes(kinds, quantities)
    shares = np.exp([weight for _, weight in rows])
    assert shares.sum() == pytest.approx(1.0)
    of_kinds, of_readings = (np.array([any(row[part]) for row, _ in rows])
                             for part in (slice(kinds), slice(kinds, None)))
    assert (of_kinds ^ of_readings).all()
    assert shares[of_readings].sum() == pytest.approx(outside.OF_READING if quantities else 0.0)
