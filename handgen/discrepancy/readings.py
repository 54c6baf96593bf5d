"""A measurements file's tests -> what the scoring reads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handgen.discrepancy.observed import Observed, Readings
from handgen.measurements.model import Test

FEWEST = 3
"""Read loads from which a held-out test is worth a diagnosis."""


def chosen(tests: Sequence[Test]) -> tuple[tuple[Test, ...], tuple[Test, ...], tuple[str, ...]]:
    """(tests to score, tests only to predict, remarks).

    A test that calibrations must not see (`held_out`) is scored where no other test shows its part: what a
    finger lacks cannot be seen in its parts. Each of its loads is then predicted by a fit without it.
    """
    shown = {test.part for test in tests if any(test.fitted)}
    scored, predicted, remarks = [], [], []
    for test in tests:
        read = sum(any(row[i] is not None for row in test.repeats) for i in range(len(test.load.values)))
        if any(test.fitted):
            scored.append(test)
        elif test.part not in shown and read >= FEWEST:
            scored.append(test.model_copy(update={"held_out": False}))
            remarks.append(f"held out: {test.id} may not be fitted, but no other test shows the {test.part}: "
                           "it is scored, and each load is predicted by a fit that has not seen it")
        else:
            predicted.append(test)
    return tuple(scored), tuple(predicted), tuple(remarks)


def observed_of(tests: Sequence[Test]) -> Observed:
    """Readings of `tests`, with what each allows to be fitted."""
    return Observed(tuple(
        Readings(test.id, np.array(test.repeats, float), test.resolution or 0.0, test.fitted)
        for test in tests))
