"""The times that steps have to end at: breaking points and delayed events under way."""

from __future__ import annotations

from pddecont.simulate.integrator.calls import internal
from pddecont.simulate.integrator.history import time_tolerance
from pddecont.simulate.integrator.state import N_BREAKING, N_PENDING

# A jump in a derivative of order 8 or more leaves an error of h^8 once, which is the order of the method itself.
LEVELS = 7


@internal
def add_breaking_points(c, t, level):
    """Note where a jump at ``t`` in a derivative of order ``level`` comes back: one order higher, each delay later."""
    if c.chain_n > 0 or level >= LEVELS:
        return
    for k in range(c.n_delays):
        if c.tau[k] > 0.0:
            _insert(c, t + c.tau[k], level + 1)


@internal
def _insert(c, t, level):
    """Add a breaking point at its place in the queue.

    One that is there already, to rounding, keeps its time and gets the lower level of the two.
    """
    times, levels, n = c.breaking_time, c.breaking_level, c.count[N_BREAKING]
    i = n
    while i > 0 and times[i - 1] > t:
        i -= 1
    for j in (i - 1, i):
        if 0 <= j < n and abs(times[j] - t) <= time_tolerance(t):
            levels[j] = min(levels[j], level)
            return
    for j in range(n, i, -1):
        times[j], levels[j] = times[j - 1], levels[j - 1]
    times[i], levels[i] = t, level
    c.count[N_BREAKING] = n + 1


@internal
def pass_breaking_points(c, t):
    """Remove the breaking points up to ``t`` and note where their jumps come back."""
    while c.count[N_BREAKING] > 0 and c.breaking_time[0] <= t + time_tolerance(t):
        passed, level = c.breaking_time[0], c.breaking_level[0]
        n = c.count[N_BREAKING] - 1
        for j in range(n):
            c.breaking_time[j], c.breaking_level[j] = c.breaking_time[j + 1], c.breaking_level[j + 1]
        c.count[N_BREAKING] = n
        add_breaking_points(c, passed, level)


@internal
def add_pending(c, t, event, shift):
    """Add a delayed event at its place in the queue, with how much later it comes for the tangent."""
    i = c.count[N_PENDING]
    while i > 0 and c.pending_time[i - 1] > t:
        c.pending_time[i] = c.pending_time[i - 1]
        c.pending_event[i] = c.pending_event[i - 1]
        c.pending_shift[i] = c.pending_shift[i - 1]
        i -= 1
    c.pending_time[i], c.pending_event[i], c.pending_shift[i] = t, event, shift
    c.count[N_PENDING] += 1


@internal
def remove_pending(c, place):
    """Remove the delayed event at a place in the queue."""
    n = c.count[N_PENDING] - 1
    for j in range(place, n):
        c.pending_time[j] = c.pending_time[j + 1]
        c.pending_event[j] = c.pending_event[j + 1]
        c.pending_shift[j] = c.pending_shift[j + 1]
    c.count[N_PENDING] = n


@internal
def find_next_stop(c, t_stop):
    """Return the next time at which a step has to end, at the latest ``t_stop``."""
    stop = t_stop
    if c.count[N_BREAKING] > 0:
        stop = min(stop, c.breaking_time[0])
    if c.count[N_PENDING] > 0:
        stop = min(stop, c.pending_time[0])
    return stop


@internal
def queues_have_capacity(c, n_events):
    """Return whether what ``n_events`` events bring fits into the queues."""
    most = n_events * (c.n_delays + 1) * (c.n_events + 1) + LEVELS
    return (c.count[N_BREAKING] + most < c.mask + 1) and (c.count[N_PENDING] + most < c.mask + 1)
