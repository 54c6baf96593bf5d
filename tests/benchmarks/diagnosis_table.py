"""Figures of the study of the diagnosis, from its rows: counts, shares, 95 % intervals."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from handgen.discrepancy.sides import signed

Rows = Sequence[dict]
NAMING = ("named", "pair")
PRIOR = {"none": 0.4, "single": 0.3, "pair": 0.1, "outside": 0.2}
"""How often each kind is believed to come: the calibration is weighed by it."""
RESAMPLED = 400
"""Times that the outcomes are drawn from what was said, to see by how much chance alone parts the two."""
MEASURE = "beyond"
"""Key of a row that says how large an effect is: "beyond", deviations of the baseline's whole uncertainty,
or "sigmas", deviations of the repeats' means alone."""
CLASSES = (
    {"silicone_softening", "wrong_convention", "creep", "mullins", "thread_spacing", "uniaxial_only_law"},
    {"pressure_offset", "pressure_gain"},
    {"bore_friction", "bore_clearance", "self_contact"},
    {"print_porosity", "base_compliance"},
)
"""Effects on one and the same thing: silicone's stiffness, the gauge, the bore, what the finger hangs on."""


FORCED = ("contact_angle",)
"""What the source's three tests cannot show: its draws are given a fourth, the fingertip's force."""


def wilson(right: int, count: int, z: float = 1.96) -> tuple[float, float]:
    """95 % interval of a share."""
    if count == 0:
        return 0.0, 1.0
    p = right / count
    middle = p + z * z / (2 * count)
    half = z * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count))
    low, high = (middle - half) / (1 + z * z / count), (middle + half) / (1 + z * z / count)
    return max(low, 0.0), min(high, 1.0)


def share(right: int, count: int) -> str:
    """ "97.1 % (94.0-98.6 %, 203 of 209)"."""
    if count == 0:
        return "no draw"
    low, high = wilson(right, count)
    return f"{100 * right / count:.1f} % ({100 * low:.1f}-{100 * high:.1f} %, {right} of {count})"


def part(rows: Iterable[dict], test: Callable[[dict], bool]) -> str:
    rows = list(rows)
    return share(sum(bool(test(row)) for row in rows), len(rows))


def names(row: dict) -> bool:
    return row["word"] in NAMING


def right(row: dict, hidden: Sequence[str] | None = None) -> bool:
    """It names what is hidden, and nothing else."""
    return names(row) and set(row["effects"]) == set(hidden if hidden is not None else row["hidden"])


def same_class(row: dict, hidden: Sequence[str]) -> bool:
    """All that it names acts on the same thing as what is hidden."""
    return all(any({name, other} <= group for group in CLASSES for other in hidden)
               for name in row["effects"])


def reported_as_one(row: dict) -> bool:
    """What is named with the hidden effect struck off was, beside it, one class with it that foretells the
    same readings (`whole`: the classes that were reported then)."""
    return any({*row["effects"], *row["hidden"]} <= set(group) for group in row["whole"])


def tells(row: dict) -> bool:
    """It names an effect, or effects of one class that it would name but for each other."""
    return names(row) or bool(row["untold"])


def first_effect(row: dict) -> str:
    """The effect that is most probably there."""
    return max(row["present"], key=row["present"].get)


def tables(rows: Rows) -> str:
    """Everything that is published."""
    kinds = defaultdict(list)
    for row in rows:
        kinds[row["kind"]].append(row)
    lines = [f"{len(rows)} draws: " + ", ".join(f"{kind} {len(of)}" for kind, of in kinds.items())]
    for section in (_naming, _silence, _calibration, _asking, _pairs, _gap, _trouble, _stress):
        lines += ["", *section(kinds)]
    return "\n".join([*lines, "", *confusion(kinds)])


def seen(kinds, least: float = 6.0, kind: str = "single") -> Rows:
    """Draws whose effect can be seen at all, beyond what the model leaves open."""
    of = kinds[kind] + (kinds["large"] if kind == "single" else [])
    return [row for row in of if row["hidden"] and row[MEASURE] >= least]


