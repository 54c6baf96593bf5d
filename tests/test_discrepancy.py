"""Scoring, verdict and the next test, on arrays: against integrals done otherwise, and as
properties."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handgen.discrepancy import ask, gaussian, law, outside, untold
from handgen.discrepancy.library import Series, same_state
from handgen.discrepancy.observed import Observed, Readings
from handgen.discrepancy.problem import SCALE_WEIGHTS, SCALES, Problem
from handgen.discrepancy.score import lawful, score, score_problem
from handgen.discrepancy.verdict import verdict
from tests.small_library import MORE, TESTS, library, readings, truth


def test_evidence_is_the_integral_over_everything_that_is_open():
    """Sums over 60000 draws of all nuisances, structural errors and sizes; the closed form must lie within 3
    sigma."""
    lib = library()
    seen = readings(lib, truth(lib, sag=0.4))
    problem = Problem.of(lib, seen)
    found = score_problem(problem, pairs=False)
    rng = np.random.default_rng(1)
    scales = rng.choice(SCALES, 60000, p=SCALE_WEIGHTS)
    nuisances = rng.standard_normal((60000, 3)) * np.sqrt(np.diag(lib.prior))
    response = lib.responses["sag"]
    sizes = rng.choice(
        np.linspace(0, 2, 2001),
        60000,
        p=_share(np.interp(np.linspace(0, 2, 2001), response.axes[0], response.densities[0])),
    )
    move = response.predictions[-1] - response.predictions[0]
    for name, centre in (("none", 0.0), ("sag", sizes[:, None] / 2 * move)):
        logs = []
        for scale in SCALES:
            chosen = scales == scale
            mean = (
                lib.baseline + (centre[chosen] if name == "sag" else 0.0) + nuisances[chosen] @ lib.jacobian.T
            )
            whiten = gaussian.Whitener.of(problem.reading + scale**2 * lib.structural)
            logs.append(whiten.log_density(problem.data - mean))
        logs = np.concatenate(logs)
        terms = np.exp(logs - logs.max())
        sampled = logs.max() + np.log(terms.mean())
        error = terms.std() / terms.mean() / np.sqrt(len(terms))
        assert found[name].log_evidence == pytest.approx(sampled, abs=max(3 * error, 0.02))
        assert error < 0.5


def _share(weights):
    return weights / weights.sum()


def test_probabilities_add_up_and_order_the_hypotheses():
    lib = library()
    found = score(lib, readings(lib, truth(lib, curl=1.0)))
    shares = [h.probability for h in found.hypotheses]
    assert sum(shares) == pytest.approx(1.0)
    assert shares == sorted(shares, reverse=True)
    assert {"none", "outside", "sag", "sag+curl"} <= set(found.probabilities)


@pytest.mark.parametrize("seed", range(5))
def test_nothing_hidden_is_called_nothing(seed):
    lib = library()
    assert verdict(score(lib, readings(lib, lib.baseline, seed))).word == "none"


@pytest.mark.parametrize("effect", ["sag", "curl", "soft"])
def test_a_clear_effect_is_named_with_its_size(effect):
    lib = library()
    found = score(lib, readings(lib, truth(lib, **{effect: 1.2})))
    said = verdict(found)
    assert (said.word, said.effects) == ("named", (effect,))
    (size,) = found[effect].parameters[effect]
    assert size.low <= 1.2 <= size.high
    assert size.value == pytest.approx(1.2, abs=0.3)


def test_what_the_gauge_may_be_off_by_is_no_effect():
    lib = library()
    assert verdict(score(lib, readings(lib, lib.baseline + 3.0 * lib.jacobian[:, 2]))).word == "none"


def test_two_effects_are_a_pair():
    lib = library()
    said = verdict(score(lib, readings(lib, truth(lib, curl=1.0, soft=1.0))))
    assert (said.word, set(said.effects)) == ("pair", {"curl", "soft"})


def test_a_second_effect_is_named_only_where_one_alone_is_given_up():
    lib = library()
    found = score(lib, readings(lib, truth(lib, curl=1.0, soft=1.0), 3))
    assert verdict(found).word == "pair"

    def said(chance, probability):
        changed = [replace(one, p_value=chance, probability=probability) if one.id == "curl" else one
                   for one in found.hypotheses]
        return verdict(replace(found, hypotheses=tuple(changed)))

    assert said(0.01, 1e-5).word == said(0.0005, 0.01).word == "pair"
    assert said(0.01, 0.01).word == "ambiguous"
    assert (said(0.5, 0.01).word, said(0.5, 0.01).effects) == ("named", ("curl",))


def test_what_is_certain_is_named_where_a_second_effect_is_open():
    """The curl cannot be missed; of the softness a little is there, which noise could be as well."""
    lib = library()
    found = [score(lib, readings(lib, truth(lib, curl=1.2, soft=0.5), seed)) for seed in range(8)]
    open_ = [one for one in found if one.present("curl") >= 0.9 and one.hypotheses[0].id == "curl+soft"
             and one.hypotheses[0].probability < 0.9]
    assert open_
    for one in open_:
        said = verdict(one)
        assert (said.word, said.effects, said.best.id) == ("named", ("curl",), "curl")


def test_something_else_is_outside_and_never_named():
    lib = library()
    odd = np.where(lib.owner == 1, 3.0 * np.cos(lib.loads / 5), 0.0)
    assert verdict(score(lib, readings(lib, lib.baseline + odd))).word == "outside"


def test_what_is_unknown_is_called_so_only_where_that_is_rather_so_than_not():
    lib = library()
    odd = np.where(lib.owner == 1, 3.0 * np.cos(lib.loads / 5), 0.0)
    found = score(lib, readings(lib, lib.baseline + odd))
    best, second, *others = found.hypotheses
    assert best.id == "outside"
    for share, word in ((0.6, "outside"), (0.45, "ambiguous")):
        third, *rest = [replace(h, probability=0.0) for h in others]
        split = (replace(best, probability=share), replace(second, probability=0.3),
                 replace(third, probability=0.7 - share), *rest)
        assert verdict(replace(found, hypotheses=split)).word == word


def test_a_struck_off_effect_is_not_replaced_by_a_wrong_one():
    lib = library().without("sag", "curl", "slide", "glide")
    said = verdict(score(lib, readings(lib, truth(library(), sag=1.0))))
    assert said.word in ("outside", "ambiguous")


def test_striking_an_effect_off_is_scoring_without_it():
    lib = library()
    seen = readings(lib, truth(lib, sag=1.0))
    struck, anew = score(lib, seen).without("sag"), score(lib.without("sag"), seen)
    assert list(struck.probabilities) == list(anew.probabilities)
    assert list(struck.probabilities.values()) == pytest.approx(list(anew.probabilities.values()))


def test_what_does_not_fit_is_vetoed():
    """The only explanation offered is far better than none and still wrong."""
    lib = library().without("sag", "curl", "slide", "glide")
    found = score(lib, readings(lib, truth(lib, soft=1.0) + np.where(lib.loads == 0.3, 9.0, 0.0)))
    best = max((h for h in found.hypotheses if h.id != "outside"), key=lambda h: h.probability)
    assert best.p_value < 1e-3
    assert verdict(found).word in ("outside", "ambiguous")


def test_twins_are_told_as_a_class_and_the_test_that_parts_them_is_asked_for():
    wide = library((*TESTS, *MORE))
    seen = readings(wide, truth(wide, glide=1.0))
    found = score(wide, seen)
    said = verdict(found)
    assert said.word == "ambiguous" and set(said.effects) == {"slide", "glide"}
    assert set(said.alike) == {"slide", "glide"} and said.classes == (said.alike,)
    asked = ask.next_test(found, ["angle", "up"], {"tip_drop": 0.5, "bend_angle": 1.0})
    assert asked.test == "angle" and set(asked.separates) >= {"slide", "glide"}
    rng = np.random.default_rng(3)
    done = Readings("angle", truth(wide, glide=1.0)[wide.points("angle")] + rng.standard_normal((3, 3)), 0.5)
    settled = verdict(score(wide, Observed((*seen.tests, done))))
    assert (settled.word, settled.effects) == ("named", ("glide",))


def test_what_only_another_kind_of_test_tells_apart_is_one_class_until_it_is_done(monkeypatch):
    """However probable: a slide that creeps in is a slide to a test that only goes up."""
    creeping = SimpleNamespace(told_by={"slide": ("hold",)})
    monkeypatch.setattr(untold, "catalogue", lambda: {"glide": creeping})
    wide = library((*TESTS, *MORE))
    held = replace(wide, prior_odds={"glide": 0.01}, tests=tuple(
        replace(test, path="hold") if test.id == "angle" else test for test in wide.tests))
    seen = readings(held, truth(held, slide=1.2))
    found = score(held, seen)
    said = verdict(found)
    assert found.present("slide") >= 0.9
    assert (said.word, said.effects, said.untold) == ("ambiguous", ("slide", "glide"), ("slide", "glide"))
    assert said.classes[0] == ("slide", "glide") and said.probability >= 0.9
    blunt = {"tip_drop": 0.5, "bend_angle": 1.0}
    assert ask.next_test(found, ["up", "angle"], blunt, said.untold).test == "angle"
    assert ask.next_test(found, ["up"], blunt, said.untold) is None
    done = Readings("angle", truth(held, slide=1.2)[held.points("angle")]
                    + np.random.default_rng(3).standard_normal((3, 3)), 0.5)
    settled = verdict(score(held, Observed((*seen.tests, done))))
    assert (settled.word, settled.effects) == ("named", ("slide",))


def test_what_fits_at_no_size_needs_no_other_test_to_be_told(monkeypatch):
    monkeypatch.setattr(untold, "catalogue", lambda: {"soft": SimpleNamespace(told_by={"curl": ("hold",)})})
    lib = library()
    found = score(lib, readings(lib, truth(lib, curl=1.2)))
    assert all(h.p_value < 1e-3 for h in found.hypotheses if "soft" in h.ids and "curl" not in h.ids)
    assert verdict(found).effects == ("curl",)


def test_what_moves_nothing_that_was_read_is_no_rival(monkeypatch):
    """Beside a glide, which reads as the slide does, the softness fits; what moves nothing always would."""
    lib = replace(library(), prior_odds={"glide": 0.01})
    moves = lib.responses["soft"]
    still = replace(moves, predictions=np.broadcast_to(lib.baseline, moves.predictions.shape))
    forced = SimpleNamespace(told_by={"slide": ("force",)})
    monkeypatch.setattr(untold, "catalogue", lambda: {"soft": forced})
    seen = readings(lib, truth(lib, slide=1.2))
    assert verdict(score(lib, seen)).untold == ("slide", "soft")
    alone = replace(lib, responses={**lib.responses, "soft": still})
    assert verdict(score(alone, seen)).effects == ("slide",) and not verdict(score(alone, seen)).untold


def test_a_size_that_only_an_unread_test_cannot_predict_stays_possible():
    wide = library((*TESTS, *MORE))
    seen = readings(wide, truth(wide, sag=1.2))
    lost = wide.responses["sag"].predictions.copy()
    lost[2:, wide.points("up")] = np.nan
    sag = replace(wide.responses["sag"], predictions=lost)
    gappy = replace(wide, responses=wide.responses | {"sag": sag})
    found, whole = score(gappy, seen), score(wide, seen)
    for name in ("sag", "sag+curl"):
        assert found[name].log_evidence == pytest.approx(whole[name].log_evidence, abs=1e-9)
    assert found["sag"].parameters == whole["sag"].parameters
    assert ask.proposal(found, "up", {"tip_drop": 0.5}).gain == 0.0


def test_another_law_of_an_effect_is_still_that_effect_and_no_pair():
    """Its size grows over the load from 0.8 to 1.2, as another law's would."""
    lib = library()
    x = np.concatenate([np.array(t.loads) / max(t.loads) for t in lib.tests])
    straight = truth(lib, curl=1.5)
    bent = lib.baseline + (0.8 + 0.4 * x) * (straight - lib.baseline)
    problem = lawful(Problem.of(lib, readings(lib, bent)))
    residual = (bent - straight)[problem.scored]
    without, with_ = problem.covariance(), problem.covariance(ids=("curl",))
    assert residual @ np.linalg.solve(with_, residual) < 0.5 * residual @ np.linalg.solve(without, residual)
    said = verdict(score(lib, readings(lib, bent)))
    assert (said.word, said.effects) == ("named", ("curl",))


