"""Returns of a motion to a section: until it repeats itself, until it reaches an attractor that is known, or for its tangent's growth."""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.kernel.advance import advance, begin
from pddecont.simulate.kernel.calls import entry, inner
from pddecont.simulate.kernel.past import near
from pddecont.simulate.kernel.slopes import slopes
from pddecont.simulate.kernel.tables import (
    CONSTANT,
    FIRST,
    MODE,
    N_COEFFICIENTS,
    N_PENDING,
    READY,
    SHIFT,
    USED,
    Status,
    T,
    core,
    enlarged,
    new_log,
    new_memory,
)

# A motion has a period when it comes back so closely (relative to its size, and to the error allowed in a step) this many times
# running ...
SAME, SAME_ERRORS, REPEATS = 1e-7, 30.0, 3
# ... and otherwise if it comes back this closely when its time is over.
CLOSE = 1e-4
# How near to an attractor's returns a motion is that is taken to stay there.
ARRIVED = 1e-4
# How fast distances shrink at best, for telling a period from its divisors: they beat where multipliers are complex.
SLOW = 0.95
STEPS = 1 << 40


@inner
def next_return(system, values, memory, work, log, period, phase, t_end, stop):
    """Integrate to the next return: the next time at which ``phase`` of the forcing period has passed, or to the section.

    ``period`` is 0 where returns are to a section. Returns a status: REACHED where ``t_end`` comes first, ROOM to be called again with a
    larger memory. ``stop`` keeps in between, in its one place, the time that the motion is under way to, and is NaN otherwise.
    """
    if math.isnan(stop[0]):
        stop[0] = t_end
        if period > 0.0:
            turn = math.floor(memory.clock[T] / period - phase + 1.0 + 1e-9)
            stop[0] = min((turn + phase) * period, np.nextafter(t_end, math.inf))
    t_stop = stop[0]
    memory.count[READY] = 0
    status = advance(core(system, values, memory, log, work), min(t_stop, t_end), STEPS)
    if status == Status.ROOM:
        return status
    stop[0] = math.nan
    return Status.SECTION if status == Status.REACHED and period > 0.0 and t_stop <= t_end else status


@entry
def settle(system, values, memory, work, returns, period, phase, t_end, max_period):
    """Follow a motion until it repeats itself or its time is over; return a status and its period in returns, 0 where there is none.

    ``returns`` are filled; ROOM asks to be called again with a larger memory.
    """
    log = new_log(0, 0, 0)
    states, times, hits, distances, running = returns.states, returns.times, returns.hits, returns.distances, returns.running
    room = len(times)
    # Where a forcing counts the returns, the states say all; at a section the slopes tell motions apart that they cannot.
    width = system.n if period > 0.0 else 2 * system.n
    size, noise = np.zeros(2 * system.n), np.zeros(2 * system.n)
    same = max(SAME, SAME_ERRORS * values.rtol)
    while True:
        status = next_return(system, values, memory, work, log, period, phase, t_end, returns.stop)
        if status != Status.SECTION:
            break
        number = returns.number[0]
        row = number % room
        _note(core(system, values, memory, log, work), states, row)
        times[row] = memory.clock[T]
        for k in range(hits.shape[1]):
            hits[row, k] = memory.hits[k]
        number += 1
        returns.number[0] = number
        gap = times[row] - times[(row - 1) % room] if number > 1 else math.inf
        _sizes(states, min(number, room, 2 * max_period + 2), number, values.atol, values.rtol, gap, size, noise)
        for q in range(1, min(max_period, number - 1, room - 1) + 1):
            distances[row, q] = _distance(states, row, (number - 1 - q) % room, width, size, noise)
            alike = distances[row, q] <= same and _same_counts(hits, number, q, room) and _same_gaps(times, number, q, room, 10.0 * same)
            running[q] = running[q] + 1 if alike else 0
            # As many times as the period is long, and longer than the longest delay.
            if (running[q] >= REPEATS * q and times[row] - times[(number - 1 - min(running[q], room - 1)) % room] >= values.longest
                    and _smallest(distances, number, q, room, same)):  # fmt: skip
                return np.int64(Status.SECTION), q
    q = _period(distances, times, hits, returns.number[0], max_period, room, same) if status == Status.REACHED else 0
    return np.int64(status), q


