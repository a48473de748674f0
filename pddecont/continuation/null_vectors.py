"""Null vectors of equations that lack one rank, by inverse iteration on a bordered matrix.

With b near the left null vector of A (n, n + k), and the rows of C near the k + 1 right ones,

    [A  b]
    [C  0]

is regular, and its solutions for the last units are nearer to them.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), section 3.2.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix, add_row, factor

Array = NDArray[np.float64]
# Each iteration gains the ratio of the two smallest singular values.
N_ITERATIONS = 3


def find_null_vectors(matrix: Matrix) -> tuple[Array, Array]:
    """Return the left null vector and the right ones of a matrix (n, n + k) whose rank is nearly n - 1.

    Its unknowns and rows are scaled.

    Returns
    -------
    left, right
        Shapes (n,) and (k + 1, n + k): a unit vector, and unit vectors at right angles.

    Raises
    ------
    ConvergenceError
        If the matrix is not finite, or lacks more ranks.
    """
    n, n_columns = matrix.shape
    k, size, rng = n_columns - n + 1, n_columns + 1, np.random.default_rng(1)
    left, right = rng.standard_normal(n), rng.standard_normal((k, n_columns))
    for _ in range(N_ITERATIONS):
        bordered = add_border(matrix, left / np.linalg.norm(left), _make_orthonormal(right))
        turned = sp.csc_matrix(bordered.T) if sp.issparse(bordered) else bordered.T
        right = factor(bordered)(np.eye(size, k, k - size))[:n_columns].T
        left = factor(turned)(np.eye(size, 1, 1 - size))[:n, 0]
    return left / np.linalg.norm(left), _make_orthonormal(right)


def add_border(matrix: Matrix, column: Array, rows: Array) -> Matrix:
    """Return ``matrix`` (n, m) with a ``column`` (n,) beside it and ``rows`` (k, m) below, zero where both meet."""
    if sp.issparse(matrix):
        wide = sp.csc_matrix(sp.hstack([matrix, column[:, None]]))
    else:
        wide = np.hstack([matrix, column[:, None]])
    for row in rows:
        wide = add_row(wide, np.append(row, 0.0))
    return wide


def _make_orthonormal(rows: Array) -> Array:
    """Return rows that span the same, at right angles and of length 1; the first keeps its direction."""
    result = rows.copy()
    for i, row in enumerate(rows):
        rest = row - result[:i].T @ (result[:i] @ row)
        result[i] = rest / np.linalg.norm(rest)
    return result
