"""Special orbits as a system of equations: an orbit's own and one more, which defines the special point.

A defining function is a smooth function of the orbit. A Newton step needs its rates of change in no more than three
directions: the one or two in which the orbit's own equations leave it free, and a correction that these equations ask
for. With two free parameters the solutions form a curve, with one they are points.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), chapters 3 and 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import (
    Matrix,
    NewtonSettings,
    Scaling,
    Solution,
    TimeOrder,
    add_row,
    equilibrate,
    solve_adaptively,
    solve_newton,
)
from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property
from pddecont.orbit import Orbit, OrbitEvaluation, OrbitProblem, PeriodicOrbitSystem

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Length of the step over which a defining function's rate of change is taken; its error balances that of rounding.
DIFFERENCE = 1e-6
# A correction shorter than this changes nothing.
NO_CORRECTION = 1e-12
# Two parameters whose directions along the curve enclose less than this area are not independent.
NO_AREA = 1e-12


class DefiningFunction(Protocol):
    """What makes an orbit a special one."""

    @property
    def kind(self) -> str:
        """Label of such points."""
        ...

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return a smooth function of the orbit that is zero at special ones; NaN where it is not defined."""
        ...

    def update_at(self, at: OrbitEvaluation) -> Self:
        """Return the same function, with what it keeps of one orbit taken from another."""
        ...


@dataclass(frozen=True, eq=False)
class ExtendedEvaluation:
    """The equations of special orbits at one orbit."""

    system: ExtendedSystem
    inner: OrbitEvaluation

    @property
    def x(self) -> Array:
        """The unknowns."""
        return self.inner.x

    @property
    def orbit(self) -> Orbit:
        """The orbit."""
        return self.inner.orbit

    @cached_property
    def value(self) -> float:
        """The defining function."""
        return self.system.defining.evaluate(self.inner)

    @cached_property
    def residual(self) -> Array:
        """The residuals of the orbit's equations, then the defining function."""
        if not np.isfinite(self.value):
            raise ConvergenceError(f"the condition of {self.system.defining.kind} is not defined here")
        return np.append(self.inner.residual, self.value)

    def jacobian(self) -> Matrix:
        """Return their derivatives."""
        matrix, size = self.inner.jacobian(), self.system.scaling.size
        directions, correction = self._span(matrix, -self.inner.residual)
        length = float(np.linalg.norm(correction / size))
        if length > NO_CORRECTION:
            directions = np.vstack([directions, correction / length])
        rows = (directions / size).T
        slopes = self.rates_along(directions)
        return add_row(matrix, (rows @ np.linalg.solve(rows.T @ rows, slopes)) / size)

    @property
    def time_order(self) -> TimeOrder | None:
        """In which order of time the Jacobian is eliminated."""
        return self.inner.time_order

    def free_directions(self) -> Array:
        """Return unit directions that span the null space of the orbit's equations, shape (n_free, n_unknowns)."""
        return self._span(self.inner.jacobian(), np.zeros(len(self.x) - len(self.orbit.problem.free)))[0]

    def direction_along(self) -> Array:
        """Return the unit direction among the orbits of two free parameters in which the function does not change."""
        directions = self.free_directions()
        first, second = self.rates_along(directions)
        return self.system.scaling.normalise(np.array([-second, first]) @ directions)

    def rates_along(self, directions: Array) -> Array:
        """Return the defining function's rates of change along unit ``directions`` (k, n_unknowns), shape (k,)."""
        values = [self.system.at(self.x + DIFFERENCE * d).value for d in directions]
        return np.array([(value - self.value) / DIFFERENCE for value in values])

    def _span(self, matrix: Matrix, rhs: Array) -> tuple[Array, Array]:
        """Return unit directions that span the null space, and a solution for ``rhs``, from one factorisation."""
        size, n_free, basis = self.system.scaling.size, len(self.orbit.problem.free), self.system.basis
        if basis.directions is None:
            basis.directions = np.random.default_rng(1).standard_normal((n_free, matrix.shape[1])) * size
            for _ in range(2):
                basis.directions = _span_null(matrix, size, basis.directions, rhs, self.time_order)[0]
        basis.directions, solution = _span_null(matrix, size, basis.directions, rhs, self.time_order)
        return basis.directions, solution


def _span_null(matrix: Matrix, size: Array, near: Array, rhs: Array, order: TimeOrder | None) -> tuple[Array, Array]:
    """Return unit vectors that span the null space, and the solution for ``rhs`` at right angles to those ``near``."""
    null, solution = equilibrate(matrix, size).solve_with_border(near / size, rhs, order)
    basis, upper = np.linalg.qr(null)
    return (basis * np.sign(np.diag(upper))).T * size, solution * size


