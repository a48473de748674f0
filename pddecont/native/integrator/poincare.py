"""Returns of a motion to a section, until it repeats itself: its period, counted in returns."""

from __future__ import annotations

from math import floor, inf, isnan, nan, nextafter

from pddecont.native.arrays import Floats, entry
from pddecont.native.integrator.advance import run
from pddecont.native.integrator.core import Core, Returns
from pddecont.native.integrator.places import LONGEST, MODE, T
from pddecont.native.integrator.rhs import evaluate_rhs
from pddecont.native.integrator.ring import time_tolerance
from pddecont.native.integrator.status import Status

# A motion has a period when it comes back so closely, relative to its size, or so close in errors allowed in a step,
# this many times running ...
SAME, SAME_ERRORS, REPEATS = 1e-7, 30.0, 3
# ... taking as long each time but for so many times that, and for this rounding of the time in tolerances of it ...
SAME_GAPS, TIME_ROUNDING = 10.0, 8.0
# ... and otherwise if it comes back this closely when its time is over.
CLOSE = 1e-4
# Errors of a step that returns may differ by from noise: of states, and of slopes over the time between returns.
NOISE, NOISE_OF_SLOPES = 10.0, 100.0
# What is left to settle is estimated from how fast distances shrink, at best and at worst by these factors a period:
# at best, because distances beat where multipliers are complex. A divisor's distance has to be this much larger.
SLOW, SLOWEST, MARGIN = 0.95, 0.999, 4.0
# A return at a phase is at that phase whatever rounding made of the time, in parts of the period.
SAME_PHASE = 1e-9
# More steps than any motion makes between two returns.
STEPS = 1 << 40


@entry
def advance_to_return(c: Core, period: float, phase: float, t_end: float, stop: Floats) -> int:
    """Integrate to the next return; return a status: REACHED where ``t_end`` comes first, CAPACITY for a larger state.

    Returns are the times at which ``phase`` of the forcing period has passed, or where ``period`` is 0 those to the
    section. ``stop`` (1,) keeps the time that the motion is under way to for the next call; NaN otherwise.
    """
    if isnan(stop[0]):
        stop[0] = t_end
        if period > 0.0:
            turn = floor(c.clock[T] / period - phase + 1.0 + SAME_PHASE)
            stop[0] = min((turn + phase) * period, nextafter(t_end, inf))
    t_stop = stop[0]
    status = run(c, min(t_stop, t_end), STEPS)
    if status == Status.CAPACITY or status == Status.NEW_WAY:
        return status
    stop[0] = nan
    return Status.SECTION if status == Status.REACHED and period > 0.0 and t_stop <= t_end else status


@entry
def follow_to_period(
    c: Core, r: Returns, period: float, phase: float, t_end: float, max_period: int
) -> tuple[int, int]:
    """Follow a motion until it repeats itself or its time is over; return a status and its period in returns (0: none).

    The returns are filled; CAPACITY asks for a larger state.
    """
    capacity = r.capacity
    same = max(SAME, SAME_ERRORS * c.rtol)
    while True:
        status = advance_to_return(c, period, phase, t_end, r.stop)
        if status != Status.SECTION:
            break
        number = r.number[0]
        row = number % capacity
        _record_return(c, r, row)
        number += 1
        r.number[0] = number
        gap = r.times[row] - r.times[(row + capacity - 1) % capacity] if number > 1 else inf
        _measure_sizes(c, r, min(number, capacity, 2 * max_period + 2), gap)
        for q in range(1, min(max_period, number - 1, capacity - 1) + 1):
            r.distances[row * r.n_distances + q] = _measure_distance(r, row, (number - 1 - q) % capacity)
            alike = (
                r.distances[row * r.n_distances + q] <= same
                and _counts_repeat(r, q)
                and _gaps_repeat(r, q, SAME_GAPS * same)
            )
            r.running[q] = r.running[q] + 1 if alike else 0
            # As many times as the period is long, and longer than the longest delay.
            if r.running[q] < REPEATS * q:
                continue
            since = (number - 1 - min(r.running[q], capacity - 1)) % capacity
            if r.times[row] - r.times[since] >= max(c.longest, c.lag_time[LONGEST]) and _is_smallest_period(r, q, same):
                return Status.SECTION, q
    q = _find_period(r, max_period, same) if status == Status.REACHED else 0
    return status, q


