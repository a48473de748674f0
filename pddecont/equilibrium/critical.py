"""Curves of special equilibria in two parameters: folds, Hopf points, boundary equilibria.

To the equations G(y; p) = 0 of an equilibrium, y = (x, mu), come those of what is special there:

    fold        G_y v = 0,  c . v = 1
    Hopf        Delta(i omega; x, p) q = 0 (``hopf_condition``)
    boundary    h(x; p) = 0, h the function of an event

The vector c is v of the point before.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), chapter 4.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import FixedUnknowns, Scaling
from pddecont.equilibrium.critical_roots import find_zero, leave_out
from pddecont.equilibrium.equations import Equilibrium, EquilibriumEvaluation, EquilibriumProblem, EquilibriumSystem
from pddecont.equilibrium.roots import Roots
from pddecont.equilibrium.stability import find_own_roots
from pddecont.memo import cached_property

Array = NDArray[np.float64]
# Length of the steps over which what is special is differentiated, in sizes of the unknowns: the error is of the order
# of its square, and only slows Newton's method.
DIFFERENCE = 1e-5


@dataclass(frozen=True, eq=False)
class Critical(ABC):
    """What is special along a curve: its unknowns and equations."""

    @property
    @abstractmethod
    def label(self) -> str:
        """The label of the special point."""

    @abstractmethod
    def count_unknowns(self, problem: EquilibriumProblem) -> int:
        """Return how many unknowns there are besides those of the equilibrium."""

    @abstractmethod
    def find_scale(self, sizes: Array, own: Array) -> Array:
        """Return the sizes of these unknowns, of which ``own`` are values."""

    @abstractmethod
    def evaluate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return the residuals of what is special, as many as unknowns and one more."""

    @abstractmethod
    def differentiate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return their derivatives in these unknowns."""

    def update(self, own: Array) -> Critical:
        """Return the same with what it keeps of a point taken from another."""
        return self

    def remove_own(self, roots: Roots, own: Array) -> Roots:
        """Return the characteristic roots without those that lie on the imaginary axis by the point's nature."""
        return roots


@dataclass(frozen=True, eq=False)
class FoldCondition(Critical):
    """A null vector of the Jacobian; ``normal`` is the one before."""

    normal: Array

    @property
    def label(self) -> str:
        """LP."""
        return "LP"

    def count_unknowns(self, problem: EquilibriumProblem) -> int:
        """Return the length of the null vector."""
        return problem.motion.n_states + problem.n_forces

    def find_scale(self, sizes: Array, own: Array) -> Array:
        """Return one for each component."""
        return np.ones(len(own))

    def evaluate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return G_y v and c . v - 1."""
        return np.append(make_dense(inner.jacobian())[:, : len(own)] @ own, self.normal @ own - 1.0)

    def differentiate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return G_y and c."""
        return np.vstack([make_dense(inner.jacobian())[:, : len(own)], self.normal])

    def update(self, own: Array) -> Critical:
        """Return the condition with the present vector as normal."""
        return FoldCondition(own / (own @ own))

    def remove_own(self, roots: Roots, own: Array) -> Roots:
        """Return the roots without the one nearest zero."""
        return leave_out(roots, find_zero(roots))


@dataclass(frozen=True, eq=False)
class BoundaryCondition(Critical):
    """The function of an event is zero."""

    event: str

    @property
    def label(self) -> str:
        """BE."""
        return "BE"

    def count_unknowns(self, problem: EquilibriumProblem) -> int:
        """Return none."""
        return 0

    def find_scale(self, sizes: Array, own: Array) -> Array:
        """Return nothing."""
        return np.zeros(0)

    def evaluate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return the event function."""
        at = inner.equilibrium
        return np.array([at.motion.measure_event(self.event, at.states, at.parameters)[0]])

    def differentiate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return nothing."""
        return np.zeros((1, 0))


