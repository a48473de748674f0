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
        return sp.csc_matrix(sp.diags_array(rows) @ matrix @ sp.diags_array(columns))
    return rows[:, None] * matrix * columns


def row_maxima(matrix: Matrix) -> Array:
    """Return the largest modulus in each row (1 for a row of zeros)."""
    largest = np.asarray(abs(matrix).max(axis=1).todense()).ravel() if sp.issparse(matrix) else np.abs(matrix).max(axis=1)
    return np.where(largest > 0, largest, 1.0)


def add_row(matrix: Matrix, row: Array) -> Matrix:
    """Return ``matrix`` with one more row below."""
    if sp.issparse(matrix):
        return sp.csc_matrix(sp.vstack([matrix, sp.csr_matrix(row[None])]))
    return np.vstack([matrix, row])
