"""The zero of a test function between two points of a branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from pddecont.continuation.arclength import bordered
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
FRACTION_TOL = 1e-13
JUMP_TOL = 1e-5
MAX_MESHES = 4


@dataclass(frozen=True, eq=False)
class Located:
    """A point of a branch with the problem that it solves."""

    problem: Any
    x: Array
    solution: Solution | None = None

    @property
    def n_iterations(self) -> int:
        """Number of Newton steps that it took."""
        return self.solution.n_iterations if self.solution else 0


def locate(test: Callable[[Any, Array], float], a: Located, b: Located, fa: float, fb: float,
           settings: NewtonSettings) -> tuple[Located, float] | None:  # fmt: skip
    """Return the point of the branch between ``a`` and ``b`` where ``test`` is zero, and its fraction of the way.

    Each trial is corrected onto the branch in a hyperplane across the chord of the unknowns that no mesh changes, on a mesh of its
    own where it needs one; the zero is found by Brent's method. Returns None where the test function jumps through zero or
    cannot be followed: there is no special point then.
    """
    ya, yb = a.problem.outline(a.x), b.problem.outline(b.x)
    scale = a.problem.metric().scale[a.problem.outline_index()]
    row = (yb - ya) / scale**2
    row /= np.linalg.norm(row * scale)
    known: dict[float, Located] = {0.0: a, 1.0: b}

    def value(fraction: float) -> float:
        if fraction in (0.0, 1.0):
            return fa if fraction == 0.0 else fb
        places = np.array(sorted(known))
        below, above = float(places[places <= fraction].max()), float(places[places >= fraction].min())
        part = 0.0 if above == below else (fraction - below) / (above - below)
        near, far, part = (below, above, part) if part < 0.5 else (above, below, 1.0 - part)
        problem = known[near].problem
        guess = (1.0 - part) * known[near].x + part * problem.carry(known[far].problem, known[far].x)
        known[fraction] = _correct(problem, guess, row, float(row @ (ya + fraction * (yb - ya))), settings)
        result = test(known[fraction].problem, known[fraction].x)
        if not np.isfinite(result):
            raise ConvergenceError("the test function is not defined between two points")
        return result

    try:
        fraction = float(scipy.optimize.brentq(value, 0.0, 1.0, xtol=FRACTION_TOL, rtol=1e-14))
        at_zero = value(fraction)
    except ConvergenceError:
        return None
    if abs(at_zero) > JUMP_TOL * max(abs(fa), abs(fb)):
        return None
    return known[fraction], fraction


def _correct(problem: Any, guess: Array, outline_row: Array, level: float, settings: NewtonSettings) -> Located:
    if not problem.holds(guess):
        problem, guess, _ = problem.refit(guess, [], solved=False)
    for _ in range(MAX_MESHES):
        row = np.zeros(len(guess))
        row[problem.outline_index()] = outline_row
        solution = bordered(problem, row, level, guess, problem.metric(), settings)
        if problem.suits(solution.x):
            return Located(problem, solution.x, solution)
        problem, guess, _ = problem.refit(solution.x, [], solved=True)
    raise ConvergenceError("the mesh does not settle")
