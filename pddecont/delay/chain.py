"""The delay as a chain of Taylor steps (the paper's section 2.2), eliminated from the orbit's unknowns.

Stage i of the chain obeys sum_{k=0}^{M} u_i^(k) delta^k / k! = u_{i-1} with delta = tau / n, u_0 the delayed quantity
and u_n in place of its delayed value (eq. (2.4); M = 1 is eq. (2.6), M = 2 is eq. (2.7)). Every stage is the same
linear operator: with collocation on the orbit's own mesh u_i = P u_{i-1} at the collocation points, one matrix P, so
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

from pddecont.collocation import Mesh, MeshPoints
from pddecont.delay.delay_line import LineOnMesh, no_delay, refuse_varying_delay
from pddecont.delay.interface import DelayLine, DelayOperator, FullWeights, LineStages

Array = NDArray[np.float64]
BLOCK_ROWS = 512


@dataclass(frozen=True)
class Chain:
    """Chain of ``n`` Taylor steps of order ``order`` for every delay."""

    order: int
    n: int

    @property
    def tracks_breaking_points(self) -> bool:
        """False: a delay line is smooth, no breaking point comes through it."""
        return False

    @property
    def stages(self) -> LineStages:
        """The Taylor steps."""
        return LineStages(taylor_step(self.order), self.n)

    @property
    def simulated_stages(self) -> tuple[int, int]:
        """Order and number of the Taylor steps, which a simulation integrates."""
        return self.order, self.n

    def mesh_is_valid(self, mesh: Mesh, theta: Array, lags: Array, varying: Array) -> bool:
        """Return True: a delay line reads what it reads on any mesh."""
        return True

    def operator(self, mesh: Mesh, theta: Array, lag: Array, points: MeshPoints, *, orders: int = 0) -> DelayOperator:
        """Return the operator of the chain whose delay is ``lag @ theta``, one component of theta."""
        if lag @ theta == 0.0:
            return no_delay(mesh, theta, lag, points)
        stage = LineOnMesh(self.stages.line, mesh, theta, lag, self.n, points)
        powers = MatrixPowers(stage.to_nodes, self.n)
        if points is mesh.equation_points:
            ends = stage.to_points[mesh.n_collocation :]
            weights = np.concatenate([powers.matrix(self.n), powers.from_left(ends, self.n - 1)])
        else:
            weights = powers.from_left(stage.to_points, self.n - 1)

        def theta_derivative(values: Array, which: Sequence[int], order: int) -> Array:
            slopes = _Slopes(stage, powers, self.n, mesh.interpolate_at_nodes(values)).all()
            return np.stack([slopes[component] for component in which], axis=-1)

        return DelayOperator(FullWeights(stage.through_nodes(weights)), theta_derivative)

    def varying_operator(
        self, mesh: Mesh, theta: Array, lags: Array, points: MeshPoints, *, number: int, orders: int = 0
    ) -> DelayOperator:
        """Raise ConvergenceError: a delay line passes everything on after one and the same time."""
        return refuse_varying_delay()


class MatrixPowers:
    """MatrixPowers P, P^2, P^4, ... of one stage, up to the largest below ``n``, and what is made of them."""

    def __init__(self, matrix: Array, n: int):
        self.squares = [matrix]
        while 2 ** len(self.squares) <= n:
            self.squares.append(self.squares[-1] @ self.squares[-1])

    def matrix(self, n: int) -> Array:
        """Return P^n, n >= 1."""
        bits = [k for k in range(n.bit_length()) if n >> k & 1]
        result = self.squares[bits[0]]
        for k in bits[1:]:
            result = self.squares[k] @ result
        return result

    def from_left(self, rows: Array, n: int) -> Array:
        """Return ``rows`` P^n."""
        for k in range(n.bit_length()):
            if n >> k & 1:
                rows = rows @ self.squares[k]
        return rows

    def on(self, vectors: Array, n: int) -> Array:
        """Return P^n ``vectors``."""
        for k in range(n.bit_length()):
            if n >> k & 1:
                vectors = self.squares[k] @ vectors
        return vectors


class _Slopes:
    """Derivatives of the chain's output in all components of theta that it depends on.

    All stages with different tau on one mesh are functions of one differentiation matrix, so dP/dtau commutes with P.
    Nothing changes when durations and tau grow together, which gives the derivative in the longest duration from the
    others.
    """

    def __init__(self, stage: LineOnMesh, powers: MatrixPowers, n: int, u: Array):
        self.stage, self.powers, self.n, self.u = stage, powers, n, u

    def all(self) -> dict[int, Array]:
        """Return the derivatives (n_points, n_quantities) by component of theta."""
        stage, mesh, theta = self.stage, self.stage.mesh, self.stage.theta
        before = self.powers.on(self.u, self.n - 1)
        tau = int(np.flatnonzero(stage.lag)[0])
        result = {k: np.zeros((len(stage.points), self.u.shape[1])) for k in range(len(theta))}
        last = stage.output_at_points(stage.derivative(before, tau))
        if self.n > 1:
            hit = stage.output_at_nodes(stage.derivative(self.u, tau))
            last = last + (self.n - 1) * (stage.to_points @ self.powers.on(hit, self.n - 2))
        result[tau] = last
        longest = int(np.argmax(theta[: mesh.n_segments]))
        moving = [k for k in range(len(theta)) if k not in (tau, longest) and np.any(mesh.length[:, k])]
        for k in moving:
            tail = stage.to_points @ self.sum_over_stages(k)
            result[k] = stage.output_at_points(stage.derivative(before, k)) + tail
        result[longest] = -sum(theta[k] * result[k] for k in [tau, *moving]) / theta[longest]
        return result

    def sum_over_stages(self, component: int) -> Array:
        """Return sum_j P^(n-2-j) dP P^j u over the n - 1 first stages, shape (n_collocation, n_quantities).

        dP = U F has the small rank of the equations in the component's segment. Blocks of b stages are taken at once:
        the rows F, F P, .., F P^(b-1) and the columns P^(b-1) U, .., U are made by doubling, and a block is two
        products with a vector.
        """
        squares = self.powers.squares
        U, F = self.stage.derivative_factors(component)
        rank = U.shape[1]
        level = max(0, min(len(squares) - 1, (BLOCK_ROWS // rank).bit_length() - 1))
        rows, columns = F, U
        for k in range(level):
            rows = np.concatenate([rows, rows @ squares[k]])
            columns = np.concatenate([squares[k] @ columns, columns], axis=1)
        n_blocks, rest = divmod(self.n - 1, 2**level)
        total, v = np.zeros_like(self.u), self.u
        for _ in range(n_blocks):
            total = squares[level] @ total + columns @ (rows @ v)
            v = squares[level] @ v
        for _ in range(rest):
            total = squares[0] @ total + U @ (F @ v)
            v = squares[0] @ v
        return total


def taylor_step(order: int) -> DelayLine:
    """Return one stage of the chain as a delay line in the states w_0 .. w_{M-1}."""
    mass = np.ones(order)
    mass[-1] = 1.0 / math.factorial(order)
    A = np.diag(np.ones(order - 1), 1)
    A[-1] -= [1.0 / math.factorial(k) for k in range(order)]
    B = np.zeros(order)
    B[-1] = 1.0
    return DelayLine(mass, A, B, 0)
