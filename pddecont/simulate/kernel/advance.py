"""The integration itself: steps from one breaking point to the next, cut by events."""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.kernel.breaking import next_stop, note_breaking, pass_breaking, queues_have_room
from pddecont.simulate.kernel.calls import at, entry, inner
from pddecont.simulate.kernel.crossings import event_value, first_crossing, slope_and_size
from pddecont.simulate.kernel.moment import moment, starts_into, stick
from pddecont.simulate.kernel.pair import N_STAGES, explicit_extension, explicit_step, extension_error
from pddecont.simulate.kernel.past import near, prepare, remember, room_left, state_at
from pddecont.simulate.kernel.radau import stiff_extension, stiff_step
from pddecont.simulate.kernel.slopes import slopes
from pddecont.simulate.kernel.tables import (
    ARC,
    FIRST,
    FRESH,
    MODE,
    N_BREAKING,
    N_COEFFICIENTS,
    N_PENDING,
    N_REJECTED,
    N_STEPS,
    READY,
    T_START,
    UNRESOLVED,
    USED,
    Status,
    T,
    core,
    new_log,
)
from pddecont.simulate.kernel.tangent import prepare_with_echoes

SAFETY, SHRINK, GROW = 0.9, 0.2, 6.0
# No step is made shorter than so many units of rounding for an event function's sake.
SHORTEST = 1000.0
# Events at one moment that there is always room for.
MOMENT = 16


@entry
def begin(system, values, memory, work, t, mode):
    """Set the clock to ``t`` and the mode; the states stand in ``memory.y`` already."""
    c = core(system, values, memory, new_log(0, 0, 0), work)
    c.clock[T] = c.clock[T_START] = t
    c.count[MODE] = mode
    c.count[FRESH] = 1
    note_breaking(c, t, 0)


@entry
def change(system, values, memory, work, before):
    """Go on with other ``values`` than those ``before``: the vector field jumps now, and jumps of the past come back after other delays."""
    c = core(system, values, memory, new_log(0, 0, 0), work)
    t = c.clock[T]
    c.count[ARC] += 1
    c.count[FRESH], c.count[READY] = 1, 0
    moved = False
    for k in range(c.n_delays):
        moved = moved or before.tau[k] != c.tau[k]
    if moved and c.chain_n > 0:
        for i in range(c.n_pairs):
            k = c.pair_delay[i]
            for stage in range(c.chain_n):
                if before.tau[k] == 0.0:
                    c.y[c.n + (i * c.chain_n + stage) * c.chain_order] = c.y[c.pair_state[i]]
                for power in range(1, c.chain_order):
                    # w_k is the k-th derivative times the k-th power of the step of the chain.
                    ratio = c.tau[k] / before.tau[k] if before.tau[k] > 0.0 else 0.0
                    c.y[c.n + (i * c.chain_n + stage) * c.chain_order + power] *= ratio**power
    elif moved:
        c.count[N_BREAKING] = 0
        last = c.past_arc[c.count[FIRST] & c.mask]
        for number in range(c.count[FIRST], c.count[FIRST] + c.count[USED]):
            j = number & c.mask
            if c.past_arc[j] != last or c.past_time[j] == c.clock[T_START]:
                note_breaking(c, c.past_time[j], 0)
            last = c.past_arc[j]
        pass_breaking(c, t)
    note_breaking(c, t, 0)


@entry
def run(system, values, memory, log, work, t_stop, most_steps):
    """Do what :func:`advance` does, from Python; ROOM asks to be called again with a larger memory."""
    memory.count[READY] = 0
    return np.int64(advance(core(system, values, memory, log, work), t_stop, most_steps))