def by_three(rows: Rows) -> Rows:
    """Draws that were given the source's three tests and no more."""
    return [row for row in rows if not set(row["hidden"]) & set(FORCED)]


def _naming(kinds) -> list[str]:
    lines = ["1 naming (one effect, >= 6 sigma)"]
    for words, rows in (("by the source's three tests", by_three(seen(kinds))),
                        ("by these, and of a slanted balance by the force as well", seen(kinds))):
        named = [row for row in rows if names(row)]
        lines += [
            f"  {words}",
            f"    right when it names      {part(named, right)}   [>= 95, lower >= 93]",
            f"    ... or of the same class {part(named, lambda r: right(r) or same_class(r, r['hidden']))}",
            f"    names                    {part(rows, names)}   [>= 65]",
            f"    ... or a class of which only a test of another kind names one  {part(rows, tells)}; the "
            "hidden one is among them "
            f"{part(filter(tells, rows), lambda r: right(r) or r['hidden'][0] in r['untold'])}"]
    every = [row for row in kinds["single"] if names(row)]
    lines.append(f"  right when it names, of all sizes  {part(every, right)}")
    for least in (10.0, 20.0):
        lines.append(f"  first candidate right at >= {least:g} sigma  "
                     f"{part(seen(kinds, least), lambda r: first_effect(r) == r['hidden'][0])}"
                     + ("   [>= 85]" if least == 10 else ""))
    with_tests = [{**r, **r["asked"]["best"]} for r in seen(kinds, 20.0)]
    raw = [row for row in kinds["single"] if row["sigmas"] >= 6]
    lines.append(f"  names, by the repeats' scatter alone >= 6 sigma  {part(raw, names)}")
    lines.append("  the same with asked-for tests          "
                 f"{part(with_tests, lambda r: first_effect(r) == r['hidden'][0])}   [>= 95]")
    return lines


def _silence(kinds) -> list[str]:
    without = [{**r["without"], "hidden": r["hidden"], "whole": r["classes"]} for r in seen(kinds)]
    three = by_three(without)
    return [
        "2 silence",
        f"  nothing hidden, names           {part(kinds['none'], names)}   [<= 5]",
        f"  nothing hidden, says none       {part(kinds['none'], lambda r: r['word'] == 'none')}",
        f"  outside the catalogue, names    {part(kinds['outside'], names)}   [<= 5]",
        f"  with asked-for tests, nothing hidden: names {part(asked_for(kinds['none']), names)}, "
        f"{_extra(kinds['none']):.2f} more tests; outside: names {part(asked_for(kinds['outside']), names)}, "
        f"{_extra(kinds['outside']):.2f}   [<= 5]",
        "  outside: outside or ambiguous   "
        f"{part(kinds['outside'], lambda r: r['word'] in ('outside', 'ambiguous'))}   [>= 85]",
        "  effect struck off, false name   by the source's three tests "
        f"{part(three, lambda r: names(r) and not same_class(r, r['hidden']))}; by the force as well "
        f"{part(without, lambda r: names(r) and not same_class(r, r['hidden']))}   [<= 10]",
        f"  ... of them, of an effect that the whole catalogue reports as one class with what is hidden  "
        f"{part(without, lambda r: names(r) and not same_class(r, r['hidden']) and reported_as_one(r))}",
        f"  ... name of the same class      "
        f"{part(without, lambda r: names(r) and same_class(r, r['hidden']))}",
    ]


def _extra(rows: Rows) -> float:
    """Tests that were asked for, a finger."""
    return float(np.mean([len(row["asked"]["best"]["tests"]) for row in rows])) if rows else 0.0


def truth(row: dict) -> str:
    """The hypothesis that is true."""
    return row["kind"] if row["kind"] in ("none", "outside") else "+".join(row["hidden"])


def holds(row: dict, hypothesis: str) -> bool:
    """Whether `hypothesis` is what is true, pairs in any order."""
    return set(hypothesis.split("+")) == set(truth(row).split("+"))


