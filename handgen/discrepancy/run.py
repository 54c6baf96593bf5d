"""The whole diagnosis: check, locate, score, name, patch, show the gap, ask for the next test."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from handgen.bending.model import BendModel, default_name, load_model
from handgen.discrepancy import convention, nuisance, simulated
from handgen.discrepancy.ask import Proposal, next_test
from handgen.discrepancy.candidates import SIGMAS, candidates
from handgen.discrepancy.closely import beside_missing, closely
from handgen.discrepancy.direct import Finding, findings, materials
from handgen.discrepancy.library import NONE, Library
from handgen.discrepancy.locate import STANDS_OUT, Located, locate
from handgen.discrepancy.observed import Observed
from handgen.discrepancy.problem import Problem
from handgen.discrepancy.readings import chosen, observed_of
from handgen.discrepancy.refit import Fitted, Refit
from handgen.discrepancy.score import Scores, score_problem
from handgen.discrepancy.sides import either_way, which_way
from handgen.discrepancy.simulated import Simulation
from handgen.discrepancy.verdict import Verdict, verdict
from handgen.discrepancy.worker import Bends
from handgen.effects import catalogue
from handgen.errors import InputError
from handgen.errors import Problem as Wrong
from handgen.measurements.load import Measured, load_measurements
from handgen.measurements.model import Test
from handgen.parameters.load import load

WORKERS = 2
MISREAD = "wrong_convention"
ODDS = 10.0
"""By which a direct check that points to an effect raises its odds."""
MOST = 8
"""Effects that the next test may tell apart, the most probable first: each is simulated in all tests."""
DRIFT = 3.0
"""Deviations from which a drift is spoken of."""


@dataclass(frozen=True)
class Diagnosis:
    """Everything that was found."""

    measured: Measured
    model: BendModel
    tests: tuple[Test, ...]
    """Those that were scored."""
    held_out: tuple[Test, ...]
    """Those that were only predicted."""
    findings: tuple[Finding, ...]
    located: tuple[Located, ...]
    problem: Problem
    """Of the model as it was."""
    scores: Scores
    verdict: Verdict
    retuned: Fitted
    patched: Fitted
    predictions: dict[str, dict[str, np.ndarray]]
    """before, retuned, patched -> held-out test -> what it would read."""
    next_test: tuple[Test, Proposal] | None
    materials: dict[str, str]
    """Body -> material."""
    solved: int
    """Bends that were not in the cache."""
    flags: tuple[str, ...] = field(default=())


def diagnose(
    measurements: str | os.PathLike,
    *,
    params: str | os.PathLike | None = None,
    model: str | os.PathLike | None = None,
    seed: int = 0,
    workers: int = WORKERS,
    progress: Callable[[str], None] = lambda line: None,
) -> Diagnosis:
    """Hold `model` (a name of params/models, or a file) against a measurements file.

    `params`: another hand than the file names. `seed`: of the ensemble within tolerance.

    Raises:
        InputError: everything wrong with measurements, hand and model.
        EngineError: a solver cannot be loaded, or the model finds no balance at all.
    """
    measured = load_measurements(measurements)
    if params is not None:
        measured = replace(measured, hand=load(params))
    subject = load_model(model if model is not None else default_name())[0]
    tests, held_out, remarks = chosen(measured.measurements.tests)
    if not tests:
        all_held_out = "all are held out: nothing can be diagnosed"
        raise InputError([Wrong(str(measured.file), "tests", None, all_held_out,
                                "a test with `held_out: false`")])
    bends = Bends(workers, progress)
    simulation = Simulation(measured, tests, subject, bends, seed)
    observed = observed_of(tests)
    found = tuple(findings(subject, measured.hand.hand, measured.measurements))
    odds = _odds(subject, measured, found)
    plain = score_problem(Problem.of(replace(simulated.library(simulation), prior_odds=odds), observed))
    missing = {one.effect: one.probability for one in found
               if one.probability is not None and one.effect in plain.problem.library.responses}
    if missing:
        wider, scores = _with_missing(simulation, plain, missing, observed)
    else:
        wider, scores = simulation, closely(simulation, plain, observed)
    said = verdict(scores)
    progress(f"verdict: {said.word} {', '.join(said.effects)}")
    left_open = nuisance.nuisances(list(tests))
    retuned = Refit(simulation, plain.problem, left_open, (), "re-tuned only").run(plain[NONE])
    patched = retuned
    if said.best.ids and (said.known or said.word in ("named", "pair", "ambiguous")):
        problem = scores.problem if said.known else plain.problem
        patched = Refit(simulation, problem, left_open, said.best.ids, "patched").run(said.best)
    asked = None
    if said.word == "ambiguous" or said.or_both or either_way(said):
        asked = _next(wider if said.known else simulation, scores, said, observed)
    located = tuple(locate(plain.problem.library, observed))
    return Diagnosis(
        measured,
        subject,
        tests,
        held_out,
        found,
        located,
        plain.problem,
        scores,
        said,
        retuned,
        patched,
        _held_out(simulation, held_out, left_open, retuned, patched),
        asked,
        materials(measured.hand.hand),
        bends.solved,
        (*remarks, *_flags(plain.problem.library, located)),
    )


def _odds(model: BendModel, measured: Measured, found: Sequence[Finding]) -> dict[str, float]:
    """Effect -> by what direct checks multiply its odds."""
    odds = {one.effect: ODDS for one in found if one.effect and one.probability is None}
    read = convention.odds(model, list(materials(measured.hand.hand).values()))
    if read is not None:
        odds[MISREAD] = max(read, odds.get(MISREAD, 0.0))
    return odds


def _with_missing(simulation: Simulation, plain: Scores, missing: Mapping[str, float],
                  observed: Observed) -> tuple[Simulation, Scores]:
    """(`simulation` with the `missing` effects on, see `beside_missing`)."""
    simulation.bends.progress(f"the same with {' and '.join(missing)}")
    wider = replace(simulation, on={name: catalogue()[name].filled({}) for name in missing})
    library = replace(simulated.library(wider), prior_odds=plain.problem.library.prior_odds)
    return wider, beside_missing(wider, library, plain, missing, observed)


def _next(simulation: Simulation, scores: Scores, said: Verdict,
          observed: Observed) -> tuple[Test, Proposal] | None:
    """The test that best separates what is left."""
    asked = candidates(simulation.measured.measurements.tests)
    if not asked:
        return None
    simulation.bends.progress("which test next")
    wider, names = replace(simulation, tests=(*simulation.tests, *asked)), [test.id for test in asked]
    ways = either_way(said)
    likely = list(ways) or list(dict.fromkeys(name for one in said.candidates for name in scores[one].ids))
    library = simulated.library(wider, only=likely[:MOST], members=simulated.FEW)
    problem = Problem.of(library, observed)
    if ways:
        proposal = which_way(problem, ways, names)
    else:
        proposal = next_test(score_problem(problem), names, SIGMAS, said.untold, said.or_both)
    return None if proposal is None else (next(t for t in asked if t.id == proposal.test), proposal)


def _held_out(
    simulation: Simulation,
    tests: Sequence[Test],
    left_open: Sequence[nuisance.Nuisance],
    retuned: Fitted,
    patched: Fitted,
) -> dict[str, dict[str, np.ndarray]]:
    """What each model says about tests that nothing was fitted on."""
    if not tests:
        return {}
    other = replace(simulation, tests=tuple(tests))
    rows = [other.row()]
    for fitted in (retuned, patched):
        rows.append(
            other.row(other.with_effects(fitted.effects()), simulated.shifted(left_open, fitted.nuisances()))
        )
    predictions = other.predict(rows, "held-out tests")
    ends = np.cumsum([len(test.load.values) for test in tests])[:-1]
    return {
        state: dict(zip([test.id for test in tests], np.split(row, ends), strict=True))
        for state, row in zip(("before", "retuned", "patched"), predictions, strict=True)
    }


def _flags(library: Library, located: Sequence[Located]) -> Iterator[str]:
    """What a user must know of the readings and of what could not be simulated."""
    for one in located:
        for repeat, at, sigmas in one.outlying:
            where = "as a whole" if at is None else f"at {at:g}"
            yield (f"outlying repeat: {one.test}, repeat {repeat} {where}, {sigmas:+.1f} deviations off the "
                   "others; kept, with little weight")
        if one.assumed is not None:
            yield (f"one repeat: {one.test} was read once at each load: a scatter of {one.assumed:.2g} "
                   f"{one.unit} is assumed; a second repeat would show it")
        if one.last is not None and abs(one.last[1]) >= STANDS_OUT:
            yield (f"last load: {one.test} at {one.points[-1].load:g}: the model leaves the course of the "
                   f"other loads by {one.last[0]:+.2g} {one.unit} ({abs(one.last[1]):.1f} deviations): "
                   "something may begin there that the model does not know, a fold or a contact")
        if one.drift is not None and abs(one.drift[1]) >= DRIFT:
            yield f"drift: {one.test} moves by {one.drift[0]:+.2g} {one.unit} from repeat to repeat"
    for test in library.tests:
        values = library.baseline[library.points(test.id)]
        lost = ", ".join(f"{at:g}" for at, value in zip(test.loads, values, strict=True)
                         if not np.isfinite(value))
        if lost:
            yield f"not simulated: {test.id} at {lost}: the model finds no balance there"
