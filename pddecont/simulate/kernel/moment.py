"""What happens at one moment: events in declared order, their resets, what they set going, and whether they accumulate."""

from __future__ import annotations

import math

from pddecont.simulate.kernel.breaking import drop_pending, note_breaking, note_pending, queues_have_room
from pddecont.simulate.kernel.calls import at, call, inner
from pddecont.simulate.kernel.crossings import event_value, slope_and_size
from pddecont.simulate.kernel.past import near, read
from pddecont.simulate.kernel.tables import (
    ARC,
    AT_ONCE,
    FRESH,
    LAST_EVENT,
    MODE,
    N_PENDING,
    READY,
    SHIFT,
    TURN,
    ZENO_TIME,
    Status,
    T,
)
from pddecont.simulate.kernel.tangent import after_reset, before_reset, event_shift

MAX_AT_ONCE = 1000
SHRINKING = 8
ACCUMULATED = 1e-10
UNSEEN = 1000.0


@inner
def moment(c, hit, direction):
    """Let everything happen that is due at the present time; segment ``hit`` (-1: none) crosses in ``direction``.

    Returns a status: REACHED to go on, SECTION after the event that returns are counted at, ZENO or SLIDING; ROOM or LOG_FULL after more
    events at one moment than are ever prepared for.
    """
    t = c.clock[T]
    _candidates(c, t, hit, direction)
    forced = c.segment_event[hit] if hit >= 0 else -1
    result = Status.REACHED
    while True:
        segment, pending = _next(c, t, forced)
        if segment < 0:
            break
        event = c.segment_event[segment]
        status = _fire(c, segment, pending)
        forced = -1
        if pending < 0:
            c.crossing[event] = 0
        if status != Status.REACHED:
            return status
        if event == c.stop_event:
            result = Status.SECTION
        if not queues_have_room(c, 1):
            return Status.ROOM
        if 0 < c.log_events <= c.log_n[1]:
            return Status.LOG_FULL
    while c.count[N_PENDING] > 0 and c.pending_time[0] <= t + near(t):
        drop_pending(c, 0)
    return result


@inner
def starts_into(c):
    """Return the segment that ends at the very start, and the direction of its crossing; -1 if none does.

    A motion that starts on a surface has not crossed it, unless it moves into it and the reset turns it round: that is an impact. From
    rest on the surface it moves where its acceleration points.
    """
    t, mode = c.clock[T], c.count[MODE]
    for segment in range(c.n_segments):
        event = c.segment_event[segment]
        if c.segment_mode[segment] != mode or c.after[event] >= 0:
            continue
        slope, size = slope_and_size(c, event, mode, t, c.y)
        into = slope if slope != 0.0 else _curvature(c, event, mode, t, slope)
        direction = 1 if into > 0.0 else -1
        if into == 0.0 or direction * c.segment_direction[segment] < 0 or abs(event_value(c, event, t, c.y)) > size:
            continue
        read(c, t, c.y, c.xd, 0)
        for i in range(c.dimension):
            c.trial[i] = c.y[i]
        for i in range(c.n):
            c.trial[i] = 0.0
        call(c.reset, c.segment_reset[segment], t, c.y, c.xd, c.p, c.trial)
        after, _ = slope_and_size(c, event, c.segment_to[segment], t, c.trial)
        if after * direction <= 0.0 and c.segment_to[segment] == mode:
            return segment, direction
    return -1, 0


@inner
def _candidates(c, t, hit, direction):
    """Write for each event function in which direction it crosses its zero at this moment (0: it does not)."""
    mode = c.count[MODE]
    for event in range(c.n_events):
        c.crossing[event] = 0
    for segment in range(c.n_segments):
        event = c.segment_event[segment]
        if c.segment_mode[segment] != mode or c.after[event] >= 0 or c.crossing[event] != 0:
            continue
        if hit >= 0 and event == c.segment_event[hit]:
            c.crossing[event] = direction
            continue
        side = c.side[segment]
        if side == 0 or c.count[FRESH] == 1:
            continue
        slope, size = slope_and_size(c, event, mode, t, c.y)
        if slope * side < 0.0 and abs(event_value(c, event, t, c.y)) <= size:
            c.crossing[event] = -side


@inner
def _next(c, t, forced):
    """Return the first segment in declared order that ends now, and which delayed event ends it (-1: an event function does)."""
    mode = c.count[MODE]
    for segment in range(c.n_segments):
        if c.segment_mode[segment] != mode:
            continue
        event = c.segment_event[segment]
        if c.after[event] >= 0:
            for i in range(c.count[N_PENDING]):
                if c.pending_time[i] > t + near(t):
                    break
                if c.pending_event[i] == event:
                    return segment, i
        elif c.crossing[event] != 0 and c.segment_direction[segment] * c.crossing[event] >= 0:
            if event == forced:
                return segment, -1
            _, size = slope_and_size(c, event, mode, t, c.y)
            if abs(event_value(c, event, t, c.y)) <= size:
                return segment, -1
            c.crossing[event] = 0
    return -1, -1


