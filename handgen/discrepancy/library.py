"""What the model can say about a row of tests, as arrays: its baseline, and all that could move it.

Built from the full simulation by `handgen.discrepancy.simulated`, or handed in. Values in the unit of each
test's observable (mm, deg, N), loads in that of its loads (kPa, N).
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from handgen import atomic
from handgen.discrepancy.dense import Dense, dense
from handgen.measurements.model import DIRECT

FORMAT = 2
RESPONSE = ("predictions", "jacobian", "structural")
"""Arrays of a Response, in their order there."""
NONE, OUTSIDE = "none", "outside"
"""Explanations beside the effects: nothing is missing, something that no effect explains."""
Sizes = Mapping[str, float]
"""Parameters of an effect by name."""


@dataclass(frozen=True)
class Series:
    """One test: what is read over which loads."""

    id: str
    part: str
    quantity: str
    loads: tuple[float, ...]
    unit: str = "mm"
    load: str = "pressure"
    orientation: str = "palm_down"
    path: str = "loading"
    obstacle: float | None = None

    @property
    def kind(self) -> str:
        """Tests of one kind share what the model gets wrong."""
        return f"{self.part} {self.quantity}"

    @property
    def direct(self) -> bool:
        """Whether it is answered without a bend."""
        return self.quantity in DIRECT

    @property
    def state(self) -> tuple:
        """What is read of what in which pose."""
        return self.part, self.quantity, self.orientation, self.obstacle


def same_state(tests: Sequence[Series]) -> tuple[np.ndarray, np.ndarray]:
    """(which points read the same thing in the same pose, whatever the path, (n, n) of 0 and 1; load of each
    point as a share of the largest of all that do, (n,)).

    What a mesh or a law gets wrong there is wrong going up as going down.
    """
    points = [(test.state, load) for test in tests for load in test.loads]
    reach: dict[tuple, float] = {}
    for state, load in points:
        reach[state] = max(load, reach.get(state, 0.0))
    known = list(reach)
    group = np.array([known.index(state) for state, _ in points])
    shares = np.array([load / (reach[state] or 1.0) for state, load in points])
    return (group[:, None] == group[None, :]).astype(float), shares


@dataclass(frozen=True)
class Response:
    """What an effect does: predictions on a grid over its parameters."""

    id: str
    parameters: tuple[str, ...]
    axes: tuple[np.ndarray, ...]
    """Ascending values of each parameter."""
    densities: tuple[np.ndarray, ...]
    """Prior density of each parameter up to a factor: at its values, or a table (2, q) of value, density."""
    predictions: np.ndarray
    """(len(axis 1), ..., n); NaN where the simulation found no balance."""
    jacobian: np.ndarray | None = None
    """(n, k) of the nuisances with the effect on, where it was simulated; else the library's."""
    structural: np.ndarray | None = None
    """(n, n) of fingers within tolerance with the effect on, likewise."""

    @property
    def local(self) -> bool:
        """Whether what is open was simulated with the effect on."""
        return self.jacobian is not None or self.structural is not None

    def __post_init__(self):
        shape = tuple(len(axis) for axis in self.axes)
        if self.predictions.shape[:-1] != shape or len(self.densities) != len(shape):
            raise ValueError(f"{self.id}: predictions {self.predictions.shape} on a grid of {shape}")

    @cached_property
    def dense(self) -> Dense:
        """Interpolated, as fine as the integration over the parameters asks for."""
        return dense(self.axes, self.densities, self.predictions)

    def at(self, points: np.ndarray) -> Response:
        """The response at some of the points alone."""
        return replace(
            self, predictions=self.predictions[..., points],
            jacobian=None if self.jacobian is None else self.jacobian[points],
            structural=None if self.structural is None else self.structural[np.ix_(points, points)])


@dataclass(frozen=True)
class Interplay:
    """What two effects do together, at one size of both; NaN where there is no balance."""

    shifts: np.ndarray
    """(2, n) what each does alone."""
    excess: np.ndarray
    """(n,) what both do beyond the sum of these."""

    def at(self, points: np.ndarray) -> Interplay:
        """The same at some of the points alone."""
        return Interplay(self.shifts[:, points], self.excess[points])


def size_name(effect: str, parameter: str) -> str:
    """The name of a nuisance: how far a parameter of an effect that is on is off."""
    return f"size {effect} {parameter}"


