"""The reference interval [0, 1]: base points, Gauss points, Lagrange polynomials."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pddecont.native import compiled_assembly

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# The highest degree that is offered: files from somebody else may claim any.
MAX_DEGREE = 20


@dataclass(frozen=True, eq=False)
class Basis:
    """Lagrange basis of one degree on [0, 1].

    ``base`` holds the m + 1 base points (Chebyshev extrema), ``nodes`` and ``weights`` the m Gauss-Legendre points and
    quadrature weights; ``values`` and ``slopes``, shape (m, m + 1), take base values to values and slopes at the nodes;
    ``differentiate``, shape (m + 1, m + 1), takes base values to slopes at the base points.

    References: Ascher, Mattheij, Russell (1995), section 5.3; Berrut, Trefethen, SIAM Review 46 (2004), eq. (4.2).
    """

    degree: int
    base: Array
    barycentric: Array
    nodes: Array
    weights: Array
    values: Array
    slopes: Array
    differentiate: Array

    def lagrange(self, sigma: Array) -> Array:
        """Return the basis polynomials at ``sigma`` (any shape), the polynomials on a new last axis of length m + 1."""
        return _lagrange(sigma, self.base, self.barycentric)


@cache
def make_basis(degree: int) -> Basis:
    """Return the basis of polynomials of ``degree`` >= 1."""
    base = 0.5 - 0.5 * np.cos(np.pi * np.arange(degree + 1) / degree)
    barycentric = np.array([(-1.0) ** i for i in range(degree + 1)])
    barycentric[[0, -1]] *= 0.5
    difference = base[:, None] - base
    np.fill_diagonal(difference, 1.0)
    differentiate = barycentric / barycentric[:, None] / difference
    np.fill_diagonal(differentiate, 0.0)
    np.fill_diagonal(differentiate, -differentiate.sum(axis=1))
    nodes, weights = np.polynomial.legendre.leggauss(degree)
    nodes, weights = np.asarray(0.5 + 0.5 * nodes, dtype=np.float64), np.asarray(0.5 * weights, dtype=np.float64)
    values = _lagrange(nodes, base, barycentric)
    return Basis(degree, base, barycentric, nodes, weights, values, values @ differentiate, differentiate)


def weigh(weights: Array, columns: Ints, values: Array) -> Array:
    """Return the sums of base ``values`` (n_base, n) in ``columns`` (n_points, degree + 1) times ``weights``.

    The result has shape (n_points, n).
    """
    if values.dtype != np.float64:
        return np.asarray(np.matmul(weights[:, None], values[columns])[:, 0])
    n_points, m = columns.shape
    result = np.empty((n_points, values.shape[1]))
    w, c, v = np.ascontiguousarray(weights), np.ascontiguousarray(columns), np.ascontiguousarray(values)
    compiled_assembly.weigh_values(w, c, n_points, m, v, v.shape[1], result)
    return result


def _lagrange(sigma: Array, base: Array, barycentric: Array) -> Array:
    places = np.asarray(sigma, dtype=np.float64, order="C")
    weights = np.empty((*places.shape, len(base)))
    compiled_assembly.evaluate_lagrange(places, places.size, base, barycentric, len(base), weights)
    return weights
