"""How often the diagnosis is right: `python -m tests.benchmarks.diagnosis FOLDER [--part NAME ...] [--share
0.1]`.

Worlds of another structure than the model (tests/worlds) hide something; the library that judges them comes
from the full simulation (`diagnosis_library`), and so does what a diagnosis simulates anew of its likeliest
explanations (`diagnosis_close`). One JSON row a draw in FOLDER/rows.jsonl: a run that was
stopped goes on where it was. Prints the tables of `diagnosis_table`. The seeds of the figures (FRESH) were
never looked at before.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from itertools import combinations
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from tests.benchmarks.diagnosis_draws import Draw, checked, deviation, hidden
from tests.benchmarks.diagnosis_table import FORCED
from tests.worlds.effects import EFFECTS
from tests.worlds.outside import OUTSIDE

FRESH = 280_000
"""First seed of what is published; seeds below are for finding out what goes wrong."""
COUNT = {"none": 600, "single": 80, "large": 100, "outside": 80, "pair": 240, "large pair": 6000,
         "outlier": 4, "one repeat": 1, "missing": 2, "five points": 1,
         "tolerance x2": 6, "noise x4": 6, "wrong priors": 6}
"""Draws a kind; of singles and of what is done to singles: an effect; of outside: a cause. Of the large ones
those are judged that are large."""
LARGE = 6.0
"""Deviations of all that the model leaves open from which an effect is large."""
GIVEN = ("exoskeleton-weights", "actuator-pressure", "assembly-pressure")
FORCE = "fingertip-force"
NOT_ASKED = ("ask-exoskeleton-tip-drop-palm-up-loading",)
"""The chain's strips bend back otherwise than the solid ones, whose arc flattens: by up to 17 mm."""
ASKED = {"single": ("best", "random"), "large": ("best", "random"),
         **dict.fromkeys(("pair", "large pair", "none", "outside"), ("best",))}
"""How more tests are chosen, by kind of draw."""
MOST_ASKED = 3
UNSEEN = "ask-assembly-bend-angle-palm-down-loading"
"""A kind of test that is never fitted where the gap on an unseen kind is judged."""


def plan(first: int, share: float = 1.0) -> Iterator[Draw]:
    """All draws, kind by kind."""
    def seeds(kind: str, times: int = 1) -> range:
        return range(first, first + max(round(COUNT[kind] * times * share), 1))

    def given(names: tuple[str, ...]) -> tuple[str, ...]:
        return (*GIVEN, FORCE) if set(names) & set(FORCED) else GIVEN

    for seed in seeds("none"):
        yield Draw("none", (), seed, ids=GIVEN)
    for name in EFFECTS:
        base = Draw("single", (name,), first, ids=given((name,)))
        yield from (replace(base, seed=seed) for seed in seeds("single"))
        yield from (replace(base, kind="large", seed=seed) for seed in seeds("large"))
        for kind, change in (
                ("outlier", {"trouble": "outlier"}), ("missing", {"trouble": "missing"}),
                ("one repeat", {"repeats": 1}), ("five points", {"trouble": "five points", "ids": GIVEN}),
                ("tolerance x2", {"tolerance": 2.0}), ("noise x4", {"noise": 4.0}), ("wrong priors", {})):
            yield from (replace(base, kind=kind, seed=seed, **change) for seed in seeds(kind))
    for kind, change in (("tolerance x2", {"tolerance": 2.0}), ("noise x4", {"noise": 4.0}),
                         ("wrong priors", {}), ("outlier", {"trouble": "outlier"})):
        yield from (Draw(kind, (), seed, ids=GIVEN, **change) for seed in seeds(kind, 10))
    for name in OUTSIDE:
        yield from (Draw("outside", (name,), seed, ids=GIVEN) for seed in seeds("outside"))
    twos = list(combinations([name for name in EFFECTS if name not in FORCED], 2))
    order = np.random.default_rng(first).permutation(len(twos))
    for kind in ("pair", "large pair"):
        yield from (Draw(kind, twos[order[(seed - first) % len(twos)]], seed, ids=GIVEN)
                    for seed in seeds(kind))


def judgeable(draws: Iterable[Draw], library, least: float) -> Iterator[Draw]:
    """Those that are as large as their kind says, and as `least`."""
    for draw in draws:
        asked = max(least, LARGE if draw.kind.startswith("large") else 0.0)
        if not asked or size(draw, library) >= asked:
            yield draw


def scored(library, kept, observed):
    """Scores as a diagnosis has them; `kept` stands in for its simulation."""
    from handgen.discrepancy.closely import closely
    from handgen.discrepancy.problem import Problem
    from handgen.discrepancy.score import score_problem

    return closely(kept, score_problem(Problem.of(library, observed)), observed)


