"""What is wrong in a sweep file by itself, before its base and its model are looked at."""

from __future__ import annotations

import math
from collections.abc import Iterator

from handgen.parameters import document
from handgen.parameters.fault import Fault, Path
from handgen.sweep import draw
from handgen.sweep.model import MOST, Axis, Sweep

LEAST_SHARE = 1e-6
"""Of a bell that its ends must leave."""


def spelled_out(data: dict) -> list[Fault]:
    """Lists and `low:high:step` in `data` as axes; what is neither."""
    vary, faults = data.get("vary"), []
    if not isinstance(vary, dict):
        return faults
    data["vary"] = {}
    for name, given in vary.items():
        if isinstance(given, list):
            given = {"choices": given}
        elif isinstance(given, str):
            parts = [_number(part) for part in given.split(":")]
            whole = len(parts) in (2, 3) and None not in parts
            given = dict(zip(("low", "high", "step"), parts, strict=False)) if whole else None
        if not isinstance(given, dict):
            faults.append(Fault(("vary", name), "is neither a list nor a range", vary[name],
                                "low:high:step, a list, or keys such as low, high, steps"))
            given = {"choices": [None]}
        data["vary"][name] = given
    return faults


def _number(word: str) -> float | None:
    try:
        number = float(word)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def related(sweep: Sweep) -> list[Fault]:
    """What is wrong between keys that are right by themselves."""
    faults = [fault for name, axis in sweep.vary.items() for fault in _axis(axis, ("vary", name))]
    faults += _methodical(sweep, {fault.path[1] for fault in faults})
    for name, bound in sweep.constraints.items():
        if bound.min is None and bound.max is None:
            faults.append(Fault(("constraints", name), "bounds nothing", None, "min, max or both"))
        elif bound.min is not None and bound.max is not None and bound.min > bound.max:
            faults.append(Fault(("constraints", name), f"can never be met: min {bound.min:g} is above max",
                                bound.max, f"max of at least {bound.min:g}"))
    if isinstance(sweep.keep, str) and not (
            sweep.keep.startswith("best ") and sweep.keep[5:].isdecimal() and int(sweep.keep[5:])):
        faults.append(Fault(("keep",), "should say how many", sweep.keep, "best N"))
    if (sweep.keep or sweep.confirm) and not sweep.objectives:
        faults.append(Fault(("objectives",), "missing: without one nothing is best"))
    return faults


def _axis(axis: Axis, at: Path) -> Iterator[Fault]:
    if axis.adds and axis.scales:
        yield Fault((*at, "scales"), "an axis either adds or scales")
    if axis.choices is not None:
        yield from _choices(axis, at)
        return
    yield from _unused(axis, at)
    ranged = axis.low is not None and axis.high is not None
    if axis.distribution == "normal":
        if axis.mean is None or axis.sigma is None:
            yield Fault(at, "a normal distribution needs mean and sigma")
    elif not ranged:
        yield Fault(at, "is no range", None, "low and high, a list of choices, or a distribution")
    if ranged and not axis.low < axis.high:
        yield Fault((*at, "high"), f"the range is empty: it begins at {axis.low:g}", axis.high,
                    f"above {axis.low:g}")
        return
    match axis.distribution:
        case "loguniform" if ranged and axis.low <= 0:
            yield Fault((*at, "low"), "has no logarithm", axis.low, "above 0")
        case "triangular" if ranged and not (axis.mode is not None and axis.low <= axis.mode <= axis.high):
            yield Fault((*at, "mode"), "a triangular distribution needs its mode within the range",
                        axis.mode, f"{axis.low:g} to {axis.high:g}")
        case "normal" if axis.mean is not None and axis.sigma is not None:
            below, above = draw.cut(axis)
            if not above - below > LEAST_SHARE:
                end = "low" if axis.low is not None and axis.low > axis.mean else "high"
                yield Fault((*at, end), "leaves nothing of the distribution", getattr(axis, end),
                            f"within 4 sigma of the mean {axis.mean:g}")
    if axis.step is not None and ranged:
        if axis.step > axis.high - axis.low:
            yield Fault((*at, "step"), "is longer than the range", axis.step,
                        f"{axis.high - axis.low:g} at most")
        elif (axis.high - axis.low) / axis.step > 10_000:
            yield Fault((*at, "step"), "makes too many values", axis.step, "10000 values at most")


def _choices(axis: Axis, at: Path) -> Iterator[Fault]:
    more = [k for k in axis.model_fields_set if k not in ("choices", "adds", "scales")]
    if more:
        yield Fault((*at, more[0]), "says nothing beside a list of choices")
    kinds = {document.json.dumps(draw.plain(choice)) for choice in axis.choices}
    if len(kinds) < len(axis.choices):
        yield Fault(at, "has the same choice twice", axis.choices)
    for choice in axis.choices:
        if isinstance(choice, float) and not math.isfinite(choice):
            yield Fault((*at, "choices"), "is not a finite number", choice)
        elif (axis.adds or axis.scales) and (isinstance(choice, bool) or not isinstance(choice, int | float)):
            yield Fault((*at, "choices"), "is no number to scale by, or to add", choice)


def _unused(axis: Axis, at: Path) -> Iterator[Fault]:
    """Keys that would be passed over."""
    kind = axis.distribution or "uniform"
    for keys, wanted in ((("mean", "sigma"), "normal"), (("mode",), "triangular")):
        for key in keys:
            if getattr(axis, key) is not None and kind != wanted:
                yield Fault((*at, key), f"says nothing of a {kind} distribution", getattr(axis, key),
                            f"`distribution: {wanted}`")
    if axis.step is not None and (axis.steps is not None or kind != "uniform"):
        yield Fault((*at, "step"), "says nothing beside `steps`" if axis.steps is not None else
                    f"says nothing of a {kind} distribution", axis.step, "steps: how many values")


def _methodical(sweep: Sweep, wrong: set[str]) -> Iterator[Fault]:
    """What the method asks of axes, budget and objectives; axes that are `wrong` already are passed over."""
    if sweep.method == "grid":
        vague = [name for name, axis in sweep.vary.items()
                 if axis.choices is None and axis.step is None and axis.steps is None]
        for name in vague:
            if name not in wrong:
                yield Fault(("vary", name), "a grid needs to know how many values", None,
                            "step, steps, or a list; or `method: sobol`")
        if vague or wrong:
            return
        asked = math.prod(len(draw.levels(axis)) for axis in sweep.vary.values())
        if asked > (sweep.budget or MOST):
            yield Fault(("budget",), f"the grid has {asked} variants", sweep.budget or MOST,
                        f"at least {asked}, or fewer values" if asked <= MOST else "fewer values")
        return
    if sweep.budget is None:
        yield Fault(("budget",), f"`method: {sweep.method}` needs to know how many variants", None,
                    f"1 to {MOST}")
    if sweep.method == "optimise":
        if not sweep.objectives:
            yield Fault(("objectives",), "missing: what is best?", None, "result: maximise or minimise")
        for name, axis in sweep.vary.items():
            if axis.distribution not in (None, "uniform", "loguniform"):
                yield Fault(("vary", name, "distribution"), "an optimisation draws from ranges and lists",
                            axis.distribution, "low and high")
