"""Deeper worlds for the diagnosis: `python -m tests.benchmarks.diagnosis_deep FOLDER [--draws 3]`.

Data from the full simulation by other laws than the judged model's (silicone neo-Hookean, TPU neo-Hookean,
friction at random), of a finger within tolerance of its drawing, with an effect of random size. These worlds
share the effects' code with the judged model and are reported apart from those of `diagnosis`, which share
nothing. Bends are cached and rows kept: a stopped run goes on.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.benchmarks import diagnosis_library
from tests.benchmarks.diagnosis import FORCE, FRESH, GIVEN, NEEDS_FORCE, beyond, said
from tests.benchmarks.diagnosis_draws import OF
from tests.benchmarks.diagnosis_table import names, part, right, same_class
from tests.worlds.noise import REPEATS, RESOLUTION, SCATTER, TOGETHER

OTHER_LAWS: Mapping[str, dict] = {
    "Ecoflex 00-50": {"law": "neo_hookean", "unit": "kPa", "constants": {"c10": 25.5}, "strain": [0, 1]},
    "Ninjaflex": {"law": "neo_hookean", "unit": "MPa", "constants": {"c10": 0.72}, "strain": [0, 1]},
}
"""As stiff as the judged laws where a bend works, of another form: one constant each."""
KEEPS_LAW = ("wrong_convention",)
"""Effects on the judged law's own form."""


def model(judged, effect: str, rng: np.random.Generator):
    """The judged model with other laws, other friction, and the effect at a random size of its prior."""
    from handgen.bending.model import Choice, Effect
    from handgen.effects import catalogue
    from handgen.materials.sets import ParameterSet

    materials = dict(judged.materials)
    for material, given in OTHER_LAWS.items():
        if effect not in KEEPS_LAW or material == "Ninjaflex":
            old = materials[material].parameters
            new = ParameterSet.model_validate({**given, "material": material, "source": old.source,
                                               "density": old.density})
            materials[material] = Choice(name="another law", parameters=new)
    sizes = {one.name: float(one.quantile(rng.uniform(0.15, 0.95))) for one in catalogue()[effect].parameters}
    return judged.model_copy(update={
        "materials": materials, "friction": float(rng.uniform(0.4, 1.2)),
        "effects": [Effect(id=effect, parameters=sizes)]}), sizes


def draw(simulation, library, effect: str, seed: int) -> dict:
    """One deep world, measured and judged."""
    from handgen.discrepancy import tolerance
    from handgen.discrepancy.observed import Observed, Readings
    from handgen.discrepancy.problem import Problem
    from handgen.discrepancy.score import score_problem

    rng = np.random.default_rng([seed, *effect.encode()])
    wanted, sizes = model(simulation.model, effect, rng)
    (by,) = tolerance.members(1, int(rng.integers(1 << 30)))
    given = (*GIVEN, FORCE) if effect in NEEDS_FORCE else GIVEN
    rows = [simulation.row(one, lambda case: tolerance.deviating(case, by))
            for one in (wanted, wanted.model_copy(update={"effects": []}))]
    truth, plain = simulation.predict(rows, f"{effect} {seed}")
    moved, tests = {}, []
    for name in given:
        at = library.points(name)
        moved[name] = truth[at] - plain[at]
        sigma, step = SCATTER[OF[name]], RESOLUTION[OF[name][1]]
        scatter = (np.sqrt(TOGETHER) * rng.standard_normal((REPEATS, 1))
                   + np.sqrt(1 - TOGETHER) * rng.standard_normal((REPEATS, len(at))))
        tests.append(Readings(name, np.round((truth[at] + sigma * scatter) / step) * step, step))
    problem = Problem.of(library, Observed(tuple(tests)))
    return {"kind": "deep", "hidden": [effect], "seed": seed, "sizes": sizes,
            "beyond": beyond(moved, problem), **said(score_problem(problem))}


def main() -> None:
    from handgen.discrepancy.library import Library
    from handgen.effects import catalogue

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--effects", nargs="*")
    parser.add_argument("--library", type=Path, default=diagnosis_library.SHIPPED)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    file = asked.folder / "deep.jsonl"
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["hidden"][0], row["seed"]) for row in rows}
    library = Library.load(asked.library)
    whole = diagnosis_library.simulation(2)
    for effect in asked.effects or catalogue():
        given = (*GIVEN, FORCE) if effect in NEEDS_FORCE else GIVEN
        simulation = replace(whole, tests=[test for test in whole.tests if test.id in given])
        for seed in range(FRESH, FRESH + asked.draws):
            if (effect, seed) not in done:
                rows.append(draw(simulation, library.only(given), effect, seed))
                with open(file, "a", encoding="utf-8") as out:
                    out.write(json.dumps(rows[-1]) + "\n")
    seen = [row for row in rows if row["beyond"] >= 6]
    for row in rows:
        print(f"{row['hidden'][0]:20s} {row['beyond']:5.1f} sigma  {row['word']} {' '.join(row['effects'])}"
              f"   first {row['best']}")
    print("right when it names   ", part(filter(names, rows), right))
    told = [row for row in rows if names(row)]
    print("... or the same class ", part(told, lambda r: right(r) or same_class(r, r["hidden"])))
    print("names at >= 6 sigma   ", part(seen, names))


if __name__ == "__main__":
    main()