def test_what_a_law_gets_wrong_is_a_share_of_what_its_effect_moves():
    lib = library()
    grid = lib.responses["sag"].dense
    at = int(np.abs(grid.values[:, 0] - 1.5).argmin())
    found = law.errors(lib, {"sag": grid}, {"sag": at})["sag"]
    moved = np.abs(grid.predictions[at] - lib.baseline)
    assert np.sqrt(np.diag(found)) == pytest.approx(law.SHARE * moved, rel=1e-3)
    assert np.linalg.eigvalsh(found).min() > -1e-9 * found.max()
    assert not found[lib.points("finger")][:, lib.points("free")].any()


def test_the_way_back_repeats_the_errors_of_the_way_there():
    back = Series("back", "assembly", "tip_drop", TESTS[2].loads[::-1], path="unloading")
    same, loads = same_state((*TESTS, *MORE, back))
    lib = library((*TESTS, *MORE))
    up, down = np.flatnonzero(lib.owner == 2), lib.size + np.arange(6)
    assert same[np.ix_(up, down)].all() and loads[up] == pytest.approx(loads[down][::-1])
    assert not same[np.ix_(down, np.flatnonzero(lib.owner != 2))].any()


def test_no_test_is_asked_for_that_tells_nothing():
    wide = library((*TESTS, *MORE))
    found = score(wide, readings(wide, truth(wide, sag=1.2)))
    assert found["sag"].probability > 0.5
    blunt = {"tip_drop": 500.0, "bend_angle": 500.0}
    assert ask.next_test(found, ["angle", "up"], blunt) is None


