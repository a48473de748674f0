"""Pseudo-arclength: the tangent to a branch and the correction back onto it.

Lengths are measured in scaled unknowns. Reference: Allgower, Georg, Introduction to Numerical Continuation Methods
(2003), chapters 2 and 6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix, ScaledFactors, add_row, equilibrate
from pddecont.continuation.newton import NewtonSettings, Solution, solve_newton
from pddecont.continuation.scaling import Scaling
from pddecont.continuation.system import E, Evaluation, System
from pddecont.continuation.time_order import TimeOrder
from pddecont.memo import cached_property

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BorderedEvaluation(Generic[E]):
    """Equations of a branch and one linear equation more, ``row @ x = level``, which picks a point of it."""

    inner: E
    row: Array
    level: float

    @property
    def x(self) -> Array:
        """The unknowns."""
        return self.inner.x

    @cached_property
    def residual(self) -> Array:
        """The residuals, that of the linear equation last."""
        result = np.empty(len(self.row))
        result[:-1], result[-1] = self.inner.residual, float(self.row @ self.x) - self.level
        return result

    def jacobian(self) -> Matrix:
        """Return the residuals' derivatives, square."""
        return add_row(self.inner.jacobian(), self.row)

    @property
    def time_order(self) -> TimeOrder | None:
        """In which order of time the Jacobian is eliminated."""
        return self.inner.time_order


def find_tangent(at: Evaluation, scaling: Scaling, towards: Array) -> Array:
    """Return the unit tangent of the branch at one of its points that makes an acute angle with ``towards``."""
    bordered = equilibrate(add_row(at.jacobian(), scaling.covector(towards)), scaling.scale)
    return scaling.normalise(bordered.factor(at.time_order).solve(_last_unit(len(at.x))))


def tangent_at(solution: Solution[E], scaling: Scaling, towards: Array) -> Array:
    """Return the unit tangent at a corrected point from the factors of its last Newton step.

    Whatever row bordered the Jacobian, the solution for the last unit vector is the direction that the other rows leave
    free. It makes an acute angle with ``towards``.
    """
    return orient(solution.solve(_last_unit(len(solution.x))), scaling, towards)


def orient(tangent: Array, scaling: Scaling, towards: Array) -> Array:
    """Return a ``tangent`` of any length as a unit vector that makes an acute angle with ``towards``."""
    direction = scaling.normalise(tangent)
    return direction if scaling.dot(direction, towards) > 0.0 else -direction


def correct(
    system: System[E], predicted: Array, direction: Array, settings: NewtonSettings, guess: Array | None = None
) -> Solution[E]:
    """Return the branch's point in the hyperplane through ``predicted`` across ``direction``.

    Newton's method starts from ``guess``, by default from the predicted point.
    """
    row = system.scaling.covector(direction)
    return solve_with_row(system, row, float(row @ predicted), predicted if guess is None else guess, settings)


def correct_component(
    system: System[E], guess: Array, index: int, value: float, settings: NewtonSettings
) -> Solution[E]:
    """Return the branch's point near ``guess`` at which unknown ``index`` equals ``value``."""
    row = np.zeros(len(guess))
    row[index] = 1.0
    return solve_with_row(system, row, value, guess, settings)


def solve_with_row(
    system: System[E],
    row: Array,
    level: float,
    guess: Array,
    settings: NewtonSettings,
    near: ScaledFactors | None = None,
) -> Solution[E]:
    """Return the branch's point near ``guess`` with ``row @ x = level``; ``near`` are factors of a point near it.

    Raises
    ------
    ConvergenceError
        If Newton's method fails.
    """
    bordered = solve_newton(
        lambda x: BorderedEvaluation(system.at(x), row, level), guess, system.scaling.scale, settings, near
    )
    inner, n = bordered.at.inner, bordered.n_iterations
    return Solution(inner, bordered.history, bordered.solve, n, bordered.factor_anew, bordered.factors)


def _last_unit(n: int) -> Array:
    unit = np.zeros(n)
    unit[-1] = 1.0
    return unit