def judge(draw: Draw, library, kept) -> dict:
    """Everything that is recorded of one draw."""
    from handgen.discrepancy.problem import Problem

    found = hidden(draw, library, draw.ids)
    judged = checked(library, found)
    if draw.kind == "wrong priors":
        judged = replace(judged, prior=library.prior / 16)
    known = {test.id: test for test in library.tests}
    moved = {name: found.shift(known[name]) for name in draw.ids}
    observed = found.observed()
    scores = scored(judged, kept, observed)
    row = {"key": draw.key, "kind": draw.kind, "hidden": draw.hidden, "seed": draw.seed, "sizes": found.sizes,
           "sigmas": sigmas(moved, draw), "beyond": beyond(moved, Problem.of(judged, observed))}
    row |= said(scores)
    row["flagged"] = sum(len(test.summary.outlying) for test in observed.tests)
    if draw.kind in ("single", "large"):
        if row["beyond"] < LARGE:
            return row
        row["without"] = said(scored(judged.without(*draw.hidden), kept, observed))
        row["gap"] = gaps(found, draw, scores)
    row["asked"] = {how: ask(draw, judged, kept, how, scores) for how in ASKED.get(draw.kind, ())}
    return row


def size(draw: Draw, library) -> float:
    """`beyond` of a draw, without judging it; of a pair the lesser of both, each given the other."""
    from handgen.discrepancy.problem import Problem

    found, known = hidden(draw, library, draw.ids), {test.id: test for test in library.tests}
    problem = Problem.of(library, found.observed())
    without = [found.without(name) for name in draw.hidden] if len(draw.hidden) > 1 else [found.plain]
    return min(beyond({name: found.shift(known[name], world) for name in draw.ids}, problem)
               for world in without)


def sigmas(moved: dict[str, np.ndarray], draw: Draw) -> float:
    """By how many deviations of the repeats' means the hidden moves all readings together."""
    return float(np.sqrt(sum((shift / deviation(name, draw)) @ (shift / deviation(name, draw))
                             for name, shift in moved.items())))


def beyond(moved: dict[str, np.ndarray], problem) -> float:
    """The same in deviations of all that the model leaves open: repeats, stiffness, gauge, tolerance."""
    everywhere = np.full(problem.library.size, np.nan)
    for name, shift in moved.items():
        everywhere[problem.library.points(name)] = shift
    shift = everywhere[problem.scored]
    return float(np.sqrt(max(shift @ np.linalg.solve(problem.covariance(), shift), 0.0)))


def said(scores) -> dict:
    """Verdict and probabilities."""
    from handgen.discrepancy.verdict import verdict

    found = verdict(scores)
    shares = {h.id: round(h.probability, 6) for h in scores.hypotheses[:25]}
    return {"word": found.word, "effects": found.effects, "probability": found.probability,
            "best": found.best.id, "alike": found.alike, "candidates": found.candidates,
            "classes": found.classes, "untold": found.untold,
            "class_shares": [sum(scores[one].probability for one in ids) for ids in found.classes],
            "vetoed": bool(found.vetoed),
            "p": found.best.p_value, "shares": shares, "sides": sides(found),
            "present": {name: round(scores.present(name), 5) for name in scores.problem.library.responses}}


def sides(found) -> dict[str, float]:
    """Of each named effect of either sign, how far its size lies from none; 0 where the side is open."""
    from handgen.discrepancy.sides import either_way, signed

    named = found.effects if found.word in ("named", "pair") else ()
    return {name: 0.0 if name in either_way(found) else found.best.parameters[name][0].value - size.null
            for name in named if (size := signed(name)) is not None}


def gaps(found, draw: Draw, scores) -> dict:
    """RMS of what is left: each load predicted without it, and a kind of test that was never fitted.

    Of lengths; where the force was measured because only it can tell, of forces.
    """
    from handgen.discrepancy.score import NONE, score_problem
    from handgen.discrepancy.verdict import verdict

    problem, library = scores.problem, scores.problem.library
    left = {"before": [], "retuned": [], "patched": []}
    said_first = verdict(scores)
    named = said_first.word in ("named", "pair")
    chosen = said_first.best if named else scores[NONE]
    few = replace(problem, library=replace(
        library, responses={name: library.responses[name] for name in chosen.ids}))
    tells = library.points(FORCE) if FORCE in draw.ids else problem.points
    for i, point in enumerate(problem.points):
        if point not in tells:
            continue
        part = score_problem(few.leaving(np.array([point])), pairs=len(chosen.ids) > 1, process=False)
        for state, predicted in (("before", library.baseline), ("retuned", part[NONE].predicted),
                                 ("patched", part[chosen.id].predicted)):
            left[state].append(predicted[point] - problem.means[i])
    result = {"named": named, "loads": {state: _rms(values) for state, values in left.items()}}
    known = {test.id: test for test in library.tests}
    if UNSEEN in known:
        from tests.benchmarks.diagnosis_draws import asked
        from tests.worlds.world import run

        at, truth = library.points(UNSEEN), run(found.world, asked(known[UNSEEN]), 0, len(found.records))
        result["unseen"] = {state: _rms(predicted[at] - truth) for state, predicted in (
            ("before", library.baseline), ("retuned", scores[NONE].predicted), ("patched", chosen.predicted))}
    return result


