"""The delay as a pseudospectral delay line on Chebyshev points.

The travelling profile u(t, s) = q(t - s tau), 0 <= s <= 1, obeys u_t = -u_s / tau with u(t, 0) = q(t). On n + 1 Chebyshev
points in s the derivative u_s becomes the matrix D, which leaves n ordinary differential equations; the last is the delayed
value. The error falls faster than any power of 1/n for smooth q.

References: Trefethen, Spectral Methods in MATLAB (2000), chapter 6; Breda, Maset, Vermiglio, SIAM J. Sci. Comput. 27 (2005).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.line import Line, LineOnMesh, no_delay
from pddecont.delay.operator import DelayOperator, FullWeights
from pddecont.orbit.basis import make_basis
from pddecont.orbit.mesh import Mesh, Places

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chebyshev:
    """Pseudospectral delay line of ``n`` + 1 Chebyshev points for every delay."""

    n: int

    def operator(self, mesh: Mesh, theta: Array, tau_index: int, places: Places) -> DelayOperator:
        """Return the line's operator of the delay ``theta[tau_index]`` for reads at ``places``."""
        if theta[tau_index] == 0.0:
            return no_delay(mesh, theta, tau_index, places)
        line = LineOnMesh(profile_line(self.n), mesh, theta, tau_index, 1, places)

        def theta_derivative(values: Array, which: Sequence[int]) -> Array:
            u = mesh.at_nodes(values)
            return np.stack([line.at_places(line.derivative(u, component)) for component in which], axis=-1)

        return DelayOperator(FullWeights(line.through_nodes(line.to_places)), theta_derivative)


def profile_line(n: int) -> Line:
    """Return the delay line of n + 1 Chebyshev points on [0, 1]; the states are the profile at points 1 .. n."""
    differentiate = make_basis(n).differentiate
    return Line(np.ones(n), -differentiate[1:, 1:], -differentiate[1:, 0], n - 1)
