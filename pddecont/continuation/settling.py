"""Solving on a mesh that suits the solution, whatever is solved for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.newton import Solution
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
MAX_MESHES = 8
UNSETTLED = "the mesh does not settle: a delayed value is read across a jump of the state here, or 'mesh: {tol}' is too small"


def settled(problem: Any, guess: Array, solve: Callable[[Any, Array], Solution]) -> tuple[Any, Solution]:
    """Return the problem on a mesh that holds and suits the solution that ``solve(problem, guess)`` finds on it, and that solution.

    Raises
    ------
    ConvergenceError
        If ``solve`` fails, or the mesh does not settle.
    """
    for _ in range(MAX_MESHES):
        if not problem.holds(guess):
            problem, guess, _ = problem.refit(guess, [], solved=False)
        solution = solve(problem, guess)
        if problem.suits(solution.x):
            return problem, solution
        problem, guess, _ = problem.refit(solution.x, [], solved=True)
    raise ConvergenceError(UNSETTLED)
