"""What is known to be missing is on and open, and two effects do more than their sum: on arrays."""

from dataclasses import replace

import numpy as np
import pytest

from handgen.discrepancy import ask, law
from handgen.discrepancy.hypothesis import REFUTED
from handgen.discrepancy.library import Interplay, Library, size_name
from handgen.discrepancy.pairs import Together, coarsened
from handgen.discrepancy.problem import Problem
from handgen.discrepancy.score import score, score_problem
from handgen.discrepancy.verdict import MISFIT, SURE, verdict
from tests.small_library import MORE, TESTS, library, readings, truth


def together(lib, excess, at=1.2):
    """`lib` in which a curl and softness of size `at` go `excess` (n,) further than their sum."""
    alone = np.array([truth(lib, **{name: at}) - lib.baseline for name in ("curl", "soft")])
    return replace(lib, interplays={("curl", "soft"): Interplay(alone, excess)})


def test_two_effects_that_enhance_each_other_are_the_pair_where_that_was_simulated():
    """The sum of both does not fit: something unknown, until the interplay is known."""
    lib = library().without("slide", "glide")
    excess = np.where(lib.owner == 2, 8.0 * np.sin(np.pi * lib.loads / 20), 0.0)
    seen = readings(lib, truth(lib, curl=1.2, soft=1.2) + excess)
    added, simulated = score(lib, seen), score(together(lib, excess), seen)
    assert verdict(added).word == "outside"
    said = verdict(simulated)
    assert (said.word, set(said.effects)) == ("pair", {"curl", "soft"}) and said.best.p_value > 0.05


def test_an_interplay_goes_with_the_product_of_both_sizes():
    """At half of the curl, half of what both do beyond their sum."""
    lib = library()
    excess = np.where(lib.owner == 2, 4.0, 0.0)
    first, second = (coarsened(lib.responses[name]) for name in ("curl", "soft"))
    found = Together.of(together(lib, excess), "curl", "soft", first, second, np.arange(lib.size))
    assert found.first == pytest.approx(first.values[:, 0] / 1.2)
    assert found.second == pytest.approx(second.values[:, 0] / 1.2)
    problem = Problem.of(together(lib, excess), readings(lib, truth(lib, curl=0.6, soft=1.2) + excess / 2))
    pair = score_problem(problem)["curl+soft"]
    wanted = truth(lib, curl=pair.parameters["curl"][0].value, soft=pair.parameters["soft"][0].value)
    by = pair.parameters["curl"][0].value * pair.parameters["soft"][0].value / 1.44
    assert pair.centre == pytest.approx(wanted + by * excess, abs=0.1)
    size = pair.parameters["curl"][0]
    assert size.low <= 0.6 <= size.high and pair.p_value > 0.05


def test_an_interplay_without_balance_at_a_reading_is_not_used():
    """At one of the loads: what is known at the others is then nothing to go by either."""
    lib = library()
    excess = np.where(lib.owner == 2, 8.0 * np.sin(np.pi * lib.loads / 20), 0.0)
    excess[lib.points("finger")[-1]] = np.nan
    seen = readings(lib, truth(lib, curl=1.0, soft=1.0))
    found = [score(one, seen)["curl+soft"].log_evidence for one in (together(lib, excess), lib)]
    assert found[0] == pytest.approx(found[1])


@pytest.mark.parametrize("soft", [0.5, 0.8])
def test_a_pair_that_is_likelier_than_the_one_effect_that_is_named_is_asked_about(soft):
    """The curl alone fits, so it is named; a test tells the two apart however sure it seems."""
    lib = library((*TESTS, *MORE))
    scores = score(lib, readings(lib, truth(lib, curl=0.7, soft=soft)))
    said = verdict(scores)
    assert (said.word, said.effects, said.or_both) == ("named", ("curl",), ("curl", "curl+soft"))
    assert said.more > SURE
    told = ask.next_test(scores, ["angle", "up"], {"bend_angle": 1.0, "tip_drop": 0.5}, or_both=said.or_both)
    assert set(told.separates) == {"curl", "curl+soft"} and told.gain > 0.1
    scores = score(lib, readings(lib, truth(lib, curl=0.7, soft=0.9)))
    badly = verdict(scores)
    assert badly.word == "ambiguous" and badly.or_both == ("curl", "curl+soft")
    assert MISFIT > scores["curl"].p_value > REFUTED
    sure = verdict(score(lib, readings(lib, truth(lib, curl=1.0, soft=1.0))))
    assert sure.word == "pair" and not sure.or_both


