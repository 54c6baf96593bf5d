"""The system's sparse matrix: one pattern for all load steps, and who factorises it.

A factoriser takes the lower triangle and says whether it is positive definite: the tangent of a stable
state is, so that a factorisation that fails is itself the guard. Our own `envelope` knows that a finger is
slender, and takes it from both ends at once, in half of the time of CHOLMOD (Y. Chen, T. A. Davis, W. W.
Hager, S. Rajamanickam, ACM Trans. Math. Softw. 35 (2008) 22). That one, through cvxopt (the extra `cholmod`),
scipy's SuperLU and PARDISO (the extra `pardiso`: several hundred megabytes) are there to compare with:
`python -m tests.benchmarks.bend factorisers`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from handgen.simulation.envelope import Envelope

if TYPE_CHECKING:
    from handgen.simulation.block import Crew

WIDE = 4
"""Times as many neighbours as usual, from which on an unknown is eliminated last."""


class Pattern:
    """Where the entries of elements' matrices go in the lower triangle, column by column.

    `groups`: for each kind of element an array (m, n) of unknowns, -1 for none.
    """

    def __init__(self, groups: Sequence[np.ndarray], size: int):
        self.size = size
        keys = [self._keys(g) for g in groups]
        known = np.sort(np.concatenate([np.arange(size, dtype=np.int64) * (size + 1),
                                        *(k[k >= 0] for k in keys)]))
        known = known[np.append(True, known[1:] != known[:-1])]
        self.columns, self.rows = known // size, known % size
        self.entries = len(known)
        self.places = [np.where(k >= 0, np.searchsorted(known, k), -1).astype(np.int32) for k in keys]
        self.diagonal = np.searchsorted(known, np.arange(size, dtype=np.int64) * (size + 1))

    def _keys(self, dofs: np.ndarray) -> np.ndarray:
        """(m, n, n) column * size + row of entries (row, column) in the lower triangle, else -1."""
        row, column = dofs[:, :, None].astype(np.int64), dofs[:, None, :].astype(np.int64)
        kept = (row >= column) & (column >= 0)
        return np.where(kept, column * self.size + row, -1)


def along(pattern: Pattern) -> tuple[np.ndarray, int]:
    """(unknowns in an order for a slender body, how many of them lie along it): by reverse Cuthill-McKee;
    those that meet many more than usual, as bones do, last."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    lower = csr_matrix((np.ones(pattern.entries), (pattern.rows, pattern.columns)),
                       shape=(pattern.size, pattern.size))
    whole = (lower + lower.T).tocsr()
    many = np.diff(whole.indptr)
    wide = many > WIDE * np.median(many)
    narrow = np.flatnonzero(~wide)
    order = reverse_cuthill_mckee(whole[narrow][:, narrow], symmetric_mode=True)
    return np.concatenate([narrow[order], np.flatnonzero(wide)]), len(narrow)


class Cholmod:
    """Supernodal Cholesky of cvxopt, along the body where that leaves less to do than CHOLMOD's own order."""

    name = "CHOLMOD"

    def __init__(self, pattern: Pattern):
        from cvxopt import cholmod, matrix, spmatrix

        self._cholmod, self._matrix = cholmod, matrix
        cholmod.options["supernodal"] = 2
        cholmod.options["print"] = 0
        self._a = spmatrix(1.0, pattern.rows.tolist(), pattern.columns.tolist(), (pattern.size, pattern.size))
        order = matrix(along(pattern)[0].tolist())
        self._factor = self._used = cholmod.symbolic(self._a, p=order, uplo="L")
        self._simplicial = None

    def factorise(self, values: np.ndarray) -> bool:
        """Whether the matrix of `values` is positive definite; then `solve` may be called."""
        self._a.V = self._matrix(values)
        self._used = self._factor
        try:
            self._cholmod.numeric(self._a, self._factor)
        except ArithmeticError:
            return False
        return True

    def indefinite(self, values: np.ndarray) -> int:
        """Factorise what need not be positive definite; returns the number of negative pivots."""
        self._a.V = self._matrix(values)
        self._cholmod.options["supernodal"] = 0
        try:
            if self._simplicial is None:
                self._simplicial = self._cholmod.symbolic(self._a, uplo="L")
            self._cholmod.numeric(self._a, self._simplicial)
            self._used = self._simplicial
            pivots = self._matrix(1.0, (self._a.size[0], 1))
            self._cholmod.solve(self._simplicial, pivots, sys=6)
        except ArithmeticError:
            return self._a.size[0]
        finally:
            self._cholmod.options["supernodal"] = 2
        return int((np.array(pivots) < 0).sum())

    def solve(self, right: np.ndarray) -> np.ndarray:
        found = self._matrix(right)
        self._cholmod.solve(self._used, found)
        return np.array(found).ravel()