@inner
def _note(c, states, row):
    """Write the states and their slopes at a return."""
    slopes(c, c.count[MODE], c.clock[T], c.y, c.slope)
    for i in range(c.n):
        states[row, i], states[row, c.n + i] = c.y[i], c.slope[i]


@inner
def _sizes(states, kept, number, atol, rtol, gap, size, noise):
    """Write how large states and slopes are over the last returns, and what of them is noise of the integration."""
    n, room = states.shape[1] // 2, len(states)
    size[:] = 0.0
    for back in range(kept):
        row = (number - 1 - back) % room
        for i in range(2 * n):
            size[i] = max(size[i], abs(states[row, i]))
    for i in range(n):
        noise[i] = 10.0 * atol
        noise[n + i] = 100.0 * (atol + rtol * size[i]) / gap if gap > 0.0 else 0.0


@inner
def _distance(states, a, b, width, size, noise):
    """Return how far apart two returns are, relative to the motion's size; what is noise counts for nothing."""
    distance = 0.0
    for i in range(width):
        distance = max(distance, (abs(states[a, i] - states[b, i]) - noise[i]) / (size[i] + 1e-300))
    return distance


@inner
def _same_counts(hits, number, q, room):
    """Whether the last ``q`` returns brought as many ends of each segment as the ``q`` before them."""
    if number - 1 - 2 * q < 0 or 2 * q >= room:
        return number - 1 >= q
    last, middle, first = (number - 1) % room, (number - 1 - q) % room, (number - 1 - 2 * q) % room
    for k in range(hits.shape[1]):
        if hits[last, k] - hits[middle, k] != hits[middle, k] - hits[first, k]:
            return False
    return True


@inner
def _same_gaps(times, number, q, room, tolerance):
    """Whether the last ``q`` returns took as long as the ``q`` before them."""
    if number - 1 - 2 * q < 0 or 2 * q >= room:
        return number - 1 >= q
    last, middle, first = times[(number - 1) % room], times[(number - 1 - q) % room], times[(number - 1 - 2 * q) % room]
    return abs(last - 2.0 * middle + first) <= tolerance * (last - middle) + 8.0 * near(last)


@inner
def _smallest(distances, number, q, room, same):
    """Whether no divisor of a period is the period that the motion is still settling to.

    What is left to settle is estimated from how fast the distance after ``q`` returns shrinks; the distance after a divisor has to be
    larger. Where multipliers lie near a q-th root of 1 the former is small long before the latter is.
    """
    window = REPEATS * q
    now, then = _largest(distances, number, q, 0, window, room), _largest(distances, number, q, window, 2 * window, room)
    shrinks = (now / then) ** (1.0 / REPEATS) if then > now > 0.0 else SLOW
    left = max(now, same) / (1.0 - min(max(shrinks, SLOW), 0.999))
    for divisor in range(1, q):
        if q % divisor == 0 and _largest(distances, number, divisor, 0, window, room) <= 4.0 * left:
            return False
    return True


@inner
def _largest(distances, number, q, first, last, room):
    """Return the largest distance after ``q`` returns, of those ``first`` to ``last`` returns back."""
    largest = 0.0
    for back in range(first, min(last, number - q, room)):
        largest = max(largest, distances[(number - 1 - back) % room, q])
    return largest


@inner
def _period(distances, times, hits, number, max_period, room, same):
    """Return the period of the returns kept, told less strictly: the motion may still be settling."""
    kept = min(number, room)
    for q in range(1, max_period + 1):
        if 2 * q + 1 > kept or not _same_counts(hits, number, q, room) or not _same_gaps(times, number, q, room, CLOSE):
            continue
        worst = 0.0
        for back in range(min(q + 2, kept - q)):
            worst = max(worst, distances[(number - 1 - back) % room, q])
        if worst <= CLOSE and _smallest(distances, number, q, room, same):
            return q
    return 0


