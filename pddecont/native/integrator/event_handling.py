"""What happens at one moment: events in declared order, their resets, and the delayed events that they start."""

from __future__ import annotations

from pddecont.native.arrays import Floats
from pddecont.native.calls import call
from pddecont.native.integrator.accumulation import detect_accumulation, estimate_curvature, is_at_rest, is_sliding
from pddecont.native.integrator.breaking import add_breaking_points, add_pending, queues_have_capacity, remove_pending
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_functions import evaluate_event, evaluate_event_slope
from pddecont.native.integrator.event_sides import carry_sides
from pddecont.native.integrator.history import read_delayed
from pddecont.native.integrator.lag_crossing import choose_pieces
from pddecont.native.integrator.places import ARC, FRESH, LAST_EVENT, MODE, N_PENDING, READY, SHIFT, ZENO_TIME, T
from pddecont.native.integrator.ring import time_tolerance
from pddecont.native.integrator.status import Status
from pddecont.native.integrator.variational import find_event_shift, map_tangent, set_tangent
from pddecont.native.integrator.ways import ask_for_rest, choose_way


def handle_events(c: Core, hit: int, direction: int) -> int:
    """Let everything happen that is due at the present time; segment ``hit`` (-1: none) crosses in ``direction``.

    Returns a status: REACHED to go on, SECTION after the event that returns are counted at, ZENO, SLIDING or REPELLED;
    CAPACITY or LOG_FULL after more events at one moment than there is capacity for; NEW_WAY to go on by
    :func:`resume_events`.
    """
    _mark_crossings(c, c.clock[T], hit, direction)
    c.resume[1], c.resume[2] = c.segment_event[hit] if hit >= 0 else -1, Status.REACHED
    c.resume[3] = -1
    return resume_events(c)


def resume_events(c: Core) -> int:
    """Let everything happen that is due at the present time, from where :func:`handle_events` had to stop."""
    t, forced, result, repelling = c.clock[T], c.resume[1], c.resume[2], c.resume[3]
    c.resume[0] = 0
    while True:
        segment, pending = _find_next_segment(c, t, forced)
        if segment < 0:
            break
        event = c.segment_event[segment]
        if _leaves_to_both_sides(c, segment):
            result = Status.REPELLED
        status, segment = _apply_event(c, segment, pending)
        if status == Status.NEW_WAY:
            c.resume[0], c.resume[1], c.resume[2], c.resume[3] = 1, forced, result, repelling
            return status
        if _is_repelled(c, segment, t):
            repelling = segment
        forced = -1
        if pending < 0:
            c.crossing[event] = 0
        if status != Status.REACHED:
            return status
        if event == c.stop_event and result == Status.REACHED:
            result = Status.SECTION
        if not queues_have_capacity(c, 1):
            return Status.CAPACITY
        if 0 < c.log_events <= c.log_n[1]:
            return Status.LOG_FULL
    while c.count[N_PENDING] > 0 and c.pending_time[0] <= t + time_tolerance(t):
        remove_pending(c, 0)
    # Other events of this moment may have moved it off the surface.
    return Status.REPELLED if repelling >= 0 and _is_repelled(c, repelling, t) else result


def find_start_crossing(c: Core) -> tuple[int, int]:
    """Return the segment that ends at the very start and the direction of its crossing; -1 and 0 if none does.

    The segment is -2 where the tables do not hold what one leads to.

    A motion that starts on a surface has not crossed it, unless it moves into it and the reset turns it round: that is
    an impact. From rest on the surface it moves where its acceleration points.
    """
    t, mode = c.clock[T], c.count[MODE]
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        event = c.segment_event[segment]
        slope, size = evaluate_event_slope(c, event, mode, t, c.y)
        into = slope if slope != 0.0 else estimate_curvature(c, event, mode, t, slope)
        direction = 1 if into > 0.0 else -1
        if into == 0.0 or direction * c.segment_direction[segment] < 0 or abs(evaluate_event(c, event, t, c.y)) > size:
            continue
        for i in range(c.dimension):
            c.trial[i] = c.y[i]
        _apply_reset(c, segment, t, c.trial)
        way = choose_way(c, segment, t, c.trial)
        if way < 0:
            return -2, 0
        target = c.segment_to[way]
        after, _ = evaluate_event_slope(c, event, target, t, c.trial)
        if after * direction <= 0.0 and target == mode:
            return segment, direction
    return -1, 0


