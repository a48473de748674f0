"""The interface between the boundary-value problem and a way to discretise the delay.

A delay is a linear operator that takes an orbit's base-point values to delayed values at any points of its mesh, with
its derivatives in theta = (T_1..T_S, tau_1..tau_K). How far back a point reads, its lag, is affine in theta as the mesh
is: ``lag @ theta`` with coefficients of shape (n_theta,), one unit vector for a constant delay.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints, weigh
from pddecont.native import compiled_assembly

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class LocalWeights:
    """A sparse operator that reads each delayed value from one mesh interval.

    ``columns`` (n_points, degree + 1) are base points, ``weights`` of the same shape their weights. The read lies at
    ``sigma`` of mesh ``interval``, ``wraps`` periods back; all of shape (n_points,).
    """

    columns: Ints
    weights: Array
    interval: Ints
    sigma: Array
    wraps: Ints

    def differentiate(self, matrix: Array, lengths: Array) -> LocalWeights:
        """Return what reads the time derivative: ``matrix`` is that of slopes, ``lengths`` (n_points,) of intervals."""
        return replace(self, weights=(self.weights @ matrix) / lengths[:, None])

    def apply(self, values: Array) -> Array:
        """Return the delayed values of base ``values`` (n_base, n_quantities), shape (n_points, n_quantities)."""
        return weigh(self.weights, self.columns, values)

    def read(self, values: Array, states: Ints, rows: Ints, out: Array) -> None:
        """Write the delayed values of some of the ``states`` of base ``values`` to ``rows`` of ``out``.

        Shapes: values (n_base, n_states), states and rows (n,), out (n_points, n_rows).
        """
        n_points, m = self.columns.shape
        base_values = np.ascontiguousarray(values)
        compiled_assembly.read_states(
            self.weights,
            self.columns,
            n_points,
            m,
            base_values,
            base_values.shape[1],
            states,
            rows,
            len(states),
            out.shape[1],
            out,
        )

    def reads_as(self, other: LocalWeights) -> bool:
        """Return whether every point reads the same base points, as many periods back, as with ``other``."""
        same = self.columns is other.columns or np.array_equal(self.columns, other.columns)
        return same and (self.wraps is other.wraps or np.array_equal(self.wraps, other.wraps))


@dataclass(frozen=True, eq=False)
class FullWeights:
    """A dense operator, ``weights`` of shape (n_points, n_base)."""

    weights: Array

    def apply(self, values: Array) -> Array:
        """Return the delayed values of base ``values`` (n_base, n_quantities), shape (n_points, n_quantities)."""
        return self.weights @ values

    def read(self, values: Array, states: Ints, rows: Ints, out: Array) -> None:
        """Write delayed values as :meth:`LocalWeights.read` does."""
        out[:, rows] = self.apply(values[:, states])

    @property
    def amplification(self) -> float:
        """By how much the operator can magnify an error in the base values."""
        return float(np.max(np.sum(np.abs(self.weights), axis=1), initial=0.0))


@dataclass(frozen=True, eq=False)
class DelayOperator:
    """One delay on one mesh.

    ``rates`` read the first and second derivatives in time, where they are read. ``theta_derivative(values, which,
    order)`` returns the derivatives of what reads derivative number ``order`` of ``values`` in the components ``which``
    of theta, shape (n_points, n_quantities, len(which)).
    """

    weights: LocalWeights | FullWeights
    theta_derivative: Callable[[Array, Sequence[int], int], Array]
    rates: tuple[LocalWeights, ...] = ()

    def reads_as(self, other: DelayOperator) -> bool:
        """Return whether delayed values are read from the same unknowns as with ``other``."""
        a, b = self.weights, other.weights
        if isinstance(b, FullWeights):
            return isinstance(a, FullWeights)
        return isinstance(a, LocalWeights) and a.reads_as(b)

    def weights_of(self, order: int) -> LocalWeights | FullWeights:
        """Return what reads a derivative in time; 0: the value."""
        return self.rates[order - 1] if order else self.weights


@dataclass(frozen=True, eq=False)
class DelayLine:
    """Coefficients of a delay line with n states, mass_k y_k' = (A y + B q)_k / delta: mass (n,), A (n, n), B (n,).

    ``out`` is the state that is its output.
    """

    mass: Array
    A: Array
    B: Array
    out: int


@dataclass(frozen=True, eq=False)
class LineStages:
    """A delay as ``n`` equal delay lines one after another, each for a part delta = tau / n of it."""

    line: DelayLine
    n: int


class DelayMethod(Protocol):
    """A way to discretise the delay."""

    @property
    def tracks_breaking_points(self) -> bool:
        """Whether meshes follow the breaking points that events send through the delays."""
        ...

    @property
    def stages(self) -> LineStages | None:
        """The delay lines that hold the history; None where delayed values are values of the orbit itself."""
        ...

    @property
    def simulated_stages(self) -> tuple[int, int]:
        """Order and number of the stages that a simulation integrates; (0, 0) where it reads the past itself."""
        ...

    def mesh_is_valid(self, mesh: Mesh, theta: Array, lags: Array, varying: Array) -> bool:
        """Return whether equations on ``mesh`` still read at ``theta`` what they read where the mesh was made.

        ``lags`` (n_delays, n_theta) are the constant delays; ``varying`` (n_varying, n_equation_points) the values of
        those that vary.
        """
        ...

    def operator(self, mesh: Mesh, theta: Array, lag: Array, points: MeshPoints, *, orders: int = 0) -> DelayOperator:
        """Return the operator that reads ``lag @ theta`` before ``points``, and as many derivatives there.

        Raises
        ------
        ConvergenceError
            If there is no such operator at ``theta``.
        """
        ...

    def varying_operator(
        self, mesh: Mesh, theta: Array, lags: Array, points: MeshPoints, *, number: int, orders: int = 0
    ) -> DelayOperator:
        """Return the operator that reads ``lags`` (n_points,) before ``points``, of varying delay ``number``.

        Raises
        ------
        ConvergenceError
            If there is no such operator at ``theta``.
        """
        ...
