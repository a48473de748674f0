"""How far a computed orbit is from the exact one: one Newton step on polynomials of one degree more.

The orbit's polynomials of degree m solve their collocation equations. Written as polynomials of degree m + 1 on the same mesh they leave
a residual at the m + 1 Gauss points there, and the Newton step that it asks for is the difference to the solution of degree m + 1: the
error itself, up to terms of higher order. Errors that one interval passes on to others, through the orbit's stability, its delays, the
stages of a chain and the times of its events, are counted, and so is what Newton's method and rounding left.

Reference: Ascher, Mattheij, Russell (1995), sections 5.5.2 and 9.3, for corrections by a residual of higher order.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric
from pddecont.continuation.linear import Matrix, add_row, factor, row_maxima, scale_matrix
from pddecont.errors import ConvergenceError
from pddecont.orbit.curve import Curve, sizes_of
from pddecont.orbit.error import rounding_error
from pddecont.orbit.mesh import Mesh
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]


def error_estimate(problem: OrbitProblem, x: Array, ranges: tuple[float, ...] = ()) -> float:
    """Return the estimated error of the orbit ``x``: the largest of its states, durations and start, relative to their sizes.

    States count relative to their sizes along the orbit, times to the period. An orbit with free parameters is compared with the
    nearest exact orbit, whose parameters may differ; they count relative to the widths of their ``ranges``. Infinite where exact
    orbits are not isolated.
    """
    finer, y = raised(problem, x)
    curve = Curve(finer, sizes_of(finer, y, ranges))
    try:
        step = nearest_solution(curve.jacobian(y), -curve.residual(y), curve.metric())
    except ConvergenceError:
        return np.inf
    return max(float(np.max(np.abs(step) / curve.metric().scale)), rounding_error(problem, x))


def raised(problem: OrbitProblem, x: Array) -> tuple[OrbitProblem, Array]:
    """Return the same orbit as polynomials of one degree more on the same mesh."""
    mesh = problem.mesh
    # Its points read other intervals than those of the mesh as it was made: which ones is decided where the orbit is now.
    finer = replace(mesh, degree=mesh.degree + 1, anchor=problem.theta(x))
    reference = None if problem.reference is None else _resampled(mesh, problem.reference, finer)
    values, durations, start, free = problem.layout.split(x)
    new = replace(problem, mesh=finer, reference=reference)
    return new, new.layout.join(_resampled(mesh, values, finer), durations, start, free)


def _resampled(mesh: Mesh, values: Array, finer: Mesh) -> Array:
    """Return base ``values`` (n_base, n) at the base points of a mesh with the same intervals."""
    places = mesh.grid(finer.basis.base)
    result = np.empty((finer.n_base, values.shape[1]))
    result[finer.base_index.ravel()] = mesh.at(values, places)
    return result


def nearest_solution(matrix: Matrix, rhs: Array, metric: Metric) -> Array:
    """Return the shortest solution of ``matrix @ step = rhs`` for a matrix with k >= 0 columns more than rows.

    k rows are added below; which ones does not matter as long as the matrix becomes regular, and random ones make it so. The solutions
    for their unit vectors span the null space, and what any solution has along it is taken off.
    """
    n_rows, n = matrix.shape
    size, n_free = metric.size, n - n_rows
    scaled = scale_matrix(matrix, np.ones(n_rows), size)
    rows = 1.0 / row_maxima(scaled)
    scaled = scale_matrix(scaled, rows, np.ones(n))
    for border in np.random.default_rng(1).standard_normal((n_free, n)):
        scaled = add_row(scaled, border / np.linalg.norm(border))
    right = np.zeros((n, 1 + n_free))
    right[:n_rows, 0] = rows * rhs
    right[n_rows:, 1:] = np.eye(n_free)
    solved = factor(scaled).solve(right)
    free, _ = np.linalg.qr(solved[:, 1:])
    step = solved[:, 0]
    return size * (step - free @ (free.T @ step))