@pytest.mark.parametrize("whole", [True, False])
def test_a_repeat_that_is_off_is_flagged_weighs_little_and_changes_no_name(whole):
    lib = library()
    seen = readings(lib, truth(lib, sag=1.0))
    rows = seen.tests[2].repeats.copy()
    rows[1] += 8 * 0.5 * (1.0 if whole else np.eye(6)[3])
    spoilt = Readings("finger", rows, 0.5)
    (place,) = spoilt.summary.outlying
    assert place[0] == 1 and place[1] == (None if whole else 3)
    moved = np.abs(spoilt.summary.means - seen.tests[2].summary.means).max()
    assert 0 < moved < 8 * 0.5 / 3 / 2
    said = verdict(score(lib, Observed((*seen.tests[:2], spoilt))))
    assert said.effects == ("sag",)


def test_good_repeats_are_rarely_flagged():
    lib = library()
    flagged = sum(bool(t.summary.outlying) for s in range(200) for t in readings(lib, lib.baseline, s).tests)
    assert flagged <= 12


def test_one_repeat_missing_readings_and_five_points_are_enough():
    lib = library()
    one = readings(lib, truth(lib, sag=1.2), repeats=1)
    assert verdict(score(lib, one)).effects == ("sag",)
    rows = [t.repeats.copy() for t in readings(lib, truth(lib, sag=1.2)).tests]
    rows[2][0, 2:4], rows[2][:, 5], rows[0][1] = np.nan, np.nan, np.nan
    gappy = Observed(tuple(Readings(t.id, r, 0.5) for t, r in zip(TESTS, rows, strict=True)))
    assert verdict(score(lib, gappy)).effects == ("sag",)
    assert Problem.of(lib, gappy).points.size == lib.size - 1
    only = readings(lib, truth(lib, sag=1.2)).only(["finger"])
    assert verdict(score(lib, only)).word in ("named", "ambiguous")


