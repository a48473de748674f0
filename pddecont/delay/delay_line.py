"""Delay lines on a mesh: linear equations between a quantity and its delayed value, eliminated from the unknowns.

Every line is  mass_k y_k' = (A y + B q)_k / delta  with input q and output y_out. On an interval of length h, with rho
= h/delta and D, L the slope and value matrices of the reference basis, collocation reads

    mass_k D y_k = rho (L (A y)_k + B_k q)

so a line on a mesh is a function of rho alone. Its states are continuous through every event and reset.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints
from pddecont.delay.interface import DelayLine, DelayOperator, LocalWeights
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]


class LineOnMesh:
    """A line collocated on a mesh: matrices from input at the collocation points to output, and their derivatives.

    Each interval is condensed to its first base point: all its base values are A_j y_j + B_j r_j for the line's states
    y_j at its left edge and any right-hand side r_j; the left edges then obey a system over the intervals, ``periodic``
    or one that starts from given states.
    """

    def __init__(
        self,
        line: DelayLine,
        mesh: Mesh,
        theta: Array,
        lag: Array,
        n_stages: int,
        points: MeshPoints,
        *,
        periodic: bool = True,
    ):
        self.periodic = periodic
        self.line, self.mesh, self.theta, self.lag, self.points = line, mesh, theta, lag, points
        size, n = len(line.mass), mesh.n_intervals
        self.size = size
        self.tau = float(lag @ theta)
        self.rho = (mesh.length @ theta) * n_stages / self.tau
        blocks = _blocks(line, mesh, self.rho)
        self.from_rhs = np.linalg.inv(blocks[:, :, size:])
        self.from_start = -self.from_rhs @ blocks[:, :, :size]
        # Left edges: y_{j+1} - a_j y_j = b_j, round the period. Solved as one system: forward recursion would let
        # growing solutions (a chain of order 5 or more has them) drown the answer.
        ring = np.eye(n * size).reshape(n, size, n, size)
        here = np.arange(n if periodic else n - 1)
        ring[(here + 1) % n, :, here, :] -= self.from_start[here, -size:]
        self.ring = np.linalg.inv(ring.reshape(n * size, n * size))
        inputs = np.zeros((n, mesh.degree, size, n, mesh.degree))
        nodes = np.arange(mesh.degree)
        for j in range(n):
            inputs[j, nodes, :, j, nodes] = self.rho[j] * line.B
        self.response = self.solve(inputs.reshape(n, mesh.degree * size, -1))
        self.to_nodes = self.output_at_nodes(self.response)
        self.to_points = self.output_at_points(self.response)

    def solve(self, rhs: Array, start: Array | None = None) -> Array:
        """Return the line's states for right-hand sides (n_intervals, degree * size, columns).

        The result has shape (n_intervals, degree + 1, size, columns): base points, states. A line that is not periodic
        starts at ``start`` (size, columns), or at zero.
        """
        mesh, size = self.mesh, self.size
        particular = self.from_rhs @ rhs
        jump = np.roll(particular[:, -size:], 1, axis=0)
        if not self.periodic:
            jump[0] = 0.0 if start is None else start
        starts = (self.ring @ jump.reshape(-1, rhs.shape[-1])).reshape(jump.shape)
        result = np.empty((mesh.n_intervals, mesh.degree + 1, size, rhs.shape[-1]))
        result[:, 0] = starts
        result[:, 1:] = (self.from_start @ starts + particular).reshape(mesh.n_intervals, mesh.degree, size, -1)
        return result

    def output_at_nodes(self, states: Array) -> Array:
        """Return the output at the collocation points, shape (n_collocation, columns)."""
        nodes = self.mesh.basis.values @ states[:, :, self.line.out]
        return nodes.reshape(-1, nodes.shape[-1])

    def output_at_points(self, states: Array) -> Array:
        """Return the output at the points where it is wanted, shape (n_points, columns)."""
        if self.points is self.mesh.equation_points:
            ends = states[self.mesh.last_interval, -1, self.line.out]
            return np.concatenate([self.output_at_nodes(states), ends])
        local = self.mesh.local_weights(self.points)
        result: Array = np.matmul(local[:, None], states[self.points.interval, :, self.line.out])[:, 0]
        return result

    def derivative(self, inputs: Array, component: int) -> Array:
        """Return how the line's states move with a component of theta, for inputs (n_collocation, columns) that stay.

        Differentiating the collocated line in rho leaves the same operator with mass_k D y_k / rho on the right. The
        result has shape (n_intervals, degree + 1, size, columns).
        """
        return self.solve(self.slope_terms(self.response @ inputs, self.log_rho_derivative(component)))

    def derivative_factors(self, component: int) -> tuple[Array, Array]:
        """Return U (n_collocation, r) and F (r, n_collocation) with d(output at the nodes) / d(component) = U F.

        r counts the equations in the mesh intervals whose length the component moves.
        """
        relative = self.log_rho_derivative(component)
        moving = np.flatnonzero(relative)
        F = self.slope_terms(self.response[moving], relative[moving])
        rank = F.shape[0] * F.shape[1]
        unit = np.zeros((self.mesh.n_intervals, F.shape[1], rank))
        unit[moving] = np.eye(rank).reshape(len(moving), F.shape[1], rank)
        return self.output_at_nodes(self.solve(unit)), F.reshape(rank, -1)

    def log_rho_derivative(self, component: int) -> Array:
        """Return d(log rho) / d(component) of each interval."""
        relative = self.mesh.length[:, component] / (self.mesh.length @ self.theta)
        result: Array = relative - self.lag[component] / self.tau
        return result

    def slope_terms(self, states: Array, relative: Array) -> Array:
        """Return relative * mass_k D y_k for states (intervals, degree + 1, size, columns).

        The result has shape (intervals, degree * size, columns).
        """
        slopes = np.tensordot(states, self.mesh.basis.slopes, (1, 1))  # (interval, state, column, node)
        slopes *= self.line.mass[:, None, None] * relative[:, None, None, None]
        return slopes.transpose(0, 3, 1, 2).reshape(len(states), self.mesh.degree * self.size, -1)

    def through_nodes(self, weights: Array) -> Array:
        """Return weights on collocation-point values as weights on base-point values, shape (n_points, n_base)."""
        mesh = self.mesh
        local = weights.reshape(len(weights), mesh.n_intervals, mesh.degree) @ mesh.basis.values
        result = np.zeros((len(weights), mesh.n_base))
        result[:, mesh.base_index[:, :-1]] = local[:, :, :-1]
        result[:, mesh.base_index[:, -1]] += local[:, :, -1]
        return result


def _blocks(line: DelayLine, mesh: Mesh, rho: Array) -> Array:
    """Return each interval's equations, shape (n_intervals, degree * n, (degree + 1) * n).

    Rows and columns run over points first.
    """
    size, degree = len(line.mass), mesh.degree
    fixed = np.einsum("ib,k,kl->ikbl", mesh.basis.slopes, line.mass, np.eye(size))
    growing = np.einsum("ib,kl->ikbl", mesh.basis.values, line.A)
    shape = (degree * size, (degree + 1) * size)
    result: Array = fixed.reshape(shape) - rho[:, None, None] * growing.reshape(shape)
    return result


def no_delay(mesh: Mesh, theta: Array, lag: Array, points: MeshPoints) -> DelayOperator:
    """Return the operator of a delay that is zero: the present value; its derivative in tau is minus the slope."""
    local = mesh.local_weights(points)
    lengths = (mesh.length @ theta)[points.interval]
    columns = mesh.base_index[points.interval]

    def theta_derivative(values: Array, which: Sequence[int], order: int) -> Array:
        slope = np.einsum("pb,pbq->pq", local @ mesh.basis.differentiate, values[columns]) / lengths[:, None]
        return np.stack([-slope * lag[component] for component in which], axis=-1)

    wraps = np.zeros(len(points), dtype=np.intp)
    return DelayOperator(LocalWeights(columns, local, points.interval, points.sigma, wraps), theta_derivative)


def refuse_varying_delay() -> NoReturn:
    """Raise ConvergenceError: a delay line passes everything on after one and the same time."""
    raise ConvergenceError("a delay that varies is no delay line; leave 'delay: {method}' out, or write 'direct'")
