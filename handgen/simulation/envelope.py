"""A slender body's matrix factorised from both of its ends at once, a thread each.

Ordered along the body a matrix has few entries besides its diagonal, and its factor none but between each
row's first and its diagonal, the envelope (A. George, J. W.-H. Liu, Computer Solution of Large Sparse
Positive Definite Systems, 1981, chapter 4). Unknowns of the body's middle are taken out of the row, with
those that meet the whole body, as bones do: what is left are two arms that do not touch. Each is eliminated
from its end towards the middle, independently of the other (the twisted factorisation: H. A. van der Vorst,
Parallel Comput. 5 (1987) 45-54), and leaves its share in the small `corner` that is eliminated last.

A = L D L' without pivoting: the signs of D's entries are those of A's eigenvalues (Sylvester), so that one
factorisation serves stable and unstable states. NB rows are eliminated at a time, and all inner loops run
along rows, which the compiler turns into vector instructions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from handgen.simulation.lanes import KERNEL

if TYPE_CHECKING:
    from handgen.simulation.block import Crew
    from handgen.simulation.sparse import Pattern

NB = 16
"""Rows eliminated together; an arm is filled up with idle ones to a multiple, so that no loop leaves a
remainder."""
LOOPS = KERNEL | {"nogil": True, "fastmath": {"contract", "reassoc", "nsz"}}
"""As the other kernels, but sums in any order: rounding is all that this changes."""


@njit(**LOOPS)
def _block(rows, at, first, b):
    """Rows of block b, from the block's first column to the last row's diagonal."""
    return rows[at[b]:at[b + 1]].reshape(NB, (b + 1) * NB - first[b])


@njit(**LOOPS)
def _fill(flat, places, values, chosen):
    """Write `values[chosen]` to `places`, zeros elsewhere."""
    flat[:] = 0.0
    for k in range(len(places)):
        flat[places[k]] = values[chosen[k]]


@njit(**LOOPS)
def _on_diagonal(own, d, room):
    """Factorise the block `own` on the diagonal, in place: L with ones, and `d`."""
    for i in range(NB):
        for j in range(i):
            t = own[i, j]
            for k in range(j):
                t -= room[i, k] * own[j, k]
            room[i, j] = t
        t = own[i, i]
        for k in range(i):
            share = room[i, k] / d[k]
            t -= room[i, k] * share
            own[i, k] = share
        d[i] = t
        own[i, i] = 1.0


@njit(**LOOPS)
def _below_diagonal(own, d, scaled, plain, count):
    """`count` rows of A below the diagonal block, in `scaled`'s columns: to those of L D, in `plain` of L."""
    for j in range(NB):
        k = 0
        while k + 4 <= j:
            a, b, c, e = own[j, k], own[j, k + 1], own[j, k + 2], own[j, k + 3]
            for r in range(count):
                scaled[j, r] -= (a * scaled[k, r] + b * scaled[k + 1, r]
                                 + (c * scaled[k + 2, r] + e * scaled[k + 3, r]))
            k += 4
        while k < j:
            a = own[j, k]
            for r in range(count):
                scaled[j, r] -= a * scaled[k, r]
            k += 1
        inverse = 1.0 / d[j]
        for r in range(count):
            plain[j, r] = inverse * scaled[j, r]


@njit(**LOOPS)
def _lessen(these, i, start, scaled, r, plain, first, count):
    """Subtract from rows i to i + 3 of `these`, over `count` columns from `start` on, what rows r to r + 3 of
    L D do by L's from `first` on."""
    r0, r1, r2, r3 = these[i, start:], these[i + 1, start:], these[i + 2, start:], these[i + 3, start:]
    for k in range(0, NB, 4):
        a0, a1, a2, a3 = scaled[k, r], scaled[k + 1, r], scaled[k + 2, r], scaled[k + 3, r]
        b0, b1, b2, b3 = scaled[k, r + 1], scaled[k + 1, r + 1], scaled[k + 2, r + 1], scaled[k + 3, r + 1]
        c0, c1, c2, c3 = scaled[k, r + 2], scaled[k + 1, r + 2], scaled[k + 2, r + 2], scaled[k + 3, r + 2]
        d0, d1, d2, d3 = scaled[k, r + 3], scaled[k + 1, r + 3], scaled[k + 2, r + 3], scaled[k + 3, r + 3]
        p0, p1, p2, p3 = plain[k, first:], plain[k + 1, first:], plain[k + 2, first:], plain[k + 3, first:]
        for j in range(count):
            w, x, y, z = p0[j], p1[j], p2[j], p3[j]
            r0[j] -= a0 * w + a1 * x + (a2 * y + a3 * z)
            r1[j] -= b0 * w + b1 * x + (b2 * y + b3 * z)
            r2[j] -= c0 * w + c1 * x + (c2 * y + c3 * z)
            r3[j] -= d0 * w + d1 * x + (d2 * y + d3 * z)


