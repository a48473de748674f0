"""Which of the turns of a curve are extrema."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Integers, entry
from pddecont.native.assembly.curve import TOGETHER, Curve, find_slope, find_time, find_value

# How far beside a turn its slopes are compared, relative to its interval.
ASIDE = 1e-5


def find_slope_beside(curve: Curve, j: int, sigma: float, away: float) -> float:
    """Return the slope in time ``away`` from a place, if need be in another interval of its segment."""
    at = sigma + away / curve.h[j]
    side = 1 if away > 0.0 else -1
    for _ in range(curve.n):
        other = j + side
        if 0.0 <= at <= 1.0 or (not curve.closed and (other < 0 or other == curve.n)):
            break
        other = (other + curve.n) % curve.n
        if curve.segment[other] != curve.segment[j]:
            break
        if away > 0.0:
            at = (at - 1.0) * curve.h[j] / curve.h[other]
        else:
            at = (curve.h[other] + at * curve.h[j]) / curve.h[other]
        j = other
    slope: float = find_slope(curve, j, at) / curve.h[j]
    return slope


def is_at_end(curve: Curve, j: int, sigma: float) -> bool:
    """Return whether a place lies at an end of its segment, to rounding."""
    time = find_time(curve, j, sigma)
    first = j
    while first > 0 and curve.segment[first - 1] == curve.segment[j]:
        first -= 1
    last = j
    while last + 1 < curve.n and curve.segment[last + 1] == curve.segment[j]:
        last += 1
    near = TOGETHER * curve.h[j]
    found: bool = time - curve.start[first] < near or find_time(curve, last, 1.0) - time < near
    return found


def are_together(curve: Curve, j: int, sigma: float, other_j: int, other_sigma: float, later: float) -> bool:
    """Return whether two places are one, the second of them moved ``later``."""
    apart = find_time(curve, other_j, other_sigma) + later - find_time(curve, j, sigma)
    found: bool = curve.segment[j] == curve.segment[other_j] and abs(apart) < TOGETHER * curve.h[j]
    return found


def drop_ends(curve: Curve, n: int, interval: Integers, sigma: Floats, is_max: Integers) -> int:
    """Leave out the turns at the ends of open segments; return how many are left."""
    n_kept = 0
    for k in range(n):
        if not curve.closed and is_at_end(curve, interval[k], sigma[k]):
            continue
        interval[n_kept] = interval[k]
        sigma[n_kept] = sigma[k]
        is_max[n_kept] = is_max[k]
        n_kept += 1
    return n_kept


@entry
def choose_extrema(
    curve: Curve, n: int, interval: Integers, sigma: Floats, is_max: Integers, value: Floats, chosen: Integers
) -> int:
    """Write which of ``n`` turns are extrema, each once, their ``value`` and what they are; return how many are.

    To rounding an extremum on an edge may show in both intervals, in one or between them: turns that lie together are
    one if the slope has different signs a little before and a little after them, and none if not. Those at the ends of
    open segments are left out. ``value``, ``is_max`` and ``interval`` are those of the turns that are left,
    ``chosen`` says which of these.
    """
    n = drop_ends(curve, n, interval, sigma, is_max)
    for k in range(n):
        value[k] = find_value(curve, interval[k], sigma[k])
    period = 0.0
    for j in range(curve.n):
        period += curve.h[j]
    # Those at the end of a closed curve may lie together with those at its start.
    begin = 0
    if curve.closed and n > 1 and are_together(curve, interval[n - 1], sigma[n - 1], interval[0], sigma[0], period):
        begin = n - 1
        while begin > 0 and are_together(
            curve, interval[begin - 1], sigma[begin - 1], interval[begin], sigma[begin], 0.0
        ):
            begin -= 1
    n_chosen = 0
    first = begin
    while first < begin + n:
        last = first
        shortest = curve.h[interval[first % n]]
        while last + 1 < begin + n:
            i = last % n
            k = (last + 1) % n
            later = period if k == 0 else 0.0
            if not are_together(curve, interval[i], sigma[i], interval[k], sigma[k], later):
                break
            shortest = min(shortest, curve.h[interval[k]])
            last += 1
        i = first % n
        k = last % n
        before = find_slope_beside(curve, interval[i], sigma[i], -ASIDE * shortest)
        after = find_slope_beside(curve, interval[k], sigma[k], ASIDE * shortest)
        if before * after < 0.0:
            best = i
            for c in range(first + 1, last + 1):
                k = c % n
                if (value[k] > value[best]) if before > 0.0 else (value[k] < value[best]):
                    best = k
            is_max[best] = 1 if before > 0.0 else 0
            chosen[n_chosen] = best
            n_chosen += 1
        first = last + 1
    return n_chosen
