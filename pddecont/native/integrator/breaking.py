"""The times that steps have to end at: breaking points and delayed events under way."""

from __future__ import annotations

from pddecont.native.calls import call
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.history import read_delayed
from pddecont.native.integrator.past_reads import read_for_derivatives
from pddecont.native.integrator.pieces import begin_piece, find_piece
from pddecont.native.integrator.places import LONGEST, MODE, N_BREAKING, N_PENDING, PIECE
from pddecont.native.integrator.ring import time_tolerance

# A jump in a derivative of order 8 or more leaves an error of h^8 once, which is the order of the method itself.
LEVELS = 7
# A jump of a rate that is so small a part of that at an event, in tolerances, changes less than a step's error allows.
SMALLEST_JUMP = 1e-2
# Lags that vary read jumps in any order of the lags, and sequences of many lags have no end. Above so many jumps in
# reach of the lags, with each doubling, they are followed to an order less, and to ten times the size; not below the
# last. Steps that are too long for one that is not followed are rejected as any others.
CROWDED, MOST_LEFT_OUT = 16, 5


def add_breaking_points(c: Core, t: float, level: int) -> None:
    """Note where a jump at ``t`` in a derivative of order ``level`` comes back: one order higher, each delay later."""
    if c.is_general == 1:
        add_jump(c, t, level, 1.0)
        return
    if c.chain_n > 0 or level >= LEVELS:
        return
    for k in range(c.n_delays):
        if c.tau[k] > 0.0:
            _insert(c, t + c.tau[k], level + 1, 1.0)


def _insert(c: Core, t: float, level: int, size: float) -> None:
    """Add a breaking point at its place in the queue.

    One that is there already, to rounding, keeps its time and gets the lower level of the two. Where rates are read
    each level has its own size, as a value and as a rate.
    """
    times, levels, sizes, n = c.breaking_time, c.breaking_level, c.breaking_size, c.count[N_BREAKING]
    i = n
    while i > 0 and times[i - 1] > t:
        i -= 1
    first, last = i - 1, i
    while c.is_general == 1 and first > 0 and abs(times[first - 1] - t) <= time_tolerance(t):
        first -= 1
    for j in range(first, last + 1):
        if 0 <= j < n and abs(times[j] - t) <= time_tolerance(t):
            t = times[j]
            if c.is_general == 0:
                levels[j] = min(levels[j], level)
                return
            if levels[j] == level and sizes[j] * size > 0.0:
                sizes[j] = max(sizes[j], size) if size > 0.0 else min(sizes[j], size)
                return
    for j in range(n, i, -1):
        times[j], levels[j], sizes[j] = times[j - 1], levels[j - 1], sizes[j - 1]
    times[i], levels[i], sizes[i] = t, level, size
    c.count[N_BREAKING] = n + 1


def pass_breaking_points(c: Core, t: float) -> None:
    """Remove the breaking points up to ``t`` and note where their jumps come back."""
    while c.count[N_BREAKING] > 0 and c.breaking_time[0] <= t + time_tolerance(t):
        passed, level, size = c.breaking_time[0], c.breaking_level[0], c.breaking_size[0]
        n = c.count[N_BREAKING] - 1
        for j in range(n):
            c.breaking_time[j], c.breaking_level[j] = c.breaking_time[j + 1], c.breaking_level[j + 1]
            c.breaking_size[j] = c.breaking_size[j + 1]
        c.count[N_BREAKING] = n
        if c.is_general == 0:
            add_breaking_points(c, passed, level)
            continue
        if size < 0.0:
            size *= -measure_rates(c, t)
        if size > SMALLEST_JUMP * c.rtol:
            add_jump(c, passed, level, size)


def drop_breaking_points(c: Core, t: float) -> None:
    """Remove the breaking points up to ``t``, whose jumps are in the past already."""
    kept = 0
    for j in range(c.count[N_BREAKING]):
        if c.breaking_time[j] > t + time_tolerance(t):
            c.breaking_time[kept], c.breaking_level[kept] = c.breaking_time[j], c.breaking_level[j]
            c.breaking_size[kept] = c.breaking_size[j]
            kept += 1
    c.count[N_BREAKING] = kept


def add_jump(c: Core, t: float, level: int, size: float) -> None:
    """Begin a piece at a jump in the derivative of order ``level``, of a ``size``, and note where it comes back."""
    left_out = _count_orders_left_out(c, t)
    if left_out > 0 and (level >= LEVELS - left_out or size <= SMALLEST_JUMP * c.rtol * 10.0**left_out):
        return
    if level < LEVELS:
        begin_piece(c, t, level, size)
    add_returns(c, t, level, size)


