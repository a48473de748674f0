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
# A step after which the next is longer than this part of it, or leaves so much of the equations, is none.
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


def find_deferred_correction(
    orbit: Orbit, finer: Orbit, scale: Array, solve: Callable[[Array], Array], tangent: Array | None = None
) -> tuple[Array, Array] | None:
    """Return the step from ``finer``, an orbit as polynomials of one degree more, and the directions that stay free.

    ``scale`` (n_unknowns,) are typical sizes of its unknowns; ``solve`` solves with the Jacobian of the orbit's own
    equations, bordered by a row for each free parameter; ``tangent`` is the direction that one free parameter leaves
    free, or empty. The step has shape (n_unknowns,), the directions (n_unknowns, n_free). None: one such step does not
    do.
    """
    tables, mesh, unknowns = _make_tables(orbit.mesh.degree), orbit.mesh, orbit.problem.unknowns
    n_free, n_values = len(orbit.problem.free), finer.problem.unknowns.values.stop

    def find_left(x: Array) -> tuple[Array, Array]:
        """Return what is left of the collocation equations, by intervals, and of the others."""
        left = compute_residual(Orbit(finer.problem, x))
        n = Rows(finer.problem.unknowns).n_collocation
        return left[:n].reshape(mesh.n_intervals, mesh.degree + 1, -1), left[n:]

    def solve_smooth(collocation: Array, others: Array) -> Array:
        """Return the step that the part of lower degree asks for."""
        restricted = np.einsum("ci,jin->jcn", tables.restrict, collocation)
        return raise_unknowns(solve(-np.concatenate([restricted.ravel(), others, np.zeros(n_free)])))

    def raise_unknowns(y: Array) -> Array:
        """Return unknowns of the orbit's mesh as those of the finer one."""
        values = resample(mesh, y[unknowns.values].reshape(mesh.n_base, -1), finer.mesh)
        return np.concatenate([values.ravel(), y[unknowns.values.stop :]])

    first, _ = find_left(finer.x)
    bubble = np.zeros((finer.mesh.n_base, first.shape[2]))
    bubble[finer.mesh.base_index] = -np.einsum("bi,jin->jbn", tables.bubble, first)
    step = np.concatenate([bubble.ravel(), np.zeros(len(finer.x) - n_values)])
    step += solve_smooth(*find_left(finer.x + step))
    last, others = find_left(finer.x + step)
    following = solve_smooth(last, others)
    states = scale[:n_values].reshape(finer.mesh.n_base, -1)[0]
    left, leaves = np.max(np.abs(last) / states), np.max(np.abs(first) / states)
    if not (left <= LEFT * leaves and np.max(np.abs(following) / scale) <= LEFT * np.max(np.abs(step) / scale)):
        return None
    if tangent is not None and len(tangent) and n_free == 1:
        return step + following, raise_unknowns(tangent)[:, None]
    free = np.zeros((len(step), n_free))
    for k in range(n_free):
        unit = np.zeros(len(orbit.x))
        unit[len(unit) - n_free + k] = 1.0
        free[:, k] = raise_unknowns(solve(unit))
    return step + following, free
