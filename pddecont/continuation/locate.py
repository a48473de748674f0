"""The zero of a test function between two points of a branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric, correct
from pddecont.continuation.newton import NewtonSettings, Solution
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
FRACTION_TOL = 1e-12
JUMP_TOL = 1e-5


def locate(problem: Any, test: Callable[[Any, Array], float], x0: Array, x1: Array, f0: float, f1: float, metric: Metric,
           settings: NewtonSettings) -> tuple[Solution, float] | None:  # fmt: skip
    """Return the point of the branch between ``x0`` and ``x1`` where ``test`` is zero and its fraction of the chord.

    Points are corrected onto the branch in hyperplanes across the chord, and the zero is found by Brent's method. Returns
    None where the test function jumps through zero or cannot be followed: there is no special point then.
    """
    chord = x1 - x0
    # A tangent direction of the chord keeps each correction in a plane of constant fraction.
    direction = metric.unit(chord)
    solutions: dict[float, Solution] = {0.0: Solution(x0, (0.0,)), 1.0: Solution(x1, (0.0,))}

    def value(fraction: float) -> float:
        if fraction == 0.0:
            return f0
        if fraction == 1.0:
            return f1
        known = np.array(sorted(solutions))
        below, above = known[known <= fraction].max(), known[known >= fraction].min()
        part = 0.0 if above == below else (fraction - below) / (above - below)
        base = (1 - part) * (solutions[below].x - below * chord) + part * (solutions[above].x - above * chord)
        solutions[fraction] = correct(problem, base + fraction * chord, direction, metric, settings)
        result = test(problem, solutions[fraction].x)
        if not np.isfinite(result):
            raise ConvergenceError("the test function is not defined between two points")
        return result

    try:
        fraction = scipy.optimize.brentq(value, 0.0, 1.0, xtol=FRACTION_TOL, rtol=1e-14)
        at_zero = value(fraction)
    except ConvergenceError:
        return None
    if abs(at_zero) > JUMP_TOL * max(abs(f0), abs(f1)):
        return None
    return solutions[fraction], fraction
