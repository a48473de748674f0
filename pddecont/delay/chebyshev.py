"""The delay as a pseudospectral delay line on Chebyshev points.

The travelling profile u(t, s) = q(t - s tau), 0 <= s <= 1, obeys u_t = -u_s / tau with u(t, 0) = q(t). On n + 1
Chebyshev points in s the derivative u_s becomes the matrix D, which leaves n ordinary differential equations; the last
is the delayed value. The error falls faster than any power of 1/n for smooth q.

References: Trefethen, Spectral Methods in MATLAB (2000), chapter 6; Breda, Maset, Vermiglio, SIAM J. Sci. Comput. 27
(2005).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints, make_basis
from pddecont.delay.delay_line import LineOnMesh, no_delay, refuse_varying_delay
from pddecont.delay.interface import DelayLine, DelayOperator, FullWeights, LineStages

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chebyshev:
    """Pseudospectral delay line of ``n`` + 1 Chebyshev points for every delay."""

    n: int

    @property
    def tracks_breaking_points(self) -> bool:
        """False: a delay line is smooth, no breaking point comes through it."""
        return False

    @property
    def stages(self) -> LineStages:
        """One line for the whole delay."""
        return LineStages(profile_line(self.n), 1)

    @property
    def simulated_stages(self) -> tuple[int, int]:
        """(0, 0): a simulation reads the past itself."""
        return 0, 0

    def mesh_is_valid(self, mesh: Mesh, theta: Array, lags: Array, varying: Array) -> bool:
        """Return True: a delay line reads what it reads on any mesh."""
        return True

    def operator(self, mesh: Mesh, theta: Array, lag: Array, points: MeshPoints, *, orders: int = 0) -> DelayOperator:
        """Return the operator of the line whose delay is ``lag @ theta``."""
        if lag @ theta == 0.0:
            return no_delay(mesh, theta, lag, points)
        line = LineOnMesh(self.stages.line, mesh, theta, lag, 1, points)

        def theta_derivative(values: Array, which: Sequence[int], order: int) -> Array:
            u = mesh.interpolate_at_nodes(values)
            return np.stack([line.output_at_points(line.derivative(u, component)) for component in which], axis=-1)

        return DelayOperator(FullWeights(line.through_nodes(line.to_points)), theta_derivative)

    def varying_operator(
        self, mesh: Mesh, theta: Array, lags: Array, points: MeshPoints, *, number: int, orders: int = 0
    ) -> DelayOperator:
        """Raise ConvergenceError: a delay line passes everything on after one and the same time."""
        return refuse_varying_delay()


def profile_line(n: int) -> DelayLine:
    """Return the delay line of n + 1 Chebyshev points on [0, 1]; the states are the profile at points 1 .. n."""
    differentiate = make_basis(n).differentiate
    return DelayLine(np.ones(n), -differentiate[1:, 1:], -differentiate[1:, 0], n - 1)
