"""The equations of equilibria of one mode, as continuation takes them: with no, one or two free parameters.

Unknowns: the states x, one mu_j for each surface that the mode slides along (``constant_motion``), the free parameters.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation import FixedUnknowns, Matrix, NewtonSettings, Scaling, solve_newton
from pddecont.equilibrium.constant_motion import ConstantMotion
from pddecont.equilibrium.roots import Roots
from pddecont.equilibrium.stability import find_own_roots
from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property

Array = NDArray[np.float64]
# Where all states are zero, to rounding, they count as this size.
ZERO, UNIT = 1e-12, 1.0
# A state smaller than this part of the largest one has the largest one's size.
SMALL = 1e-3
# Newton steps from a guess that somebody wrote.
MAX_ITERATIONS = 40


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A state that stays: ``states`` (n_states,) of a mode at ``parameters`` (n_parameters,)."""

    motion: ConstantMotion
    states: Array
    parameters: Array


@dataclass(frozen=True, eq=False)
class EquilibriumProblem:
    """Equilibria of a mode; ``free`` are the numbers of the free parameters, ``parameters`` are all others' values."""

    motion: ConstantMotion
    parameters: Array
    free: tuple[int, ...] = ()

    @property
    def n_forces(self) -> int:
        """Number of surfaces that the mode slides along."""
        return len(self.motion.surfaces)

    @property
    def n_unknowns(self) -> int:
        """Number of unknowns."""
        return self.motion.n_states + self.n_forces + len(self.free)

    def join(self, equilibrium: Equilibrium) -> Array:
        """Return the unknowns of an equilibrium."""
        free = equilibrium.parameters[list(self.free)]
        return np.concatenate([equilibrium.states, np.zeros(self.n_forces), free])

    def split(self, unknowns: Array) -> Equilibrium:
        """Return the equilibrium of unknowns."""
        p = self.parameters.copy()
        if self.free:
            p[list(self.free)] = unknowns[-len(self.free) :]
        return Equilibrium(self.motion, unknowns[: self.motion.n_states], p)


@dataclass(frozen=True, eq=False)
class EquilibriumEvaluation:
    """The equations at the unknowns ``x``."""

    problem: EquilibriumProblem
    x: Array

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """What the unknowns stand for."""
        return self.problem.split(self.x)

    @cached_property
    def roots(self) -> Roots:
        """The leading characteristic roots."""
        return find_own_roots(self.equilibrium.motion, self.equilibrium.states, self.equilibrium.parameters)

    @cached_property
    def residual(self) -> Array:
        """F with what the surfaces add, then the functions of the surfaces."""
        field, _, _ = self._field
        forces = self.x[self.problem.motion.n_states :][: self.problem.n_forces]
        pushed = sum((mu * slopes for mu, (_, slopes, _) in zip(forces, self._surfaces, strict=True)), np.zeros(1))
        values = np.concatenate([field + pushed, [value for value, _, _ in self._surfaces]])
        if not np.all(np.isfinite(values)):
            raise ConvergenceError("the vector field has no finite value here")
        return values

    def jacobian(self) -> Matrix:
        """Return the derivatives; where the mode slides without those that are zero with mu."""
        _, in_x, in_p = self._field
        n, m = self.problem.motion.n_states, self.problem.n_forces
        if not m:
            return sp.hstack([in_x, in_p], format="csc") if sp.issparse(in_x) else np.hstack([in_x, in_p])
        slopes = np.stack([s for _, s, _ in self._surfaces])
        below = np.hstack([slopes, np.zeros((m, m)), np.stack([q for _, _, q in self._surfaces])])
        if sp.issparse(in_x):
            return sp.vstack([sp.hstack([in_x, slopes.T, in_p]), below], format="csc")
        return np.vstack([np.hstack([in_x, slopes.T, in_p]), below]).reshape(n + m, -1)

    @property
    def time_order(self) -> None:
        """None: nothing here happens in time."""

    @cached_property
    def _field(self) -> tuple[Array, Matrix, Array]:
        at = self.equilibrium
        return self.problem.motion.differentiate(at.states, at.parameters, self.problem.free)

    @cached_property
    def _surfaces(self) -> list[tuple[float, Array, Array]]:
        at, motion = self.equilibrium, self.problem.motion
        return [motion.measure_event(e, at.states, at.parameters, self.problem.free) for e in motion.surfaces]


@dataclass(frozen=True, eq=False)
class EquilibriumSystem:
    """The equations with sizes of the unknowns: ``sizes`` (n_states,) and the ``widths`` of the parameters' ranges.

    ``least`` are the sizes where a branch begins; they do not become smaller along it (None: ``sizes``).
    """

    problem: EquilibriumProblem
    sizes: Array
    widths: tuple[float, ...] = ()
    least: Array | None = None

    @cached_property
    def scaling(self) -> Scaling:
        """All states together count as one, and so does each parameter's range."""
        n, m = len(self.sizes), self.problem.n_forces
        scale = np.concatenate([self.sizes, np.ones(m), self.widths])
        weight = np.concatenate([np.full(n + m, 1.0 / n), np.ones(len(self.widths))])
        return Scaling(scale, weight)

    def at(self, x: Array) -> EquilibriumEvaluation:
        """Return the equations at the unknowns ``x``."""
        return EquilibriumEvaluation(self.problem, x)

    def enter(self, mode: str) -> EquilibriumSystem:
        """Return the equations of another mode."""
        return replace(self, problem=replace(self.problem, motion=replace(self.problem.motion, mode=mode)))

    def measure(self, states: Array) -> EquilibriumSystem:
        """Return the system with sizes of the unknowns as large as ``states`` have become."""
        least = self.sizes if self.least is None else self.least
        return replace(self, sizes=np.maximum(least, measure_sizes(states)), least=least)


class EquilibriumCurve(FixedUnknowns[EquilibriumEvaluation]):
    """Equilibria along a branch, in sizes that grow with them."""

    def __init__(self, inner: EquilibriumSystem):
        self.inner = inner
        super().__init__(inner)

    def update_reference(self, at: EquilibriumEvaluation, error: float | None = None) -> EquilibriumCurve:
        """Return the branch with sizes taken from a point."""
        return EquilibriumCurve(self.inner.measure(at.equilibrium.states))


def measure_sizes(states: Array) -> Array:
    """Return the typical size of each state (n_states,): its own, or where it is small that of the largest."""
    largest = float(np.max(np.abs(states), initial=0.0))
    largest = largest if largest > ZERO else UNIT
    return np.where(np.abs(states) > SMALL * largest, np.abs(states), largest)


def solve_equilibrium(guess: Equilibrium, settings: NewtonSettings | None = None) -> tuple[Equilibrium, float, int]:
    """Return the equilibrium near a guess, its error as Newton's last step would change it, and the steps taken.

    The error is relative to the sizes of the states.

    Raises
    ------
    ConvergenceError
        If Newton's method finds none.
    """
    problem = EquilibriumProblem(guess.motion, guess.parameters)
    system = EquilibriumSystem(problem, measure_sizes(guess.states))
    settings = settings or NewtonSettings(max_iterations=MAX_ITERATIONS)
    solution = solve_newton(system.at, problem.join(guess), system.scaling.scale, settings)
    sizes = np.concatenate([measure_sizes(solution.x[: len(guess.states)]), np.ones(problem.n_forces)])
    left = float(np.max(np.abs(solution.solve(-solution.at.residual) / sizes)))
    return replace(solution.at.equilibrium), max(left, float(np.finfo(float).eps)), solution.n_iterations
