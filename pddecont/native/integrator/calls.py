"""What the integrator calls of LAPACK; compiled it is LAPACK's own (calls.pxi)."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Integers


def factorise(matrix: Floats, pivots: Integers, n: int) -> bool:
    """Write the factors of a matrix (n, n) in its place, and the rows that they exchange; return whether it has any."""
    import numpy as np
    import scipy.linalg

    square = matrix[: n * n].reshape(n, n)
    try:
        factors, rows = scipy.linalg.lu_factor(square, check_finite=False)
    except np.linalg.LinAlgError:
        return False
    square[:], pivots[:n] = factors, rows
    return bool(np.all(np.diag(factors) != 0.0))


def solve_factorised(matrix: Floats, pivots: Integers, n: int, right: Floats) -> None:
    """Write the solution of the linear system with a matrix that :func:`factorise` left in the place of its right."""
    import scipy.linalg

    right[:n] = scipy.linalg.lu_solve((matrix[: n * n].reshape(n, n), pivots[:n]), right[:n], check_finite=False)
