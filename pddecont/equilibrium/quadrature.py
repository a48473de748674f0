"""Integrals over an interval of lags: Gauss points on panels that resolve the integrand.

A panel is halved until the Legendre coefficients of the integrand end at rounding there, and its parts are as many as
an exponential exp(-lambda s) beside it asks for. Kinks and weak singularities are closed in by ever smaller panels.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
# Values (n_functions, n_points) of functions at lags (n_points,).
Kernel: TypeAlias = Callable[[Array], Array]
# Points of a panel: polynomials up to the degree 63 are integrated exactly.
N_POINTS = 32
# Coefficients of an integrand from here on are rounding, on a panel that resolves it.
N_RESOLVED = 20
# The part of the whole integral that rounding makes of a coefficient, and the smallest panel as a part of the interval.
ROUNDING, LEAST = 2e-14, 2.0**-110
# Panels at first, so that a narrow peak is seen, and at most.
FIRST, MOST = 4, 2000
# An exponential exp(z u) over -1 < u < 1 with |z| up to this has no more than rounding beyond the degree 43.
TURN = 10.0


def _make_points() -> tuple[Array, Array, Array]:
    """Return points and weights on -1 .. 1, and what takes values there to the Legendre coefficients of the end."""
    points, weights = np.polynomial.legendre.leggauss(N_POINTS)
    polynomials = np.polynomial.legendre.legvander(points, N_POINTS - 1).T
    to_coefficients = (np.arange(N_POINTS) + 0.5)[:, None] * polynomials * weights
    return points, weights, to_coefficients[N_RESOLVED:]


POINTS, WEIGHTS, TO_TAIL = _make_points()


def find_panels(kernel: Kernel, low: float, high: float) -> Array:
    """Return the edges of panels that resolve a kernel from ``low`` to ``high``, shape (n_panels + 1,).

    Raises
    ------
    ConvergenceError
        If the kernel has no finite value somewhere, or no integral.
    """
    if low == high:
        return np.array([low, high])
    (one,) = _integrate(kernel, np.array([low, high]))
    parts = _integrate(kernel, np.linspace(low, high, FIRST + 1))
    sizes = np.sum([part.size for part in parts], axis=0)
    difference = np.abs(one.integral - np.sum([part.integral for part in parts], axis=0))
    if np.all(one.tail <= ROUNDING * sizes) and np.all(difference <= ROUNDING * sizes):
        return np.array([low, high])
    edges, ahead = [high], list(parts)
    while ahead:
        part = ahead.pop()
        sizes = np.maximum(sizes, part.size)
        if np.all(part.tail <= ROUNDING * sizes):
            edges.append(part.low)
            continue
        if abs(part.high - part.low) < LEAST * abs(high - low) or len(edges) > MOST:
            raise ConvergenceError(f"an integral over the past has no finite value: its integrand at s = {part.low:g}")
        ahead += _integrate(kernel, np.array([part.low, 0.5 * (part.low + part.high), part.high]))
    return np.array(edges[::-1])


class _Part:
    """A panel: the integrals of functions and of their moduli, and what is left out, (n_functions,) each."""

    def __init__(self, kernel: Kernel, low: float, high: float):
        self.low, self.high, half = low, high, 0.5 * (high - low)
        values = kernel(0.5 * (low + high) + half * POINTS)
        if not np.all(np.isfinite(values)):
            raise ConvergenceError(f"the integrand over the past has no finite value for s from {low:g} to {high:g}")
        self.integral, self.size = half * (values @ WEIGHTS), abs(half) * (np.abs(values) @ WEIGHTS)
        self.tail = abs(half) * np.max(np.abs(values @ TO_TAIL.T), axis=1, initial=0.0)


def _integrate(kernel: Kernel, edges: Array) -> list[_Part]:
    return [_Part(kernel, low, high) for low, high in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)]


def make_points(edges: Array, rate: float = 0.0) -> tuple[Array, Array]:
    """Return points and weights (n_points,) on panels, for kernels times exponentials exp(-lambda s), |lambda| <= rate.

    The integral is the sum of weights times values, to rounding.
    """
    widths = np.diff(edges)
    parts = np.maximum(1, np.ceil(0.5 * rate * np.abs(widths) / TURN)).astype(np.intp)
    low = np.concatenate([a + w / k * np.arange(k) for a, w, k in zip(edges[:-1], widths, parts, strict=True)])
    half = 0.5 * np.repeat(widths / parts, parts)
    points = (low + half)[:, None] + half[:, None] * POINTS
    return points.ravel(), (half[:, None] * WEIGHTS).ravel()


def integrate(kernel: Kernel, low: float, high: float) -> Array:
    """Return the integrals of a kernel's functions from ``low`` to ``high``, shape (n_functions,)."""
    points, weights = make_points(find_panels(kernel, low, high))
    return np.asarray(kernel(points) @ weights)
