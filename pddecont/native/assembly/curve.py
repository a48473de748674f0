"""A function along an orbit as one polynomial a mesh interval, its values and slopes."""

from __future__ import annotations

from typing import NamedTuple

from pddecont.native.arrays import Floats, Integers

# How far beyond its interval's ends, relative to it, a polynomial's slope is looked at; extrema nearer than this are
# one, or lie at a segment's end.
TOGETHER = 1e-6


class Curve(NamedTuple):
    """``n`` polynomials of a ``degree`` in order of time, with ``values`` at the base points (n, degree + 1).

    ``series`` (n, degree) are Chebyshev coefficients of their slopes in sigma, over -TOGETHER to 1 + TOGETHER. An
    interval belongs to a ``segment``, begins at ``start`` and lasts ``h`` (n,). The only segment of a ``closed`` curve
    goes on into itself. ``base`` and ``barycentric`` (degree + 1,) are the base points and their weights.
    """

    n: int
    degree: int
    closed: bool
    segment: Integers
    start: Floats
    h: Floats
    values: Floats
    series: Floats
    base: Floats
    barycentric: Floats


def evaluate_series(series: Floats, first: int, n: int, place: float) -> float:
    """Return the sum of ``n`` Chebyshev polynomials at ``place`` times the coefficients from ``first`` on.

    Reference: Clenshaw, Math. Comp. 9 (1955).
    """
    last = 0.0
    before = 0.0
    for k in range(n - 1, 0, -1):
        here = series[first + k] + 2.0 * place * last - before
        before = last
        last = here
    total: float = series[first] + place * last - before
    return total


def find_slope(curve: Curve, j: int, sigma: float) -> float:
    """Return the slope of interval ``j`` in sigma."""
    return evaluate_series(curve.series, j * curve.degree, curve.degree, (sigma - 0.5) / (0.5 + TOGETHER))


def find_time(curve: Curve, j: int, sigma: float) -> float:
    """Return the time at ``sigma`` of interval ``j``."""
    time: float = curve.start[j] + sigma * curve.h[j]
    return time


def find_value(curve: Curve, j: int, sigma: float) -> float:
    """Return the value at ``sigma`` of interval ``j``: Berrut, Trefethen, SIAM Review 46 (2004), eq. (4.2)."""
    m = curve.degree + 1
    above: float = 0.0
    below: float = 0.0
    for k in range(m):
        gap = sigma - curve.base[k]
        if gap == 0.0:
            above = curve.values[j * m + k]
            below = 1.0
            break
        above += curve.barycentric[k] / gap * curve.values[j * m + k]
        below += curve.barycentric[k] / gap
    return above / below
