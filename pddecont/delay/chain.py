"""The delay as a chain of Taylor steps (the paper's section 2.2), eliminated from the orbit's unknowns.

Stage i of the chain obeys sum_{k=0}^{M} u_i^(k) delta^k / k! = u_{i-1} with delta = tau / n, u_0 the delayed quantity and
u_n in place of its delayed value (eq. (2.4); M = 1 is eq. (2.6), M = 2 is eq. (2.7)). Every stage is the same linear
operator: with collocation on the orbit's own mesh u_i = P u_{i-1} at the collocation points, one matrix P, so
u_n = P^n u_0 costs log2(n) products, whatever n is. The orbit that results is the one that explicit chain states give,
to rounding.

With scaled stage variables w_k = delta^k u^(k) a stage is the delay line

    w_k' = w_{k+1} / delta,  k = 0 .. M-2;        w_{M-1}' / M! = (q - sum_{k<M} w_k / k!) / delta
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.line import Line, LineOnMesh, no_delay
from pddecont.delay.operator import DelayOperator, FullWeights
from pddecont.orbit.mesh import Mesh, Places

Array = NDArray[np.float64]
MAX_BLOCK = 64


@dataclass(frozen=True)
class Chain:
    """Chain of ``n`` Taylor steps of order ``order`` for every delay."""

    order: int
    n: int

    def operator(self, mesh: Mesh, theta: Array, tau_index: int, places: Places) -> DelayOperator:
        """Return the chain's operator of the delay ``theta[tau_index]`` for reads at ``places``."""
        if theta[tau_index] == 0.0:
            return no_delay(mesh, theta, tau_index, places)
        stage = LineOnMesh(taylor_step(self.order), mesh, theta, tau_index, self.n, places)
        before = np.linalg.matrix_power(stage.to_nodes, self.n - 1)
        weights = stage.through_nodes(stage.to_places @ before)

        def theta_derivative(values: Array, which: Sequence[int]) -> Array:
            u = mesh.at_nodes(values)
            slope = stage.derivative(which)
            tail = stage.to_places @ _power_derivative(stage.to_nodes, slope.to_nodes, u, self.n - 1)
            return np.moveaxis(slope.to_places @ (before @ u) + tail, 0, -1)

        return DelayOperator(FullWeights(weights), theta_derivative)


def taylor_step(order: int) -> Line:
    """Return one stage of the chain as a delay line in the states w_0 .. w_{M-1}."""
    mass = np.ones(order)
    mass[-1] = 1.0 / math.factorial(order)
    A = np.diag(np.ones(order - 1), 1)
    A[-1] -= [1.0 / math.factorial(k) for k in range(order)]
    B = np.zeros(order)
    B[-1] = 1.0
    return Line(mass, A, B, 0)


def _power_derivative(matrix: Array, slopes: Array, vectors: Array, n: int) -> Array:
    """Return d(P^n) v = sum_j P^(n-1-j) dP P^j v for each dP in ``slopes``, shape (n_slopes, size, n_vectors).

    Blocks of at most MAX_BLOCK stages: the vectors P^j v of a block are made by doubling, each is hit by dP, and the sum is
    folded by halving, so that all the work is in matrix products and the memory does not grow with n.
    """
    powers = [matrix]
    while 2 ** len(powers) <= min(n, MAX_BLOCK):
        powers.append(powers[-1] @ powers[-1])
    total = np.zeros((len(slopes), *vectors.shape))
    v = vectors
    remaining = n
    while remaining:
        level = min(remaining.bit_length(), len(powers)) - 1
        block = v[:, None]
        for k in range(level):
            block = np.concatenate([block, np.tensordot(powers[k], block, 1)], axis=1)
        hit = np.tensordot(slopes, block, 1)
        for k in range(level):
            hit = np.einsum("ab,sbjq->sajq", powers[k], hit[:, :, 0::2], optimize=True) + hit[:, :, 1::2]
        total = powers[level] @ total + hit[:, :, 0]
        v = powers[level] @ v
        remaining -= 2**level
    return total
