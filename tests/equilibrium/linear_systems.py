"""Linear delay systems with an independent count of their unstable roots."""

import numpy as np
import scipy.linalg

from pddecont.delay import Direct
from pddecont.equilibrium import CharacteristicMatrix


def make_matrix(present, delayed, delays, method=None):
    """Return the characteristic matrix of x' = present x + sum delayed_k x(t - delays_k)."""
    parts = tuple(np.atleast_2d(np.asarray(m, dtype=float)) for m in delayed)
    return CharacteristicMatrix(
        np.atleast_2d(np.asarray(present, dtype=float)), parts, np.asarray(delays, dtype=float), method or Direct()
    )


def draw(seed):
    """Return a random system: one to three states, one to three delays, from short to long."""
    rng = np.random.default_rng(seed)
    n, k = int(rng.integers(1, 4)), int(rng.integers(1, 4))
    present = rng.normal(size=(n, n)) - rng.uniform(0.0, 2.0) * np.eye(n)
    delayed = [rng.normal(size=(n, n)) * rng.uniform(0.1, 1.5) for _ in range(k)]
    return make_matrix(present, delayed, rng.uniform(0.05, 1.0, size=k) * 10.0 ** rng.uniform(-1.0, 1.0))


def find_multipliers(matrix, steps=20, degree=10):
    """Return the eigenvalues of the map over one longest delay, exp(lambda tau), by collocation in pieces.

    This is the solution operator, discretised on Gauss points of ``steps`` equal pieces: no characteristic equation.
    """
    longest = float(np.max(matrix.delays))
    n, h = matrix.n, longest / steps
    nodes = np.polynomial.legendre.leggauss(degree)[0] * 0.5 + 0.5
    base = np.concatenate([[0.0], nodes])
    # Interpolation from the value at the start and the values at the nodes: values and slopes anywhere in a piece.
    vander = np.vander(base, increasing=True)
    inverse = np.linalg.inv(vander)

    def values_at(s):
        return np.vander(np.atleast_1d(s), degree + 1, increasing=True) @ inverse

    powers = np.arange(degree + 1)
    slopes = (powers * np.where(powers > 0, nodes[:, None] ** np.maximum(powers - 1, 0), 0.0)) @ inverse
    width = degree + 1
    # Unknowns of piece j: its values at base points; the history is the same on pieces -steps .. -1.
    total = 2 * steps * width * n
    left, right = [], []

    def place(piece):
        return (piece + steps) * width * n

    rows = []
    for piece in range(steps):
        start = np.zeros((n, total))
        start[:, place(piece) : place(piece) + n] = np.eye(n)
        before = place(piece - 1)
        end = values_at(1.0)[0]
        for i in range(width):
            start[:, before + i * n : before + (i + 1) * n] -= end[i] * np.eye(n)
        rows.append(start)
        for c in range(degree):
            row = np.zeros((n, total))
            at = place(piece)
            for i in range(width):
                row[:, at + i * n : at + (i + 1) * n] += slopes[c, i] / h * np.eye(n)
            node = at + (c + 1) * n
            row[:, node : node + n] -= matrix.present
            for through, tau in zip(matrix.delayed, matrix.delays, strict=True):
                time = (piece + nodes[c]) * h - tau
                other = int(np.floor(time / h + 1e-12))
                weights = values_at(time / h - other)[0]
                for i in range(width):
                    where = place(other) + i * n
                    row[:, where : where + n] -= weights[i] * through
            rows.append(row)
    whole = np.concatenate(rows)
    half = total // 2
    left, right = whole[:, half:], -whole[:, :half]
    return scipy.linalg.eigvals(np.linalg.solve(left, right))
