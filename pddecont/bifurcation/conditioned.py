"""Special orbits as a system of equations: an orbit's own and one more, a condition that defines the special point.

A condition is a smooth function of the orbit. A Newton step needs its rates of change in no more than three directions: the one or two
in which the orbit's own equations leave it free, and a correction that these equations ask for. With
two free parameters the solutions form a curve, with one they are points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.arclength import Metric
from pddecont.continuation.linear import Matrix, add_row, factor, row_maxima, scale_matrix
from pddecont.continuation.newton import NewtonSettings, Solution, newton
from pddecont.continuation.settling import settled
from pddecont.errors import ConvergenceError
from pddecont.orbit.curve import Curve
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
DIFFERENCE = 1e-6
NOTHING = 1e-12


class Condition(Protocol):
    """What makes an orbit a special one."""

    @property
    def kind(self) -> str:
        """Label of such points."""
        ...

    def value(self, curve: Curve, x: Array) -> float:
        """Return a smooth function of the orbit that is zero at special ones."""
        ...

    def framed(self, curve: Curve, x: Array) -> Any:
        """Return the same condition, with what it keeps of one orbit taken from ``x``."""
        ...


@dataclass(eq=False)
class SpecialCurve:
    """Orbits of ``curve`` that fulfil a condition; followed like any branch."""

    curve: Curve
    condition: Any
    free_directions: Array | None = None

    @property
    def problem(self) -> OrbitProblem:
        """The orbits' boundary-value problem."""
        return self.curve.problem

    def residual(self, x: Array) -> Array:
        """Return the residuals of the orbit's equations and of the condition."""
        value = self.condition.value(self.curve, x)
        if not np.isfinite(value):
            raise ConvergenceError(f"the condition of {self.condition.kind} is not defined here")
        return np.append(self.curve.residual(x), value)

    def jacobian(self, x: Array) -> Matrix:
        """Return their derivatives."""
        matrix, size = self.curve.jacobian(x), self.metric().size
        directions, correction = self._spans(matrix, -self.curve.residual(x))
        length = float(np.linalg.norm(correction / size))
        if length > NOTHING:
            directions = np.vstack([directions, correction / length])
        rows = (directions / size).T
        slopes = self.slopes(x, directions)
        return add_row(matrix, (rows @ np.linalg.solve(rows.T @ rows, slopes)) / size)

    def directions(self, x: Array) -> Array:
        """Return unit directions that span the null space of the orbit's equations, shape (n_free, n_unknowns)."""
        return self._spans(self.curve.jacobian(x), np.zeros(len(x) - len(self.problem.free)))[0]

    def _spans(self, matrix: Matrix, rhs: Array) -> tuple[Array, Array]:
        """Return unit directions that span the null space, and a solution for ``rhs``, from one factorisation."""
        size, n_free = self.metric().size, len(self.problem.free)
        if self.free_directions is None:
            self.free_directions = np.random.default_rng(1).standard_normal((n_free, matrix.shape[1])) * size
            for _ in range(2):
                self.free_directions = _null(matrix, size, self.free_directions, rhs)[0]
        self.free_directions, solution = _null(matrix, size, self.free_directions, rhs)
        return self.free_directions, solution

    def along(self, x: Array) -> Array:
        """Return the unit direction among the orbits, of two free parameters, in which the condition does not change."""
        directions = self.directions(x)
        first, second = self.slopes(x, directions)
        return self.metric().unit(np.array([-second, first]) @ directions)

    def slopes(self, x: Array, directions: Array) -> Array:
        """Return the condition's rates of change along unit ``directions``."""
        here = self.condition.value(self.curve, x)
        step = DIFFERENCE
        return np.array([(self.condition.value(self.curve, x + step * d) - here) / step for d in directions])

    def metric(self) -> Metric:
        """Return sizes and weights of the unknowns."""
        return self.curve.metric()

    def outline(self, x: Array) -> Array:
        """Return the unknowns that no mesh changes."""
        return self.curve.outline(x)

    def outline_index(self) -> NDArray[np.intp]:
        """Return their places."""
        return self.curve.outline_index()

    def forbids(self, x: Array) -> str:
        """Return why ``x`` can be no point of the curve."""
        return self.curve.forbids(x)

    def holds(self, x: Array) -> bool:
        """Whether the mesh's breaking points are in their order at ``x``."""
        return self.curve.holds(x)

    def suits(self, x: Array) -> bool:
        """Whether the mesh holds and keeps its tolerance."""
        return self.curve.suits(x)

    def refit(self, x: Array, others: Sequence[Array], *, solved: bool) -> tuple[SpecialCurve, Array, list[Array]]:
        """Return the curve on a mesh made for ``x``."""
        curve, x, moved = self.curve.refit(x, others, solved=solved)
        return SpecialCurve(curve, self.condition.framed(curve, x)), x, moved

    def carry(self, other: SpecialCurve, x: Array) -> Array:
        """Return the unknowns of another curve in this one's."""
        return self.curve.carry(other.curve, x)

    def rephased(self, x: Array) -> SpecialCurve:
        """Return the curve with ``x`` as the reference of its phase and its condition."""
        curve = self.curve.rephased(x)
        return SpecialCurve(curve, self.condition.framed(curve, x))


def _null(matrix: Matrix, size: Array, near: Array, rhs: Array) -> tuple[Array, Array]:
    """Return unit vectors that span the null space, and the solution for ``rhs`` that is at right angles to those ``near``."""
    scaled = scale_matrix(matrix, np.ones(matrix.shape[0]), size)
    row_sizes = 1.0 / row_maxima(scaled)
    scaled = scale_matrix(scaled, row_sizes, np.ones(len(size)))
    for direction in near:
        scaled = add_row(scaled, direction / size)
    n = len(near)
    right = np.zeros((len(size), n + 1))
    right[-n:, :n] = np.eye(n)
    right[:-n, n] = row_sizes * rhs
    solved = factor(scaled).solve(right)
    basis, upper = np.linalg.qr(solved[:, :n])
    return (basis * np.sign(np.diag(upper))).T * size, solved[:, n] * size


def solve_special(curve: Curve, x: Array, condition: Condition, settings: NewtonSettings | None = None) -> tuple[SpecialCurve, Solution]:
    """Return the special orbit near ``x`` with one free parameter, on a mesh that suits it."""
    return settled(SpecialCurve(curve, condition), x,
                   lambda special, guess: newton(special.residual, special.jacobian, guess, special.metric().scale, settings))  # fmt: skip
