"""Solving on a mesh that is adequate for the solution, whatever is solved for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.newton import Solution
from pddecont.continuation.system import AdaptiveSystem, E
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
T = TypeVar("T")
S = TypeVar("S", bound=AdaptiveSystem[Any])
# Meshes that are tried for one solution; two are usual, three happen.
MAX_MESHES = 8
# Finer meshes that a solution's estimated error may ask for, and by what the error that each aims at is less than it
# need be where the one before did not do.
FINER_MESHES, FINER = 4, 4.0


class MeshNotSettledError(ConvergenceError):
    """No mesh was adequate for the solution found on it; ``x`` is the last solution, on the mesh of ``system``."""

    def __init__(self, system: AdaptiveSystem[Any], x: Array):
        self.system, self.x = system, x
        super().__init__(system.explain_unsettled_mesh())


def solve_adaptively(
    system: S, guess: Array, solve: Callable[[S, Array, list[Array]], Solution[E]], carried: Sequence[Array] = ()
) -> tuple[S, Solution[E]]:
    """Return the system on a mesh that is adequate for the solution found on it, and that solution.

    ``solve(system, guess, carried)`` gets the vectors ``carried`` in the unknowns of the mesh that it works on.

    Raises
    ------
    ConvergenceError
        If ``solve`` fails.
    MeshNotSettledError
        If no mesh is adequate for the solution found on it.
    """
    others = list(carried)
    start = system.at(guess)
    if not system.mesh_is_valid(start):
        system, guess, others = system.remesh(start, others, solved=False)
    for _ in range(MAX_MESHES):
        solution = solve(system, guess, others)
        if system.mesh_is_adequate(solution.at):
            return system, solution
        last = system
        system, guess, others = system.remesh(solution.at, others, solved=True)
    raise MeshNotSettledError(last, solution.x)


def keep_within(tol: float, found: T, error_of: Callable[[T], float | None], solve_finer: Callable[[T, float], T]) -> T:
    """Return what was ``found`` on a finer mesh if its estimated error is beyond ``tol``; the best, if no mesh does.

    The errors of a mesh's intervals may keep the tolerance, and what they add up to may not. ``error_of`` returns the
    estimated error, None where there is none, and ``solve_finer(found, error)`` what is found on a mesh made for as
    small a part of ``error`` as the tolerance is.
    """
    for k in range(FINER_MESHES):
        error = error_of(found)
        if error is None or error <= tol or not np.isfinite(error):
            break
        try:
            finer = solve_finer(found, FINER**k * error)
        except ConvergenceError:
            break
        now = error_of(finer)
        if now is not None and now < error:
            found = finer
    return found
