"""Curves of special equilibria in two parameters: folds, Hopf points, boundary equilibria.

To the equations G(y; p) = 0 of an equilibrium, y = (x, mu), come those of what is special there:

    fold        G_y v = 0,  c . v = 1
    Hopf        Delta(i omega; x, p) q = 0,  c . q = 1
    boundary    h(x; p) = 0, h the function of an event

The vectors c are those v or q, conjugate, of the point before.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), chapter 4; Engelborghs,
Luzyanina, Roose, ACM TOMS 28 (2002) for the delay equation.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import FixedUnknowns, Scaling
from pddecont.equilibrium.critical_roots import find_pair, find_zero, leave_out
from pddecont.equilibrium.equations import Equilibrium, EquilibriumEvaluation, EquilibriumProblem, EquilibriumSystem
from pddecont.equilibrium.roots import Roots
from pddecont.equilibrium.stability import find_own_roots
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Length of the steps over which what is special is differentiated, in sizes of the unknowns: the error is of the order
# of its square, and only slows Newton's method.
DIFFERENCE = 1e-5
# How far from a double root zero the first Hopf point is looked for, in scaled unknowns.
OFF = 0.02


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
        return np.append(_dense(inner.jacobian())[:, : len(own)] @ own, self.normal @ own - 1.0)

    def differentiate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return G_y and c."""
        return np.vstack([_dense(inner.jacobian())[:, : len(own)], self.normal])

    def update(self, own: Array) -> Critical:
        """Return the condition with the present vector as normal."""
        return FoldCondition(own / (own @ own))

    def remove_own(self, roots: Roots, own: Array) -> Roots:
        """Return the roots without the one nearest zero."""
        return leave_out(roots, find_zero(roots))


