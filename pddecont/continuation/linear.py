"""Factorisation of scaled systems, dense by LAPACK or sparse by SuperLU."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.continuation.full_rows import factor_without_full_rows
from pddecont.continuation.time_order import TimeOrder, factor_in_time
from pddecont.errors import ConvergenceError
from pddecont.native import compiled_assembly

Array = NDArray[np.float64]
Ints = NDArray[np.intc]
# An Array or a scipy.sparse matrix in CSC form; scipy has no types.
Matrix: TypeAlias = Any
# From so many unknowns on entries that happen to be zero are left out, as what they fill costs more than finding them,
# and columns are factored several at once, which takes longer for fewer.
MANY = 1000


@dataclass(frozen=True, eq=False)
class EquilibratedMatrix:
    """A matrix A with n columns, scaled by the unknowns' sizes and its rows: ``matrix`` = diag(rows) A diag(columns).

    Every row of ``matrix`` has a largest entry of modulus 1.
    """

    matrix: Matrix
    rows: Array
    columns: Array

    def factor(self, order: TimeOrder | None = None) -> ScaledFactors:
        """Return the factors of a square matrix; a sparse one is eliminated in an ``order`` of time where that does.

        Raises
        ------
        ConvergenceError
            If it is singular or not finite.
        """
        return ScaledFactors(factor(self.matrix, order), self.rows, self.columns)

    def solve_with_border(self, border: Array, rhs: Array, order: TimeOrder | None = None) -> tuple[Array, Array]:
        """Return what spans the null space of a matrix with k columns more than rows, and a solution for ``rhs``.

        With the k rows ``border`` (k, n) below it, in scaled unknowns, the matrix becomes square; which rows does not
        matter as long as it becomes regular. The solutions for their unit vectors span the null space. ``order`` is as
        for :meth:`factor`.

        Returns
        -------
        null, solution
            Shapes (n, k) and (n,), in scaled unknowns; the solution is at right angles to the border.
        """
        matrix, k = self.matrix, len(border)
        for row in border:
            matrix = add_row(matrix, row)
        right = np.zeros((matrix.shape[0], k + 1))
        right[-k or len(right) :, :k] = np.eye(k)
        right[: len(self.rows), k] = self.rows * rhs
        solved = factor(matrix, order)(right)
        return solved[:, :k], solved[:, k]


@dataclass(frozen=True, eq=False)
class ScaledFactors:
    """The factors of an equilibrated square matrix."""

    solve_raw: Callable[[Array], Array]
    rows: Array
    columns: Array

    def solve_scaled(self, b: Array) -> Array:
        """Return the solution of A x = b, shape (n,) or (n, k), in scaled unknowns x / columns."""
        return self.solve_raw((self.rows * b.T).T)

    def solve(self, b: Array) -> Array:
        """Return the solution of A x = b, shape (n,) or (n, k)."""
        return (self.columns * self.solve_scaled(b).T).T


def equilibrate(matrix: Matrix, columns: Array | None = None) -> EquilibratedMatrix:
    """Return a matrix scaled by the sizes ``columns`` of its unknowns (1 by default), then row by row."""
    n_rows, n_columns = matrix.shape
    sizes = np.ones(n_columns) if columns is None else columns
    if sp.issparse(matrix) and matrix.data.dtype == np.float64:
        data, rows, wide = np.empty(len(matrix.data)), np.empty(n_rows), np.ascontiguousarray(sizes, dtype=np.float64)
        starts, indices = _find_structure(matrix)
        compiled_assembly.scale_to_one(starts, indices, matrix.data, n_rows, n_columns, wide, rows, data)
        return EquilibratedMatrix(with_values(matrix, data), rows, sizes)
    scaled = matrix if columns is None else scale_matrix(matrix, np.ones(n_rows), sizes)
    rows = 1.0 / row_maxima(scaled)
    return EquilibratedMatrix(scale_matrix(scaled, rows, np.ones(n_columns)), rows, sizes)


def factor(matrix: Matrix, order: TimeOrder | None = None) -> Callable[[Array], Array]:
    """Return what solves with a square matrix, for one right-hand side or several.

    A sparse one is eliminated in an ``order`` of time where there is one and that does.

    Raises
    ------
    ConvergenceError
        If the matrix is singular or not finite.
    """
    if sp.issparse(matrix):
        in_time = None if order is None else factor_in_time(matrix, order)
        if in_time is not None:
            return in_time
        if not np.isfinite(matrix.data).all():
            raise ConvergenceError("the Jacobian holds values that are not finite")
        try:
            return _factor_sparse(matrix)
        except RuntimeError as exc:
            raise ConvergenceError("the Jacobian is singular") from exc
    if not np.all(np.isfinite(matrix)):
        raise ConvergenceError("the Jacobian holds values that are not finite")
    with warnings.catch_warnings():
        warnings.simplefilter("error", scipy.linalg.LinAlgWarning)
        try:
            dense = scipy.linalg.lu_factor(matrix, check_finite=False)
        except (scipy.linalg.LinAlgWarning, scipy.linalg.LinAlgError) as exc:
            raise ConvergenceError("the Jacobian is singular") from exc
    return lambda b: np.asarray(scipy.linalg.lu_solve(dense, b, check_finite=False))


def _factor_sparse(matrix: Matrix) -> Callable[[Array], Array]:
    """Return what solves with a sparse matrix; a large one is factored without its zeros and full rows."""
    if matrix.shape[0] < MANY:
        solve: Callable[[Array], Array] = scipy.sparse.linalg.splu(matrix, panel_size=1, relax=1).solve
        return solve
    whole = leave_out_zeros(matrix)
    found = factor_without_full_rows(whole, lambda part: scipy.sparse.linalg.splu(part).solve)
    if found is None:
        found = scipy.sparse.linalg.splu(whole).solve
    return found


def leave_out_zeros(matrix: Matrix) -> Matrix:
    """Return a sparse matrix (CSC) without the zeros that it stores; itself where it stores none."""
    if np.count_nonzero(matrix.data) == len(matrix.data):
        return matrix
    result = make_sparse(matrix.data.copy(), matrix.indices.copy(), matrix.indptr.copy(), matrix.shape)
    result.eliminate_zeros()
    return result


def scale_matrix(matrix: Matrix, rows: Array, columns: Array) -> Matrix:
    """Return diag(rows) * matrix * diag(columns)."""
    if sp.issparse(matrix):
        with np.errstate(all="ignore"):
            data = matrix.data * rows[matrix.indices] * np.repeat(columns, np.diff(matrix.indptr))
        return with_values(matrix, data)
    with np.errstate(all="ignore"):
        return rows[:, None] * matrix * columns


def row_maxima(matrix: Matrix) -> Array:
    """Return the largest modulus in each row (1 for a row of zeros)."""
    if sp.issparse(matrix):
        largest = np.zeros(matrix.shape[0])
        np.maximum.at(largest, matrix.indices, np.abs(matrix.data))
    else:
        largest = np.abs(matrix).max(axis=1)
    return np.where(largest > 0, largest, 1.0)


def add_row(matrix: Matrix, row: Array) -> Matrix:
    """Return ``matrix`` with one more row below; a sparse one keeps a place for each of its entries."""
    if sp.issparse(matrix):
        (n_rows, n_columns), (starts, indices) = matrix.shape, _find_structure(matrix)
        n = len(indices) + n_columns
        new_starts, new_indices, data = np.empty_like(starts), np.empty(n, dtype=np.intc), np.empty(n)
        below = np.ascontiguousarray(row, dtype=np.float64)
        compiled_assembly.append_row(
            starts, indices, matrix.data, n_rows, n_columns, below, new_starts, new_indices, data
        )
        return make_sparse(data, new_indices, new_starts, (n_rows + 1, n_columns))
    return np.vstack([matrix, row])


def _find_structure(matrix: Matrix) -> tuple[Ints, Ints]:
    """Return where columns of a sparse matrix start, and the rows of its entries."""
    return np.ascontiguousarray(matrix.indptr, dtype=np.intc), np.ascontiguousarray(matrix.indices, dtype=np.intc)


def make_sparse(data: Array, rows: Ints, starts: Ints, shape: tuple[int, int]) -> Matrix:
    """Return a sparse matrix (CSC) of columns that begin at ``starts``; in each the ``rows`` rise, none twice."""
    # scipy has no way to say so: its constructors check what is known already, for longer than the matrix is used.
    result = _copy(_make_empty(shape))
    result.data, result.indices, result.indptr = data, rows, starts
    return result


@lru_cache(maxsize=256)
def _make_empty(shape: tuple[int, int]) -> Matrix:
    empty = sp.csc_matrix(shape)
    empty.has_canonical_format = True
    # Its own arrays are never read; hundreds of large ones would stay in memory.
    empty.indptr = empty.indices
    return empty


def with_values(matrix: Matrix, values: NDArray[Any]) -> Matrix:
    """Return a sparse matrix of the same structure, which is not looked through again, with other values."""
    other = _copy(matrix)
    other.data = values
    return other


def _copy(matrix: Matrix) -> Matrix:
    """Return a sparse matrix with the same arrays, as :func:`copy.copy` does for any object in ten times as long."""
    other = object.__new__(type(matrix))
    vars(other).update(vars(matrix))
    return other


def is_odd(permutation: NDArray[np.intp]) -> bool:
    """Return whether a permutation is an odd number of exchanges: its length less its number of cycles."""
    follower, odd = permutation.tolist(), False
    for first in range(len(follower)):
        at = follower[first]
        # A cycle is walked once, from its first place; places that are done follow themselves.
        while at != first:
            follower[first], follower[at], at = follower[at], at, follower[at]
            odd = not odd
    return odd


def find_log_determinant(matrix: Matrix) -> complex:
    """Return the logarithm of the determinant of a square matrix, its imaginary part up to whole turns.

    The real part of that of a singular matrix is minus infinity.
    """
    if not sp.issparse(matrix):
        sign, logarithm = np.linalg.slogdet(matrix)
        return complex(float(logarithm), float(np.angle(sign)))
    try:
        factors = scipy.sparse.linalg.splu(matrix.tocsc())
    except RuntimeError:
        return complex(-np.inf, 0.0)
    odd = sum(is_odd(p) for p in (factors.perm_r, factors.perm_c)) % 2
    return complex(np.sum(np.log(factors.U.diagonal().astype(complex)))) + 1j * np.pi * odd