def _calibration(kinds) -> list[str]:
    rows = [(r, PRIOR[kind] / len(kinds[kind])) for kind in PRIOR for r in kinds[kind] if kinds[kind]]
    if not rows:
        return []
    weights = np.array([w for _, w in rows])
    weights /= weights.sum()
    leaders = [next(iter(r["shares"].items())) for r, _ in rows]
    sure = np.array([share_ for _, share_ in leaders])
    correct = np.array([holds(r, name) for (r, _), (name, _) in zip(rows, leaders, strict=True)], float)
    together = np.array([r["class_shares"][0] for r, _ in rows])
    any_ = np.array([any(holds(r, one) for one in r["classes"][0]) for r, _ in rows], float)
    lines = ["3 calibration (kinds weighed as they are believed to come)",
             "  of the first class that is reported", *_reliability(together, any_, weights),
             "  of the first explanation alone", *_reliability(sure, correct, weights)]
    high = sure >= 0.9
    inside = np.array([any(holds(r, c) for c in r["candidates"]) for r, _ in rows], float)
    size = np.array([len(r["candidates"]) for r, _ in rows], float)
    told = np.array([len(r["classes"]) for r, _ in rows], float)
    if high.any():
        lines.append(f"  right at >= 0.9: {100 * (correct[high] @ weights[high]) / weights[high].sum():.1f} "
                     f"% weighed; "
                     f"{share(int(correct[high].sum()), int(high.sum()))}   [>= 90]")
    lines.append(f"  90 % set holds the truth: {100 * inside @ weights:.1f} % weighed; "
                 f"{share(int(inside.sum()), len(inside))}, mean size {told @ weights:.2f} classes "
                 f"that predict the same, as reported; {size @ weights:.2f} explanations   [>= 90, <= 2.5]")
    return lines


def _reliability(sure: np.ndarray, correct: np.ndarray, weights: np.ndarray) -> list[str]:
    """A line for every tenth, and the mean distance of what was said from what was."""
    lines = []
    for mine in _tenths(sure):
        w = weights[mine]
        said_, was = (sure[mine] @ w) / w.sum(), (correct[mine] @ w) / w.sum()
        lines.append(f"  said {said_:.2f}  was {was:.2f}  ({mine.sum()} draws)")
    error = calibration_error(sure, correct, weights)
    rng = np.random.default_rng(0)
    chance = [calibration_error(sure, (rng.random(len(sure)) < sure).astype(float), weights)
              for _ in range(RESAMPLED)]
    return [*lines, f"  calibration error {error:.3f}   [<= 0.05]; were all true, as few draws would show "
            f"{np.mean(chance):.3f} ({np.quantile(chance, 0.025):.3f}-{np.quantile(chance, 0.975):.3f})"]


def calibration_error(sure: np.ndarray, correct: np.ndarray, weights: np.ndarray) -> float:
    """Mean distance of what was said from what was, over the tenths."""
    return float(sum(abs((sure[mine] - correct[mine]) @ weights[mine]) for mine in _tenths(sure)))


def _tenths(sure: np.ndarray) -> list[np.ndarray]:
    """Which draws were said to be so sure, of every tenth that has any."""
    found = np.minimum((sure * 10).astype(int), 9)
    return [found == tenth for tenth in range(10) if (found == tenth).any()]


def _asking(kinds) -> list[str]:
    lines = ["4 at most 3 tests that it asked for (one effect, >= 6 sigma)"]
    for words, drawn in (("after the source's three tests", by_three(seen(kinds))),
                         ("of a slanted balance after the force as well", seen(kinds))):
        lines.append(f"  {words}")
        for how in ("best", "random"):
            rows = [{**r, **r["asked"][how]} for r in drawn]
            if rows:
                extra = np.mean([len(r["tests"]) for r in rows])
                lines.append(f"    {how:6s} names {part(rows, names)} [>= 85]; right "
                             f"{part(filter(names, rows), right)} "
                             f"[>= 95]; {extra:.2f} more tests a finger [<= 1]")
    for words, rows in (("given", seen(kinds)), ("asked-for", asked_for(seen(kinds)))):
        sided = [row for row in rows if right(row) and row["sides"]]
        told = [row for row in sided if all(row["sides"].values())]
        lines.append(f"  which way a named effect of either sign goes, {words} tests: said "
                     f"{share(len(told), len(sided))}, and right {part(told, right_way)}")
    return lines