@dataclass(frozen=True, eq=False)
class HopfCondition(Critical):
    """A pair of roots +-i omega; the unknowns are the real and imaginary parts of q, then omega."""

    normal: Complex

    @property
    def label(self) -> str:
        """HB."""
        return "HB"

    def count_unknowns(self, problem: EquilibriumProblem) -> int:
        """Return the number of parts of the vector and one."""
        return 2 * problem.motion.n_states + 1

    def find_scale(self, sizes: Array, own: Array) -> Array:
        """Return one for each component, and the frequency's own size."""
        return np.append(np.ones(len(own) - 1), abs(own[-1]) or 1.0)

    def evaluate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return the real and imaginary parts of Delta q and c . q - 1."""
        q, omega = split_pair(own)
        at = inner.equilibrium
        delta, _ = at.motion.linearise(at.states, at.parameters).at(1j * omega)
        rows = np.append(delta @ q, self.normal @ q - 1.0)
        return np.concatenate([rows.real, rows.imag])

    def differentiate(self, inner: EquilibriumEvaluation, own: Array) -> Array:
        """Return the derivatives in q and omega."""
        q, omega = split_pair(own)
        at = inner.equilibrium
        delta, slope = at.motion.linearise(at.states, at.parameters).at(1j * omega)
        linear = np.vstack([_dense(delta), self.normal])
        turn = np.append(1j * slope @ q, 0.0)
        return np.block(
            [[linear.real, -linear.imag, turn.real[:, None]], [linear.imag, linear.real, turn.imag[:, None]]]
        )

    def update(self, own: Array) -> Critical:
        """Return the condition with the present vector as normal."""
        q, _ = split_pair(own)
        return HopfCondition(np.asarray(np.conj(q) / float(np.sum(np.abs(q) ** 2)), dtype=complex))

    def remove_own(self, roots: Roots, own: Array) -> Roots:
        """Return the roots without the pair."""
        return leave_out(roots, find_pair(roots, abs(split_pair(own)[1])))


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
        inner, special = _dense(self.inner.jacobian()), system.critical.differentiate(self.inner, self.own)
        result = np.zeros((k + len(special), len(self.x)))
        result[:k, :k], result[:k, -2:] = inner[:, :k], inner[:, -2:]
        result[k:, k : len(self.x) - 2] = special
        for column in (*range(n), len(self.x) - 2, len(self.x) - 1):
            step = DIFFERENCE * float(system.scaling.scale[column])
            ends = [self._move(column, sign * step) for sign in (-1.0, 1.0)]
            result[k:, column] = (ends[1] - ends[0]) / (2.0 * step)
        return result

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

    def update_reference(self, at: CriticalEvaluation) -> CriticalSystem:
        """Return the system with the normal of the vector taken from a point."""
        return CriticalSystem(self.inner, self.critical.update(at.own), self.start)


def make_critical_start(
    inner: EquilibriumSystem, label: str, event: str, at: Equilibrium, frequency: float | None = None
) -> tuple[CriticalSystem, Array]:
    """Return the system of a curve of special points and its unknowns at the point ``at``, or next to it.

    ``event`` is that of a boundary equilibrium. Of several pairs of roots on the imaginary axis the one nearest to
    ``frequency`` is meant; zero: a curve of Hopf points begins there, at a double root zero.
    """
    inside = inner.problem.join(at)
    critical: Critical = BoundaryCondition(event)
    own = np.zeros(0)
    if label == "LP" or frequency == 0.0:
        null = _find_null(inner, inside)
        critical, own = FoldCondition(null), null
    if label == "HB" and frequency == 0.0:
        null = own[: inner.problem.motion.n_states] / np.linalg.norm(own[: inner.problem.motion.n_states])
        critical, own = HopfCondition(null.astype(complex)), np.concatenate([null, np.zeros(len(null) + 1)])
        start = np.concatenate([inside[:-2], own, inside[-2:]])
        system = CriticalSystem(inner, critical, start)
        return system, start + OFF * _leave_double_zero(system, start)
    if label == "HB":
        roots = find_own_roots(at.motion, at.states, at.parameters)
        pairs = np.flatnonzero(roots.values.imag > 0.0)
        if not len(pairs):
            raise ConvergenceError("there is no pair of complex characteristic roots here")
        values = roots.values[pairs]
        away = np.abs(values.real if frequency is None else values - 1j * frequency)
        nearest = int(pairs[np.argmin(away)])
        q = roots.vectors[nearest] / np.linalg.norm(roots.vectors[nearest])
        own = np.concatenate([q.real, q.imag, [roots.values[nearest].imag]])
        critical = HopfCondition(np.asarray(np.conj(q), dtype=complex))
    start = np.concatenate([inside[:-2], own, inside[-2:]])
    return CriticalSystem(inner, critical, start), start


def _find_null(inner: EquilibriumSystem, inside: Array) -> Array:
    """Return the null vector of the Jacobian in what determines the equilibrium."""
    evaluation = EquilibriumEvaluation(inner.problem, inside)
    return np.asarray(np.linalg.svd(_dense(evaluation.jacobian())[:, : len(inside) - 2])[2][-1])


def _leave_double_zero(system: CriticalSystem, start: Array) -> Array:
    """Return the direction of the Hopf points at a double root zero, omega = 0, where folds solve the equations too.

    Both directions lie in the null space; along the Hopf points the parameters stay, to the first order.
    """
    scale = system.scaling.scale
    null = np.linalg.svd(system.at(start).jacobian() * scale)[2][-2:] * scale
    weights = np.linalg.svd(null[:, -2:].T / scale[-2:])[2][-1]
    direction = weights @ null
    return np.asarray(direction * np.sign(direction[-3]) / system.scaling.length(direction))


def split_pair(own: Array) -> tuple[Complex, float]:
    """Return the vector and the frequency of a pair from the unknowns of a Hopf point."""
    parts = own[:-1].reshape(2, -1)
    return np.asarray(parts[0] + 1j * parts[1]), float(own[-1])


def _dense(matrix: Any) -> NDArray[Any]:
    return matrix if isinstance(matrix, np.ndarray) else np.asarray(matrix.toarray())
