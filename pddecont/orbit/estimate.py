"""How far a computed orbit is from the exact one: one Newton step on polynomials of one degree more.

The orbit's polynomials of degree m solve their collocation equations. Written as polynomials of degree m + 1 on the
same mesh they leave a residual at the m + 1 Gauss points there, and the Newton step that it asks for is the difference
to the solution of degree m + 1: the error itself, up to terms of higher order. Errors that one interval passes on to
others, through the orbit's stability, its delays, the stages of a chain and the times of its events, are counted, and
so is what Newton's method and rounding left. Where factors of the orbit's own equations are at hand, they take the
place of those of the degree above (:mod:`pddecont.orbit.deferred_correction`).

Reference: Ascher, Mattheij, Russell (1995), sections 5.5.2 and 9.3, for corrections by a residual of higher order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import raise_degree, resample
from pddecont.continuation import Matrix, Scaling, TimeOrder, equilibrate
from pddecont.errors import ConvergenceError
from pddecont.orbit.deferred_correction import find_deferred_correction
from pddecont.orbit.error import estimate_rounding_error
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.remesh import settle_reads
from pddecont.orbit.system import PeriodicOrbitSystem, measure_orbit

Array = NDArray[np.float64]


def estimate_error(
    orbit: Orbit,
    ranges: tuple[float, ...] = (),
    solve: Callable[[Array], Array] | None = None,
    tangent: Array | None = None,
) -> float:
    """Return the estimated error of an orbit: the largest of its states, durations and start, relative to their sizes.

    States count relative to their sizes along the orbit, times to the period. An orbit with free parameters is compared
    with the nearest exact orbit, whose parameters may differ; they count relative to the widths of their ``ranges``.
    Infinite where exact orbits are not isolated. ``solve``, where it is at hand, solves with the Jacobian of the
    orbit's equations, bordered by a row for each free parameter, to a few per cent: no other matrix is factored where
    that does.
    ``tangent`` is the direction in which one free parameter leads, where that is known.
    """
    finer = _raise_orbit(orbit)
    system = PeriodicOrbitSystem(finer.problem, measure_orbit(finer, ranges))
    try:
        step = None if solve is None else _find_nearest_by_deferral(orbit, finer, solve, tangent, system.scaling)
        if step is None:
            at = system.at(finer.x)
            step = solve_nearest(at.jacobian(), -at.residual, system.scaling, at.time_order)
    except ConvergenceError:
        return np.inf
    return max(float(np.max(np.abs(step) / system.scaling.scale)), estimate_rounding_error(orbit))


def _find_nearest_by_deferral(
    orbit: Orbit, finer: Orbit, solve: Callable[[Array], Array], tangent: Array | None, scaling: Scaling
) -> Array | None:
    """Return the shortest step to an orbit of a degree more by a deferred correction, None where that does not do."""
    found = find_deferred_correction(orbit, finer, scaling.scale, solve, tangent)
    if found is None:
        return None
    step, free = found[0] / scaling.size, found[1] / scaling.size[:, None]
    along, _ = np.linalg.qr(free)
    return np.asarray(scaling.size * (step - along @ (along.T @ step)))


def _raise_orbit(orbit: Orbit) -> Orbit:
    """Return the same orbit as polynomials of one degree more on the same mesh."""
    # Its points read other intervals than those of the mesh as it was made: which ones is decided where the orbit is.
    mesh, finer = orbit.mesh, raise_degree(orbit.mesh, orbit.theta)
    reference = orbit.problem.reference
    new = replace(orbit.problem, mesh=finer, reference=None if reference is None else resample(mesh, reference, finer))
    values = resample(mesh, orbit.values, finer)
    return settle_reads(Orbit(new, new.unknowns.join(values, orbit.durations, orbit.start, orbit.free)))


def solve_nearest(matrix: Matrix, rhs: Array, scaling: Scaling, order: TimeOrder | None = None) -> Array:
    """Return the shortest solution of ``matrix @ step = rhs`` for a matrix with k >= 0 columns more than rows.

    The rows that make it square do not matter as long as it becomes regular, and random ones make it so; what the
    solution has along the null space is taken off.
    """
    n_rows, n = matrix.shape
    border = np.random.default_rng(1).standard_normal((n - n_rows, n))
    border /= np.linalg.norm(border, axis=1)[:, None]
    null, step = equilibrate(matrix, scaling.size).solve_with_border(border, rhs, order)
    along, _ = np.linalg.qr(null)
    return scaling.size * (step - along @ (along.T @ step))
