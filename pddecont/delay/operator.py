"""The interface between the boundary-value problem and a way to discretise the delay.

A delay is a linear operator that takes an orbit's base-point values to delayed values at any places of its mesh, with its
derivatives in theta = (T_1..T_S, tau_1..tau_K).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.mesh import Mesh, Places

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LocalWeights:
    """A sparse operator that reads each delayed value from one mesh interval.

    ``columns`` (n_places, degree + 1) are base points, ``weights`` of the same shape their weights. The read lies at ``sigma`` of
    mesh ``interval``, ``wraps`` periods back; all of shape (n_places,).
    """

    columns: NDArray[np.intp]
    weights: Array
    interval: NDArray[np.intp]
    sigma: Array
    wraps: NDArray[np.intp]

    def apply(self, values: Array) -> Array:
        """Return the delayed values of base ``values`` (n_base, n_quantities), shape (n_places, n_quantities)."""
        return np.matmul(self.weights[:, None], values[self.columns])[:, 0]

    def reads_as(self, other: LocalWeights) -> bool:
        """Whether every place reads the same base points, as many periods back, as with ``other``."""
        same = self.columns is other.columns or np.array_equal(self.columns, other.columns)
        return same and (self.wraps is other.wraps or np.array_equal(self.wraps, other.wraps))


@dataclass(frozen=True, eq=False)
class FullWeights:
    """A dense operator, ``weights`` of shape (n_places, n_base)."""

    weights: Array

    def apply(self, values: Array) -> Array:
        """Return the delayed values of base ``values`` (n_base, n_quantities), shape (n_places, n_quantities)."""
        return self.weights @ values

    @property
    def amplification(self) -> float:
        """By how much the operator can magnify an error in the base values."""
        return float(np.max(np.sum(np.abs(self.weights), axis=1), initial=0.0))


@dataclass(frozen=True, eq=False)
class DelayOperator:
    """One delay on one mesh.

    ``theta_derivative(values, which)`` returns the derivatives of ``weights.apply(values)`` in the components ``which``
    of theta, shape (n_places, n_quantities, len(which)).
    """

    weights: LocalWeights | FullWeights
    theta_derivative: Callable[[Array, Sequence[int]], Array]


class DelayMethod(Protocol):
    """A way to discretise the delay."""

    def operator(self, mesh: Mesh, theta: Array, tau_index: int, places: Places) -> DelayOperator:
        """Return the operator of the delay ``theta[tau_index]`` on ``mesh`` for reads at ``places``."""
        ...
