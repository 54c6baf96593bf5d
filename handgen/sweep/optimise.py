"""The search for the best variants (Optuna): several objectives, constraints, its study kept in SQLite.

Variants are drawn in rounds of one size, however many workers there are, and the draw of each rests on the
seed, its number and the rounds before: a search that was interrupted goes on as if it had not been.
"""

from __future__ import annotations

import hashlib
import json
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handgen.sweep import draw
from handgen.sweep.best import excess
from handgen.sweep.load import Prepared
from handgen.sweep.model import Axis, Sweep
from handgen.sweep.variant import task

if TYPE_CHECKING:
    import optuna

    from handgen.sweep.run import Runner

STUDY = "study.db"
"""SQLite file in the sweep's folder; any tool for Optuna's studies reads it."""
ROUND = 16
"""Variants drawn before the next ones learn from them."""
FIRST_SHARE, FIRST_MOST = 0.25, 64
"""Of the budget, drawn evenly before anything is learnt; at least a round."""
NUMBER = "variant"
"""Kept with a trial: its number among the sweep's."""
SEEDS = 1_000_003
"""Between the seeds of two sweeps."""
BROKEN, NOTHING = 1.0, 1e3
"""Excess of a variant that breaks a rule, and of one without results."""


def optimise(prepared: Prepared, runner: Runner, folder: Path) -> list[dict[str, Any]]:
    """Draw and compute the budget's variants; their values in order. The study in `folder` is taken up."""
    sweep, study, found = prepared.sweep, _study(prepared, folder), []
    trials = _kept(study, sweep)
    for start in range(0, sweep.budget, ROUND):
        numbers = range(start, min(start + ROUND, sweep.budget))
        for number in numbers:
            if number not in trials:
                trials[number] = _drawn(study, sweep, number)
        values = {number: _values(sweep, trials[number].params) for number in numbers}
        tasks = {number: task(prepared, values[number]) for number in numbers}
        runner.compute(iter(tasks.values()), f"from {start} of {sweep.budget}: ", len(numbers))
        for number in numbers:
            _tell(study, sweep, trials[number].number, runner.store.read(tasks[number].key))
        found += values.values()
    return found


def _study(prepared: Prepared, folder: Path) -> optuna.Study:
    """The study of this very question, in `folder`."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna.create_study(
        study_name=f"{prepared.sweep.name}-{_question(prepared)}", storage=f"sqlite:///{folder / STUDY}",
        directions=[way.replace("ise", "ize") for way in prepared.sweep.objectives.values()],
        load_if_exists=True)


def _question(prepared: Prepared) -> str:
    """Hash of all that decides how the search goes: what is varied, asked and bounded, and what answers."""
    sweep = prepared.sweep
    middle = {name: draw.value(axis, 0.5) for name, axis in sweep.vary.items()}
    # The budget decides how many are drawn evenly.
    said = sweep.model_dump(include={"vary", "objectives", "constraints", "seed", "budget"}, mode="json")
    content = json.dumps([said, task(prepared, middle).key], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()[:12]


def _kept(study: optuna.Study, sweep: Sweep) -> dict[int, Any]:
    """Variant's number -> trial, of those that an earlier run drew to the end."""
    from optuna.trial import TrialState

    found = {}
    for trial in study.get_trials(deepcopy=False):
        if trial.state in (TrialState.COMPLETE, TrialState.RUNNING) and set(trial.params) == set(sweep.vary):
            found.setdefault(trial.user_attrs.get(NUMBER), trial)
        elif trial.state == TrialState.RUNNING:
            study.tell(trial.number, state=TrialState.FAIL)
    found.pop(None, None)
    return found


def _drawn(study: optuna.Study, sweep: Sweep, number: int) -> optuna.Trial:
    """A trial with a value on every axis."""
    study.sampler = _sampler(sweep, number)
    trial = study.ask()
    for name, axis in sweep.vary.items():
        _suggest(trial, name, axis)
    trial.set_user_attr(NUMBER, number)
    return trial


def _sampler(sweep: Sweep, number: int, missed: float = NOTHING) -> optuna.samplers.BaseSampler:
    """Draws variant `number`, or notes that one `missed` its constraints by so much."""
    from optuna.samplers import TPESampler

    first = min(max(ROUND, round(FIRST_SHARE * sweep.budget)), FIRST_MOST)
    with warnings.catch_warnings():
        # Samplers with constraints and for several axes at once are marked experimental.
        warnings.simplefilter("ignore")
        return TPESampler(seed=sweep.seed * SEEDS + number, n_startup_trials=first, multivariate=True,
                          constant_liar=False, constraints_func=lambda trial: (missed,))


def _suggest(trial: optuna.Trial, name: str, axis: Axis) -> None:
    """A range as it is; a choice or a level by its number, so that it may be of any kind."""
    if axis.choices is not None:
        trial.suggest_categorical(name, range(len(axis.choices)))
    elif draw.stepped(axis):
        trial.suggest_int(name, 0, len(draw.levels(axis)) - 1)
    else:
        trial.suggest_float(name, axis.low, axis.high, log=axis.distribution == "loguniform")


def _values(sweep: Sweep, params: dict[str, Any]) -> dict[str, Any]:
    """Axis -> value of a trial."""
    return {name: draw.levels(axis)[params[name]] if draw.stepped(axis) else draw.tidy(params[name])
            for name, axis in sweep.vary.items()}


def _tell(study: optuna.Study, sweep: Sweep, trial: int, row: dict[str, Any] | None) -> None:
    """What came of a trial; one without results is no failure of the search, but as bad as can be."""
    row = row or {"status": "failed"}
    values = [row.get(name) for name in sweep.objectives]
    missed = excess(sweep, row) + (BROKEN if row.get("rules_passed") == 0.0 else 0.0)
    if row["status"] != "done" or None in values or not math.isfinite(missed):
        # Values must be numbers; the excess puts them last whatever they are.
        missed, values = NOTHING, [0.0] * len(values)
    study.sampler = _sampler(sweep, trial, missed)
    study.tell(trial, values, skip_if_finished=True)
