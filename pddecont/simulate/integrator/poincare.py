"""Returns of a motion to a section, until it repeats itself: its period, counted in returns."""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.integrator.advance import advance
from pddecont.simulate.integrator.buffers import make_log
from pddecont.simulate.integrator.calls import entry, internal
from pddecont.simulate.integrator.core import make_core
from pddecont.simulate.integrator.history import time_tolerance
from pddecont.simulate.integrator.rhs import evaluate_rhs
from pddecont.simulate.integrator.state import LONGEST, MODE, READY, T
from pddecont.simulate.integrator.status import Status

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


@internal
def advance_to_return(system, values, state, work, log, period, phase, t_end, stop):
    """Integrate to the next return; return a status: REACHED where ``t_end`` comes first, CAPACITY for a larger state.

    Returns are the times at which ``phase`` of the forcing period has passed, or where ``period`` is 0 those to the
    section. ``stop`` (1,) keeps the time that the motion is under way to for the next call; NaN otherwise.
    """
    if math.isnan(stop[0]):
        stop[0] = t_end
        if period > 0.0:
            turn = math.floor(state.clock[T] / period - phase + 1.0 + SAME_PHASE)
            stop[0] = min((turn + phase) * period, np.nextafter(t_end, math.inf))
    t_stop = stop[0]
    state.count[READY] = 0
    status = advance(make_core(system, values, state, log, work), min(t_stop, t_end), STEPS)
    if status == Status.CAPACITY or status == Status.NEW_WAY:
        return status
    stop[0] = math.nan
    return Status.SECTION if status == Status.REACHED and period > 0.0 and t_stop <= t_end else status


@entry
def follow_to_period(system, values, state, work, returns, period, phase, t_end, max_period):
    """Follow a motion until it repeats itself or its time is over; return a status and its period in returns (0: none).

    ``returns`` are filled; CAPACITY asks for a larger state.
    """
    log = make_log(0, 0, 0)
    states, times, segment_counts, distances, running = (
        returns.states,
        returns.times,
        returns.segment_counts,
        returns.distances,
        returns.running,
    )
    capacity = len(times)
    # At a phase of the forcing the states tell motions apart; at a section they may be the same, and slopes differ.
    width = system.n if period > 0.0 else 2 * system.n
    size, noise = np.zeros(2 * system.n), np.zeros(2 * system.n)
    same = max(SAME, SAME_ERRORS * values.rtol)
    while True:
        status = advance_to_return(system, values, state, work, log, period, phase, t_end, returns.stop)
        if status != Status.SECTION:
            break
        number = returns.number[0]
        row = number % capacity
        _record_return(make_core(system, values, state, log, work), states, row)
        times[row] = state.clock[T]
        for k in range(segment_counts.shape[1]):
            segment_counts[row, k] = state.segment_counts[k]
        number += 1
        returns.number[0] = number
        gap = times[row] - times[(row - 1) % capacity] if number > 1 else math.inf
        _measure_sizes(
            states, min(number, capacity, 2 * max_period + 2), number, values.atol, values.rtol, gap, size, noise
        )
        for q in range(1, min(max_period, number - 1, capacity - 1) + 1):
            distances[row, q] = _measure_distance(states, row, (number - 1 - q) % capacity, width, size, noise)
            alike = (
                distances[row, q] <= same
                and _counts_repeat(segment_counts, number, q, capacity)
                and _gaps_repeat(times, number, q, capacity, SAME_GAPS * same)
            )
            running[q] = running[q] + 1 if alike else 0
            # As many times as the period is long, and longer than the longest delay.
            if (
                running[q] >= REPEATS * q
                and times[row] - times[(number - 1 - min(running[q], capacity - 1)) % capacity]
                >= max(values.longest, state.lag_time[LONGEST])
                and _is_smallest_period(distances, number, q, capacity, same)
            ):
                return np.int64(Status.SECTION), q
    q = (
        _find_period(distances, times, segment_counts, returns.number[0], max_period, capacity, same)
        if status == Status.REACHED
        else 0
    )
    return np.int64(status), q