def _record_return(c: Core, r: Returns, row: int) -> None:
    """Write a return, the present, to a row."""
    evaluate_rhs(c, c.count[MODE], c.clock[T], c.y, c.slope)
    for i in range(c.n):
        r.states[row * r.width + i], r.states[row * r.width + c.n + i] = c.y[i], c.slope[i]
    r.times[row] = c.clock[T]
    for k in range(r.n_segments):
        r.segment_counts[row * r.n_segments + k] = c.segment_counts[k]


def _measure_sizes(c: Core, r: Returns, kept: int, gap: float) -> None:
    """Write how large states and slopes are over the last returns, and how much of them is noise of the integration."""
    n = c.n
    for i in range(2 * n):
        r.size[i] = 0.0
    for back in range(kept):
        row = (r.number[0] - 1 - back) % r.capacity
        for i in range(2 * n):
            r.size[i] = max(r.size[i], abs(r.states[row * r.width + i]))
    for i in range(n):
        r.noise[i] = NOISE * c.atol
        r.noise[n + i] = NOISE_OF_SLOPES * (c.atol + c.rtol * r.size[i]) / gap if gap > 0.0 else 0.0


def _measure_distance(r: Returns, a: int, b: int) -> float:
    """Return how far apart two returns are, relative to the size of the motion and beyond its noise."""
    distance = 0.0
    for i in range(r.n_compared):
        apart = abs(r.states[a * r.width + i] - r.states[b * r.width + i]) - r.noise[i]
        distance = max(distance, apart / (r.size[i] + 1e-300))
    return distance


def _counts_repeat(r: Returns, q: int) -> bool:
    """Return whether each segment ended as often in the last ``q`` returns as in the ``q`` before them."""
    number, n = r.number[0], r.n_segments
    if number - 1 - 2 * q < 0 or 2 * q >= r.capacity:
        return number - 1 >= q
    last, middle = ((number - 1) % r.capacity) * n, ((number - 1 - q) % r.capacity) * n
    first = ((number - 1 - 2 * q) % r.capacity) * n
    counts = r.segment_counts
    for k in range(n):
        if counts[last + k] - counts[middle + k] != counts[middle + k] - counts[first + k]:
            return False
    return True


def _gaps_repeat(r: Returns, q: int, tolerance: float) -> bool:
    """Return whether the last ``q`` returns took as long as the ``q`` before them."""
    number, times = r.number[0], r.times
    if number - 1 - 2 * q < 0 or 2 * q >= r.capacity:
        return number - 1 >= q
    last, middle = times[(number - 1) % r.capacity], times[(number - 1 - q) % r.capacity]
    first = times[(number - 1 - 2 * q) % r.capacity]
    return abs(last - 2.0 * middle + first) <= tolerance * (last - middle) + TIME_ROUNDING * time_tolerance(last)


def _is_smallest_period(r: Returns, q: int, same: float) -> bool:
    """Return whether no divisor of a period is the period that the motion is still settling to.

    What is left to settle is estimated from how fast the distance after ``q`` returns shrinks; the distance after a
    divisor has to be larger. Where multipliers are near a q-th root of 1 the former is small long before the latter is.
    """
    window = REPEATS * q
    now, then = _find_largest_distance(r, q, 0, window), _find_largest_distance(r, q, window, 2 * window)
    shrinks = (now / then) ** (1.0 / REPEATS) if then > now > 0.0 else SLOW
    left = max(now, same) / (1.0 - min(max(shrinks, SLOW), SLOWEST))
    for divisor in range(1, q):
        if q % divisor == 0 and _find_largest_distance(r, divisor, 0, window) <= MARGIN * left:
            return False
    return True


def _find_largest_distance(r: Returns, q: int, first: int, last: int) -> float:
    """Return the largest distance after ``q`` returns, of those ``first`` to ``last`` returns back."""
    largest = 0.0
    for back in range(first, min(last, r.number[0] - q, r.capacity)):
        largest = max(largest, r.distances[((r.number[0] - 1 - back) % r.capacity) * r.n_distances + q])
    return largest


def _find_period(r: Returns, max_period: int, same: float) -> int:
    """Return the period of the returns that are kept, by a looser measure, as the motion may still settle (0: none)."""
    number = r.number[0]
    kept = min(number, r.capacity)
    for q in range(1, max_period + 1):
        if 2 * q + 1 > kept or not _counts_repeat(r, q) or not _gaps_repeat(r, q, CLOSE):
            continue
        worst = 0.0
        for back in range(min(q + 2, kept - q)):
            worst = max(worst, r.distances[((number - 1 - back) % r.capacity) * r.n_distances + q])
        if worst <= CLOSE and _is_smallest_period(r, q, same):
            return q
    return 0
