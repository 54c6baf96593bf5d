"""A library and what was observed -> the numbers that every hypothesis is judged by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from handgen.discrepancy.gaussian import Whitener
from handgen.discrepancy.library import Library, Response
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
    laws: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Effect -> (n, n) covariance of what its law gets wrong, see `law`."""

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
        return replace(self, used=self.used & ~np.isin(self.points, points))

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

    # With some effects on: ids of those

    def covariance(self, scale: float = 1.0, ids: Sequence[str] = ()) -> np.ndarray:
        """(s, s) of data less prediction: reading, nuisances, `scale` times the structural error."""
        return self.reading + self.model(self.scored, self.scored, scale, ids)

    def model(self, rows: np.ndarray, columns: np.ndarray, scale: float = 1.0,
              ids: Sequence[str] = ()) -> np.ndarray:
        """Covariance of what the model itself leaves open, between points of the library."""
        slopes = self.jacobian(ids)
        return (slopes[rows] @ self.library.prior @ slopes[columns].T
                + scale**2 * self.structural(ids)[np.ix_(rows, columns)])

    def jacobian(self, ids: Sequence[str]) -> np.ndarray:
        """(n, k); what two effects change of it adds up."""
        base = self.library.jacobian
        local = [one.jacobian for one in self._added(ids)]
        return sum((one - base for one in local if one is not None), base)

    def structural(self, ids: Sequence[str]) -> np.ndarray:
        """(n, n); of two effects the one that leaves more open, and what the laws of both get wrong."""
        local = [one.structural for one in self._added(ids)]
        found = max((one for one in local if one is not None), key=np.trace, default=self.library.structural)
        return sum((self.laws[name] for name in ids if name in self.laws), found)

    def local(self, ids: Sequence[str]) -> tuple[str, ...]:
        """Those of `ids` that leave something else open than the model without them."""
        return tuple(one.id for one in self._added(ids) if one.id in self.laws or one.local)

    def _added(self, ids: Sequence[str]) -> list[Response]:
        """Of those of `ids` that are not on anyway."""
        return [self.library.responses[name] for name in ids if name not in self.library.on]

    def whiteners(self, ids: Sequence[str] = ()) -> list[Whitener]:
        """One for each of SCALES."""
        key = self.local(ids)
        if key not in self._whiteners:
            slopes = self.jacobian(key)[self.scored]
            rest = self.reading + slopes @ self.library.prior @ slopes.T
            structural = self.structural(key)[np.ix_(self.scored, self.scored)]
            squares = np.square(SCALES)[:, None, None]
            self._whiteners[key] = Whitener.all_of(rest + squares * structural)
        return self._whiteners[key]

    def whitener(self, ids: Sequence[str] = ()) -> Whitener:
        """At scale 1."""
        return self.whiteners(ids)[SCALES.index(1.0)]

    @cached_property
    def _whiteners(self) -> dict[tuple[str, ...], list[Whitener]]:
        return {}
