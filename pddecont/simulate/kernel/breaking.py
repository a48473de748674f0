"""The times that steps must land on: breaking points and delayed events under way."""

from __future__ import annotations

from pddecont.simulate.kernel.calls import inner
from pddecont.simulate.kernel.past import near
from pddecont.simulate.kernel.tables import N_BREAKING, N_PENDING

# A jump in a derivative of order 8 or more leaves errors of h^8 once: the order of the method itself.
LEVELS = 7


@inner
def note_breaking(c, t, level):
    """Note the echoes of a jump at ``t`` in the derivative of order ``level``: one derivative higher, a delay later."""
    if c.chain_n > 0 or level >= LEVELS:
        return
    for k in range(c.n_delays):
        if c.tau[k] > 0.0:
            _insert(c, t + c.tau[k], level + 1)


@inner
def _insert(c, t, level):
    """Put a breaking point in its place; one that is there already to rounding keeps its time and the lower level."""
    times, levels, n = c.breaking_time, c.breaking_level, c.count[N_BREAKING]
    i = n
    while i > 0 and times[i - 1] > t:
        i -= 1
    for j in (i - 1, i):
        if 0 <= j < n and abs(times[j] - t) <= near(t):
            levels[j] = min(levels[j], level)
            return
    for j in range(n, i, -1):
        times[j], levels[j] = times[j - 1], levels[j - 1]
    times[i], levels[i] = t, level
    c.count[N_BREAKING] = n + 1


@inner
def pass_breaking(c, t):
    """Take out the breaking points up to ``t`` and note their echoes."""
    while c.count[N_BREAKING] > 0 and c.breaking_time[0] <= t + near(t):
        at, level = c.breaking_time[0], c.breaking_level[0]
        n = c.count[N_BREAKING] - 1
        for j in range(n):
            c.breaking_time[j], c.breaking_level[j] = c.breaking_time[j + 1], c.breaking_level[j + 1]
        c.count[N_BREAKING] = n
        note_breaking(c, at, level)


@inner
def note_pending(c, t, event, shift):
    """Note a delayed event."""
    i = c.count[N_PENDING]
    while i > 0 and c.pending_time[i - 1] > t:
        c.pending_time[i] = c.pending_time[i - 1]
        c.pending_event[i] = c.pending_event[i - 1]
        c.pending_shift[i] = c.pending_shift[i - 1]
        i -= 1
    c.pending_time[i], c.pending_event[i], c.pending_shift[i] = t, event, shift
    c.count[N_PENDING] += 1


@inner
def drop_pending(c, place):
    """Take out a delayed event."""
    n = c.count[N_PENDING] - 1
    for j in range(place, n):
        c.pending_time[j] = c.pending_time[j + 1]
        c.pending_event[j] = c.pending_event[j + 1]
        c.pending_shift[j] = c.pending_shift[j + 1]
    c.count[N_PENDING] = n


@inner
def next_stop(c, t, t_stop):
    """Return the next time that a step must land on."""
    stop = t_stop
    if c.count[N_BREAKING] > 0:
        stop = min(stop, c.breaking_time[0])
    if c.count[N_PENDING] > 0:
        stop = min(stop, c.pending_time[0])
    return stop


@inner
def queues_have_room(c, n_events):
    """Return whether what so many events bring still fits."""
    most = n_events * (c.n_delays + 1) * (c.n_events + 1) + LEVELS
    return (c.count[N_BREAKING] + most < c.mask + 1) and (c.count[N_PENDING] + most < c.mask + 1)
