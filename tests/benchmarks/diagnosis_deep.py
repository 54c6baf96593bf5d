"""Deeper worlds for the diagnosis: `python -m tests.benchmarks.diagnosis_deep FOLDER [--draws 3]`.

Data from the full simulation by other laws than the judged model's (silicone neo-Hookean, TPU neo-Hookean,
friction at random), of a finger within tolerance of its drawing. The size of an effect is random among those
of its range that the judged model calls large; where it calls none so, among the largest. These worlds share
the effects' code with the judged model and are reported apart from those of `diagnosis`, which share nothing.
Bends are cached and rows kept: a stopped run goes on.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from handgen.bending.model import BendModel
from handgen.discrepancy import tolerance
from handgen.discrepancy.library import Library
from handgen.discrepancy.observed import Observed, Readings
from handgen.discrepancy.problem import Problem
from handgen.discrepancy.simulated import Simulation
from tests.benchmarks import diagnosis_close, diagnosis_library
from tests.benchmarks.diagnosis import (
    FORCE,
    GIVEN,
    LARGE,
    askable,
    beyond,
    more_tests,
    said,
    scored,
)
from tests.benchmarks.diagnosis_close import Kept
from tests.benchmarks.diagnosis_draws import OF, sheet
from tests.benchmarks.diagnosis_library import POWER
from tests.benchmarks.diagnosis_table import FORCED, names, part, right, same_class
from tests.worlds.noise import REPEATS, RESOLUTION, SCATTER, TOGETHER

OTHER_LAWS: Mapping[str, dict] = {
    "Ecoflex 00-50": {"law": "neo_hookean", "unit": "kPa", "constants": {"c10": 25.5}, "strain": [0, 1]},
    "Ninjaflex": {"law": "neo_hookean", "unit": "MPa", "constants": {"c10": 0.72}, "strain": [0, 1]},
}
"""As stiff as the judged laws where a bend works, of another form: one constant each."""
FIRST = 270_000
"""First seed of what is published; worlds of other seeds were looked at before."""
KEEPS_LAW = ("wrong_convention",)
"""Effects on the judged law's own form."""
LARGEST = 0.8
"""Share of the most sigma of an effect's range, above which sizes are drawn where none is large."""


def model(judged: BendModel, effect: str, sizes: Mapping[str, float], rng: np.random.Generator) -> BendModel:
    """The judged model with other laws, other friction, and the effect."""
    from handgen.bending.model import Choice, Effect
    from handgen.materials.sets import ParameterSet

    materials = dict(judged.materials)
    for material, given in OTHER_LAWS.items():
        if effect not in KEEPS_LAW or material == "Ninjaflex":
            old = materials[material].parameters
            new = ParameterSet.model_validate({**given, "material": material, "source": old.source,
                                               "density": old.density})
            materials[material] = Choice(name="another law", parameters=new)
    return judged.model_copy(update={
        "materials": materials, "friction": float(rng.uniform(0.4, 1.2)),
        "effects": [Effect(id=effect, parameters=dict(sizes))]})


def random_size(library: Library, effect: str, rng: np.random.Generator) -> dict[str, float]:
    """One of the sizes that the judged model calls large, else of the LARGEST; from the library of the given
    tests."""
    response = library.responses[effect]
    shifts = response.dense.predictions - library.baseline
    cut = min(LARGE, LARGEST * (found := foreseen(library, shifts)).max())
    values = response.dense.values[found >= cut]
    return dict(zip(response.parameters, map(float, values[rng.integers(len(values))]), strict=True))


def foreseen(library: Library, shifts: np.ndarray) -> np.ndarray:
    """(m,) deviations of all that the model leaves open by which each row of `shifts` moves the readings."""
    covariance = library.jacobian @ library.prior @ library.jacobian.T + library.structural
    for test in library.tests:
        at, sigma = library.points(test.id), SCATTER[OF[test.id]]
        own = TOGETHER + (1 - TOGETHER) * np.eye(len(at))
        covariance[np.ix_(at, at)] += sigma**2 / REPEATS * own
    shifts = np.where(np.isfinite(shifts), shifts, 0.0)
    return np.sqrt(np.einsum("ij,ji->i", shifts, np.linalg.solve(covariance, shifts.T)))