class SuperLU:
    """scipy's LU without pivoting: its pivots' signs are those of a Cholesky's squares."""

    name = "SuperLU"

    def __init__(self, pattern: Pattern):
        from scipy.sparse import csc_matrix

        starts = np.concatenate([[0], np.cumsum(np.bincount(pattern.columns, minlength=pattern.size))])
        self._lower = csc_matrix((np.ones(pattern.entries), pattern.rows, starts),
                                 shape=(pattern.size, pattern.size))

    def factorise(self, values: np.ndarray) -> bool:
        from scipy.sparse import tril
        from scipy.sparse.linalg import splu

        self._lower.data[:] = values
        whole = (self._lower + tril(self._lower, -1).T).tocsc()
        try:
            self._lu = splu(whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                            options={"SymmetricMode": True})
        except RuntimeError:
            return False
        return bool((self._lu.U.diagonal() > 0).all())

    def indefinite(self, values: np.ndarray) -> int:
        if self.factorise(values):
            return 0
        return int((self._lu.U.diagonal() < 0).sum())

    def solve(self, right: np.ndarray) -> np.ndarray:
        return self._lu.solve(right)


class Pardiso:
    """Intel MKL's L D L' for symmetric matrices: counts negative pivots and solves in any case."""

    name = "PARDISO"
    SYMMETRIC, ANALYSE, FACTORISE, SOLVE = -2, 11, 22, 33
    NEGATIVE = 22
    """Place in `iparm` where PARDISO leaves the number of negative eigenvalues."""

    def __init__(self, pattern: Pattern):
        from pypardiso import PyPardisoSolver
        from scipy.sparse import csr_matrix

        starts = np.concatenate([[0], np.cumsum(np.bincount(pattern.columns, minlength=pattern.size))])
        # The lower triangle column by column is the upper one row by row, which PARDISO wants.
        self._upper = csr_matrix((np.ones(pattern.entries), pattern.rows, starts),
                                 shape=(pattern.size, pattern.size))
        self._solver = PyPardisoSolver(mtype=self.SYMMETRIC)
        self._run(self.ANALYSE, np.zeros((pattern.size, 1)))

    def factorise(self, values: np.ndarray) -> bool:
        return self.indefinite(values) == 0

    def indefinite(self, values: np.ndarray) -> int:
        from pypardiso.pardiso_wrapper import PyPardisoError

        self._upper.data[:] = values
        try:
            self._run(self.FACTORISE, np.zeros((len(self._upper.indptr) - 1, 1)))
        except PyPardisoError:
            return self._upper.shape[0]
        return int(self._solver.iparm[self.NEGATIVE])

    def solve(self, right: np.ndarray) -> np.ndarray:
        return self._run(self.SOLVE, right.reshape(-1, 1)).ravel()

    def _run(self, phase: int, right: np.ndarray) -> np.ndarray:
        # Its public `solve` compares whole matrices to see whether it may reuse a factor; we know.
        self._solver.set_phase(phase)
        return self._solver._call_pardiso(self._upper, np.asfortranarray(right))


FACTORISERS = {kind.name: kind for kind in (Envelope, Cholmod, Pardiso, SuperLU)}
EXTRAS = {Cholmod.name: "cholmod", Pardiso.name: "pardiso"}
"""What `pip install handgen[...]` brings those that need a package of their own with."""


def factoriser(pattern: Pattern, crew: Crew, name: str = "") -> Envelope | Cholmod | Pardiso | SuperLU:
    """The envelope, whose work `crew` shares, or the one called `name`.

    Raises:
        ValueError: there is none of this name.
        ImportError: its package is missing.
    """
    if name in ("", Envelope.name):
        return Envelope(pattern, *along(pattern), crew)
    if name not in FACTORISERS:
        raise ValueError(f"there is no factoriser {name!r}; there are {', '.join(FACTORISERS)}")
    try:
        return FACTORISERS[name](pattern)
    except ImportError as error:
        raise ImportError(f"{name} is missing: pip install 'handgen[{EXTRAS[name]}]'") from error
