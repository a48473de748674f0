"""Solving for a periodic orbit with all parameters fixed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshRule
from pddecont.continuation import (
    MeshNotSettledError,
    NewtonSettings,
    Solution,
    keep_within,
    solve_adaptively,
    solve_newton,
)
from pddecont.errors import ConvergenceError
from pddecont.orbit.error import estimate_interval_errors
from pddecont.orbit.estimate import estimate_error
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.remesh import make_mesh, mesh_is_valid, transfer_orbit
from pddecont.orbit.system import OrbitEvaluation, PeriodicOrbitSystem, measure_orbit

Array = NDArray[np.float64]


def solve_orbit(guess: Orbit, rule: MeshRule, settings: NewtonSettings | None = None) -> Solution[OrbitEvaluation]:
    """Return the periodic orbit near ``guess`` on a mesh that is adequate for it.

    Raises
    ------
    ConvergenceError
        If Newton's method fails, or no mesh reaches the rule's tolerance.
    """
    if not mesh_is_valid(guess):
        guess = transfer_orbit(guess, make_mesh(guess.problem, guess.theta, rule, orbit=guess))
    system = PeriodicOrbitSystem(guess.problem, measure_orbit(guess), rule)
    return _solve_adaptively(system, guess.x, settings)


def solve_within_tolerance(guess: Orbit, rule: MeshRule) -> tuple[Solution[OrbitEvaluation], float]:
    """Return the periodic orbit near ``guess`` and its estimated error, beyond the tolerance if no mesh keeps it.

    Raises
    ------
    ConvergenceError
        If Newton's method fails, or no mesh reaches the rule's tolerance.
    """

    def solve_finer(
        coarse: tuple[Solution[OrbitEvaluation], float], error: float
    ) -> tuple[Solution[OrbitEvaluation], float]:
        at = coarse[0].at
        system = PeriodicOrbitSystem(at.orbit.problem, measure_orbit(at.orbit), rule).update_reference(at, error)
        system, x, _ = system.remesh(at, [], solved=True)
        solution = _solve_adaptively(system, x, None)
        return solution, estimate_error(solution.at.orbit)

    solution = solve_orbit(guess, rule)
    found = solution, estimate_error(solution.at.orbit)
    return found if rule.tol is None else keep_within(rule.tol, found, lambda f: f[1], solve_finer)


def _solve_adaptively(
    system: PeriodicOrbitSystem, guess: Array, settings: NewtonSettings | None
) -> Solution[OrbitEvaluation]:
    try:
        _, solution = solve_adaptively(
            system, guess, lambda on_mesh, x, _: solve_on_mesh(Orbit(on_mesh.problem, x), settings)
        )
    except MeshNotSettledError as exc:
        last = exc.system.at(exc.x).orbit
        worst = float(np.max(estimate_interval_errors(last)))
        raise ConvergenceError(
            f"no mesh reaches the tolerance: {last.mesh.n_intervals} intervals leave an estimated error of "
            f"{worst:.1e}; raise 'mesh: {{tol}}' or the degree"
        ) from exc
    return solution


def solve_on_mesh(guess: Orbit, settings: NewtonSettings | None = None) -> Solution[OrbitEvaluation]:
    """Return the periodic orbit near ``guess`` on its own mesh.

    Raises
    ------
    ConvergenceError
        If Newton's method fails, with the residuals.
    """
    assert not guess.problem.free, "all parameters are fixed here"
    system = PeriodicOrbitSystem(guess.problem, measure_orbit(guess))
    return solve_newton(system.at, guess.x, system.scaling.scale, settings)
