"""Factorisation of scaled square systems, dense by LAPACK or sparse by SuperLU."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
Matrix: TypeAlias = Any  # an Array or a scipy.sparse matrix in CSC form


@dataclass(frozen=True, eq=False)
class Factors:
    """A factored square matrix; ``solve(b)`` returns the solution for one or several right-hand sides."""

    solve: Callable[[Array], Array]


def factor(matrix: Matrix) -> Factors:
    """Return the factors of a square matrix; raise :class:`ConvergenceError` if it is singular or not finite."""
    if sp.issparse(matrix):
        if not np.all(np.isfinite(matrix.data)):
            raise ConvergenceError("the Jacobian holds values that are not finite")
        try:
            lu = scipy.sparse.linalg.splu(matrix)
        except RuntimeError as exc:
            raise ConvergenceError("the Jacobian is singular") from exc
        return Factors(lu.solve)
    if not np.all(np.isfinite(matrix)):
        raise ConvergenceError("the Jacobian holds values that are not finite")
    with warnings.catch_warnings():
        warnings.simplefilter("error", scipy.linalg.LinAlgWarning)
        try:
            dense = scipy.linalg.lu_factor(matrix, check_finite=False)
        except (scipy.linalg.LinAlgWarning, scipy.linalg.LinAlgError) as exc:
            raise ConvergenceError("the Jacobian is singular") from exc
    return Factors(lambda b: scipy.linalg.lu_solve(dense, b, check_finite=False))


def scale_matrix(matrix: Matrix, rows: Array, columns: Array) -> Matrix:
    """Return diag(rows) * matrix * diag(columns)."""
    if sp.issparse(matrix):
        with np.errstate(all="ignore"):
            data = matrix.data * rows[matrix.indices] * np.repeat(columns, np.diff(matrix.indptr))
        return _csc(data, matrix.indices, matrix.indptr, matrix.shape)
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
        n_rows, n_columns = matrix.shape
        ends, added = matrix.indptr[1:], np.arange(n_columns + 1, dtype=matrix.indptr.dtype)
        # The new entry of column j comes after all of that column's, moved on by those of the columns before.
        last = ends + added[:-1]
        old = np.ones(len(matrix.data) + n_columns, dtype=bool)
        old[last] = False
        data, indices = np.empty(len(old)), np.empty(len(old), dtype=matrix.indices.dtype)
        data[old], data[last] = matrix.data, row
        indices[old], indices[last] = matrix.indices, n_rows
        return _csc(data, indices, matrix.indptr + added, (n_rows + 1, n_columns))
    return np.vstack([matrix, row])


def _csc(data: Array, indices: Any, indptr: Any, shape: tuple[int, int]) -> sp.csc_matrix:
    return sp.csc_matrix((data, indices, indptr), shape=shape)