@njit(**LOOPS)
def _eliminate(rows, at, first, ends, border, met, corner, d, room, scaled, plain):
    """Factorise an arm in place: L in `rows` and `border` (g, n), D in `d`, what is left in `corner` (g, g).

    at (blocks + 1,), first (blocks,) and ends (blocks,): where blocks lie, the column where each begins, the
    block after the last that it meets; met (blocks,): how many of the border's rows it meets, which are the
    first; room (NB, NB), scaled and plain (NB, rows below any block): to work in.
    """
    for b in range(len(ends)):
        c0, c1, low = b * NB, (b + 1) * NB, (ends[b] - b - 1) * NB
        own = _block(rows, at, first, b)[:, c0 - first[b]:].copy()
        _on_diagonal(own, d[c0:c1], room)
        _block(rows, at, first, b)[:, c0 - first[b]:] = own
        for other in range(b + 1, ends[b]):
            below, start, r = _block(rows, at, first, other), c0 - first[other], (other - b - 1) * NB
            for i in range(NB):
                for k in range(NB):
                    scaled[k, r + i] = below[i, start + k]
        for w in range(met[b]):
            for k in range(NB):
                scaled[k, low + w] = border[w, c0 + k]
        _below_diagonal(own, d[c0:c1], scaled, plain, low + met[b])
        for other in range(b + 1, ends[b]):
            # The block on the diagonal is made whole: nothing reads what stands right of the diagonal.
            below, start, r = _block(rows, at, first, other), c0 - first[other], (other - b - 1) * NB
            for i in range(0, NB, 4):
                _lessen(below, i, start + NB, scaled, r + i, plain, 0, r + NB)
            for i in range(NB):
                for k in range(NB):
                    below[i, start + k] = plain[k, r + i]
        for w in range(0, met[b], 4):
            _lessen(border, w, c1, scaled, low + w, plain, 0, low)
            _lessen(corner, w, 0, scaled, low + w, plain, low, w + 4)
        for w in range(met[b]):
            for k in range(NB):
                border[w, c0 + k] = plain[k, low + w]


@njit(**LOOPS)
def _down(rows, at, first, border, begins, x, y):
    """Solve L x = x in an arm; take from `y` (g,) what that does to the border."""
    for b in range(len(first)):
        own, f, c0 = _block(rows, at, first, b), first[b], b * NB
        known = x[f:c0]
        for i in range(0, NB, 4):
            t0 = t1 = t2 = t3 = 0.0
            for j in range(len(known)):
                v = known[j]
                t0 += own[i, j] * v
                t1 += own[i + 1, j] * v
                t2 += own[i + 2, j] * v
                t3 += own[i + 3, j] * v
            x[c0 + i] -= t0
            x[c0 + i + 1] -= t1
            x[c0 + i + 2] -= t2
            x[c0 + i + 3] -= t3
        for i in range(NB):
            for j in range(i):
                x[c0 + i] -= own[i, c0 - f + j] * x[c0 + j]
    for w in range(len(border)):
        t = 0.0
        for j in range(begins[w], len(x)):
            t += border[w, j] * x[j]
        y[w] -= t


