"""Fold (LP): a branch turns back in its parameter; a multiplier is +1.

Along a branch the test function is the free parameter's component of the tangent, which is smooth and needs no multipliers. On a
curve in two parameters the fold is where the Jacobian J of the orbit's equations at fixed parameters is singular: with b and c near
its null vectors,

    [J   b] [v]   [0]
    [c^T 0] [g] = [1]

is regular, and g = 0 exactly where J is singular. v is then the null vector, and a cusp is where g does not change along it.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), sections 3.2 and 4.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix, add_row, factor, row_maxima, scale_matrix
from pddecont.continuation.locate import Located
from pddecont.orbit.curve import Curve
from pddecont.orbit.jacobian import Assembler
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
KIND = "LP"


def turning(point: Located) -> float:
    """Return the rate at which the (first) free parameter changes along the branch."""
    return float(point.tangent[point.problem.problem.layout.free][0])


def _jacobian(problem: OrbitProblem, x: Array) -> Matrix:
    """Return the Jacobian in the orbit's own unknowns."""
    return Assembler(problem)(x)[:, : problem.layout.free.start]


def _bordered(matrix: Matrix, b: Array, c: Array) -> Matrix:
    wide = sp.csc_matrix(sp.hstack([matrix, b[:, None]])) if sp.issparse(matrix) else np.hstack([matrix, b[:, None]])
    return add_row(wide, np.append(c, 0.0))


@dataclass(frozen=True, eq=False)
class Fold:
    """The condition g = 0, with the vectors b and c that border the Jacobian and the rows' scales."""

    b: Array
    c: Array
    rows: Array
    kind: str = KIND

    def value(self, curve: Curve, x: Array) -> float:
        """Return g at the orbit ``x``."""
        return float(self.null(curve, x)[1])

    def null(self, curve: Curve, x: Array) -> tuple[Array, float]:
        """Return the vector v (in scaled unknowns) and g."""
        n = curve.problem.layout.free.start
        matrix = scale_matrix(_jacobian(curve.problem, x), self.rows, curve.metric().scale[:n])
        last = np.zeros(n + 1)
        last[-1] = 1.0
        solved = factor(_bordered(matrix, self.b, self.c)).solve(last)
        return solved[:-1], float(solved[-1])

    def framed(self, curve: Curve, x: Array) -> Fold:
        """Return the same condition with vectors fit for the orbit ``x``."""
        return fold_at(curve, x, self)


def fold_at(curve: Curve, x: Array, near: Fold | None = None) -> Fold:
    """Return the condition with b and c the left and right null vectors at ``x``, found by inverse iteration.

    ``near`` keeps their sign.
    """
    n = curve.problem.layout.free.start
    matrix = scale_matrix(_jacobian(curve.problem, x), np.ones(n), curve.metric().scale[:n])
    rows = 1.0 / row_maxima(matrix)
    matrix = scale_matrix(matrix, rows, np.ones(n))
    rng = np.random.default_rng(1)
    b, c = rng.standard_normal(n), rng.standard_normal(n)
    last = np.zeros(n + 1)
    last[-1] = 1.0
    for _ in range(3):
        b, c = b / np.linalg.norm(b), c / np.linalg.norm(c)
        whole = _bordered(matrix, b, c)
        right = factor(whole).solve(last)[:-1]
        left = factor(sp.csc_matrix(whole.T) if sp.issparse(whole) else whole.T).solve(last)[:-1]
        b, c = left, right
    b, c = b / np.linalg.norm(b), c / np.linalg.norm(c)
    if near is not None and len(near.c) == n and near.c @ c < 0.0:
        c = -c
    if near is not None and len(near.b) == n and near.b @ b < 0.0:
        b = -b
    return Fold(b, c, rows)
