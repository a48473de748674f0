"""The delay as a chain of Taylor steps (the paper's section 2.2), eliminated from the orbit's unknowns.

Stage i of the chain obeys sum_{k=0}^{M} u_i^(k) delta^k / k! = u_{i-1} with delta = tau / n, u_0 the delayed quantity and
u_n in place of its delayed value (eq. (2.4); M = 1 is eq. (2.6), M = 2 is eq. (2.7)). Every stage is the same linear
operator: with collocation on the orbit's own mesh u_i = P u_{i-1} at the collocation points, one matrix P, so
u_n = P^n u_0 costs log2(n) products, whatever n is. The orbit that results is the one that explicit chain states give,
to rounding.

Scaled stage variables w_k = delta^k u^(k) on an interval of length h, with rho = h / delta and D, L the slope and value
matrices of the reference basis, make all stages functions of rho alone:

    D w_k                         = rho L w_{k+1},                          k = 0 .. M-2
    D w_{M-1} / M!                = rho (q - sum_{k<M} L w_k / k!),         q = u_{i-1} at the nodes

The chain's states are continuous through every event and reset.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.operator import DelayOperator, FullWeights, LocalWeights
from pddecont.orbit.basis import Basis
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
            return _no_delay(mesh, theta, tau_index, places)
        stage = _Stage(mesh, theta, tau_index, self, places)
        before = _power(stage.to_nodes, self.n - 1)
        weights = stage.to_places @ before

        def theta_derivative(values: Array, which: Sequence[int]) -> Array:
            u = mesh.at_nodes(values)
            slope = stage.derivative(which)
            tail = stage.to_places @ _power_derivative(stage.to_nodes, slope.to_nodes, u, self.n - 1)
            return np.moveaxis(slope.to_places @ (before @ u) + tail, 0, -1)

        return DelayOperator(FullWeights(_through_nodes(weights, mesh)), theta_derivative)


@dataclass(frozen=True, eq=False)
class _Slopes:
    """Derivatives of a stage in theta: to_nodes (n, n_collocation, n_collocation), to_places (n, n_places, n_collocation)."""

    to_nodes: Array
    to_places: Array


class _Stage:
    """One stage on the whole mesh: matrices from collocation-point values to sites, and their derivatives.

    Each interval is condensed to its first base point: all its base values W_j = A_j y_j + B_j r_j for the stage variables
    y_j at its left edge and any right-hand side r_j; the left edges then obey a periodic recursion over the intervals.
    """

    def __init__(self, mesh: Mesh, theta: Array, tau_index: int, chain: Chain, places: Places):
        self.mesh, self.theta, self.tau_index, self.chain, self.places = mesh, theta, tau_index, chain, places
        basis, order = mesh.basis, chain.order
        self.rho = (mesh.length @ theta) * chain.n / theta[tau_index]
        self.factorial = np.array([math.factorial(k) for k in range(order)], dtype=float)
        blocks = _blocks(basis, order, self.rho)
        size = order * mesh.degree
        self.from_rhs = np.linalg.inv(blocks[:, :, order:])
        self.from_start = -self.from_rhs @ blocks[:, :, :order]
        self.size = size
        # Left edges: y_{j+1} - a_j y_j = b_j, round the period. Solved as one system: forward recursion would let the growing
        # solutions of an order of 5 or more drown the answer.
        n = mesh.n_intervals
        ring = np.eye(n * order).reshape(n, order, n, order)
        here = np.arange(n)
        ring[(here + 1) % n, :, here, :] -= self.from_start[:, -order:]
        self.ring = np.linalg.inv(ring.reshape(n * order, n * order))
        # The input q enters the last equation of each node only.
        inputs = np.zeros((mesh.n_intervals, size, mesh.n_collocation))
        rows = order * np.arange(mesh.degree) + order - 1
        for j in range(mesh.n_intervals):
            inputs[j, rows, mesh.degree * j + np.arange(mesh.degree)] = self.rho[j]
        self.response = self.solve(inputs)
        self.to_nodes = self.at_nodes(self.response)
        self.to_places = self.at_places(self.response)

    def solve(self, rhs: Array) -> Array:
        """Return the stage variables for right-hand sides (n_intervals, order * degree, columns).

        The result has shape (n_intervals, degree + 1, order, columns): base points, stage variables w_k.
        """
        mesh, order = self.mesh, self.chain.order
        particular = self.from_rhs @ rhs
        jump = np.roll(particular[:, -order:], 1, axis=0)
        starts = (self.ring @ jump.reshape(-1, rhs.shape[-1])).reshape(jump.shape)
        rest = self.from_start @ starts + particular
        result = np.empty((mesh.n_intervals, mesh.degree + 1, order, rhs.shape[-1]))
        result[:, 0] = starts
        result[:, 1:] = rest.reshape(mesh.n_intervals, mesh.degree, order, -1)
        return result

    def at_nodes(self, variables: Array) -> Array:
        """Return w_0 at the collocation points, shape (n_collocation, columns)."""
        nodes = np.einsum("ib,jbc->jic", self.mesh.basis.values, variables[:, :, 0])
        return nodes.reshape(-1, nodes.shape[-1])

    def at_places(self, variables: Array) -> Array:
        """Return w_0 at the places where the delayed value is wanted, shape (n_places, columns)."""
        local = self.mesh.local_weights(self.places)
        return np.matmul(local[:, None], variables[self.places.interval, :, 0])[:, 0]

    def derivative(self, which: Sequence[int]) -> _Slopes:
        """Return the derivatives of ``to_nodes`` and ``to_places`` in components of theta.

        Differentiating the stage's equations in rho leaves the same operator with D w_k / rho on the right.
        """
        mesh, order = self.mesh, self.chain.order
        slopes = np.einsum("ib,jbkc->jikc", mesh.basis.slopes, self.response)
        slopes[:, :, -1] /= math.factorial(order)
        rhs = slopes.reshape(mesh.n_intervals, self.size, -1)
        lengths = mesh.length @ self.theta
        nodes, places = [], []
        for component in which:
            relative = mesh.length[:, component] / lengths
            if component == self.tau_index:
                relative = relative - 1.0 / self.theta[component]
            variables = self.solve(rhs * relative[:, None, None])
            nodes.append(self.at_nodes(variables))
            places.append(self.at_places(variables))
        return _Slopes(np.array(nodes), np.array(places))


def _blocks(basis: Basis, order: int, rho: Array) -> Array:
    """Return each interval's equations, shape (n_intervals, order * degree, order * (degree + 1)).

    Rows run over nodes and, within a node, over the equations for w_0' .. w_{M-1}'; columns over base points and, within
    one, over w_0 .. w_{M-1}:

        [ D  -rho L                    ]
        [      D    -rho L             ]
        [ rho L  rho L/1! ...   D/M!   ]     (last column: plus rho L / (M-1)!)
    """
    degree = basis.degree
    fixed = np.zeros((degree, order, degree + 1, order))
    growing = np.zeros_like(fixed)
    for k in range(order - 1):
        fixed[:, k, :, k] = basis.slopes
        growing[:, k, :, k + 1] = -basis.values
    fixed[:, -1, :, -1] = basis.slopes / math.factorial(order)
    for k in range(order):
        growing[:, -1, :, k] += basis.values / math.factorial(k)
    shape = (order * degree, order * (degree + 1))
    return fixed.reshape(shape) + rho[:, None, None] * growing.reshape(shape)


def _power(matrix: Array, n: int) -> Array:
    return np.linalg.matrix_power(matrix, n)


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


def _through_nodes(weights: Array, mesh: Mesh) -> Array:
    """Return weights on collocation-point values as weights on base-point values, shape (n_sites, n_base)."""
    local = weights.reshape(len(weights), mesh.n_intervals, mesh.degree) @ mesh.basis.values
    result = np.zeros((len(weights), mesh.n_base))
    result[:, mesh.base_index[:, :-1]] = local[:, :, :-1]
    result[:, mesh.base_index[:, -1]] += local[:, :, -1]
    return result


def _no_delay(mesh: Mesh, theta: Array, tau_index: int, places: Places) -> DelayOperator:
    """Return the operator of a delay that is zero: the present value; its derivative in tau is minus the slope."""
    local = mesh.local_weights(places)
    lengths = (mesh.length @ theta)[places.interval]
    columns = mesh.base_index[places.interval]

    def theta_derivative(values: Array, which: Sequence[int]) -> Array:
        slope = np.einsum("pb,pbq->pq", local @ mesh.basis.differentiate, values[columns]) / lengths[:, None]
        return np.stack([-slope * (component == tau_index) for component in which], axis=-1)

    return DelayOperator(LocalWeights(columns, local, np.zeros(len(places), dtype=np.intp)), theta_derivative)