def test_readings_that_do_not_belong_are_refused():
    lib = library()
    with pytest.raises(ValueError, match="3 loads read, 4 predicted"):
        score(lib, Observed((Readings("free", np.ones((2, 3))),)))
    with pytest.raises(ValueError, match="no reading at all"):
        score(lib, Observed((Readings("free", np.full((2, 4), np.nan)),)))


def test_probabilities_mean_what_they_say():
    """Worlds drawn from the priors themselves: of what is called p probable, a share p is true."""
    lib, rng = library(), np.random.default_rng(7)
    names = list(lib.responses)
    chances, hits = [], []
    for seed in range(150):
        kind = rng.choice(["none", "single"], p=[0.40 / 0.70, 0.30 / 0.70])
        hidden = str(rng.choice(names)) if kind == "single" else "none"
        sizes = {} if hidden == "none" else {hidden: float(np.clip(1 + 0.4 * rng.standard_normal(), 0, 2))}
        scale = rng.choice(SCALES, p=SCALE_WEIGHTS)
        world = (
            truth(lib, **sizes)
            + lib.jacobian @ (np.sqrt(np.diag(lib.prior)) * rng.standard_normal(3))
            + scale
            * np.linalg.cholesky(lib.structural + 1e-9 * np.eye(lib.size))
            @ rng.standard_normal(lib.size)
        )
        found = score(lib, readings(lib, world, seed), pairs=False)
        for name, chance in found.probabilities.items():
            chances.append(chance)
            hits.append(name == hidden)
    chances, hits = np.array(chances), np.array(hits)
    for low, high in ((0.0, 0.1), (0.1, 0.5), (0.5, 0.9), (0.9, 1.01)):
        here = (chances >= low) & (chances < high)
        spread = np.sqrt(max(chances[here].mean() * (1 - chances[here].mean()), 1e-3) / here.sum())
        assert abs(hits[here].mean() - chances[here].mean()) < 3 * spread + 0.03


def test_the_process_outside_learns_a_residual_and_forgets_it_far_away():
    lib = library()
    odd = np.where(lib.owner == 1, 4.0, 0.0)
    evidence, learned = outside.log_evidence(Problem.of(lib, readings(lib, lib.baseline + odd)), lib.baseline)
    assert np.isfinite(evidence)
    assert learned[lib.points("free")] == pytest.approx(4.0, abs=1.5)
    assert np.abs(learned[lib.points("weights")]).max() < 1.5