@dataclass(eq=False)
class NullBasis:
    """The directions that spanned the null space last: where the next are looked for, with the same signs."""

    directions: Array | None = None


@dataclass(frozen=True, eq=False)
class ExtendedSystem:
    """Orbits of a system for which a defining function is zero; followed like any branch."""

    inner: PeriodicOrbitSystem
    defining: DefiningFunction
    basis: NullBasis

    @property
    def problem(self) -> OrbitProblem:
        """The orbits' boundary-value problem."""
        return self.inner.problem

    @property
    def scaling(self) -> Scaling:
        """Sizes and weights of the unknowns."""
        return self.inner.scaling

    def at(self, x: Array) -> ExtendedEvaluation:
        """Return the equations at the unknowns ``x``."""
        return ExtendedEvaluation(self, self.inner.at(x))

    @property
    def mesh_independent_index(self) -> Ints:
        """Places of the unknowns that no mesh changes."""
        return self.inner.mesh_independent_index

    @property
    def order_independent_index(self) -> Ints:
        """Places of those among them that have no corner where breaking points change their order."""
        return self.inner.order_independent_index

    def mesh_is_valid(self, at: ExtendedEvaluation) -> bool:
        """Return whether the mesh's breaking points are in their order at an orbit."""
        return self.inner.mesh_is_valid(at.inner)

    def mesh_is_adequate(self, at: ExtendedEvaluation) -> bool:
        """Return whether the mesh is valid and keeps its tolerance."""
        return self.inner.mesh_is_adequate(at.inner)

    def remesh(
        self, at: ExtendedEvaluation, others: Sequence[Array], *, solved: bool
    ) -> tuple[ExtendedSystem, Array, list[Array]]:
        """Return the system on a mesh made for an orbit, with that orbit and ``others`` in its unknowns."""
        inner, x, moved = self.inner.remesh(at.inner, others, solved=solved)
        return extend_system(inner, self.defining.update_at(inner.at(x))), x, moved

    def interpolate_from(self, other: ExtendedSystem, x: Array) -> Array:
        """Return the unknowns of another system in this one's."""
        return self.inner.interpolate_from(other.inner, x)

    def explain_unsettled_mesh(self) -> str:
        """Return what it means if no mesh is adequate for the orbit found on it."""
        return self.inner.explain_unsettled_mesh()

    def update_reference(self, at: ExtendedEvaluation, error: float | None = None) -> ExtendedSystem:
        """Return the system with an orbit as the reference of its phase, its mesh and its defining function."""
        inner = self.inner.update_reference(at.inner, error)
        return extend_system(inner, self.defining.update_at(inner.at(at.x)))


def extend_system(inner: PeriodicOrbitSystem, defining: DefiningFunction) -> ExtendedSystem:
    """Return the system of the special orbits among those of ``inner``."""
    return ExtendedSystem(inner, defining, NullBasis())


def solve_special_orbit(
    inner: PeriodicOrbitSystem, guess: Array, defining: DefiningFunction, settings: NewtonSettings | None = None
) -> tuple[ExtendedSystem, Solution[ExtendedEvaluation]]:
    """Return the special orbit near ``guess`` with one free parameter, on a mesh that is adequate for it.

    Raises
    ------
    ConvergenceError
        If there is none to be found.
    """
    return solve_adaptively(
        extend_system(inner, defining),
        guess,
        lambda system, x, _: solve_newton(system.at, x, system.scaling.scale, settings),
    )


def find_good_side(at: ExtendedEvaluation, sign: float | None) -> Array:
    """Return the direction in the plane of the two parameters in which the defining function grows by ``sign``.

    That is the side on which the orbit keeps its signature, or is stable. Shape (2,), of length one in units of the
    parameters' ranges; NaN where the sign is not known (None).
    """
    if sign is None:
        return np.full(2, np.nan)
    directions = at.free_directions()
    free = at.orbit.problem.unknowns.free
    ranges = at.system.scaling.scale[free]
    in_plane = directions[:, free] / ranges
    if abs(np.linalg.det(in_plane)) < NO_AREA:
        return np.full(2, np.nan)
    gradient = sign * np.linalg.solve(in_plane, at.rates_along(directions))
    length = float(np.linalg.norm(gradient))
    return np.asarray(gradient / length * ranges) if length > 0.0 else np.full(2, np.nan)
