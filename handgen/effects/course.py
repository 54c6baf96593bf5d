"""How the loads of a test follow one another in time, and what of it silicone remembers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Path = Literal["loading", "unloading", "hold", "cycle"]
READING = 20.0
"""s from one reading to the next, and from the first load to its reading, where a test gives no times: a
manometer set by hand and a ruler read."""


@dataclass(frozen=True)
class Course:
    """What happens to the chamber, reading by reading."""

    pressures: tuple[float, ...]
    """kPa that the chamber really sees, in the order of the readings."""
    path: Path = "loading"
    times: tuple[float, ...] = ()
    """s since the first load; empty: READING apart."""
    repeats: int = 1
    """How often the course was run; what is compared is the mean."""

    @property
    def elapsed(self) -> tuple[float, ...]:
        """s since the first load of every reading."""
        return self.times or tuple(READING * (i + 1) for i in range(len(self.pressures)))

    @property
    def before(self) -> tuple[float, ...]:
        """kPa: the largest pressure of this run up to every reading.

        An unloading starts where its first reading was taken: it was loaded up to there.
        """
        return tuple(max(self.pressures[:i + 1]) for i in range(len(self.pressures)))


def course(pressures: Sequence[float], path: Path = "loading", times: Sequence[float] = (),
           repeats: int = 1) -> Course:
    """The Course of a test, from plain sequences."""
    return Course(tuple(pressures), path, tuple(times), repeats)