def _count_orders_left_out(c: Core, t: float) -> int:
    """Return by how many orders less far jumps are followed for their number within the longest lag before ``t``."""
    reach = max(c.longest, c.lag_time[LONGEST])
    number, left_out = c.lag_count[PIECE] - find_piece(c, t - reach), 0
    while number > CROWDED and left_out < MOST_LEFT_OUT:
        number //= 2
        left_out += 1
    return left_out


def add_returns(c: Core, t: float, level: int, size: float) -> None:
    """Note where a jump comes back by constant lags: one order higher as a value, two as a limit, in its own as a rate.

    A rate that is read is not smoother than the one that it becomes a part of: its jumps come back until the product of
    the factors that they are multiplied with is small. A size below zero says that the factor is still to come.
    """
    for k in range(c.n_delays):
        if c.tau[k] <= 0.0:
            continue
        if level + c.gain[k] <= LEVELS:
            _insert(c, t + c.tau[k], level + c.gain[k], size)
        if _reads_rate(c, k):
            _insert(c, t + c.tau[k], max(level, 1), -size)


def come_back(c: Core, slot: int, t: float, level: int, size: float) -> None:
    """Let a jump in the derivative of order ``level`` come back at ``t`` by the lag of a slot."""
    if _reads_rate(c, slot):
        by_rate = size * measure_rates(c, t)
        if by_rate > SMALLEST_JUMP * c.rtol:
            add_jump(c, t, max(level, 1), max(size, by_rate) if level == 0 else by_rate)
            return
    if level + c.gain[slot] <= LEVELS:
        add_jump(c, t, level + c.gain[slot], size)


def _reads_rate(c: Core, slot: int) -> bool:
    """Return whether a rate that fields depend on is read by the lag of a slot."""
    for i in range(c.n_values):
        if c.is_rate[i] == 1 and c.pair_delay[i] == slot:
            return True
    return False


def measure_rates(c: Core, t: float) -> float:
    """Return how large a part of the rates that are read the rates now are at most: a norm of df/dx'(t - tau)."""
    n, m = c.n, c.n_pairs
    for i in range(n * (n + m)):
        c.jacobian[i] = 0.0
    read_delayed(c, t, c.y, c.xd, 0)
    read_for_derivatives(c, t, c.y, c.xd)
    mode = c.count[MODE]
    call(c.field_jacobian[mode], c.field_case[mode], t, c.y, c.xd, c.p, c.jacobian)
    largest = 0.0
    for i in range(n):
        row = 0.0
        for j in range(m):
            if c.is_rate[j] == 1:
                row += abs(c.jacobian[n * n + i * m + j])
        largest = max(largest, row)
    return largest


def add_pending(c: Core, t: float, event: int, shift: float) -> None:
    """Add a delayed event at its place in the queue, with how much later it comes for the tangent."""
    i = c.count[N_PENDING]
    while i > 0 and c.pending_time[i - 1] > t:
        c.pending_time[i] = c.pending_time[i - 1]
        c.pending_event[i] = c.pending_event[i - 1]
        c.pending_shift[i] = c.pending_shift[i - 1]
        i -= 1
    c.pending_time[i], c.pending_event[i], c.pending_shift[i] = t, event, shift
    c.count[N_PENDING] += 1


def remove_pending(c: Core, place: int) -> None:
    """Remove the delayed event at a place in the queue."""
    n = c.count[N_PENDING] - 1
    for j in range(place, n):
        c.pending_time[j] = c.pending_time[j + 1]
        c.pending_event[j] = c.pending_event[j + 1]
        c.pending_shift[j] = c.pending_shift[j + 1]
    c.count[N_PENDING] = n


def find_next_stop(c: Core, t_stop: float) -> float:
    """Return the next time at which a step has to end, at the latest ``t_stop``."""
    stop = t_stop
    if c.count[N_BREAKING] > 0:
        stop = min(stop, c.breaking_time[0])
    if c.count[N_PENDING] > 0:
        stop = min(stop, c.pending_time[0])
    return stop


def queues_have_capacity(c: Core, n_events: int) -> bool:
    """Return whether what ``n_events`` events bring fits into the queues."""
    most = n_events * (c.n_delays + 1) * (c.n_events + 1) + LEVELS
    if c.is_general == 1:
        # At one time each level may come back as a value and as a rate, and each of both as either again.
        most += 4 * LEVELS * (c.n_delays + 1)
    return (c.count[N_BREAKING] + most < c.mask + 1) and (c.count[N_PENDING] + most < c.mask + 1)
