"""What continuation asks of a system of equations; everything here is about numbers, and knows no model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix
from pddecont.continuation.scaling import Scaling
from pddecont.continuation.time_order import TimeOrder

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


class Evaluation(Protocol):
    """The equations at one point: what is worked out for the residual serves the Jacobian too."""

    @property
    def x(self) -> Array:
        """The unknowns, shape (n_unknowns,)."""
        ...

    @property
    def residual(self) -> Array:
        """The residuals, shape (n_equations,).

        Raises
        ------
        ConvergenceError
            If they have no finite values here.
        """
        ...

    def jacobian(self) -> Matrix:
        """Return the residuals' derivatives, shape (n_equations, n_unknowns).

        Raises
        ------
        ConvergenceError
            If they have no finite values here.
        """
        ...

    @property
    def time_order(self) -> TimeOrder | None:
        """In which order of time the Jacobian is eliminated, once rows below it make it square; None if in none."""
        ...


E = TypeVar("E", bound=Evaluation)
E_co = TypeVar("E_co", bound=Evaluation, covariant=True)


class System(Protocol[E_co]):
    """Equations whose solutions are points (as many equations as unknowns) or curves (one less)."""

    @property
    def scaling(self) -> Scaling:
        """Sizes and weights of the unknowns."""
        ...

    def at(self, x: Array) -> E_co:
        """Return the equations at the unknowns ``x``."""
        ...


class AdaptiveSystem(System[E], Protocol[E]):
    """A system discretised on a mesh that may have to change along a branch.

    Some of its unknowns, at :attr:`mesh_independent_index`, are there on every mesh in the same order; along them
    points on different meshes are compared. A system without a mesh is made one by :class:`FixedUnknowns`.
    """

    @property
    def mesh_independent_index(self) -> Ints:
        """Places of the unknowns that no mesh changes."""
        ...

    @property
    def order_independent_index(self) -> Ints:
        """Places of those among them that have no corner where the mesh changes its order."""
        ...

    def mesh_is_valid(self, at: E) -> bool:
        """Return whether the equations on this mesh make sense at a point."""
        ...

    def mesh_is_adequate(self, at: E) -> bool:
        """Return whether the mesh is valid at a solution and fine enough."""
        ...

    def remesh(self, at: E, others: Sequence[Array], *, solved: bool) -> tuple[Self, Array, list[Array]]:
        """Return the system on a mesh made for a point, with the point and ``others`` in its unknowns.

        The point is a solution or a guess.
        """
        ...

    def interpolate_from(self, other: Self, x: Array) -> Array:
        """Return the unknowns ``x`` of the same system on another mesh in this one's."""
        ...

    def explain_unsettled_mesh(self) -> str:
        """Return what it means if no mesh is adequate for the solution found on it."""
        ...

    def update_reference(self, at: E, error: float | None = None) -> Self:
        """Return the system with what it keeps of a solution (its phase, where its mesh is fine) taken from another.

        ``error`` is that solution's estimated error, where it is known.
        """
        ...


class FixedUnknowns(Generic[E]):
    """A system without a mesh, for those who follow systems that may have one."""

    def __init__(self, system: System[E]):
        self.system = system

    @property
    def scaling(self) -> Scaling:
        """Sizes and weights of the unknowns."""
        return self.system.scaling

    def at(self, x: Array) -> E:
        """Return the equations at the unknowns ``x``."""
        return self.system.at(x)

    @property
    def mesh_independent_index(self) -> Ints:
        """Places of all unknowns."""
        return np.arange(len(self.scaling.scale))

    @property
    def order_independent_index(self) -> Ints:
        """Places of all unknowns."""
        return self.mesh_independent_index

    def mesh_is_valid(self, at: E) -> bool:
        """Return True."""
        return True

    def mesh_is_adequate(self, at: E) -> bool:
        """Return True."""
        return True

    def remesh(self, at: E, others: Sequence[Array], *, solved: bool) -> tuple[Self, Array, list[Array]]:
        """Return all as it is."""
        return self, at.x, list(others)

    def interpolate_from(self, other: Self, x: Array) -> Array:
        """Return the unknowns as they are."""
        return x

    def explain_unsettled_mesh(self) -> str:
        """Return nothing: there is no mesh."""
        return ""

    def update_reference(self, at: E, error: float | None = None) -> Self:
        """Return the same system."""
        return self