@inner
def advance(c, t_stop, most_steps):
    """Integrate to ``t_stop``, or until a return to the section, an accumulation of events, or a failure."""
    n_steps = 0
    while True:
        t = c.clock[T]
        if not room_left(c) or not queues_have_room(c, MOMENT):
            return Status.ROOM
        if c.log_events > 0 and c.log_n[1] + 64 > c.log_events:
            return Status.LOG_FULL
        if c.log_steps > 0 and c.log_n[0] + 1 > c.log_steps:
            return Status.LOG_FULL
        if c.count[ARC] == 0 and c.count[FRESH] == 1 and t == c.clock[T_START]:
            hit, direction = starts_into(c)
            if hit >= 0:
                status = _happen(c, hit, direction)
                if (status == Status.ZENO or status == Status.SLIDING) and stick(c, t_stop):
                    continue
                if status != Status.REACHED:
                    return status
                continue
        if c.count[N_PENDING] > 0 and c.pending_time[0] <= t + near(t):
            status = _happen(c, -1, 0)
            if (status == Status.ZENO or status == Status.SLIDING) and stick(c, t_stop):
                continue
            if status != Status.REACHED:
                return status
            continue
        pass_breaking(c, t)
        if t >= t_stop:
            return Status.REACHED
        if n_steps >= most_steps:
            return Status.PAUSED
        n_steps += 1
        stop = next_stop(c, t, t_stop)
        h, status = _step(c, t, stop)
        if status != Status.REACHED:
            return status
        status = _finish(c, t, h, stop)
        if (status == Status.ZENO or status == Status.SLIDING) and stick(c, t_stop):
            continue
        if status != Status.REACHED:
            return status


@inner
def _step(c, t, stop):
    """Make one step that the tolerances accept; return its length, with its extension in ``work``."""
    rest = stop - t
    mode = c.count[MODE]
    first = min(rest, c.max_step)
    changed = (prepare_with_echoes(c, t, t + 0.5 * _tried(c, first)) if c.tangent == 1
               else prepare(c, t + 0.5 * _tried(c, first)))  # fmt: skip
    if changed or c.count[READY] == 0 or c.stiff == 1:
        slopes(c, mode, t, c.y, c.stages)
    else:
        for i in range(c.dimension):
            c.stages[i] = c.stages[N_STAGES * c.dimension + i]
    if c.next_step[c.count[MODE]] == 0.0:
        c.next_step[c.count[MODE]] = _first_length(c, t, first)
        prepare(c, t + 0.5 * _tried(c, first))
    if c.count[FRESH] == 1:
        _sides(c, t)
    wanted = min(c.next_step[c.count[MODE]], c.max_step)
    # Delays and events read the step's extension, and so may who keeps the trajectory or waits at a section: else there is none.
    within = (c.n_delays > 0 and c.chain_n == 0) or c.n_segments > 0
    extended = within or c.section >= 0 or c.log_steps > 0
    rejected = False
    while True:
        h = wanted if 1.01 * wanted < rest else rest
        if rest > h > 0.5 * rest:
            h = 0.5 * rest
        if h <= 4.0 * near(t) and h < rest:
            for i in range(c.dimension):
                if not math.isfinite(c.y[i]) or not math.isfinite(c.stages[i]):
                    return h, Status.NOT_FINITE
            return h, Status.TOO_SMALL
        error = stiff_step(c, t, h) if c.stiff == 1 else explicit_step(c, t, h)
        order = 4.0 if c.stiff == 1 else 8.0
        if error <= 1.0 and c.stiff == 0 and extended:
            explicit_extension(c, t, h)
            if within:
                error = max(error, extension_error(c, t, h))
        if error <= 1.0:
            factor = GROW if error == 0.0 else min(GROW, max(SHRINK, SAFETY * error ** (-1.0 / order)))
            if rejected:
                factor = min(factor, 1.0)
            # A step cut short by a breaking point says nothing against the length that was wanted.
            c.next_step[c.count[MODE]] = max(h * factor, c.next_step[c.count[MODE]]) if h < 0.99 * wanted and not rejected else h * factor
            break
        c.count[N_REJECTED] += 1
        rejected = True
        wanted = h * (0.1 if not math.isfinite(error) else max(SHRINK, SAFETY * error ** (-1.0 / order)))
    if c.stiff == 1:
        stiff_extension(c)
    return h, Status.REACHED


@inner
def _tried(c, first):
    return first if c.next_step[c.count[MODE]] == 0.0 else min(first, c.next_step[c.count[MODE]])


@inner
def _first_length(c, t, longest):
    """Return a first step length from the sizes of the solution and its slope (Hairer, Norsett, Wanner I, section II.4)."""
    size, slope = 0.0, 0.0
    for i in range(c.n_full):
        allowed = c.atol + c.rtol * abs(c.y[i])
        size += (c.y[i] / allowed) ** 2
        slope += (c.stages[i] / allowed) ** 2
    if slope <= 1e-10 or size <= 1e-10:
        return min(longest, 1e-4 * max(1.0, abs(t)))
    return min(longest, 0.01 * math.sqrt(size / slope))


