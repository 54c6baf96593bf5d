"""The elements of one material, its law as the kernels take it, and the threads that share them."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from queue import SimpleQueue
from threading import Thread
from typing import Any

import numpy as np

from handgen.materials.law import Law
from handgen.simulation import element, principal
from handgen.simulation.lanes import KEPT, LANES, STRESSES

POLYNOMIALS = {"neo_hookean": ("c10",), "mooney_rivlin": ("c10", "c01"), "yeoh": ("c10", "c20", "c30")}
"""Laws that the kernel's polynomial holds, with their constants in order."""


def kernel_law(law: Law) -> tuple[int, np.ndarray]:
    """(form, constants) of `law` as `principal.respond` takes them.

    Raises:
        ValueError: the kernel does not know this law.
    """
    if law.name == "ogden":
        return principal.OGDEN, np.array([v for pair in zip(*law.constants, strict=True) for v in pair])
    if law.name not in POLYNOMIALS:
        raise ValueError(f"the solid model knows {', '.join([*POLYNOMIALS, 'ogden'])}, not {law.name}")
    values = dict(zip(POLYNOMIALS[law.name], law.constants, strict=True))
    return principal.POLYNOMIAL, np.array([values.get(name, 0.0) for name in ("c10", "c20", "c30", "c01")])


@dataclass
class Block:
    """The elements of one material, with what Newton extrapolates at their points, and from what."""

    cells: np.ndarray
    dn: np.ndarray
    weight: np.ndarray
    form: int
    constants: np.ndarray
    bulk: float
    mean: bool
    framed: np.ndarray
    dofs: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), int))
    place: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 0), np.int32))

    def __post_init__(self):
        count = len(self.cells)
        self.stress, self.pressure = np.zeros((count, STRESSES)), np.zeros((count, LANES))
        self.kept = np.zeros((count, KEPT))
        self.swell = np.zeros((count, 3 * self.cells.shape[1] + 1))

    def softened(self, lost: float) -> np.ndarray:
        """The constants with a share of the law's stresses `lost`; of a row of powers only the mu."""
        if self.form == principal.OGDEN:
            return self.constants * np.where(np.arange(len(self.constants)) % 2, 1.0, 1.0 - lost)
        return (1.0 - lost) * self.constants


class Crew:
    """Threads that share work; the first is the caller, who would only wait.

    Two queues hand work over in two thirds of the time that a pool's futures take, which counts where the
    work itself is a fifth of a millisecond.
    """

    def __init__(self, count: int):
        self.count = count
        self._done: SimpleQueue = SimpleQueue()
        self._jobs = [SimpleQueue() for _ in range(1, count)]
        for number, jobs in enumerate(self._jobs, 1):
            Thread(target=_serve, args=(number, jobs, self._done), daemon=True).start()
            weakref.finalize(self, jobs.put, None)

    def part(self, number: int, elements: int) -> slice:
        """What of so many `elements` is the thread `number`'s."""
        return slice(elements * number // self.count, elements * (number + 1) // self.count)

    def shared(self, work: Callable[[int], Any]) -> list[Any]:
        """`work(number)` of every thread; raises what any of them raised."""
        for jobs in self._jobs:
            jobs.put(work)
        try:
            found = {0: work(0)}
        finally:
            others = [self._done.get() for _ in self._jobs]
        for number, result, error in others:
            if error is not None:
                raise error
            found[number] = result
        return [found[number] for number in range(self.count)]


def _serve(number: int, jobs: SimpleQueue, done: SimpleQueue) -> None:
    """Do what comes as `number`, until there is nothing more to come."""
    while (work := jobs.get()) is not None:
        try:
            done.put((number, work(number), None))
        except BaseException as error:  # the caller raises it
            done.put((number, None, error))
        del work


def assemble_blocks(
    blocks: Sequence[Block], crew: Crew, x: np.ndarray, frames: np.ndarray, curves: np.ndarray, lost: float,
    exact: bool, force: np.ndarray, matrix: np.ndarray,
) -> tuple[float, float]:
    """Add all elements' forces and tangent (`element.assemble`); returns (energy, least J).

    `lost`: the share of the silicone's stresses that it has lost.
    """

    def share(number: int):
        own = (np.zeros_like(force), np.zeros_like(matrix)) if number else (force, matrix)
        energy, least = 0.0, np.inf
        for b in blocks:
            at = crew.part(number, len(b.cells))
            part, low = element.assemble(
                x, b.cells[at], b.dn[at], b.weight[at], b.form, b.softened(lost) if b.mean else b.constants,
                b.bulk, b.mean, b.stress[at], b.pressure[at], exact, b.kept[at], b.swell[at], b.dofs[at],
                b.place[at], frames, curves, b.framed[at], *own)
            energy, least = energy + part, min(least, low)
        return energy, least, own

    parts = crew.shared(share)
    for _, _, (more, stiffer) in parts[1:]:
        force += more
        matrix += stiffer
    return sum(part[0] for part in parts), min(part[1] for part in parts)


def extrapolate_blocks(blocks: Sequence[Block], crew: Crew, moved: np.ndarray) -> None:
    """Write what Newton extrapolates at the elements' points after the nodes' step `moved` (N, 3)."""

    def share(number: int) -> None:
        for b in blocks:
            at = crew.part(number, len(b.cells))
            element.extrapolate(moved, b.cells[at], b.dn[at], b.weight[at], b.bulk, b.mean, b.kept[at],
                                b.swell[at], b.stress[at], b.pressure[at])

    crew.shared(share)