def _rms(values) -> float:
    values = np.asarray(values, float)
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def ask(draw: Draw, library, kept, how: str, scores) -> dict:
    """What is said in the end, and after which tests; `scores`: of the tests that were given.

    More tests are chosen by the diagnosis or at random.
    """
    found = hidden(draw, library, draw.ids)

    def measured(name: str):
        found.measure([test for test in library.tests if test.id == name])
        return scored(library, kept, found.observed())

    return more_tests(scores, askable(library, draw.ids), measured,
                      draw.rng("asks at random") if how == "random" else None)


def askable(library, given: Iterable[str]) -> list[str]:
    """Tests that the diagnosis may ask for; those on a plane where there is one."""
    return [test.id for test in library.tests if test.id.startswith("ask-") and test.id not in NOT_ASKED
            and (test.obstacle is None or FORCE in given)]


def more_tests(scores, open_: Sequence[str], measured: Callable, rng: np.random.Generator | None) -> dict:
    """What is said after up to MOST_ASKED of the tests `open_`, asked for while the verdict is ambiguous, a
    pair is more probable than what is named, or it is open which way that is.

    `measured`: does a test and gives the new scores; `rng`: chooses instead of the diagnosis.
    """
    from handgen.discrepancy.sides import either_way
    from handgen.discrepancy.verdict import verdict

    done: list[str] = []
    while len(done) < MOST_ASKED and ((now := verdict(scores)).word == "ambiguous" or now.or_both
                                      or either_way(now)):
        left = [name for name in open_ if name not in done]
        chosen = asked_next(scores, now, left) if rng is None else left[rng.integers(len(left))]
        if chosen is None:
            break
        done.append(chosen)
        scores = measured(chosen)
    return {"tests": done, **said(scores)}


def asked_next(scores, now, left: Sequence[str]) -> str | None:
    """The test that the diagnosis asks for, of those that are `left`, when it says `now`."""
    from handgen.discrepancy.ask import next_test
    from handgen.discrepancy.candidates import SIGMAS
    from handgen.discrepancy.sides import either_way, which_way

    if ways := either_way(now):
        proposal = which_way(scores.problem, ways, left)
    else:
        proposal = next_test(scores, left, SIGMAS, now.untold, now.or_both)
    return None if proposal is None else proposal.test


# Many draws


_by: tuple = ()


def _begin(library: str, close: str) -> None:
    from handgen.discrepancy.library import Library
    from tests.benchmarks.diagnosis_close import Kept

    global _by
    _by = Library.load(Path(library)), Kept.load(Path(close))


def _judge(draw: Draw) -> dict:
    return judge(draw, *_by)


def study(draws: list[Draw], library: Path, close: Path, rows: Path, workers: int) -> None:
    """Judge what has no row yet; each row is written as it is found."""
    done = rows_of(rows) if rows.exists() else {}
    waiting = [draw for draw in draws if draw.key not in done]
    # Shuffled: figures of a study that is under way are figures of all kinds
    waiting = [waiting[i] for i in np.random.default_rng(0).permutation(len(waiting))]
    with open(rows, "a", encoding="utf-8") as file:
        for n, row in enumerate(_rows(waiting, (str(library), str(close)), workers), start=1):
            file.write(json.dumps(row) + "\n")
            file.flush()
            if n % 50 == 0:
                print(f"{n} of {len(waiting)}", flush=True)


def _rows(waiting: list[Draw], files: tuple[str, str], workers: int) -> Iterator[dict]:
    if workers == 1:
        _begin(*files)
        yield from map(_judge, waiting)
        return
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(workers, get_context("spawn"), _begin, files) as pool:
        for job in as_completed([pool.submit(_judge, draw) for draw in waiting]):
            yield job.result()


def rows_file(folder: Path, seed: int) -> Path:
    return folder / f"rows-{seed}.jsonl"


def rows_of(file: Path) -> dict[str, dict]:
    """What a study has judged so far, by draw."""
    return {row["key"]: row for row in map(json.loads, file.read_text().splitlines())}


def main() -> None:
    from handgen.discrepancy.library import Library
    from tests.benchmarks import diagnosis_close, diagnosis_library, diagnosis_table

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kinds", nargs="*", help="only these kinds of draws")
    parser.add_argument("--share", type=float, default=1.0, help="of the draws")
    parser.add_argument("--least", type=float, default=0.0, help="only what is hidden at so many sigma")
    parser.add_argument("--seed", type=int, default=FRESH)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--library", type=Path, default=diagnosis_library.SHIPPED)
    parser.add_argument("--close", type=Path, default=diagnosis_close.SHIPPED)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    rows = rows_file(asked.folder, asked.seed)
    draws = [draw for draw in plan(asked.seed, asked.share) if not asked.kinds or draw.kind in asked.kinds]
    draws = list(judgeable(draws, Library.load(asked.library), asked.least))
    study(draws, asked.library, asked.close, rows, asked.workers)
    print(diagnosis_table.tables(list(rows_of(rows).values())))


if __name__ == "__main__":
    main()
