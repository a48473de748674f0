"""Points at which an equilibrium has characteristic roots on the imaginary axis: one pair (HB), or two (HH).

With m free parameters an equilibrium x has m pairs +-i omega_j with eigenvectors q_j where

    f(x, ..., x; p) = 0,    Delta(i omega_j; x, p) q_j = 0,    c_j . q_j = 1,    j = 1 .. m

n + m (2 n + 2) real equations for as many unknowns x, q_j, omega_j and p. The vectors c_j are the eigenvectors of the
guess.

Reference: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), section 4.3; Engelborghs,
Luzyanina, Roose, ACM TOMS 28 (2002) for the delay equation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import solve_newton
from pddecont.equilibrium.constant_motion import ConstantMotion

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Length of the steps over which the characteristic matrix is differentiated, in sizes of the unknowns: the error is of
# the order of its square, and only slows Newton's method.
DIFFERENCE = 1e-5


@dataclass(frozen=True, eq=False)
class HopfPoint:
    """An equilibrium ``states`` (n_states,) at ``parameters`` with roots i ``frequencies`` (n_pairs,).

    ``vectors`` (n_pairs, n_states) are their eigenvectors. ``error`` is the largest error left, in sizes of unknowns:
    the Newton step that rounding still asks for (infinite for a guess).
    """

    states: Array
    frequencies: Array
    vectors: Complex
    parameters: Array
    error: float = np.inf


@dataclass(frozen=True, eq=False)
class HopfProblem:
    """What is solved: the equilibrium of a mode, and the places of as many ``free`` parameters as there are pairs.

    ``sizes`` (n_states,) and ``widths`` (n_free,) are the typical sizes of states and free parameters.
    """

    motion: ConstantMotion
    free: Sequence[int]
    sizes: Array
    widths: Array


def solve_hopf(problem: HopfProblem, guess: HopfPoint) -> HopfPoint:
    """Return the point near ``guess``.

    Raises
    ------
    ConvergenceError
        If Newton's method finds none.
    """
    n, m = len(guess.states), len(guess.frequencies)
    assert len(problem.free) == m, "as many parameters as pairs"
    largest = np.max(np.abs(guess.vectors / problem.sizes), axis=1)
    vectors = guess.vectors / largest[:, None]
    weighted = vectors / problem.sizes**2
    normals = np.conj(weighted) / np.sum(weighted * np.conj(vectors), axis=1).real[:, None]
    start = HopfPoint(guess.states, guess.frequencies, vectors, guess.parameters)
    places = _Places(n, m)
    scale = places.join(
        problem.sizes, np.tile(problem.sizes * (1.0 + 1.0j), (m, 1)), np.abs(guess.frequencies), problem.widths
    )
    x = places.join(start.states, start.vectors, start.frequencies, start.parameters[list(problem.free)])
    solution = solve_newton(lambda y: _Equations(problem, places, normals, guess.parameters, y), x, scale)
    left = float(np.max(np.abs(solution.solve(-solution.at.residual) / scale)))
    return replace(solution.at.point, error=max(left, float(np.finfo(float).eps)))


@dataclass(frozen=True)
class _Places:
    """Places of the unknowns: x, then real and imaginary parts of the q_j, the omega_j, the free parameters."""

    n_states: int
    n_pairs: int

    def join(self, states: Array, vectors: Complex, frequencies: Array, free: Array) -> Array:
        """Return the unknowns in one row."""
        parts = np.stack([vectors.real, vectors.imag], axis=1).ravel()
        return np.concatenate([states, parts, frequencies, free])

    def split(self, x: Array) -> tuple[Array, Complex, Array, Array]:
        """Return states, vectors (n_pairs, n_states), frequencies and free parameters of a row of unknowns."""
        n, m = self.n_states, self.n_pairs
        states, parts, frequencies, free = np.split(x, [n, n + 2 * m * n, n + 2 * m * n + m])
        parts = parts.reshape(m, 2, n)
        return states, parts[:, 0] + 1j * parts[:, 1], frequencies, free


@dataclass(frozen=True, eq=False)
class _Equations:
    """The equations at the unknowns ``x``; ``normals`` (n_pairs, n_states) are the c_j."""

    problem: HopfProblem
    places: _Places
    normals: Complex
    parameters: Array
    x: Array

    @property
    def point(self) -> HopfPoint:
        """What the unknowns stand for."""
        states, vectors, frequencies, free = self.places.split(self.x)
        p = self.parameters.copy()
        p[list(self.problem.free)] = free
        return HopfPoint(states, frequencies, vectors, p)

    @property
    def residual(self) -> Array:
        """F, then for each pair the real and imaginary parts of Delta q and of c . q - 1."""
        point, motion = self.point, self.problem.motion
        matrix, rows = motion.linearise(point.states, point.parameters), [motion.rate(point.states, point.parameters)]
        for omega, q, c in zip(point.frequencies, point.vectors, self.normals, strict=True):
            complex_rows = np.append(matrix.at(1j * omega)[0] @ q, c @ q - 1.0)
            rows += [complex_rows.real, complex_rows.imag]
        return np.concatenate(rows)

    def jacobian(self) -> Array:
        """Return the derivatives: in q and omega exact, in x and p by central differences.

        The block pattern, for two pairs:

                 x   q1  q2  w1 w2  p
            f    #                  #
            q1   #   #       #      #
            q2   #       #      #   #
        """
        n, m = self.places.n_states, self.places.n_pairs
        point = self.point
        matrix = self.problem.motion.linearise(point.states, point.parameters)
        result = np.zeros((len(self.x), len(self.x)))
        for j, (omega, q, c) in enumerate(zip(point.frequencies, point.vectors, self.normals, strict=True)):
            delta, slope = matrix.at(1j * omega)
            row, column = n + j * 2 * (n + 1), n + 2 * j * n
            linear = np.vstack([delta, c])
            result[row : row + n + 1, column : column + n] = linear.real
            result[row : row + n + 1, column + n : column + 2 * n] = -linear.imag
            result[row + n + 1 : row + 2 * (n + 1), column : column + n] = linear.imag
            result[row + n + 1 : row + 2 * (n + 1), column + n : column + 2 * n] = linear.real
            turn = 1j * slope @ q
            result[row : row + n, n + 2 * m * n + j] = turn.real
            result[row + n + 1 : row + 2 * n + 1, n + 2 * m * n + j] = turn.imag
        steps = DIFFERENCE * np.concatenate([self.problem.sizes, self.problem.widths])
        for column, step in zip([*range(n), *range(len(self.x) - m, len(self.x))], steps, strict=True):
            ends = [self._moved(column, sign * step).residual for sign in (-1.0, 1.0)]
            result[:, column] = (ends[1] - ends[0]) / (2.0 * step)
        return result

    @property
    def time_order(self) -> None:
        """None: nothing here happens in time."""

    def _moved(self, column: int, step: float) -> _Equations:
        x = self.x.copy()
        x[column] += step
        return _Equations(self.problem, self.places, self.normals, self.parameters, x)