@dataclass
class Deep:
    """A finger of a deep world in a lab."""

    whole: Simulation
    """The judged model's, over all tests."""
    library: Library
    model: BendModel
    """What is true."""
    by: Mapping[str, float]
    """How it deviates from its drawing."""
    name: str
    written: list[Readings] = field(default_factory=list)

    def measure(self, names: Sequence[str], rng: np.random.Generator) -> None:
        """Do these tests and write down what is read."""
        truth, tests = self.truth(self.model, names), self.library.only(names).tests
        ends = np.cumsum([len(test.loads) for test in tests])[:-1]
        for test, values in zip(tests, np.split(truth, ends), strict=True):
            sigma, step = SCATTER[test.part, test.quantity], RESOLUTION[test.quantity]
            scatter = (np.sqrt(TOGETHER) * rng.standard_normal((REPEATS, 1))
                       + np.sqrt(1 - TOGETHER) * rng.standard_normal((REPEATS, len(values))))
            self.written.append(Readings(test.id, np.round((values + sigma * scatter) / step) * step, step))

    def truth(self, model: BendModel, names: Sequence[str]) -> np.ndarray:
        """Of the tests `names`, in the order of the library, by `model`."""
        order = [test.id for test in self.library.tests]
        tests = sorted((test for test in self.whole.tests if test.id in names),
                       key=lambda test: order.index(test.id))
        simulation = replace(self.whole, tests=tests)
        row = simulation.row(model, lambda case: tolerance.deviating(case, self.by))
        return simulation.predict([row], self.name)[0]

    @property
    def observed(self) -> Observed:
        return Observed(tuple(self.written))


def draw(whole: Simulation, library: Library, kept: Kept, effect: str, seed: int) -> dict:
    """One deep world, measured and judged; then with the tests that the diagnosis asks for."""
    rng = np.random.default_rng([seed, *effect.encode()])
    given = (*GIVEN, FORCE) if effect in FORCED else GIVEN
    sizes = random_size(library.only(given), effect, rng)
    wanted = model(whole.model, effect, sizes, rng)
    (by,) = tolerance.members(1, int(rng.integers(1 << 30)))
    deep = Deep(whole, library, wanted, by, f"{effect} {seed}")
    deep.measure(given, rng)
    deep.library = sheet(library, rng, POWER / 2 if effect == "wrong_convention" else 1.0)
    shift = deep.truth(wanted, given) - deep.truth(wanted.model_copy(update={"effects": []}), given)
    ends = np.cumsum([len(library.points(name)) for name in given])[:-1]
    moved = dict(zip(given, np.split(shift, ends), strict=True))
    scores = scored(deep.library, kept, deep.observed)
    found = {"kind": "deep", "hidden": [effect], "seed": seed, "sizes": sizes,
             "beyond": beyond(moved, Problem.of(deep.library, deep.observed)), **said(scores)}

    def more(name: str):
        deep.measure((name,), np.random.default_rng([seed, *f"{effect} {name}".encode()]))
        return scored(deep.library, kept, deep.observed)

    return {**found, "asked": {"best": more_tests(scores, askable(library, given), more, None)}}


def main() -> None:
    from handgen.effects import catalogue

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--effects", nargs="*")
    parser.add_argument("--library", type=Path, default=diagnosis_library.SHIPPED)
    parser.add_argument("--close", type=Path, default=diagnosis_close.SHIPPED)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    file = asked.folder / "deep.jsonl"
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["hidden"][0], row["seed"]) for row in rows}
    library, kept = Library.load(asked.library), Kept.load(asked.close)
    whole = diagnosis_library.simulation(asked.workers)
    for seed in range(FIRST, FIRST + asked.draws):
        for effect in asked.effects or catalogue():
            if (effect, seed) in done:
                continue
            rows.append(draw(whole, library, kept, effect, seed))
            with open(file, "a", encoding="utf-8") as out:
                out.write(json.dumps(rows[-1]) + "\n")
    print(table(rows))


def table(rows: Sequence[dict]) -> str:
    """A line a draw, and what they come to."""
    lines = ["effect               sigma  said of the three tests          after those asked for"]
    for row in rows:
        asked = row["asked"]["best"]
        lines.append(f"{row['hidden'][0]:20s} {row['beyond']:5.1f}  {verdict_of(row):32s} "
                     f"{verdict_of({**row, **asked}) if asked['tests'] else ''}".rstrip())
    for words, of in (("three tests", rows), ("asked-for", [{**r, **r["asked"]["best"]} for r in rows])):
        told = [row for row in of if names(row)]
        lines += [f"{words}: right when it names {part(told, right)}, or of the same class "
                  f"{part(told, lambda r: right(r) or same_class(r, r['hidden']))}",
                  f"  names at >= 6 sigma {part([row for row in of if row['beyond'] >= LARGE], names)}"]
    return "\n".join(lines)


def verdict_of(row: dict) -> str:
    """What is said, and whether it is right."""
    if names(row):
        return f"{' + '.join(row['effects'])}: {'right' if right(row) else 'WRONG'}"
    return f"{row['word']} of {len(row['classes'])}" if row["word"] == "ambiguous" else row["word"]


if __name__ == "__main__":
    main()
