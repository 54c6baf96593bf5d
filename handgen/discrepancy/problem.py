"""A library and what was observed -> the numbers that every hypothesis is judged by."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handgen.discrepancy.library import Library
from handgen.discrepancy.observed import Observed

SCALES = (0.5, 1.0, 2.0)
"""The structural error may be so many times what the ensemble says..."""
SCALE_WEIGHTS = (0.25, 0.5, 0.25)
"""... with these prior probabilities."""


@dataclass(frozen=True)
class Problem:
    """Points that were read and can be predicted, m of the library's n."""

    library: Library
    points: np.ndarray
    """(m,) indices into the library's points."""
    means: np.ndarray
    """(m,)."""
    errors: np.ndarray
    """(m, m) covariance of the means: repeats, resolution."""
    used: np.ndarray
    """(m,) whether a point takes part in the scoring; the others are only predicted."""

    @classmethod
    def of(cls, library: Library, observed: Observed, *, everything: bool = False) -> Problem:
        """Tests and loads are matched by name and order.

        `everything`: also score what a test calls not to be fitted.

        Raises:
            ValueError: a test has other loads than the library says.
        """
        n = library.size
        means, errors, used = np.full(n, np.nan), np.zeros((n, n)), np.zeros(n, bool)
        for test in observed.tests:
            at, summary = library.points(test.id), test.summary
            if len(at) != len(summary.means):
                raise ValueError(f"{test.id}: {len(summary.means)} loads read, {len(at)} predicted")
            means[at] = summary.means
            errors[np.ix_(at, at)] = summary.covariance
            used[at] = True if everything or test.fitted is None else test.fitted
        known = np.isfinite(means) & np.isfinite(library.baseline) & np.isfinite(library.jacobian).all(axis=1)
        points = np.flatnonzero(known)
        return cls(library, points, means[points], errors[np.ix_(points, points)], used[points])

    def leaving(self, points: np.ndarray) -> Problem:
        """The same with some of the library's points only predicted."""
        return Problem(self.library, self.points, self.means, self.errors,
                       self.used & ~np.isin(self.points, points))

    @cached_property
    def scored(self) -> np.ndarray:
        """(s,) indices into the library's points that take part."""
        return self.points[self.used]

    @cached_property
    def data(self) -> np.ndarray:
        """(s,) means that take part."""
        return self.means[self.used]

    @cached_property
    def reading(self) -> np.ndarray:
        """(s, s) covariance of these means."""
        return self.errors[np.ix_(self.used, self.used)]

    def covariance(self, scale: float = 1.0) -> np.ndarray:
        """(s, s) of data less prediction: reading, nuisances, `scale` times the structural error."""
        return self.reading + self.model(self.scored, self.scored, scale)

    def model(self, rows: np.ndarray, columns: np.ndarray, scale: float = 1.0) -> np.ndarray:
        """Covariance of what the model itself leaves open, between points of the library."""
        found = self.library
        return (found.jacobian[rows] @ found.prior @ found.jacobian[columns].T
                + scale**2 * found.structural[np.ix_(rows, columns)])
