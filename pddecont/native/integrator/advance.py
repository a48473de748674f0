"""The integration itself: steps from one stop to the next, cut by events."""

from __future__ import annotations

from pddecont.native.arrays import Floats, entry
from pddecont.native.calls import offset
from pddecont.native.integrator.breaking import (
    add_breaking_points,
    add_returns,
    drop_breaking_points,
    find_next_stop,
    pass_breaking_points,
    queues_have_capacity,
)
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_handling import find_start_crossing, handle_events, resume_events
from pddecont.native.integrator.event_location import find_first_crossing
from pddecont.native.integrator.event_sides import update_side
from pddecont.native.integrator.history import interpolate_state, past_has_capacity, read_delayed, record_step
from pddecont.native.integrator.lag_crossing import find_lag_crossing, pass_lag
from pddecont.native.integrator.overlap import leave_step
from pddecont.native.integrator.places import (
    ARC,
    FIRST,
    FRESH,
    MODE,
    N_BREAKING,
    N_COEFFICIENTS,
    N_PENDING,
    N_REJECTED,
    N_STEPS,
    PIECE_START,
    READY,
    T_START,
    UNRESOLVED,
    USED,
    T,
)
from pddecont.native.integrator.ring import time_tolerance
from pddecont.native.integrator.sliding import return_to_surfaces
from pddecont.native.integrator.status import Status
from pddecont.native.integrator.step import make_step

# A step that is too long for an event function is made shorter by this factor, but not shorter than so many tolerances
# of time: below that the values of the function are mostly rounding.
UNRESOLVED_SHRINK, SHORTEST_RESOLVED = 16.0, 1000.0
# Events at one moment for which the queues, and the log, have capacity left whenever a step begins. Both are chosen
# large; a moment that brings more ends with CAPACITY or LOG_FULL.
EVENTS_AT_ONCE, LOG_HEADROOM = 16, 64


@entry
def initialise(c: Core, t: float, mode: int) -> None:
    """Set the clock of a new integration to ``t`` and its mode; its states are in ``c.y`` already.

    A mode of -1 says that nothing decides in which one it starts.
    """
    c.clock[T] = c.clock[T_START] = t
    c.count[MODE] = mode
    c.count[FRESH] = 1
    c.lag_time[PIECE_START] = t
    add_breaking_points(c, t, 0)


@entry
def change_parameters(c: Core, before: Floats) -> None:
    """Let new parameters hold from the present time on; ``before`` are the delays so far (n_delays,).

    The vector field jumps now, and the jumps of the past come back after other delays. The variables of a chain are its
    derivatives times powers of its step, which changes with the delay. The delayed values at the present time are left
    in ``c.xd``.
    """
    t = c.clock[T]
    c.count[ARC] += 1
    c.count[FRESH], c.count[READY] = 1, 0
    moved = False
    for k in range(c.n_delays):
        moved = moved or before[k] != c.tau[k]
    if moved and c.chain_n > 0:
        for i in range(c.n_pairs):
            k = c.pair_delay[i]
            for stage in range(c.chain_n):
                if before[k] == 0.0:
                    c.y[c.n + (i * c.chain_n + stage) * c.chain_order] = c.y[c.pair_state[i]]
                for power in range(1, c.chain_order):
                    # w_k is the k-th derivative times the k-th power of the step of the chain.
                    ratio = c.tau[k] / before[k] if before[k] > 0.0 else 0.0
                    c.y[c.n + (i * c.chain_n + stage) * c.chain_order + power] *= ratio**power
    elif moved and c.is_general == 1:
        _renew_returns(c, t)
    elif moved:
        c.count[N_BREAKING] = 0
        last = c.past_arc[c.count[FIRST] & c.mask]
        for number in range(c.count[FIRST], c.count[FIRST] + c.count[USED]):
            j = number & c.mask
            if c.past_arc[j] != last or c.past_time[j] == c.clock[T_START]:
                add_breaking_points(c, c.past_time[j], 0)
            last = c.past_arc[j]
        pass_breaking_points(c, t)
    add_breaking_points(c, t, 0)
    read_delayed(c, t, c.y, c.xd, 0)


def _renew_returns(c: Core, t: float) -> None:
    """Note anew where the jumps between the pieces of the past come back after ``t`` by constant lags."""
    c.count[N_BREAKING] = 0
    last = -1
    for number in range(c.count[FIRST], c.count[FIRST] + c.count[USED]):
        j = number & c.mask
        if c.past_piece[j] != last:
            add_returns(c, c.past_time[j], c.past_level[j], c.past_size[j])
        last = c.past_piece[j]
    drop_breaking_points(c, t)


@entry
def run(c: Core, t_stop: float, most_steps: int) -> int:
    """Do what :func:`advance` does, from Python; return a status, of which CAPACITY asks for a larger state."""
    c.count[READY] = 0
    return advance(c, t_stop, most_steps)


