"""Pseudo-arclength: the tangent to a branch and the correction back onto it.

Lengths are measured in scaled unknowns, |dx|^2 = sum_i w_i (dx_i / scale_i)^2. Reference: Allgower, Georg, Introduction to
Numerical Continuation Methods (2003), chapters 2 and 6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix, add_row, factor, row_maxima, scale_matrix
from pddecont.continuation.newton import NewtonSettings, Solution, newton

Array = NDArray[np.float64]


class Problem(Protocol):
    """A system of n equations in n + 1 unknowns whose solutions form curves."""

    def residual(self, x: Array) -> Array:
        """Return the n residuals."""
        ...

    def jacobian(self, x: Array) -> Matrix:
        """Return their derivatives, n by n + 1."""
        ...


@dataclass(frozen=True, eq=False)
class Metric:
    """Typical size and weight of each unknown."""

    scale: Array
    weight: Array

    @property
    def size(self) -> Array:
        """How far each unknown moves when a direction of length one lies along it."""
        return self.scale / np.sqrt(self.weight)

    def dot(self, a: Array, b: Array) -> float:
        """Return the inner product of two directions."""
        return float(np.sum(self.weight * (a / self.scale) * (b / self.scale)))

    def covector(self, a: Array) -> Array:
        """Return the row that takes the inner product with ``a``."""
        return self.weight * a / self.scale**2

    def unit(self, a: Array) -> Array:
        """Return ``a`` at length one."""
        return a / np.sqrt(self.dot(a, a))


def tangent(problem: Problem, x: Array, metric: Metric, towards: Array) -> Array:
    """Return the unit tangent of the branch at ``x`` that makes an acute angle with ``towards``."""
    matrix = add_row(problem.jacobian(x), metric.covector(towards))
    matrix = scale_matrix(matrix, np.ones(len(x)), metric.scale)
    rows = 1.0 / row_maxima(matrix)
    rhs = np.zeros(len(x))
    rhs[-1] = rows[-1]
    return metric.unit(metric.scale * factor(scale_matrix(matrix, rows, np.ones(len(x)))).solve(rhs))


def tangent_of(solution: Solution, metric: Metric, towards: Array) -> Array:
    """Return the unit tangent at a corrected point from the factors of its last Newton step, at an acute angle to ``towards``.

    Whatever row bordered the Jacobian, the solution for the last unit vector is the direction that the other rows leave free.
    """
    rhs = np.zeros(len(solution.x))
    rhs[-1] = 1.0
    direction = metric.unit(solution.solve(rhs))
    return direction if metric.dot(direction, towards) > 0.0 else -direction


def correct(problem: Problem, predicted: Array, direction: Array, metric: Metric, settings: NewtonSettings,
            guess: Array | None = None) -> Solution:  # fmt: skip
    """Return the branch's point in the hyperplane through ``predicted`` across ``direction``; Newton starts from ``guess``."""
    row = metric.covector(direction)
    return bordered(problem, row, float(row @ predicted), predicted if guess is None else guess, metric, settings)


def correct_at(problem: Problem, guess: Array, index: int, value: float, metric: Metric, settings: NewtonSettings) -> Solution:
    """Return the branch's point near ``guess`` at which unknown ``index`` equals ``value``."""
    row = np.zeros(len(guess))
    row[index] = 1.0
    return bordered(problem, row, value, guess, metric, settings)


def bordered(problem: Problem, row: Array, level: float, guess: Array, metric: Metric, settings: NewtonSettings) -> Solution:
    """Return the branch's point near ``guess`` with ``row @ x = level``."""
    return newton(lambda x: np.append(problem.residual(x), float(row @ x) - level), lambda x: add_row(problem.jacobian(x), row),
                  guess, metric.scale, settings)  # fmt: skip