def right_way(row: dict) -> bool:
    """The named effect lies on the side of none that it truly lies on."""
    ((name, side),) = row["sides"].items()
    size = signed(name)
    return size is not None and side * (row["sizes"][0] - size.null) > 0


def _pairs(kinds) -> list[str]:
    lines = ["5 pairs, and those in which each moves the readings by >= 6 sigma beyond the other"]
    for words, rows in (("three tests", kinds["pair"]), ("asked-for", asked_for(kinds["pair"])),
                        ("large, three tests", kinds["large pair"]),
                        ("large, asked-for", asked_for(kinds["large pair"]))):
        told = [row for row in rows if names(row)]
        each = [(name, row["hidden"]) for row in told for name in row["effects"]]
        alike = [name in of or same_class({"effects": [name]}, of) for name, of in each]
        lines.append(f"  {words}: both named {part(rows, right)}; one or both named {part(rows, names)}; "
                     f"each name right {share(sum(name in of for name, of in each), len(each))}, or of "
                     f"the same class {share(sum(alike), len(each))}")
    return lines


def asked_for(rows: Rows) -> Rows:
    """What is said after the tests that were asked for."""
    return [{**row, **row["asked"]["best"]} for row in rows]


def _gap(kinds) -> list[str]:
    lines = ["6 gap on held-out readings (one effect, >= 6 sigma)"]
    for what in ("loads", "unseen"):
        for words, keep in (("all", lambda r: True), ("named", names)):
            found = [r["gap"][what] for r in seen(kinds) if what in r["gap"] and keep(r)]
            if not found:
                continue
            before, retuned, patched = (
                np.array([g[s] for g in found]) for s in ("before", "retuned", "patched"))
            falls = np.median(1 - patched / before), np.median(1 - retuned / before)
            lines.append(f"  {what}, {words}: falls by {100 * falls[0]:.0f} %, re-tuned alone "
                         f"{100 * falls[1]:.0f} % "
                         f"(medians of {len(found)}); worse by over 10 %: "
                         f"{share(int((patched > 1.1 * before).sum()), len(found))}   [>= 70, +25, <= 2]")
    return lines


def _trouble(kinds) -> list[str]:
    lines = ["7 trouble"]
    for kind in ("outlier", "missing", "one repeat", "five points"):
        rows = [r for r in kinds[kind] if r["hidden"]]
        told = [r for r in rows if names(r)]
        flagged = f"; flagged {part(kinds[kind], lambda r: r['flagged'] > 0)}" if kind == "outlier" else ""
        lines.append(f"  {kind}: right when it names {part(told, right)}; names "
                     f"{part(seen(kinds, kind=kind), names)}{flagged}")
    return lines


def _stress(kinds) -> list[str]:
    lines = ["8 stress"]
    for kind in ("tolerance x2", "noise x4", "wrong priors"):
        rows = seen(kinds, kind=kind)
        nothing = [r for r in kinds[kind] if not r["hidden"]]
        lines.append(f"  {kind}: right when it names {part(filter(names, rows), right)}; names "
                     f"{part(rows, names)}; "
                     f"false name with nothing hidden {part(nothing, names)}")
    return lines


def confusion(kinds) -> list[str]:
    """What is said (columns by their count) of what is hidden."""
    lines = ["what is said of what is hidden (all sizes)"]
    groups = defaultdict(list)
    for kind in ("none", "single", "outside"):
        for row in kinds[kind]:
            groups["+".join(row["hidden"]) or "nothing"].append(row)
    for name, rows in groups.items():
        told = Counter("+".join(r["effects"]) if names(r) else r["word"] for r in rows)
        first = Counter(r["best"] for r in rows if not names(r))
        lines.append(f"  {name:20s} " + ", ".join(f"{what} {n}" for what, n in told.most_common(6))
                     + (f"   | first of the others: "
                        f"{', '.join(f'{w} {n}' for w, n in first.most_common(4))}"))
    return lines