def advance(c: Core, t_stop: float, most_steps: int) -> int:
    """Integrate to ``t_stop``, or to a return to the section, an accumulation of events or a failure; return a status.

    Each turn of the loop handles what is due at the present time or makes one step. At most ``most_steps`` are made.
    """
    n_steps = 0
    if c.count[MODE] < 0:
        read_delayed(c, c.clock[T], c.y, c.xd, 0)
        return Status.REPELLED
    while True:
        t = c.clock[T]
        if not past_has_capacity(c) or not queues_have_capacity(c, EVENTS_AT_ONCE):
            return Status.CAPACITY
        if c.log_events > 0 and c.log_n[1] + LOG_HEADROOM > c.log_events:
            return Status.LOG_FULL
        if c.log_steps > 0 and c.log_n[0] + 1 > c.log_steps:
            return Status.LOG_FULL
        if c.resume[0] == 1:
            status = resume_events(c)
            if status != Status.REACHED:
                return status
            continue
        if c.count[ARC] == 0 and c.count[FRESH] == 1 and t == c.clock[T_START]:
            hit, direction = find_start_crossing(c)
            if hit == -2:
                return Status.NEW_WAY
            if hit >= 0:
                status = handle_events(c, hit, direction)
                if status != Status.REACHED:
                    return status
                continue
        if c.count[N_PENDING] > 0 and c.pending_time[0] <= t + time_tolerance(t):
            status = handle_events(c, -1, 0)
            if status != Status.REACHED:
                return status
            continue
        pass_breaking_points(c, t)
        if t >= t_stop:
            return Status.REACHED
        if n_steps >= most_steps:
            return Status.PAUSED
        n_steps += 1
        stop = find_next_stop(c, t_stop)
        h, status = make_step(c, t, stop)
        if status != Status.REACHED:
            return status
        status = _finish_step(c, t, h, stop)
        if status != Status.REACHED:
            return status


def _finish_step(c: Core, t: float, h: float, stop: float) -> int:
    """Look for events in the step just made, record it, move to its end and handle what is due; return a status.

    A step over which an event function cannot be resolved is discarded, and the next one is shorter.
    """
    sigma, hit, lag, passed = _find_first_event(c, t, h)
    if _discard_unresolved_step(c, t, h):
        return Status.REACHED
    whole = sigma > 1.0
    end = (stop if t + h >= stop - time_tolerance(stop) else t + h) if whole else min(t + sigma * h, stop)
    _move_to_end(c, t, h, end, sigma)
    # At the very start of a step a function that is on another side than it was has jumped, which is an event.
    if end > t + time_tolerance(t):
        _update_sides(c, hit, end, whole)
    if hit == c.n_segments:
        c.side[hit] = 0
        return Status.SECTION
    if lag >= 0:
        return pass_lag(c, lag, passed, end)
    return handle_events(c, hit, c.found_side[hit]) if hit >= 0 else Status.REACHED


def _find_first_event(c: Core, t: float, h: float) -> tuple[float, int, int, int]:
    """Return where in [0, 1] of the step just made something happens first, and what it is; 2 where nothing does.

    It is a segment that ends (-1: none; ``c.n_segments`` stands for the section), or a lag (-1: none) that passes the
    end of what it reads, with what :func:`find_lag_crossing` says that it passes.
    """
    mode, n_segments = c.count[MODE], c.n_segments
    hit, earliest = -1, 2.0
    same = time_tolerance(t + h) / h
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        event = c.segment_event[segment]
        s, c.found_side[segment] = find_first_crossing(
            c, event, c.segment_direction[segment], t, h, c.side[segment], c.residue[segment]
        )
        # Of events at one moment the one declared first comes first.
        if s >= 0.0 and s < earliest - same:
            hit, earliest = segment, s
    if c.section >= 0:
        s, c.found_side[n_segments] = find_first_crossing(
            c, c.section, c.section_direction, t, h, c.side[n_segments], 0.0
        )
        if s >= 0.0 and s < earliest:
            hit, earliest = n_segments, s
    if c.n_varying > 0:
        lag, s, passed = find_lag_crossing(c, t, h)
        if lag >= 0 and s < earliest - same:
            return s, -1, lag, passed
    return earliest, hit, -1, 0


def _discard_unresolved_step(c: Core, t: float, h: float) -> bool:
    """Discard the step just made if an event function varies faster than a step of its length can show."""
    if c.count[UNRESOLVED] == 0:
        return False
    c.count[UNRESOLVED] = 0
    if h <= SHORTEST_RESOLVED * time_tolerance(t):
        return False
    c.next_step[c.count[MODE]] = h / UNRESOLVED_SHRINK
    c.count[READY] = 0
    leave_step(c)
    c.count[N_REJECTED] += 1
    return True


def _move_to_end(c: Core, t: float, h: float, end: float, sigma: float) -> None:
    """Record the step just made up to ``end``, where ``sigma`` of it is over, and make that the present."""
    whole = sigma > 1.0
    if end > t:
        record_step(c, t, h, end)
    if end > t and c.log_steps > 0:
        _log_step(c, t, h, end)
    c.count[N_STEPS] += 1
    if not whole:
        interpolate_state(c, sigma, offset(c.trial, c.dimension), c.dimension)
    if c.is_general == 1:
        leave_step(c)
    for i in range(c.dimension):
        c.y[i] = c.trial[c.dimension + i]
    return_to_surfaces(c, end, h)
    c.count[READY] = 1 if whole else 0
    c.clock[T] = end


def _update_sides(c: Core, hit: int, end: float, whole: bool) -> None:
    """Note on which sides the functions of events that did not happen, and the section's, are at the end of a step."""
    mode = c.count[MODE]
    for place in range(c.crossing_first[mode], c.crossing_first[mode + 1]):
        segment = c.crossing_segment[place]
        if segment != hit:
            update_side(c, segment, c.segment_event[segment], end, whole)
    if c.section >= 0:
        update_side(c, c.n_segments, c.section, end, whole)


def _log_step(c: Core, t: float, h: float, end: float) -> None:
    """Write the step just made to the log."""
    row, n = c.log_n[0], c.n
    c.log_time[row], c.log_length[row], c.log_end[row], c.log_mode[row], c.log_arc[row] = (
        t,
        h,
        end,
        c.count[MODE],
        c.count[ARC],
    )
    for i in range(n):
        c.log_value[row * n + i] = c.y[i]
        for k in range(N_COEFFICIENTS):
            c.log_coefficients[(row * N_COEFFICIENTS + k) * n + i] = c.extension[k * c.dimension + i]
    c.log_n[0] = row + 1
