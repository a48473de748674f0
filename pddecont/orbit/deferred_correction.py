"""The step from an orbit to one of a degree more, by factors of the orbit's own equations.

What the orbit's polynomials of degree m leave of the equations at the m + 1 Gauss points of the next degree is taken
care of in two parts. Its integral over each interval, less a straight line, vanishes at both ends: a bubble. What is
left with it is smooth enough for polynomials of degree m, whose equations were factored when the orbit was found.

Reference: Skeel, SIAM J. Numer. Anal. 19 (1982), for deferred corrections.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from pddecont.collocation import make_basis, resample
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.residual import Rows, compute_residual

Array = NDArray[np.float64]
# A step that leaves more than this part of what the orbit left of the equations is none.
LEFT = 0.1


@dataclass(frozen=True, eq=False)
class _Tables:
    """From values at the m + 1 Gauss points to the bubble at the m + 2 base points, and to values at the m points."""

    bubble: Array
    restrict: Array


@cache
def _make_tables(degree: int) -> _Tables:
    coarse, fine = make_basis(degree), make_basis(degree + 1)
    to_series = np.linalg.inv(legendre.legvander(2.0 * fine.nodes - 1.0, degree))
    integrals = legendre.legint(np.eye(degree + 1), lbnd=-1.0) / 2.0
    integral = legendre.legvander(2.0 * fine.base - 1.0, degree + 1) @ integrals @ to_series
    return _Tables(
        integral - np.outer(fine.base, integral[-1]), legendre.legvander(2.0 * coarse.nodes - 1.0, degree) @ to_series
    )


def find_deferred_correction(orbit: Orbit, finer: Orbit, solve: Callable[[Array], Array]) -> tuple[Array, Array] | None:
    """Return the step from ``finer``, an orbit as polynomials of one degree more, and the directions that stay free.

    ``solve`` solves with the Jacobian of the orbit's equations, bordered by a row for each free parameter. The step has
    shape (n_unknowns,), the directions (n_unknowns, n_free). None: the step leaves too much of the equations.
    """
    tables, size = _make_tables(orbit.mesh.degree), np.ptp(orbit.values, axis=0) + np.max(np.abs(orbit.values), axis=0)
    n_free = len(orbit.problem.free)

    def split(x: Array) -> tuple[Array, Array]:
        """Return what is left of the collocation equations by intervals, and of the others."""
        left = compute_residual(Orbit(finer.problem, x))
        n = Rows(finer.problem.unknowns).n_collocation
        return left[:n].reshape(finer.mesh.n_intervals, orbit.mesh.degree + 1, -1), left[n:]

    def raise_unknowns(y: Array) -> Array:
        """Return unknowns of the orbit's mesh as those of the finer one."""
        values = y[orbit.problem.unknowns.values].reshape(orbit.mesh.n_base, -1)
        raised = resample(orbit.mesh, values, finer.mesh)
        return np.concatenate([raised.ravel(), y[orbit.problem.unknowns.values.stop :]])

    first, _ = split(finer.x)
    bubble = np.zeros((finer.mesh.n_base, first.shape[2]))
    bubble[finer.mesh.base_index] = -np.einsum("bi,jin->jbn", tables.bubble, first)
    step = np.zeros(len(finer.x))
    step[finer.problem.unknowns.values] = bubble.ravel()
    second, others = split(finer.x + step)
    restricted = np.einsum("ci,jin->jcn", tables.restrict, second)
    step += raise_unknowns(solve(-np.concatenate([restricted.ravel(), others, np.zeros(n_free)])))
    last, _ = split(finer.x + step)
    largest = [float(np.max(np.abs(left) / np.where(size > 0.0, size, 1.0))) for left in (first, last)]
    if not largest[1] <= LEFT * largest[0]:
        return None
    n_rows = len(orbit.x)
    free = np.zeros((len(step), n_free))
    for k in range(n_free):
        unit = np.zeros(n_rows)
        unit[n_rows - n_free + k] = 1.0
        free[:, k] = raise_unknowns(solve(unit))
    return step, free
