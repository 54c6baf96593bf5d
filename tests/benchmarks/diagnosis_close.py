"""What a diagnosis simulates beyond every effect alone, kept for the study.

`python -m tests.benchmarks.diagnosis_close FOLDER` simulates it for `diagnosis_library`'s model. A diagnosis
takes the most probable sizes of a pair; here an interplay is that of the nearest of a few. Both then go
through the code of a diagnosis, `closely`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations, product
from pathlib import Path

import numpy as np

from handgen.discrepancy.closely import whole
from handgen.discrepancy.library import Interplay, Library, Sizes
from handgen.discrepancy.simulated import Simulation
from handgen.effects import Parameter, catalogue

LEVELS = (0.75, 0.95)
"""Quantiles of their sizes at which two effects are simulated together: both as usual, or both large; of
either sign where an effect has one."""
SHIPPED = Path(__file__).parents[1] / "worlds" / "close.npz"


@dataclass(frozen=True)
class Open:
    """What is open with an effect on, and the size that this was simulated at, its first parameter."""

    size: float
    jacobian: np.ndarray
    structural: np.ndarray


@dataclass(frozen=True)
class Two:
    """An interplay and the sizes that it was simulated at, each of its effect's first parameter."""

    sizes: tuple[float, float]
    interplay: Interplay


@dataclass(frozen=True)
class Kept:
    """Stands in for `simulated.Simulation` where a diagnosis simulates anew."""

    opens: Mapping[str, tuple[Open, ...]]
    twos: Mapping[tuple[str, str], tuple[Two, ...]]

    def localised(self, library: Library, values: Mapping[str, Sizes]) -> Library:
        """As `simulated.Simulation.localised`."""
        found = dict(library.responses)
        for name, sizes in values.items():
            wanted = sizes[first(name).name]
            near = min(self.opens[name], key=lambda kept, wanted=wanted: abs(kept.size - wanted))
            found[name] = replace(found[name], jacobian=near.jacobian, structural=near.structural)
        return replace(library, responses=found)

    def together(self, library: Library, pairs: Mapping[tuple[str, str], tuple[Sizes, Sizes]]) -> Library:
        """As `simulated.Simulation.together`."""
        found = dict(library.interplays)
        for two, sizes in pairs.items():
            scales = [first(name).deviation for name in two]
            wanted = [one[first(name).name] for name, one in zip(two, sizes, strict=True)]
            found[two] = min(self.twos[two], key=lambda kept, wanted=wanted, scales=scales: sum(
                ((a - b) / scale)**2 for a, b, scale in zip(kept.sizes, wanted, scales, strict=True))
            ).interplay
        return replace(library, interplays=found)

    def save(self, path: Path) -> None:
        """One .npz; single precision is far below what a mesh gets wrong."""
        arrays = {f"open/{name}": np.array([np.hstack([one.jacobian, one.structural]) for one in opens])
                  for name, opens in self.opens.items()}
        for (a, b), twos in self.twos.items():
            arrays[f"two/{a}/{b}"] = np.array([[*one.interplay.shifts, one.interplay.excess] for one in twos])
        about = {"opens": {name: [one.size for one in opens] for name, opens in self.opens.items()},
                 "twos": [[*two, [one.sizes for one in twos]] for two, twos in self.twos.items()]}
        np.savez_compressed(path, about=np.frombuffer(json.dumps(about).encode(), np.uint8),
                            **{key: array.astype(np.float32) for key, array in arrays.items()})

    @classmethod
    def load(cls, path: Path) -> Kept:
        """What `save` wrote."""
        with np.load(path, allow_pickle=False) as stored:
            about = json.loads(stored["about"].tobytes())
            rows = {key: stored[key].astype(float) for key in stored.files if key != "about"}
        opens = {}
        for name, at in about["opens"].items():
            both = [np.split(row, [-len(row)], axis=1) for row in rows[f"open/{name}"]]
            opens[name] = tuple(Open(size, jacobian, (structural + structural.T) / 2)
                                for size, (jacobian, structural) in zip(at, both, strict=True))
        twos = {(a, b): tuple(Two(tuple(at), Interplay(row[:2], row[2]))
                              for at, row in zip(sizes, rows[f"two/{a}/{b}"], strict=True))
                for a, b, sizes in about["twos"]}
        return cls(opens, twos)


def first(effect: str) -> Parameter:
    """The parameter that is the effect's size."""
    return catalogue()[effect].parameters[0]


def sizes(effect: str, share: float) -> Iterator[Sizes]:
    """Parameters of an effect that is as large as at `share` of its prior, of either sign where it has one;
    those beside its size are as usual."""
    own = first(effect)
    for at in ((share,) if own.switch or own.usual is not None else (1.0 - share, share)):
        yield {one.name: one.quantile(at if one is own else 0.5) for one in catalogue()[effect].parameters}


def simulated(simulation: Simulation, library: Library, opened: Iterable[str] = ()) -> Kept:
    """All of it, from the full simulation; `opened`: effects with a size that what is open is found with."""
    def size(name: str, values: Sizes) -> float:
        return values[first(name).name]

    opens: dict[str, tuple[Open, ...]] = {}
    sized = [(name, values) for name in opened for level in LEVELS for values in sizes(name, level)]
    for name, values in (*whole(library).items(), *sized):
        there = simulation.localised(library, {name: values}).responses[name]
        opens[name] = (*opens.get(name, ()), Open(size(name, values), there.jacobian, there.structural))
    twos: dict[tuple[str, str], tuple[Two, ...]] = {}
    for level, signs in product(LEVELS, product((0, 1), repeat=2)):
        pairs = {}
        for a, b in combinations(library.responses, 2):
            both = [list(sizes(name, level)) for name in (a, b)]
            if all(sign < len(of) for sign, of in zip(signs, both, strict=True)):
                pairs[a, b] = tuple(of[sign] for sign, of in zip(signs, both, strict=True))
        # Of a library without effects of either sign some combinations hold no pair
        for (a, b), one in simulation.together(library, pairs).interplays.items() if pairs else ():
            at = size(a, pairs[a, b][0]), size(b, pairs[a, b][1])
            twos[a, b] = (*twos.get((a, b), ()), Two(at, one))
    return Kept(opens, twos)


if __name__ == "__main__":
    import sys

    from tests.benchmarks import diagnosis_library

    def say(line: str) -> None:
        print(line, flush=True)

    simulated(diagnosis_library.simulation(2, say), Library.load(diagnosis_library.SHIPPED)).save(
        Path(sys.argv[1]) / "close.npz")