@inner
def _fire(c, segment, pending):
    """End a segment: reset, new mode, echoes and delayed events to come."""
    t, n, mode = c.clock[T], c.n, c.count[MODE]
    event, target = c.segment_event[segment], c.segment_to[segment]
    shift = 0.0
    if pending >= 0:
        shift = c.pending_shift[pending]
        drop_pending(c, pending)
    elif c.tangent == 1:
        shift = event_shift(c, event, mode, t)
    if c.tangent == 1:
        before_reset(c, c.segment_reset[segment], mode, t, shift)
    crossing, resolution = (c.crossing[event] if pending < 0 else 0), 0.0
    if crossing != 0:
        _, resolution = slope_and_size(c, event, mode, t, c.y)
    read(c, t, c.y, c.xd, 0)
    row = c.log_n[1]
    logged = row < c.log_events
    if logged:
        c.event_time[row], c.event_segment[row] = t, segment
        for i in range(n):
            c.event_before[row * n + i] = c.y[i]
    for i in range(n):
        c.after_reset[i] = 0.0
    call(c.reset, c.segment_reset[segment], t, c.y, c.xd, c.p, c.after_reset)
    for i in range(n):
        c.y[i] = c.after_reset[i]
        if logged:
            c.event_after[row * n + i] = c.y[i]
    if logged:
        c.event_arc[row] = c.count[ARC] + 1
        c.log_n[1] = row + 1
    if c.tangent == 1:
        after_reset(c, target, t, shift)
    c.count[MODE] = target
    c.count[ARC] += 1
    c.count[FRESH], c.count[READY] = 1, 0
    c.count[LAST_EVENT] = event
    c.clock[SHIFT] = shift
    c.hits[segment] += 1
    note_breaking(c, t, 0)
    for other in range(c.n_events):
        if c.after[other] == event:
            note_pending(c, t + c.event_delay[other], other, shift)
    if _slides(c, event, crossing, mode, target, t):
        c.clock[ZENO_TIME] = t
        return Status.SLIDING
    if _rests(c, event, crossing, target, t, resolution):
        c.clock[ZENO_TIME] = t
        return Status.ZENO
    return _accumulates(c, event, t)


@inner
def _slides(c, event, crossing, old, new, t):
    """Return whether the new mode's flow leads straight back through the event just met, while the old one's still leads here.

    Both vector fields then point at the surface (Filippov's criterion), and no motion leaves it.
    """
    if crossing == 0 or old == new:
        return False
    if not _watched(c, event, -crossing, new):
        return False
    there, size = slope_and_size(c, event, new, t, c.y)
    if there * crossing >= 0.0 or abs(event_value(c, event, t, c.y)) > size:
        return False
    here, _ = slope_and_size(c, event, old, t, c.y)
    return here * crossing > 0.0


@inner
def _watched(c, event, direction, mode):
    """Whether a segment of a mode ends where an event function crosses its zero in a direction."""
    for segment in range(c.n_segments):
        if c.segment_mode[segment] == mode and c.segment_event[segment] == event and c.segment_direction[segment] * direction >= 0:
            return True
    return False


@inner
def _rests(c, event, crossing, mode, t, resolution):
    """Return whether the motion lies on the event's surface after the reset: it is pressed on it, and leaves it by less than rounding.

    ``resolution`` is how far from zero the event function may have been, to rounding, when the event was met.
    """
    if crossing == 0 or not _watched(c, event, crossing, mode):
        return False
    slope, size = slope_and_size(c, event, mode, t, c.y)
    size = max(size, resolution)
    if abs(event_value(c, event, t, c.y)) > size:
        return False
    curvature = _curvature(c, event, mode, t, slope)
    return curvature * crossing > 0.0 and slope * slope <= 2.0 * abs(curvature) * size


@inner
def _curvature(c, event, mode, t, slope):
    """Return how ``slope``, an event function's, changes along the flow, from a short way ahead; :func:`slope_and_size` comes first."""
    ahead = 1e-6 * max(1.0, abs(t))
    y = c.trial
    for i in range(c.dimension):
        y[i] = c.y[i] + ahead * c.slope[i]
    later, _ = slope_and_size(c, event, mode, t + ahead, y)
    return (later - slope) / ahead


@inner
def _accumulates(c, event, t):
    """Follow the gaps between events: those that shrink geometrically end at t + gap r / (1 - r)."""
    row = at(c.accumulation, 4 * event)
    c.count[AT_ONCE] = c.count[AT_ONCE] + 1 if abs(t - c.clock[TURN]) <= near(t) else 0
    c.clock[TURN] = t
    if c.count[AT_ONCE] > MAX_AT_ONCE:
        c.clock[ZENO_TIME] = t
        return Status.ZENO
    gap = t - row[0]
    ratio = gap / row[1] if row[1] > 0.0 else 0.0
    row[3] = row[3] + 1.0 if 0.0 < ratio < 1.0 and abs(ratio - row[2]) < 0.1 else 0.0
    row[0], row[1], row[2] = t, gap, ratio
    if row[3] >= SHRINKING:
        rest = gap * ratio / (1.0 - ratio)
        slope, size = slope_and_size(c, event, c.count[MODE], t, c.y) if c.after[event] < 0 else (math.inf, 0.0)
        # Below some gap rounding in the event function is all that is left of it.
        if rest <= ACCUMULATED * max(1.0, abs(t)) or abs(slope) * gap <= UNSEEN * size:
            c.clock[ZENO_TIME] = t + rest
            return Status.ZENO
    return Status.REACHED


@inner
def stick(c, t_stop):
    """Hand over to the mode that the last event sticks to; return whether there is one."""
    mode = c.stick[c.count[LAST_EVENT]]
    if mode < 0:
        return False
    c.clock[T] = min(c.clock[ZENO_TIME], max(t_stop, c.clock[T]))
    c.count[MODE] = mode
    c.count[ARC] += 1
    c.count[FRESH], c.count[READY] = 1, 0
    for i in range(1, 4):
        c.accumulation[4 * c.count[LAST_EVENT] + i] = 0.0
    return True
