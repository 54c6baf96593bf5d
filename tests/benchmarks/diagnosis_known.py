"""What is named beside an effect that a direct check shows to be missing: `python -m
tests.benchmarks.diagnosis_known FOLDER [--simulate]`.

The judged model leaves the assembly's own weight out, as the source's did, and the assembly hung free: the
diagnosis switches own weight on, leaves its size open, and judges all else beside it. Here it acts in every
world, beside an effect, something outside the catalogue, or nothing; the lab does the source's three tests.
`--simulate`: keeps in FOLDER what the full simulation says with own weight on, an hour of bends.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from tests.benchmarks.diagnosis import GIVEN, LARGE, beyond
from tests.benchmarks.diagnosis_draws import Draw, checked, hidden
from tests.benchmarks.diagnosis_table import FORCED, share
from tests.worlds.effects import EFFECTS
from tests.worlds.outside import OUTSIDE

FRESH = 260_000
"""First seed of what is published."""
COUNT = {"nothing": 200, "effect": 100, "outside": 30}
"""Draws a kind; an effect, or a cause outside the catalogue. Of the effects those are judged that are
large."""
KNOWN = "own_weight"
WORLDS = Path(__file__).parents[1] / "worlds"
SHIPPED = WORLDS / "known.npz", WORLDS / "known_close.npz"


def simulation(workers: int, say=print):
    """The judged model with own weight on, over the source's tests."""
    from handgen.effects import catalogue
    from tests.benchmarks import diagnosis_library

    found = diagnosis_library.simulation(workers, say, 1)
    return replace(found, tests=[test for test in found.tests if test.id in GIVEN],
                   on={KNOWN: catalogue()[KNOWN].filled({})})


def simulate(folder: Path, workers: int) -> None:
    """Library, and what a diagnosis simulates anew, of all effects beside own weight."""
    from handgen.discrepancy import simulated
    from tests.benchmarks import diagnosis_close

    one = simulation(workers, lambda line: print(line, flush=True))
    found = simulated.library(one)
    found.save(folder / SHIPPED[0].name)
    sized = [name for name in found.responses if name not in diagnosis_close.whole(found)]
    diagnosis_close.simulated(one, found, sized).save(folder / SHIPPED[1].name)


def plan(first: int, part: float = 1.0) -> Iterator[Draw]:
    """All draws; own weight is in each."""
    def seeds(kind: str) -> range:
        return range(first, first + max(round(part * COUNT[kind]), 1))

    for seed in seeds("nothing"):
        yield Draw("nothing", (KNOWN,), seed, ids=GIVEN)
    for kind, names in (("effect", EFFECTS), ("outside", OUTSIDE)):
        for name in names:
            if name != KNOWN and name not in FORCED:
                yield from (Draw(kind, (KNOWN, name), seed, ids=GIVEN) for seed in seeds(kind))


class Judge:
    """Everything that a draw is judged by."""

    def __init__(self, library: Path, close: Path):
        from handgen.discrepancy.library import Library
        from tests.benchmarks import diagnosis_library
        from tests.benchmarks.diagnosis_close import Kept

        self.plain = Library.load(diagnosis_library.SHIPPED).only(GIVEN)
        self.library, self.kept = Library.load(library), Kept.load(close)

    def scored(self, found):
        """Scores as a diagnosis has them."""
        from handgen.discrepancy.closely import beside_missing
        from handgen.discrepancy.direct import POSED
        from handgen.discrepancy.problem import Problem
        from handgen.discrepancy.score import score_problem

        plain, observed = checked(self.plain, found), found.observed()
        wider = replace(self.library, prior_odds=plain.prior_odds)
        return beside_missing(self.kept, wider, score_problem(Problem.of(plain, observed)), {KNOWN: POSED},
                              observed)

    def size(self, found) -> float:
        """Deviations of all that is open with own weight on, by which what is beside it moves the
        readings."""
        from handgen.discrepancy.problem import Problem

        known = {test.id: test for test in self.library.tests}
        world = found.without(found.draw.hidden[-1])
        return beyond({name: found.shift(known[name], world) for name in GIVEN},
                      Problem.of(self.library, found.observed()))

    def row(self, draw: Draw) -> dict | None:
        """What is recorded of a draw; None of an effect that is not large."""
        from handgen.discrepancy.verdict import verdict

        found = hidden(draw, self.plain, draw.ids)
        size = self.size(found) if len(draw.hidden) > 1 else 0.0
        if draw.kind == "effect" and size < LARGE:
            return None
        scores = self.scored(found)
        said = verdict(scores)
        return {"key": draw.key, "kind": draw.kind, "hidden": draw.hidden, "sizes": found.sizes,
                "beyond": size, "word": said.word, "effects": said.effects, "probability": said.probability,
                "best": said.best.id, "candidates": said.candidates,
                "shares": {h.id: round(h.probability, 5) for h in scores.hypotheses[:12]}}


def table(rows: list[dict]) -> str:
    """What is named beside own weight, and how often it is right."""
    def beside(row: dict) -> list[str]:
        named = row["effects"] if row["word"] in ("named", "pair") else ()
        return [name for name in named if name != KNOWN]

    lines = []
    for kind, what in (("nothing", "nothing beside own weight"),
                       ("outside", "something outside the catalogue beside it"),
                       ("effect", f"an effect beside it, >= {LARGE:g} sigma")):
        mine = [row for row in rows if row["kind"] == kind]
        naming = [row for row in mine if beside(row)]
        right = sum(set(beside(row)) <= set(row["hidden"]) for row in naming)
        own = sum(row["word"] in ("named", "pair") and KNOWN in row["effects"] for row in mine)
        lines += [f"{what}: {len(mine)} draws",
                  f"  own weight is named                  {share(own, len(mine))}",
                  f"  something beside it is named         {share(len(naming), len(mine))}",
                  f"  ... and is right                     {share(right, len(naming))}",
                  f"  outside or ambiguous                 "
                  f"{share(sum(row['word'] in ('outside', 'ambiguous') for row in mine), len(mine))}"]
        if kind != "outside":
            held = sum(any(set(one.split('+')) == set(row["hidden"]) for one in row["candidates"])
                       for row in mine)
            lines.append(f"  the 90 % set holds the truth         {share(held, len(mine))}")
    return "\n".join(lines)


_judge: list[Judge] = []


def _begin(*files: Path) -> None:
    _judge[:] = [Judge(*files)]


def _row(draw: Draw) -> dict | None:
    return _judge[0].row(draw)


def main() -> None:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--simulate", action="store_true")
    parser.add_argument("--seed", type=int, default=FRESH)
    parser.add_argument("--share", type=float, default=1.0, help="of the draws")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    if asked.simulate:
        simulate(asked.folder, asked.workers)
        return
    with ProcessPoolExecutor(asked.workers, get_context("spawn"), _begin, SHIPPED) as pool:
        rows = [row for row in pool.map(_row, plan(asked.seed, asked.share), chunksize=4) if row]
    (asked.folder / f"known-{asked.seed}.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    print(table(rows))


if __name__ == "__main__":
    main()