def with_sag(lib, size=1.0, off=0.4):
    """What a model with the sag at `size` says, by how much that is off left open."""
    sag = lib.responses["sag"]
    move = (sag.predictions[-1] - lib.baseline) / sag.axes[0][-1]
    others = {name: replace(one, predictions=one.predictions + size * move)
              for name, one in lib.responses.items() if name != "sag"}
    return replace(
        lib, baseline=lib.baseline + size * move, responses=others, on={"sag": {"size": size}},
        nuisances=(*lib.nuisances, size_name("sag", "size")),
        prior=np.diag([*np.diag(lib.prior), off**2]), jacobian=np.column_stack([lib.jacobian, move]))


def known(lib, seen, probability=0.99):
    """Scores where a direct check says that the sag is missing."""
    return score(with_sag(lib), seen).or_else(score(lib, seen).without("sag"), probability)


def test_an_effect_known_to_be_missing_is_named_though_more_may_be_missing():
    """A surprise at the first load: without the check it is something unknown, with it beside the sag."""
    lib = library(structural=1.5)
    world = truth(lib, sag=0.6)
    world[lib.points("finger")[0]] -= 5.0
    seen = readings(lib, world)
    assert verdict(score(lib, seen)).word != "named"
    found = known(lib, seen)
    said = verdict(found)
    assert (said.word, said.effects, said.known) == ("named", ("sag",), ("sag",))
    assert said.best.id == "sag" and said.best.ids == ("sag",)
    assert sum(h.probability for h in found.hypotheses) == pytest.approx(1.0)
    assert found["sag+outside"].probability > found["outside"].probability


def test_beside_what_is_known_one_more_effect_is_named_by_the_readings():
    lib = library()
    found = known(lib, readings(lib, truth(lib, sag=0.8, soft=1.2)))
    said = verdict(found)
    assert (said.word, said.effects, said.known) == ("pair", ("sag", "soft"), ("sag",))
    assert said.best.id == "sag+soft"
    (size,) = said.best.parameters["sag"]
    assert size.low <= 0.8 <= size.high < 1.6 and size.value == pytest.approx(0.8, abs=0.1)
    assert said.best.parameters["soft"][0].value == pytest.approx(1.2, abs=0.3)


def test_what_is_on_is_as_open_as_an_effect_of_the_catalogue():
    """The sag at 1, off by 0.2, and a sag with this prior that the scoring sums over are the same."""
    lib, size = library(), np.linspace(0.2, 1.8, 41)
    sag = lib.responses["sag"]
    move = (sag.predictions[-1] - lib.baseline) / sag.axes[0][-1]
    bell = np.exp(-((size - 1.0) / 0.2)**2 / 2)
    same = replace(sag, axes=(size,), densities=(bell,), predictions=lib.baseline + np.outer(size, move))
    seen = readings(lib, truth(lib, sag=0.9))
    summed, on = (_without_laws(Problem.of(one, seen))["sag"].log_evidence
                  for one in (replace(lib, responses={"sag": same}), with_sag(lib, off=0.2)))
    assert on == pytest.approx(summed, abs=0.02)


def _without_laws(problem):
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(law, "SHARE", 0.0)
        return score_problem(problem, pairs=False)


def test_either_of_two_libraries_is_weighed_by_its_evidence():
    lib = library()
    seen = readings(lib, truth(lib, sag=1.0))
    on, off = score(with_sag(lib), seen), score(lib, seen).without("sag")
    found = on.or_else(off, 0.99)
    odds = np.log(found["sag"].probability / found["none"].probability)
    own = np.log(on["sag"].probability) + on.log_evidence - np.log(off["none"].probability) - off.log_evidence
    assert odds - own == pytest.approx(np.log(99.0))
    assert np.logaddexp(on.log_evidence + np.log(0.99), off.log_evidence + np.log(0.01)) \
        == pytest.approx(found.log_evidence)


def test_readings_that_deny_what_is_known_are_believed():
    lib = library()
    said = verdict(known(lib, readings(lib, lib.baseline)))
    assert (said.word, said.known) == ("none", ())


def test_a_library_survives_its_file(tmp_path):
    lib = together(with_sag(library()), np.ones(library().size))
    lib.save(tmp_path / "library.npz")
    again = Library.load(tmp_path / "library.npz")
    seen = readings(lib, truth(lib, curl=1.0))
    assert score(again, seen).probabilities == score(lib, seen).probabilities
    assert [p.name for p in tmp_path.iterdir()] == ["library.npz"]