@dataclass(frozen=True)
class Library:
    """All predictions of a model about `tests`; n points, those of the first test first."""

    tests: tuple[Series, ...]
    baseline: np.ndarray
    """(n,)."""
    nuisances: tuple[str, ...]
    """Names of what every model leaves open: stiffnesses, references, the gauge's offset."""
    prior: np.ndarray
    """(k, k) their covariance; means are 0."""
    jacobian: np.ndarray
    """(n, k) of the predictions by them."""
    responses: Mapping[str, Response]
    structural: np.ndarray
    """(n, n) covariance of what the model gets wrong with everything within tolerance."""
    prior_odds: Mapping[str, float] = field(default_factory=dict)
    """Effect -> what direct checks make of its odds; 1 where none is given."""
    on: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """Effects that are on in all of this, at these values of their parameters; how far those are off is a
    nuisance, see `size_name`."""
    interplays: Mapping[tuple[str, str], Interplay] = field(default_factory=dict)
    """Of two effects, named as they follow each other in `responses`; where none is, what they do adds up."""

    def __post_init__(self):
        n, k = sum(len(test.loads) for test in self.tests), len(self.nuisances)
        shapes = {"baseline": (n,), "prior": (k, k), "jacobian": (n, k), "structural": (n, n)}
        for name, shape in shapes.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}, not {shape}")
        for name, response in self.responses.items():
            if response.predictions.shape[-1] != n:
                raise ValueError(f"{name} predicts {response.predictions.shape[-1]} points, not {n}")

    @property
    def size(self) -> int:
        return len(self.baseline)

    @cached_property
    def owner(self) -> np.ndarray:
        """(n,) index of the test of each point."""
        return np.repeat(np.arange(len(self.tests)), [len(test.loads) for test in self.tests])

    @cached_property
    def loads(self) -> np.ndarray:
        """(n,) load of each point."""
        return np.concatenate([np.asarray(test.loads, float) for test in self.tests])

    def called(self, *parts: str) -> str:
        """The id of an explanation: these effects, or something outside, beside those that are on."""
        return "+".join((*self.on, *parts)) or NONE

    def points(self, test: str) -> np.ndarray:
        """Indices of the points of a test."""
        return np.flatnonzero(self.owner == [one.id for one in self.tests].index(test))

    def only(self, tests: Sequence[str]) -> Library:
        """The library of some of its tests, in the order of the library."""
        kept = tuple(test for test in self.tests if test.id in tests)
        if len(kept) != len(set(tests)):
            known = {test.id for test in self.tests}
            raise ValueError(f"no test {', '.join(sorted(set(tests) - known))}")
        at = np.flatnonzero(np.isin(self.owner, [i for i, t in enumerate(self.tests) if t in kept]))
        return replace(
            self, tests=kept, baseline=self.baseline[at], jacobian=self.jacobian[at],
            structural=self.structural[np.ix_(at, at)],
            responses={name: response.at(at) for name, response in self.responses.items()},
            interplays={two: one.at(at) for two, one in self.interplays.items()})

    def without(self, *effects: str) -> Library:
        """The library with effects struck off its catalogue."""
        return replace(self, responses={k: v for k, v in self.responses.items() if k not in effects})

    # Files

    def save(self, path: str | os.PathLike) -> None:
        """Write all arrays to one .npz, beside and renamed."""
        arrays = {name: getattr(self, name) for name in ("baseline", "prior", "jacobian", "structural")}
        about: dict = {"format": FORMAT, "tests": [asdict(test) for test in self.tests],
                       "nuisances": self.nuisances, "prior_odds": dict(self.prior_odds), "on": dict(self.on),
                       "responses": {}, "interplays": list(self.interplays)}
        for name, response in self.responses.items():
            about["responses"][name] = response.parameters
            arrays |= {f"{name}/{what}": getattr(response, what) for what in RESPONSE
                       if getattr(response, what) is not None}
            for i, (axis, density) in enumerate(zip(response.axes, response.densities, strict=True)):
                arrays[f"{name}/axis/{i}"], arrays[f"{name}/density/{i}"] = axis, density
        for two, one in self.interplays.items():
            arrays["/".join(("interplay", *two))] = np.vstack([one.shifts, one.excess])
        with atomic.writing(Path(path)) as beside, open(beside, "wb") as file:
            np.savez_compressed(file, about=np.frombuffer(json.dumps(about).encode(), np.uint8), **arrays)

    @classmethod
    def load(cls, path: str | os.PathLike) -> Library:
        """Read what `save` wrote.

        Raises:
            ValueError, KeyError, OSError: the file is no library of this format.
        """
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        about = json.loads(arrays.pop("about").tobytes())
        if about["format"] != FORMAT:
            raise ValueError(f"{path} has format {about['format']}, not {FORMAT}")
        responses = {
            name: Response(name, tuple(parameters),
                           tuple(arrays[f"{name}/axis/{i}"] for i in range(len(parameters))),
                           tuple(arrays[f"{name}/density/{i}"] for i in range(len(parameters))),
                           *(arrays.get(f"{name}/{what}") for what in RESPONSE))
            for name, parameters in about["responses"].items()}
        tests = tuple(Series(**{**test, "loads": tuple(test["loads"])}) for test in about["tests"])
        rows = {tuple(two): arrays["/".join(("interplay", *two))] for two in about["interplays"]}
        interplays = {two: Interplay(found[:2], found[2]) for two, found in rows.items()}
        return cls(tests, arrays["baseline"], tuple(about["nuisances"]), arrays["prior"], arrays["jacobian"],
                   responses, arrays["structural"], about["prior_odds"], about["on"], interplays)