@entry
def recognise_cells(system, values, work, template, initial, mode, constant, period, phase, t_end, points, owner, following, length,
                    size, labels, times):  # fmt: skip
    """Write which known attractor each of ``initial`` (n_cells, n) leads to, and when it was recognised; -1 where none was.

    ``template`` holds all variables at the start but those. ``points`` (n_points, n) are the attractors' returns, ``owner`` says whose
    each is, ``following`` which comes after it, ``length`` how many returns the attractor has, ``size`` how large its states are. A
    motion is on an attractor when its returns are near to the attractor's, in their order, for longer than these take and than the
    longest delay.
    """
    log, stop = new_log(0, 0, 0), np.zeros(1)
    for cell in range(len(initial)):
        memory = new_memory(system, values)
        memory.y[:] = template
        memory.y[: system.n] = initial[cell]
        if constant == 1:
            memory.count[CONSTANT] = 1
            memory.constant[:] = initial[cell]
            _start_chain(system, memory)
        begin(system, values, memory, work, 0.0, mode)
        labels[cell], expected, since, met = -1, -1, 0.0, 0
        stop[0] = math.nan
        while True:
            status = next_return(system, values, memory, work, log, period, phase, t_end, stop)
            if status == Status.ROOM:
                memory = enlarged(memory)
                continue
            if status != Status.SECTION:
                break
            if expected >= 0 and _near(points, expected, memory.y, size, values.atol):
                found, met = expected, met + 1
            else:
                found, met = _nearest(points, memory.y, size, values.atol), 1
                since = memory.clock[T]
            expected = -1 if found < 0 else following[found]
            if found >= 0 and met > length[found] and memory.clock[T] - since >= values.longest:
                labels[cell] = owner[found]
                break
        times[cell] = memory.clock[T]


@inner
def _start_chain(system, memory):
    """Let the chains of a constant history begin: every stage has the state's value, and no derivatives."""
    for i in range(len(system.pair_state) if system.chain_n > 0 else 0):
        for stage in range(system.chain_n):
            memory.y[system.n + (i * system.chain_n + stage) * system.chain_order] = memory.constant[system.pair_state[i]]


@inner
def _near(points, j, y, size, atol):
    for i in range(points.shape[1]):
        if not abs(points[j, i] - y[i]) <= ARRIVED * size[j, i] + 100.0 * atol:
            return False
    return True


@inner
def _nearest(points, y, size, atol):
    """Return the point that ``y`` is near to (-1: none)."""
    for j in range(len(points)):
        if _near(points, j, y, size, atol):
            return j
    return -1


@entry
def growth(system, values, memory, work, interval, logs, done):
    """Write the logarithm of the tangent's growth over each of ``len(logs)`` intervals; return a status.

    ROOM asks to be called again with a larger memory; ``done`` keeps in between how many intervals are, and when the present one ends
    (NaN: none is under way). It begins with (0, NaN).
    """
    log = new_log(0, 0, 0)
    if done[0] == 0.0 and math.isnan(done[1]):
        _rescale(system, memory)
    for k in range(int(done[0]), len(logs)):
        if math.isnan(done[1]):
            done[1] = memory.clock[T] + interval
        status = Status.SECTION
        while status == Status.SECTION:
            memory.count[READY] = 0
            status = advance(core(system, values, memory, log, work), done[1], STEPS)
        if status != Status.REACHED:
            return np.int64(status)
        logs[k] = _rescale(system, memory)
        done[0], done[1] = k + 1.0, math.nan
        if not math.isfinite(logs[k]):
            break
    return np.int64(Status.REACHED)


@inner
def _rescale(system, memory):
    """Make the tangent, and all that depends on it, of length 1; return the logarithm of the length that it had."""
    full, kept = system.n_full, len(system.kept)
    mask = len(memory.past_time) - 1
    length = 0.0
    for i in range(full):
        length = max(length, abs(memory.y[full + i]))
    numbers = range(memory.count[FIRST], memory.count[FIRST] + memory.count[USED])
    for number in numbers:
        for k in range(kept):
            length = max(length, abs(memory.past_value[number & mask, kept + k]))
    if length == 0.0 or not math.isfinite(length):
        return -math.inf if length == 0.0 else math.inf
    for i in range(full):
        memory.y[full + i] /= length
    for number in numbers:
        j = number & mask
        memory.past_shift[j] /= length
        for k in range(kept):
            memory.past_value[j, kept + k] /= length
            for i in range(N_COEFFICIENTS):
                memory.past_coefficients[j, i, kept + k] /= length
    for k in range(memory.count[N_PENDING]):
        memory.pending_shift[k] /= length
    memory.clock[SHIFT] /= length
    return math.log(length)
