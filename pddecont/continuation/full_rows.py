"""Systems of sparse equations of which a few hold nearly all unknowns: phase conditions, steps along a branch.

One such row fills the factors of all others. Each is taken with its largest entry alone, which fixes the same unknowns
in another way; the rest of it is put back as a change of low rank, and what is left of the equations is solved for once
more. A right-hand side of random numbers shows whether that was enough.

Reference: Golub, Van Loan, Matrix Computations (2013), section 2.1.4, for the formula of Sherman, Morrison, Woodbury.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from pddecont.continuation.trial import solves

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Solve = Callable[[Array], Array]
# A row that holds more than this part of all unknowns is full; more full rows than the second are not few.
FULL, FEW = 0.1, 8


def factor_without_full_rows(matrix: Any, factor: Callable[[Any], Solve]) -> Solve | None:
    """Return what solves with a square sparse matrix (CSC) of real numbers, whose rows are scaled.

    It takes right-hand sides of shape (n,) or (n, k); ``factor`` factors a sparse matrix, and raises RuntimeError where
    that is singular. None where no row is full, or too many are; where the matrix is singular without what rows hold
    beside their largest entries, or nearly singular with it; or where rounding has grown.
    """
    n = matrix.shape[0]
    if matrix.data.dtype != np.float64:
        return None
    full = np.flatnonzero(np.bincount(matrix.indices, minlength=n) > FULL * n)
    if not 0 < len(full) <= FEW:
        return None
    rest = matrix[full].toarray()
    kept = _choose_entries(rest)
    rest[np.arange(len(full)), kept] = 0.0
    units = np.zeros((n, len(full)))
    units[full, np.arange(len(full))] = 1.0
    try:
        solve = factor(_leave_one_entry(matrix, full, kept))
    except RuntimeError:
        return None
    with np.errstate(all="ignore"):
        answers = solve(units)
        lu, exchanged, singular = lapack.dgetrf(np.eye(len(full)) + rest @ answers)

    def solve_once(b: Array) -> Array:
        x = solve(b)
        return np.asarray(x - answers @ lapack.dgetrs(lu, exchanged, rest @ x)[0])

    def solve_whole(b: Array) -> Array:
        x = solve_once(b)
        return x + solve_once(b - matrix @ x)

    sums = np.asarray(abs(matrix).sum(axis=1), dtype=np.float64).ravel()
    return None if singular or not solves(matrix, solve_whole, sums=sums) else solve_whole


def _choose_entries(rows: Array) -> Ints:
    """Return the column of the largest entry of each row, no column twice."""
    left, found = np.abs(rows), np.empty(len(rows), dtype=np.intp)
    for k in range(len(rows)):
        found[k] = np.argmax(left[k])
        left[:, found[k]] = 0.0
    return found


def _leave_one_entry(matrix: Any, rows: Ints, columns: Ints) -> Any:
    """Return a matrix without all entries of ``rows`` but those in ``columns``, one each, and without zeros."""
    of_row = np.full(matrix.shape[0], -1)
    of_row[rows] = columns
    column = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    only = of_row[matrix.indices]
    result = matrix.copy()
    result.data[(only >= 0) & (only != column)] = 0.0
    result.eliminate_zeros()
    return result
