"""A diagnosis as the contract's `handgen.diagnosis/1`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from handgen import __version__
from handgen.discrepancy import outside
from handgen.discrepancy.candidates import words
from handgen.discrepancy.gap import STATES, gaps, pooled, unit_of
from handgen.discrepancy.run import Diagnosis
from handgen.discrepancy.sides import either_way
from handgen.discrepancy.verdict import RATHER
from handgen.effects import catalogue

SCHEMA = "handgen.diagnosis/1"
BESIDE = 0.3
"""Probability from which it is said that more may be missing than what is named."""


def document(found: Diagnosis, model_file: str) -> dict[str, Any]:
    """JSON data; residuals are simulated less measured, in the unit of each test."""
    problem = found.problem
    before = problem.library.baseline
    unit = unit_of(problem)
    retuned, patched = found.retuned, found.patched
    in_reading = _in_reading(found)
    return {
        "schema": SCHEMA,
        "name": found.measured.measurements.name,
        "hand": found.measured.hand.hand.name,
        "finger": found.measured.measurements.finger,
        "diagnosed_model": found.model.name,
        "verdict": found.verdict.word,
        "probability": _number(found.verdict.probability),
        "effects": [_effect(found, name) for name in found.verdict.effects],
        "candidates": [
            {
                "id": h.id,
                "probability": h.probability,
                "log_evidence": _number(h.log_evidence),
                "chance_of_misfit": _number(h.p_value),
            }
            for h in found.scores.hypotheses
        ],
        "classes": [
            {"ids": list(ids), "probability": sum(found.scores[one].probability for one in ids)}
            for ids in found.verdict.classes
        ],
        "where": _where(found),
        "located": [_located(one) for one in found.located],
        "gap": {
            "unit": unit,
            "rms": _states(
                pooled(
                    problem,
                    {"before": before, "retuned": retuned.predicted, "patched": patched.predicted},
                    unit,
                )
            ),
            "held_out": _states(
                pooled(
                    problem,
                    {"before": before, "retuned": retuned.left_out, "patched": patched.left_out},
                    unit,
                )
            ),
            "tests": _test_gaps(found),
        },
        "next_test": _next(found),
        "measure_directly": _directly(found),
        "unknown_in_reading": in_reading,
        "model": model_file,
        "patch": list(found.patched.effects()),
        "retuned": _nuisances(found, retuned),
        "patched": _nuisances(found, patched),
        "checks": [asdict(one) for one in found.findings],
        "flags": [*(str(one) for one in found.findings), *found.flags, *_vetoed(found), *_cut(found),
                  *_beside(found), *_unknown(in_reading)],
        "curves": _curves(found),
        "bends_solved": found.solved,
        "handgen_version": __version__,
    }


def _effect(found: Diagnosis, name: str) -> dict[str, Any]:
    effect = catalogue()[name]
    either = name in either_way(found.verdict)
    fitted = found.patched.effects().get(name)
    estimates = next((h.parameters[name] for h in found.scores.hypotheses if name in h.ids), ())
    if found.verdict.best.ids and name in found.verdict.best.ids:
        estimates = found.verdict.best.parameters[name]
    parameters = []
    for estimate in estimates:
        value, low, high = estimate.value, estimate.low, estimate.high
        if fitted and estimate.name in fitted:
            sigma = found.patched.sigma(name, estimate.name)
            about = next(p for p in effect.parameters if p.name == estimate.name)
            value = fitted[estimate.name]
            low, high = max(value - 1.96 * sigma, about.low), min(value + 1.96 * sigma, about.high)
        if either:
            # The fit knows but the side that it began on
            low, high = min(low, estimate.wide[0]), max(high, estimate.wide[1])
        unit = next(p.unit for p in effect.parameters if p.name == estimate.name)
        parameters.append(
            {
                "name": estimate.name,
                "unit": unit,
                "value": _number(value),
                "low": _number(low),
                "high": _number(high),
            }
        )
    said = effect.said({p["name"]: p["value"] for p in parameters})
    if either:
        said += "; or it is the other way round, which these readings do not rule out"
    return {
        "id": name,
        "name": effect.name,
        "sentence": said,
        "probability": found.scores.present(name),
        "parameters": parameters,
        "signature": effect.signature,
        "settle": effect.settle,
        "settled": _settled(found, name),
        "source": effect.source,
    }


def _where(found: Diagnosis) -> list[dict[str, Any]]:
    """Every point that is off by more than three deviations of its mean, the largest first."""
    units = {one.test: one.unit for one in found.located}
    points = [point for one in found.located for point in one.points if abs(point.sigmas) >= 3.0]
    return [
        {
            "test": p.test,
            "load": p.load,
            "residual": _number(p.residual),
            "unit": units[p.test],
            "sigmas": _number(p.sigmas),
        }
        for p in sorted(points, key=lambda p: -abs(p.sigmas))
    ]


def _located(one) -> dict[str, Any]:
    return {
        "test": one.test,
        "unit": one.unit,
        "beyond_repeats": one.beyond,
        "misfit": _number(one.misfit),
        "chance": _number(one.chance),
        "words": one.words,
        "points": [
            {"load": p.load, "residual": _number(p.residual), "sigmas": _number(p.sigmas)} for p in one.points
        ],
        **{name: {"size": _number(size), "sigmas": _number(sigmas)} for name, size, sigmas in one.shapes},
        "last_point": None
        if one.last is None
        else {"size": _number(one.last[0]), "sigmas": _number(one.last[1])},
        "drift": None
        if one.drift is None
        else {"per_repeat": _number(one.drift[0]), "sigmas": _number(one.drift[1])},
        "assumed_scatter": _number(one.assumed),
        "outlying": [
            {"repeat": repeat, "load": load, "sigmas": _number(sigmas)}
            for repeat, load, sigmas in one.outlying
        ],
    }


def _test_gaps(found: Diagnosis) -> list[dict[str, Any]]:
    """Of every test, those last that nothing was fitted on."""
    before = found.problem.library.baseline
    rows = [_test_gap(one) for one in gaps(found.problem, before, found.retuned, found.patched)]
    titles = {test.id: test.title or test.id for test in (*found.tests, *found.held_out)}
    return [{"title": titles[row["test"]], **row} for row in rows + _held_out(found)]


def _test_gap(one) -> dict[str, Any]:
    return {
        "test": one.test,
        "unit": one.unit,
        "rms": _states(one.fitted),
        "held_out": _states(one.held_out),
        "held_out_test": False,
    }


def _held_out(found: Diagnosis) -> list[dict[str, Any]]:
    """Gaps of tests that nothing was fitted on."""
    rows = []
    for test in found.held_out:
        from handgen.measurements.statistics import means

        mean = np.array([np.nan if m is None else m for m in means(test)])
        values = {state: _rms(found.predictions[state][test.id] - mean) for state in STATES}
        rows.append(
            {
                "test": test.id,
                "unit": test.observable.unit,
                "rms": dict.fromkeys(STATES),
                "held_out": _states(values),
                "held_out_test": True,
            }
        )
    return rows


def _rms(residual: np.ndarray) -> float | None:
    residual = residual[np.isfinite(residual)]
    return float(np.sqrt((residual**2).mean())) if len(residual) else None


def _next(found: Diagnosis) -> dict[str, Any] | None:
    if found.next_test is None:
        return None
    test, proposal = found.next_test
    return {
        "part": test.part,
        "orientation": test.orientation,
        "path": test.path,
        "load": test.load.model_dump(),
        "observable": test.observable.model_dump(),
        "separates": list(proposal.separates),
        "gain": _number(proposal.gain),
        "words": words(test),
    }


def _directly(found: Diagnosis) -> dict[str, Any] | None:
    """The direct measurement of the effect that it is most open about, where nothing is named; none that was
    made."""
    left = [name for name in found.verdict.effects if not _settled(found, name)]
    if found.verdict.word != "ambiguous" or not left:
        return None
    name = max(left, key=lambda one: -abs(found.scores.present(one) - 0.5))
    effect = catalogue()[name]
    return {"effect": name, "name": effect.name, "how": effect.settle}


def _settled(found: Diagnosis, name: str) -> bool:
    """Whether a test is the direct measurement of an effect."""
    return any(test.observable.quantity in catalogue()[name].settled_by for test in found.tests)


def _nuisances(found: Diagnosis, fitted) -> dict[str, float]:
    """Values of what every model leaves open; stiffnesses as factors."""
    return {
        name: _number(float(np.exp(value)) if name.startswith("stiffness") else value)
        for name, value in fitted.nuisances().items()
    }


def _vetoed(found: Diagnosis) -> list[str]:
    if not found.verdict.vetoed:
        return []
    best = found.scores.hypotheses[0]
    return [
        f"vetoed: {best.id} is the most probable explanation, but does not fit: chance of so large a "
        f"misfit "
        f"{best.p_value:.1g}"
    ]


def _cut(found: Diagnosis) -> list[str]:
    """Sizes beyond which the model cannot follow the readings."""
    best = found.scores.hypotheses[0]
    if found.verdict.word != "ambiguous":
        return []
    return [f"beyond the model: {best.id} is the most probable explanation, and is so with the last size of "
            f"{name} that the model finds a balance for: more of it, or something else, cannot be judged"
            for name in best.cut]


def _beside(found: Diagnosis) -> list[str]:
    """Beside what is named, what else the readings ask for."""
    named, more = found.verdict.effects, found.verdict.more
    if more < BESIDE:
        return []
    first = next(h for h in found.scores.hypotheses if h.more_than(named))
    return [f"beside {' and '.join(named)} something more may be missing ({100 * more:.0f} %), "
            f"most likely {first.id} ({100 * first.probability:.0f} %): these readings cannot tell"]


def _in_reading(found: Diagnosis) -> float | None:
    """Of something unknown, the probability that it is a reading that is off."""
    if found.verdict.word != "outside":
        return None
    # With the effects on that a direct check shows to be missing, unless the readings deny them
    first = next(one for one in found.scores.hypotheses if one.outside)
    problem = found.scores.problem if first.ids else found.problem
    return outside.share_of_reading(problem, problem.library.baseline)


def _unknown(share: float | None) -> list[str]:
    if share is None or share <= RATHER:
        return []
    return [f"unknown: rather in the reading ({100 * share:.0f} %) than in what the finger does, for tests "
            "are off alike where they read alike"]


def _curves(found: Diagnosis) -> list[dict[str, Any]]:
    """Readings and the three predictions, load by load."""
    problem = found.problem
    rows = []
    for i, test in enumerate(found.tests):
        at = np.flatnonzero(problem.library.owner == i)
        summary = found.located[i]
        sigma = {p.load: abs(p.residual / p.sigmas) if p.sigmas else None for p in summary.points}
        rows.append(
            {
                "test": test.id,
                "title": test.title or test.id,
                "note": test.note,
                "loads": test.load.values,
                "load_unit": test.load.unit,
                "load": test.load.quantity,
                "quantity": test.observable.quantity,
                "unit": test.observable.unit,
                "fitted": list(test.fitted),
                "repeats": test.repeats,
                "sigma": [_number(sigma.get(load)) for load in test.load.values],
                "before": _numbers(problem.library.baseline[at]),
                "retuned": _numbers(found.retuned.predicted[at]),
                "patched": _numbers(found.patched.predicted[at]),
                "held_out": {
                    "retuned": _numbers(found.retuned.left_out[at]),
                    "patched": _numbers(found.patched.left_out[at]),
                },
            }
        )
    return rows


def _states(values: dict[str, float | None]) -> dict[str, float | None]:
    return {state: _number(values[state]) for state in STATES}


def _numbers(values: np.ndarray) -> list[float | None]:
    return [_number(float(value)) for value in values]


def _number(value: float | None) -> float | None:
    """Short, and null where it is none."""
    if value is None or not np.isfinite(value):
        return None
    return float(f"{value:.6g}")