@inner
def _sides(c, t):
    """Note on which side of each event's surface an arc begins; 0 on the surface itself."""
    mode = c.count[MODE]
    c.count[FRESH] = 0
    for segment in range(c.n_segments):
        event = c.segment_event[segment]
        if c.segment_mode[segment] == mode and c.after[event] < 0:
            c.side[segment] = _side(c, event, mode, t)
    if c.section >= 0:
        c.side[c.n_segments] = _side(c, c.section, mode, t)


@inner
def _side(c, event, mode, t):
    _, size = slope_and_size(c, event, mode, t, c.y)
    value = event_value(c, event, t, c.y)
    if abs(value) <= size:
        return 0
    return 1 if value > 0.0 else -1


@inner
def _finish(c, t, h, stop):
    """Look for events in the step just made, keep it, move to its end and let happen what happens there."""
    mode = c.count[MODE]
    hit, earliest = -1, 2.0
    same = near(t + h) / h
    n_segments = c.n_segments
    for segment in range(n_segments):
        event = c.segment_event[segment]
        if c.segment_mode[segment] != mode or c.after[event] >= 0:
            continue
        direction, side = c.segment_direction[segment], c.side[segment]
        s, c.found_side[segment] = first_crossing(c, event, direction, t, h, side)
        # Of events at one moment the one declared first comes first.
        if s >= 0.0 and s < earliest - same:
            hit, earliest = segment, s
    marked = False
    if c.section >= 0:
        direction, side = c.section_direction, c.side[n_segments]
        s, c.found_side[n_segments] = first_crossing(c, c.section, direction, t, h, side)
        if s >= 0.0 and s < earliest:
            marked, hit, earliest = True, -1, s
    if c.count[UNRESOLVED] == 1:
        # An event function varies faster than a step of this length can show.
        c.count[UNRESOLVED] = 0
        if h > SHORTEST * near(t):
            c.next_step[c.count[MODE]] = h / 16.0
            c.count[READY] = 0
            c.count[N_REJECTED] += 1
            return Status.REACHED
    whole = earliest > 1.0
    end = (stop if t + h >= stop - near(stop) else t + h) if whole else min(t + earliest * h, stop)
    if end > t:
        remember(c, t, h, end)
    if end > t and c.log_steps > 0:
        row, n = c.log_n[0], c.n
        c.log_time[row], c.log_length[row], c.log_end[row], c.log_mode[row], c.log_arc[row] = t, h, end, mode, c.count[ARC]
        for i in range(n):
            c.log_value[row * n + i] = c.y[i]
            for k in range(N_COEFFICIENTS):
                c.log_coefficients[(row * N_COEFFICIENTS + k) * n + i] = c.extension[k * c.dimension + i]
        c.log_n[0] = row + 1
    c.count[N_STEPS] += 1
    if not whole:
        state_at(c, earliest, at(c.trial, c.dimension), c.dimension)
    for i in range(c.dimension):
        c.y[i] = c.trial[c.dimension + i]
    c.count[READY] = int(whole)
    c.clock[T] = end
    for segment in range(n_segments):
        event = c.segment_event[segment]
        if c.segment_mode[segment] == mode and c.after[event] < 0 and segment != hit:
            _note_side(c, segment, event, end, whole)
    if c.section >= 0:
        _note_side(c, n_segments, c.section, end, whole)
    if marked:
        c.side[n_segments] = 0
        return Status.SECTION
    if hit < 0:
        return Status.REACHED
    direction = c.segment_direction[hit]
    if direction == 0:
        slope, _ = slope_and_size(c, c.segment_event[hit], mode, end, c.y)
        direction = -c.side[hit] if c.side[hit] != 0 else (1 if slope > 0.0 else -1)
    return _happen(c, hit, direction)


@inner
def _happen(c, hit, direction):
    """Let everything happen that is due now, and note the sides on which the new arc begins.

    They are those of the delayed values before this moment: one that jumps now carries its event function over zero, and that counts.
    """
    status = moment(c, hit, direction)
    if c.count[FRESH] == 1:
        _sides(c, c.clock[T])
    return status


@inner
def _note_side(c, place, event, t, whole):
    """Keep the sign of an event function where a step ends: what the search found, or where the step is cut, what it is there.

    A value that is zero to rounding leaves the sign as it was, and the crossing to the next step.
    """
    if whole:
        c.side[place] = c.found_side[place]
        return
    _, size = slope_and_size(c, event, c.count[MODE], t, c.y)
    value = event_value(c, event, t, c.y)
    if abs(value) > size:
        c.side[place] = 1 if value > 0.0 else -1
