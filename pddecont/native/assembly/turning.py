"""Where a curve turns: zeros of its polynomials' slopes, told apart by halving and refined by Newton's method.

A series whose first coefficient outweighs the rest has no zero; one whose derivative is such a series has one at most,
which a change of sign shows. Parts of an interval of which neither is true are halved.
"""

from __future__ import annotations

from math import isfinite

from pddecont.native.arrays import Floats, Integers, entry
from pddecont.native.assembly.curve import TOGETHER, Curve, evaluate_series, find_slope

# By how much the first coefficient must outweigh the rest, against rounding.
OUTWEIGH = 1.0 + 1e-6
# Coefficients below this part of the interval's are rounding.
ROUNDING = 1e-15
# How often an interval is halved at most: zeros in parts so short are one.
MAX_HALVINGS = 20
# Steps of Newton's method at most, and the step after which a zero is known to rounding.
MAX_STEPS, LAST_STEP = 60, 1e-12


def outweighs(series: Floats, first: int, n: int) -> bool:
    """Return whether a Chebyshev series has no zero in [-1, 1], since its first coefficient outweighs the rest."""
    rest = 0.0
    for k in range(1, n):
        rest += abs(series[first + k])
    found: bool = abs(series[first]) > OUTWEIGH * rest
    return found


def differentiate(series: Floats, first: int, n: int, out: Floats) -> None:
    """Write the coefficients of the derivative of a Chebyshev series, ``out`` (n,), the last of them zero."""
    out[n - 1] = 0.0
    for k in range(n - 1, 0, -1):
        out[k - 1] = 2.0 * k * series[first + k] + (out[k + 1] if k + 1 < n else 0.0)
    out[0] *= 0.5


def halve(parts: Floats, n: int, level: int, halves: Floats, side: int) -> None:
    """Write the series of one half of the part at ``level``, 0 for the left one, to the next level."""
    for i in range(n):
        total = 0.0
        for k in range(i, n):
            total += halves[(side * n + i) * n + k] * parts[level * n + k]
        parts[(level + 1) * n + i] = total


def may_turn_twice(parts: Floats, n: int, level: int, rates: Floats, least: float) -> bool:
    """Return whether the series of a part may have more than one zero; one no larger than ``least`` counts for none."""
    total = 0.0
    for k in range(n):
        total += abs(parts[level * n + k])
    if level == MAX_HALVINGS or total <= least or outweighs(parts, level * n, n):
        return False
    differentiate(parts, level * n, n, rates)
    return not outweighs(rates, 0, n)


def refine_zero(curve: Curve, j: int, rates: Floats, left: float, right: float, falls: bool) -> float:
    """Return the zero of the slope of interval ``j`` between two places in [-1, 1], where it ``falls`` or rises.

    ``rates`` (degree,) are the coefficients of its derivative.
    """
    place = 0.5 * (left + right)
    for _ in range(MAX_STEPS):
        slope = evaluate_series(curve.series, j * curve.degree, curve.degree, place)
        if (slope > 0.0) == falls:
            left = place
        else:
            right = place
        rate = evaluate_series(rates, 0, curve.degree, place)
        following = 0.5 * (left + right)
        if rate != 0.0 and left <= place - slope / rate <= right:
            following = place - slope / rate
        step = following - place
        place = following
        if abs(step) < LAST_STEP:
            break
    return place


def find_zeros(
    curve: Curve,
    j: int,
    halves: Floats,
    parts: Floats,
    rates: Floats,
    n: int,
    room: int,
    sigma: Floats,
    is_max: Integers,
) -> int:
    """Write where the slope of interval ``j`` changes its sign, from place ``n`` on; return the place after them."""
    degree = curve.degree
    first = j * degree
    total = 0.0
    for k in range(degree):
        parts[k] = curve.series[first + k]
        total += abs(parts[k])
    if not isfinite(total):
        return n
    # One part after the other, by its number among those of its level.
    level = 0
    number = 0
    left = -1.0
    width = 2.0
    before = evaluate_series(curve.series, first, degree, left)
    while True:
        if may_turn_twice(parts, degree, level, rates, ROUNDING * total):
            halve(parts, degree, level, halves, 0)
            level += 1
            number *= 2
            width *= 0.5
            continue
        after = evaluate_series(curve.series, first, degree, left + width)
        falls = before > 0.0
        if falls != (after > 0.0) and n < room:
            differentiate(curve.series, first, degree, rates)
            place = refine_zero(curve, j, rates, left, left + width, falls)
            sigma[n] = min(max(0.5 + place * (0.5 + TOGETHER), 0.0), 1.0)
            is_max[n] = 1 if falls else 0
            n += 1
        left += width
        before = after
        number += 1
        while level > 0 and number % 2 == 0:
            level -= 1
            number //= 2
            width *= 2.0
        if level == 0:
            return n
        halve(parts, degree, level - 1, halves, 1)


@entry
def find_turns(
    curve: Curve,
    halves: Floats,
    parts: Floats,
    rates: Floats,
    room: int,
    interval: Integers,
    sigma: Floats,
    is_max: Integers,
) -> int:
    """Write where a curve turns inside intervals, and at edges between those of a segment; return how often it does.

    Turns come in order of time, ``room`` of them at most: their ``interval``, ``sigma`` there, and 1 for a maximum.
    ``halves`` (2, degree, degree) takes Chebyshev series to those of their halves; ``parts`` (MAX_HALVINGS + 1, degree)
    and ``rates`` (degree,) are worked in.
    """
    n_found = 0
    for j in range(curve.n):
        n_before = n_found
        n_found = find_zeros(curve, j, halves, parts, rates, n_found, room, sigma, is_max)
        if (j + 1 < curve.n or curve.closed) and n_found < room:
            following = (j + 1) % curve.n
            slope = find_slope(curve, j, 1.0)
            if curve.segment[following] == curve.segment[j] and slope * find_slope(curve, following, 0.0) <= 0.0:
                sigma[n_found] = 1.0
                is_max[n_found] = 1 if slope > 0.0 else 0
                n_found += 1
        for k in range(n_before, n_found):
            interval[k] = j
    return n_found