def _mark_crossings(c: Core, t: float, hit: int, direction: int) -> None:
    """Write to ``c.crossing`` in which direction each event function crosses its zero at this moment (0: none).

    Twice the direction says that it has jumped over its zero with a delayed value.
    """
    mode = c.count[MODE]
    for event in range(c.n_events):
        c.crossing[event], c.passed[event] = 0, 0
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        event = c.segment_event[segment]
        if c.crossing[event] != 0:
            continue
        if hit >= 0 and event == c.segment_event[hit]:
            c.crossing[event] = direction
            continue
        side = c.side[segment]
        if side == 0 or c.count[FRESH] == 1:
            continue
        slope, size = evaluate_event_slope(c, event, mode, t, c.y)
        value = evaluate_event(c, event, t, c.y)
        if value * side < -size:
            c.crossing[event] = -2 * side
        elif slope * side < 0.0 and abs(value) <= size:
            c.crossing[event] = -side


def _find_next_segment(c: Core, t: float, forced: int) -> tuple[int, int]:
    """Return the first segment in declared order that ends now, and the place in the queue of the event that ends it.

    The place is -1 where an event function ends it; the segment is -1 if none ends.
    """
    mode = c.count[MODE]
    for place in range(c.ending_first[mode], c.ending_first[mode + 1]):
        segment = c.ending_segment[place]
        event = c.segment_event[segment]
        if c.after[event] >= 0:
            for i in range(c.count[N_PENDING]):
                if c.pending_time[i] > t + time_tolerance(t):
                    break
                if c.pending_event[i] == event:
                    return segment, i
        elif c.crossing[event] != 0 and c.segment_direction[segment] * c.crossing[event] >= 0:
            if event == forced:
                return segment, -1
            # An event before it at this moment may have moved the function off its zero, or turned the motion round.
            slope, size = evaluate_event_slope(c, event, mode, t, c.y)
            value = evaluate_event(c, event, t, c.y)
            if abs(c.crossing[event]) == 2:
                if value * c.crossing[event] > 2.0 * size:
                    return segment, -1
            elif slope * c.crossing[event] > 0.0 and abs(value) <= size:
                return segment, -1
            c.crossing[event] = 0
    return -1, -1


def _apply_event(c: Core, segment: int, pending: int) -> tuple[int, int]:
    """End a segment: reset, new mode, breaking points and delayed events to come; return a status.

    The segment that it turned out to be is returned too. ``pending`` is the place of the delayed event in the queue, -1
    for an event function. Nothing has happened yet where the status is NEW_WAY.
    """
    t, n, mode = c.clock[T], c.n, c.count[MODE]
    event = c.segment_event[segment]
    crossing, resolution = (c.crossing[event] if pending < 0 else 0), 0.0
    if crossing != 0:
        _, resolution = evaluate_event_slope(c, event, mode, t, c.y)
    status, way = _find_way_on(c, segment, crossing, resolution)
    if way < 0:
        return Status.NEW_WAY, segment
    shift = 0.0
    if pending >= 0:
        shift = c.pending_shift[pending]
        remove_pending(c, pending)
    elif c.tangent == 1:
        shift = find_event_shift(c, event, mode, t)
    if c.tangent == 1:
        map_tangent(c, c.segment_reset[way], mode, t, shift)
    target = c.segment_to[way]
    _log_event(c, way, t)
    level = c.is_general
    for i in range(n):
        # Where lags vary only what jumps is followed: the states, or without a reset their rates.
        if c.y[i] != c.after_reset[i]:
            level = 0
        c.y[i] = c.after_reset[i]
    c.count[MODE] = target
    c.count[ARC] += 1
    c.count[FRESH], c.count[READY] = 1, 0
    c.count[LAST_EVENT] = event
    c.clock[SHIFT] = shift
    c.segment_counts[way] += 1
    add_breaking_points(c, t, level)
    if c.is_general == 1:
        choose_pieces(c, t)
    if c.tangent == 1:
        set_tangent(c, target, t, shift)
    for place in range(c.clock_first[event], c.clock_first[event + 1]):
        other = c.clock_event[place]
        add_pending(c, t + c.event_delay[other], other, shift)
    carry_sides(c, event if crossing != 0 else -1, resolution, mode, t)
    return status, way


