"""A library made by hand: three tests, straight responses, so that every number can be checked otherwise."""

import numpy as np

from handgen.discrepancy.library import Library, Response, Series
from handgen.discrepancy.observed import Observed, Readings

TESTS = (
    Series("weights", "exoskeleton", "tip_drop", (0.0, 0.1, 0.2, 0.3, 0.4, 0.5), load="tip_load", unit="mm"),
    Series("free", "actuator", "elongation", (20.0, 30.0, 40.0, 50.0)),
    Series("finger", "assembly", "tip_drop", (0.0, 20.0, 30.0, 40.0, 50.0, 60.0)),
)
MORE = (
    Series("angle", "assembly", "bend_angle", (0.0, 30.0, 60.0), unit="deg"),
    Series("up", "assembly", "tip_drop", (0.0, 30.0, 60.0), orientation="palm_up"),
)
SCATTER = {"weights": 1.0, "free": 0.4, "finger": 0.5}


def library(tests=TESTS, structural=0.3):
    """Baseline, two stiffnesses and the gauge; effects that differ in where and how they show."""
    owner = np.repeat(np.arange(len(tests)), [len(t.loads) for t in tests])
    x = np.concatenate([np.array(t.loads) / max(t.loads) for t in tests])
    kind = np.array([t.part for t in tests])[owner]
    angle = np.array([t.quantity == "bend_angle" for t in tests])[owner]
    up = np.array([t.orientation == "palm_up" for t in tests])[owner]
    bare, free, whole = kind == "exoskeleton", kind == "actuator", kind == "assembly"
    baseline = bare * (40 + 40 * np.sqrt(x)) + free * 18 * x + whole * (25 + 55 * x)
    jacobian = np.stack([bare * -8 * (1 - x / 2) + whole * -6 * (1 - x), free * -18 * x + whole * -20 * x,
                         free * 0.3 + whole * (x > 0) * 0.9], axis=1)
    moves = {
        "sag": whole * 15.0 * (1 - 0.6 * x) * np.where(up, -1, 1),
        "curl": (bare * 12 * (1 - x) + whole * 10 * (1 - 0.3 * x)),
        "soft": free * 4.0 * x**2 + whole * 9 * x**2,
        "slide": whole * 8.0 * np.sin(np.pi * x),
        "glide": whole * 8.0 * np.sin(np.pi * x) * np.where(angle, 3.0, 1.0),
    }
    size = np.linspace(0, 2, 6)
    density = np.exp(-((size - 1) / 0.4)**2 / 2)
    responses = {name: Response(name, ("size",), (size,), (density,), baseline + np.outer(size, move))
                 for name, move in moves.items()}
    apart = (x[:, None] - x[None, :]) / 0.5
    same = owner[:, None] == owner[None, :]
    return Library(tuple(tests), baseline, ("stiffness exoskeleton", "stiffness actuator", "gauge"),
                   np.diag([0.2, 0.1, 3.0])**2, jacobian, responses,
                   structural**2 * np.where(same, np.exp(-apart**2 / 2), 0.0))


def readings(of, truth, seed=0, repeats=3, scatter=SCATTER, ids=("weights", "free", "finger")):
    """Repeats of `truth` (n,) with the tests' scatter, read to half a millimetre."""
    rng = np.random.default_rng(seed)
    found = []
    for name in ids:
        at = of.points(name)
        x = truth[at] + scatter[name] * rng.standard_normal((repeats, len(at)))
        found.append(Readings(name, np.round(2 * x) / 2, 0.5))
    return Observed(tuple(found))


def truth(of, **effects):
    """Baseline with effects of these sizes, exactly."""
    found = of.baseline.copy()
    for name, size in effects.items():
        response = of.responses[name]
        found += size * (response.predictions[-1] - of.baseline) / response.axes[0][-1]
    return found