@dataclass(frozen=True, eq=False)
class CriticalEvaluation:
    """The equations of a curve at the unknowns ``x``: those of the equilibrium, what is special, two parameters."""

    system: CriticalSystem
    x: Array

    @cached_property
    def inner(self) -> EquilibriumEvaluation:
        """The equations of the equilibrium."""
        k = self.system.n_inner
        return EquilibriumEvaluation(self.system.problem, np.concatenate([self.x[:k], self.x[-2:]]))

    @property
    def equilibrium(self) -> Equilibrium:
        """What the unknowns stand for."""
        return self.inner.equilibrium

    @property
    def own(self) -> Array:
        """The unknowns of what is special."""
        return self.x[self.system.n_inner : -2]

    @cached_property
    def all_roots(self) -> Roots:
        """The leading characteristic roots."""
        at = self.equilibrium
        return find_own_roots(at.motion, at.states, at.parameters)

    @cached_property
    def roots(self) -> Roots:
        """The leading characteristic roots without those that all points of the curve have on the imaginary axis."""
        return self.system.critical.remove_own(self.all_roots, self.own)

    @cached_property
    def residual(self) -> Array:
        """All residuals."""
        return np.concatenate([self.inner.residual, self.system.critical.evaluate(self.inner, self.own)])

    def jacobian(self) -> Array:
        """Return the derivatives: of what is special in x and p by central differences, all others exact."""
        system, k = self.system, self.system.n_inner
        n = system.problem.motion.n_states
        inner, special = make_dense(self.inner.jacobian()), system.critical.differentiate(self.inner, self.own)
        result = np.zeros((k + len(special), len(self.x)))
        result[:k, :k], result[:k, -2:] = inner[:, :k], inner[:, -2:]
        result[k:, k : len(self.x) - 2] = special
        for column in (*range(n), len(self.x) - 2, len(self.x) - 1):
            step = DIFFERENCE * float(system.scaling.scale[column])
            ends = [self._move(column, sign * step) for sign in (-1.0, 1.0)]
            result[k:, column] = (ends[1] - ends[0]) / (2.0 * step)
        return result

    @property
    def time_order(self) -> None:
        """None: nothing here happens in time."""

    def _move(self, column: int, step: float) -> Array:
        x = self.x.copy()
        x[column] += step
        moved = CriticalEvaluation(self.system, x)
        return self.system.critical.evaluate(moved.inner, moved.own)


class CriticalSystem(FixedUnknowns[CriticalEvaluation]):
    """A curve of special equilibria; ``start`` are unknowns near it, which say how large they are."""

    def __init__(self, inner: EquilibriumSystem, critical: Critical, start: Array):
        self.inner, self.critical, self.start = inner, critical, start
        self.problem = inner.problem
        self.n_inner = inner.problem.n_unknowns - 2
        super().__init__(self)

    @cached_property
    def scaling(self) -> Scaling:
        """Sizes and weights: all of what is special together counts as one."""
        own = self.start[self.n_inner : -2]
        scale, weight = self.inner.scaling.scale, self.inner.scaling.weight
        between = self.critical.find_scale(self.inner.sizes, own)
        return Scaling(
            np.concatenate([scale[:-2], between, scale[-2:]]),
            np.concatenate([weight[:-2], np.full(len(own), 1.0 / max(len(own), 1)), weight[-2:]]),
        )

    def at(self, x: Array) -> CriticalEvaluation:
        """Return the equations at the unknowns ``x``."""
        return CriticalEvaluation(self, x)

    def update_reference(self, at: CriticalEvaluation, error: float | None = None) -> CriticalSystem:
        """Return the system with the normal of the vector and the sizes of the states taken from a point."""
        inner = self.inner.measure(at.equilibrium.states)
        return CriticalSystem(inner, self.critical.update(at.own), self.start)


def make_dense(matrix: Any) -> NDArray[Any]:
    """Return a matrix as an array."""
    return matrix if isinstance(matrix, np.ndarray) else np.asarray(matrix.toarray())