@njit(**LOOPS)
def _up(rows, at, first, border, begins, d, x, y):
    """Solve D L' x = x in an arm, the border's unknowns being `y`."""
    for i in range(len(x)):
        x[i] /= d[i]
    for w in range(len(border)):
        for j in range(begins[w], len(x)):
            x[j] -= border[w, j] * y[w]
    for b in range(len(first) - 1, -1, -1):
        own, f, c0 = _block(rows, at, first, b), first[b], b * NB
        for i in range(NB - 1, -1, -1):
            for j in range(i):
                x[c0 + j] -= own[i, c0 - f + j] * x[c0 + i]
        known = x[f:c0]
        for i in range(0, NB, 4):
            t0, t1, t2, t3 = x[c0 + i], x[c0 + i + 1], x[c0 + i + 2], x[c0 + i + 3]
            for j in range(len(known)):
                known[j] -= own[i, j] * t0 + own[i + 1, j] * t1 + (own[i + 2, j] * t2 + own[i + 3, j] * t3)


def filled_up(count: int) -> int:
    """`count` and the idle rows that fill it up."""
    return -(-count // NB) * NB


class Arm:
    """One end of the body: n rows, each from its first column on, and g of a border that meet it.

    which, r, c: numbers, rows and columns of its entries, no column after its row; rows from n on are the
    border's, which the arm keeps in the order in which they meet it. Both n and g are filled up; idle: rows
    that do that, and have no entries; `full`: any entry may come to be, given or not.
    """

    def __init__(self, n: int, g: int, which: np.ndarray, r: np.ndarray, c: np.ndarray, idle: np.ndarray,
                 full: bool = False):
        starts = np.arange(0, n, NB)
        inside, low, begins = r < n, np.arange(n), np.full(g, n)
        np.minimum.at(low, r[inside], c[inside])
        np.minimum.at(begins, r[~inside] - n, c[~inside])
        low = np.zeros(n, int) if full else np.minimum.accumulate(low[::-1])[::-1]
        self.kept = np.argsort(begins, kind="stable")
        """(g,) numbers of the border's rows as they are kept, and ..."""
        self.at_border = np.argsort(self.kept)
        """(g,) ... where each is."""
        self.first, self.begins = low[::NB] // NB * NB, begins[self.kept] // NB * NB
        self.width = starts + NB - self.first
        self.at = np.concatenate([[0], np.cumsum(NB * self.width)])
        ends = np.searchsorted(self.first, starts, side="right")
        met = -(-np.searchsorted(self.begins, starts, side="right") // 4) * 4
        self.rows, self.border = np.zeros(self.at[-1]), np.zeros((g, n))
        self.corner, self.d = np.zeros((g, g)), np.zeros(n)
        most = int((ends * NB - starts - NB + met).max(initial=0))
        self._how = (self.rows, self.at, self.first, ends, self.border, met, self.corner, self.d,
                     np.empty((NB, NB)), np.empty((NB, most)), np.empty((NB, most)))
        self.idle = self.place(idle, idle)
        self.filled = [
            (self.rows, which[inside], self.place(r[inside], c[inside])),
            (self.border.reshape(-1), which[~inside], self.at_border[r[~inside] - n] * n + c[~inside])]

    def place(self, r: np.ndarray, c: np.ndarray) -> np.ndarray:
        """Where in `rows` the entries in rows r and columns c lie."""
        b = r // NB
        return self.at[b] + (r - b * NB) * self.width[b] + c - self.first[b]

    def factorise(self, values: np.ndarray) -> None:
        """L and D of the matrix whose entries have `values`."""
        self.fill(values)
        self.eliminate()

    def fill(self, values: np.ndarray) -> None:
        """Write the entries' `values` to where they belong."""
        for flat, which, places in self.filled:
            _fill(flat, places, values, which)

    def eliminate(self) -> None:
        """L and D of what stands in `rows` and `border`."""
        self.rows[self.idle] = 1.0
        self.corner[:] = 0.0
        _eliminate(*self._how)

    def in_corner(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Where in `corner`, flat, stands what is left of the border's entries in rows i and columns j."""
        a, b = self.at_border[i], self.at_border[j]
        return np.maximum(a, b) * len(self.corner) + np.minimum(a, b)

    def down(self, x: np.ndarray, y: np.ndarray) -> None:
        """Solve L x = x; take from the border's `y` what that does to it."""
        kept = y[self.kept]
        _down(self.rows, self.at, self.first, self.border, self.begins, x, kept)
        y[self.kept] = kept

    def up(self, x: np.ndarray, y: np.ndarray) -> None:
        """Solve D L' x = x, the border's unknowns being `y`."""
        _up(self.rows, self.at, self.first, self.border, self.begins, self.d, x, y[self.kept])


class Envelope:
    """L D L' of a matrix of `pattern`, whose unknowns are ordered along the body but for the last few.

    order (size,): unknown of every place; narrow: how many of them lie along the body; the others meet more
    than their neighbours.
    """

    name = "envelope"

    def __init__(self, pattern: Pattern, order: np.ndarray, narrow: int, crew: Crew):
        self.crew = crew
        r, c = self._places(pattern, order)
        low = np.arange(narrow)
        inside = r < narrow
        np.minimum.at(low, r[inside], c[inside])
        low = np.minimum.accumulate(low[::-1])[::-1]
        # The first arm ends before place m, the second begins, backwards, where no row meets the first.
        ends = np.arange(narrow + 1)
        beyond = np.maximum(ends, np.searchsorted(low, ends))
        m = int(np.abs(ends - (narrow - beyond)).argmin())
        e = int(beyond[m])
        parts = order[:m], order[e:narrow][::-1], np.concatenate([order[m:e], order[narrow:]])
        n0, n1, g = (filled_up(len(part)) for part in parts)
        # Idle rows stand at an arm's outer end, which meets nothing, and at the corner's beginning.
        self.size, self.order = pattern.size, np.full(n0 + n1 + g, pattern.size)
        for part, end in zip(parts, (n0, n0 + n1, n0 + n1 + g), strict=True):
            self.order[end - len(part):end] = part
        r, c = self._places(pattern, self.order)
        tail, idle = n0 + n1, self.order == pattern.size
        self.cuts = n0, tail
        self.arms = []
        for base, n in ((0, n0), (n0, n1)):
            part = np.flatnonzero((c >= base) & (c < base + n))
            self.arms.append(Arm(n, g, part, np.where(r[part] < tail, r[part] - base, n + r[part] - tail),
                                 c[part] - base, np.flatnonzero(idle[base:base + n])))
        i, j = np.tril_indices(g)
        last = np.flatnonzero(c >= tail)
        self.corner = Arm(g, 0, last, r[last] - tail, c[last] - tail, np.flatnonzero(idle[tail:]), full=True)
        self.left = self.corner.place(i, j), [arm.in_corner(i, j) for arm in self.arms]
        self._values: np.ndarray | None = None

    @staticmethod
    def _places(pattern: Pattern, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(rows, columns) of the lower triangle's entries, the unknowns in `order`."""
        place = np.empty(pattern.size + 1, int)
        place[order] = np.arange(len(order))
        a, b = place[pattern.rows], place[pattern.columns]
        return np.maximum(a, b), np.minimum(a, b)

    def factorise(self, values: np.ndarray) -> bool:
        """Whether the matrix of `values` is positive definite; `solve` may be called in any case."""
        self._values = values
        self._each(lambda k: self.arms[k].factorise(values))
        self.corner.fill(values)
        places, left = self.left
        self.corner.rows[places] += sum(arm.corner.take(at) for arm, at in zip(self.arms, left, strict=True))
        self.corner.eliminate()
        return self.indefinite(values) == 0

    def indefinite(self, values: np.ndarray) -> int:
        """Number of pivots that are not positive; the matrix of `values` stands factorised."""
        if self._values is not values:
            self.factorise(values)
        return sum(int((~(arm.d > 0)).sum()) for arm in (*self.arms, self.corner))

    def solve(self, right: np.ndarray) -> np.ndarray:
        x = np.append(right, 0.0)[self.order]
        *ends, y = np.split(x, self.cuts)
        taken = np.zeros((len(ends), len(y)))
        self._each(lambda k: self.arms[k].down(ends[k], taken[k]))
        y += taken.sum(axis=0)
        nothing = y[:0]
        self.corner.down(y, nothing)
        self.corner.up(y, nothing)
        self._each(lambda k: self.arms[k].up(ends[k], y))
        found = np.empty(self.size + 1)
        found[self.order] = x
        return found[:-1]

    def _each(self, work: Callable[[int], None]) -> None:
        """`work` on each arm's number, shared by the crew."""
        arms = range(len(self.arms))
        self.crew.shared(lambda number: [work(k) for k in arms[number::self.crew.count]])