def _find_way_on(c: Core, segment: int, crossing: int, resolution: float) -> tuple[int, int]:
    """Return whether the motion goes on after a segment, and the segment that it is; ``c.after_reset`` is what follows.

    The status is SLIDING or ZENO where nothing is said of the motion there, else REACHED. The segment is -1 where the
    tables do not hold it, or the mode that it leads to.
    """
    t, event, mode, resting = c.clock[T], c.segment_event[segment], c.count[MODE], c.resting[segment]
    _apply_reset(c, segment, t, c.after_reset)
    way = choose_way(c, segment, t, c.after_reset)
    status: int = Status.REACHED
    if way >= 0 and way != resting:
        status = _find_halt(c, event, crossing, mode, c.segment_to[way], t, resolution)
        if status != Status.REACHED and resting >= 0:
            way, status = ask_for_rest(c, segment), Status.REACHED
    if way >= 0 and way == resting:
        _apply_reset(c, way, t, c.after_reset)
        for i in range(1, 4):
            c.accumulation[4 * event + i] = 0.0
    return status, way


def _log_event(c: Core, segment: int, t: float) -> None:
    """Write the event that ends a segment to the log, if there is room for it."""
    row, n = c.log_n[1], c.n
    if row < c.log_events:
        c.event_time[row], c.event_segment[row], c.event_arc[row] = t, segment, c.count[ARC] + 1
        for i in range(n):
            c.event_before[row * n + i] = c.y[i]
            c.event_after[row * n + i] = c.after_reset[i]
        c.log_n[1] = row + 1


def _find_halt(c: Core, event: int, crossing: int, mode: int, target: int, t: float, resolution: float) -> int:
    """Return whether the motion goes on from ``c.after_reset``: SLIDING or ZENO where it does not, else REACHED."""
    _swap_states(c)
    status: int = Status.REACHED
    if is_sliding(c, event, crossing, mode, target, t, resolution):
        c.clock[ZENO_TIME], status = t, Status.SLIDING
    elif is_at_rest(c, event, crossing, target, t, resolution):
        c.clock[ZENO_TIME], status = t, Status.ZENO
    else:
        status = detect_accumulation(c, event, mode, t)
    _swap_states(c)
    return status


def _swap_states(c: Core) -> None:
    """Exchange the states before and after a reset."""
    for i in range(c.n):
        c.y[i], c.after_reset[i] = c.after_reset[i], c.y[i]


def _leaves_to_both_sides(c: Core, segment: int) -> bool:
    """Return whether a motion that leaves a surface by ``segment`` is let go to the other side at the same moment."""
    other = c.segment_opposite[segment]
    return other >= 0 and c.crossing[c.segment_event[other]] * c.segment_direction[other] > 0


def _apply_reset(c: Core, segment: int, t: float, after: Floats) -> None:
    """Write the states after the reset of a segment to ``after``; ``c.xd`` holds the delayed values then."""
    read_delayed(c, t, c.y, c.xd, 0)
    for i in range(c.n):
        after[i] = 0.0
    reset = c.segment_reset[segment]
    call(c.reset[reset], c.reset_case[reset], t, c.y, c.xd, c.p, after)


def _is_repelled(c: Core, segment: int, t: float) -> bool:
    """Return whether the motion is on a surface after ``segment`` from which both fields point away."""
    if c.segment_repulsion[segment] == 0:
        return False
    read_delayed(c, t, c.y, c.xd, 0)
    c.gradient[0] = 0.0
    call(c.segment_repulsion[segment], c.segment_repulsion_case[segment], t, c.y, c.xd, c.p, c.gradient)
    return c.gradient[0] > 0.0
