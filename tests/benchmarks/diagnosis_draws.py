"""Measurements of the study: worlds with something hidden, by kind, name and seed."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from handgen.discrepancy import convention
from handgen.discrepancy.library import Library, Series
from handgen.discrepancy.observed import Observed, Readings
from tests.benchmarks.diagnosis_library import POWER
from tests.worlds.effects import EFFECTS
from tests.worlds.made import lab
from tests.worlds.noise import REPEATS, RESOLUTION, SCATTER, Record, campaign
from tests.worlds.outside import OUTSIDE
from tests.worlds.world import Test, World, run

HOLD = (0.0, 60.0, 300.0, 900.0, 1800.0)
"""s of a hold's readings."""
SHEET = 0.10
"""Scatter of the logarithm of the data sheet's stress about that of the judged model's set."""
OFF = 8.0
"""Deviations by which an outlying repeat is off."""


@dataclass(frozen=True)
class Draw:
    """One measured finger. `kind` "single", "none", "outside", "pair"; `hidden`: what is in its world."""

    kind: str
    hidden: tuple[str, ...]
    seed: int
    tolerance: float = 1.0
    noise: float = 1.0
    repeats: int = REPEATS
    trouble: str = ""
    """"outlier", "missing", "five points"."""
    ids: Sequence[str] = ()
    """Tests that are given."""

    @property
    def key(self) -> str:
        return "/".join((self.kind, "+".join(self.hidden) or "-", str(self.seed)))

    def rng(self, what: str) -> np.random.Generator:
        """A stream of its own for every part of a draw, so that one part does not change the others."""
        return np.random.default_rng([zlib.crc32(f"{self.kind} {self.hidden} {what}".encode()), self.seed])


@dataclass
class Hidden:
    """A draw's world and what it was measured to."""

    draw: Draw
    plain: World
    """The same finger without what is hidden."""
    world: World
    sizes: list[float]
    records: dict[str, Record] = field(default_factory=dict)
    written: dict[str, Readings] = field(default_factory=dict)

    def measure(self, tests: Sequence[Series]) -> None:
        """Do these tests, after those that were done."""
        first = len(self.records)
        rng = self.draw.rng("noise " + " ".join(test.id for test in tests))
        done = campaign(self.world, tuple(asked(test) for test in tests), rng, repeats=self.draw.repeats,
                        noise=self.draw.noise, first=first)
        for record in done:
            self.records[record.test.id] = record

    def observed(self) -> Observed:
        """What the lab has written down."""
        found = {name: record.repeats.copy() for name, record in self.records.items()}
        if self.draw.trouble:
            trouble(self.draw, found, self.records)
            self.written.clear()
        for name, repeats in found.items():
            if name not in self.written:
                self.written[name] = Readings(name, repeats, RESOLUTION[self.records[name].test.quantity])
        return Observed(tuple(self.written.values()))

    def without(self, name: str) -> World:
        """The same finger with what is hidden but `name`."""
        world = self.plain
        for other in self.draw.hidden:
            if other != name:
                world, _ = (EFFECTS | OUTSIDE)[other](world, self.draw.rng(f"size {other}"))
        return world

    def shift(self, test: Series, world: World | None = None) -> np.ndarray:
        """How far the hidden moves every mean reading, in the test's unit; beyond `world`, else all of it."""
        order = list(self.records).index(test.id)
        one = asked(test)
        plain = np.mean([run(world or self.plain, one, k, order) for k in range(self.draw.repeats)], axis=0)
        return self.records[test.id].truth.mean(axis=0) - plain


def checked(library: Library, found: Hidden) -> Library:
    """`library` with what the silicone's data sheet says to the model's set, before any test.

    The sheet is of the silicone as it is meant to be: what softens a pour does not show there.
    """
    sizes = dict(zip(found.draw.hidden, found.sizes, strict=True))
    return sheet(library, found.draw.rng("sheet"), sizes.get("wrong_convention", 1.0))


def sheet(library: Library, rng: np.random.Generator, meant: float) -> Library:
    """The same by chance; `meant`: the silicone's stress over that of the set as the model reads it."""
    own = SHEET * float(np.clip(rng.standard_normal(), -2.5, 2.5)) - np.log(meant)
    odds = convention.likelihood_ratio(own, own + np.log(POWER / 2))
    return replace(library, prior_odds={**library.prior_odds, "wrong_convention": odds})


FIVE = {"exoskeleton-weights": [0, 2], "actuator-pressure": [1], "assembly-pressure": [0, 4]}
"""Loads that are left of five points."""
OF = {"exoskeleton-weights": ("exoskeleton", "tip_drop"), "actuator-pressure": ("actuator", "elongation"),
      "assembly-pressure": ("assembly", "tip_drop"), "fingertip-force": ("assembly", "tip_force")}
"""What the given tests read."""


def deviation(test: str, draw: Draw) -> float:
    """Of a mean of the repeats of a given test, by the source's scatter."""
    return draw.noise * SCATTER[OF[test]] / np.sqrt(draw.repeats)


def asked(test: Series) -> Test:
    """A series of the library as a world's lab does it."""
    return Test(test.id, test.part, test.quantity, test.loads, test.orientation, test.path, test.obstacle,
                HOLD if test.path == "hold" else ())


def hidden(draw: Draw, library: Library, given: Sequence[str]) -> Hidden:
    """The world of `draw`, measured by the tests that are `given`."""
    plain = lab(draw.rng("made"), draw.tolerance)
    world, sizes = plain, []
    for name in draw.hidden:
        world, size = (EFFECTS | OUTSIDE)[name](world, draw.rng(f"size {name}"))
        sizes.append(float(size))
    found = Hidden(draw, plain, world, sizes)
    found.measure([test for test in library.tests if test.id in given])
    return found


def trouble(draw: Draw, found: dict[str, np.ndarray], records: dict[str, Record]) -> None:
    """What went wrong with the readings, in place."""
    rng = draw.rng("trouble")
    name = list(found)[rng.integers(len(found))]
    test = records[name].test
    if draw.trouble == "outlier":
        sigma = draw.noise * SCATTER[test.part, test.quantity]
        found[name][rng.integers(len(found[name]))] += rng.choice([-1, 1]) * OFF * sigma
    elif draw.trouble == "missing":
        for repeats in found.values():
            repeats[rng.random(repeats.shape) < 0.25] = np.nan
            repeats[0, 0] = repeats[0, 0] if np.isfinite(repeats[0, 0]) else records[name].repeats[0, 0]
    elif draw.trouble == "five points":
        for name, repeats in found.items():
            kept = FIVE[name]
            repeats[:, [i for i in range(repeats.shape[1]) if i not in kept]] = np.nan