@internal
def _record_return(c, states, row):
    """Write the states and their slopes at a return to a row of ``states``."""
    evaluate_rhs(c, c.count[MODE], c.clock[T], c.y, c.slope)
    for i in range(c.n):
        states[row, i], states[row, c.n + i] = c.y[i], c.slope[i]


@internal
def _measure_sizes(states, kept, number, atol, rtol, gap, size, noise):
    """Write how large states and slopes are over the last returns, and how much of them is noise of the integration."""
    n, capacity = states.shape[1] // 2, len(states)
    size[:] = 0.0
    for back in range(kept):
        row = (number - 1 - back) % capacity
        for i in range(2 * n):
            size[i] = max(size[i], abs(states[row, i]))
    for i in range(n):
        noise[i] = NOISE * atol
        noise[n + i] = NOISE_OF_SLOPES * (atol + rtol * size[i]) / gap if gap > 0.0 else 0.0


@internal
def _measure_distance(states, a, b, width, size, noise):
    """Return how far apart two returns are, relative to the size of the motion and beyond its noise."""
    distance = 0.0
    for i in range(width):
        distance = max(distance, (abs(states[a, i] - states[b, i]) - noise[i]) / (size[i] + 1e-300))
    return distance


@internal
def _counts_repeat(segment_counts, number, q, capacity):
    """Return whether each segment ended as often in the last ``q`` returns as in the ``q`` before them."""
    if number - 1 - 2 * q < 0 or 2 * q >= capacity:
        return number - 1 >= q
    last, middle, first = (number - 1) % capacity, (number - 1 - q) % capacity, (number - 1 - 2 * q) % capacity
    for k in range(segment_counts.shape[1]):
        if segment_counts[last, k] - segment_counts[middle, k] != segment_counts[middle, k] - segment_counts[first, k]:
            return False
    return True


@internal
def _gaps_repeat(times, number, q, capacity, tolerance):
    """Return whether the last ``q`` returns took as long as the ``q`` before them."""
    if number - 1 - 2 * q < 0 or 2 * q >= capacity:
        return number - 1 >= q
    last, middle, first = (
        times[(number - 1) % capacity],
        times[(number - 1 - q) % capacity],
        times[(number - 1 - 2 * q) % capacity],
    )
    return abs(last - 2.0 * middle + first) <= tolerance * (last - middle) + TIME_ROUNDING * time_tolerance(last)


@internal
def _is_smallest_period(distances, number, q, capacity, same):
    """Return whether no divisor of a period is the period that the motion is still settling to.

    What is left to settle is estimated from how fast the distance after ``q`` returns shrinks; the distance after a
    divisor has to be larger. Where multipliers are near a q-th root of 1 the former is small long before the latter is.
    """
    window = REPEATS * q
    now, then = (
        _find_largest_distance(distances, number, q, 0, window, capacity),
        _find_largest_distance(distances, number, q, window, 2 * window, capacity),
    )
    shrinks = (now / then) ** (1.0 / REPEATS) if then > now > 0.0 else SLOW
    left = max(now, same) / (1.0 - min(max(shrinks, SLOW), SLOWEST))
    for divisor in range(1, q):
        if (
            q % divisor == 0
            and _find_largest_distance(distances, number, divisor, 0, window, capacity) <= MARGIN * left
        ):
            return False
    return True


@internal
def _find_largest_distance(distances, number, q, first, last, capacity):
    """Return the largest distance after ``q`` returns, of those ``first`` to ``last`` returns back."""
    largest = 0.0
    for back in range(first, min(last, number - q, capacity)):
        largest = max(largest, distances[(number - 1 - back) % capacity, q])
    return largest


@internal
def _find_period(distances, times, segment_counts, number, max_period, capacity, same):
    """Return the period of the returns that are kept, by a looser measure, as the motion may still settle (0: none)."""
    kept = min(number, capacity)
    for q in range(1, max_period + 1):
        if (
            2 * q + 1 > kept
            or not _counts_repeat(segment_counts, number, q, capacity)
            or not _gaps_repeat(times, number, q, capacity, CLOSE)
        ):
            continue
        worst = 0.0
        for back in range(min(q + 2, kept - q)):
            worst = max(worst, distances[(number - 1 - back) % capacity, q])
        if worst <= CLOSE and _is_smallest_period(distances, number, q, capacity, same):
            return q
    return 0
