"""The other branch of equilibria that crosses at a branch point.

At a simple branch point the null space of (G_y, G_p) has two dimensions; tangents v of branches solve the quadratic
equation w . D2G(v, v) = 0, w the left null vector.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), section 3.2; Allgower, Georg,
Introduction to Numerical Continuation Methods (2003), section 8.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.equilibrium.equations import EquilibriumSystem
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
# Length of the steps over which the equations are differentiated twice, in scaled unknowns.
DIFFERENCE = 1e-4
# Tangents of which one has less than this part across the other are one.
SAME = 1e-6


def find_other_tangent(system: EquilibriumSystem, x: Array, tangent: Array) -> Array:
    """Return the tangent of the branch that crosses at ``x`` that with a ``tangent``, both in unknowns.

    Raises
    ------
    ConvergenceError
        If no other branch crosses there.
    """
    size = system.scaling.size
    jacobian = system.at(x).jacobian()
    dense = (jacobian if isinstance(jacobian, np.ndarray) else jacobian.toarray()) * size
    rows = np.max(np.abs(dense), axis=1)
    left, _, right = np.linalg.svd(dense / np.where(rows > 0.0, rows, 1.0)[:, None])
    weights = left[:, -1] / np.where(rows > 0.0, rows, 1.0)
    one = tangent / size
    null = right[-2:]
    # In the null space: along the branch, and across it.
    along = null.T @ (null @ one)
    along /= np.linalg.norm(along)
    across = null[0] - along * (along @ null[0])
    if np.linalg.norm(across) < 0.5:
        across = null[1] - along * (along @ null[1])
    across /= np.linalg.norm(across)

    def bend(v: Array, w: Array) -> float:
        """Return w . D2G(v, w) by the polarisation of second differences."""

        def second(u: Array) -> float:
            ends = [weights @ system.at(x + sign * DIFFERENCE * size * u).residual for sign in (-1.0, 0.0, 1.0)]
            return float(ends[0] - 2.0 * ends[1] + ends[2]) / DIFFERENCE**2

        return 0.25 * (second(v + w) - second(v - w))

    mixed, square = bend(along, across), bend(across, across)
    # Of a s^2 + 2 b s t + c t^2 = 0 the root t = 0 is the branch itself, a = 0; the other one is 2 b s + c t = 0.
    direction = -square * along + 2.0 * mixed * across
    length = float(np.linalg.norm(direction))
    if not length > 0.0 or abs(direction @ across) < SAME * length:
        raise ConvergenceError("no other branch of equilibria crosses here to the second order")
    return np.asarray(size * direction / length)
