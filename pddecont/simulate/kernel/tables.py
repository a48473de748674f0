"""What the compiled functions share: the model in numbers, its values at given parameters, and the state of an integration."""

from __future__ import annotations

from collections import namedtuple
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from pddecont.simulate.kernel.calls import either, inner, pointer

# Coefficients that a step's continuous extension has beside its first value.
N_COEFFICIENTS = 7


class Status(IntEnum):
    """Why :func:`advance` came back."""

    REACHED = 0
    SECTION = 1
    PAUSED = 2
    ROOM = 3
    LOG_FULL = 4
    ZENO = 5
    SLIDING = 6
    TOO_SMALL = 7
    NOT_FINITE = 8


class System(NamedTuple):
    """A model in numbers; nothing here depends on parameter values.

    Addresses of functions; pairs (state, delay) that are read delayed; the states that the past keeps and the place of each
    (-1: not kept); segments; ``after`` (the event that a delayed event follows, -1: none); ``reads`` whether an event function
    reads delayed values; the chain's order and length (0: delayed values come from the past); ``section`` numbers an event
    function that only marks returns (-1: none), ``stop_event`` an event at which to come back.
    """

    field: int
    event: int
    reset: int
    history: int
    field_jacobian: int
    event_jacobian: int
    reset_jacobian: int
    n: int
    n_full: int
    tangent: int
    pair_state: Any
    pair_delay: Any
    kept: Any
    place: Any
    segment_mode: Any
    segment_event: Any
    segment_direction: Any
    segment_reset: Any
    segment_to: Any
    after: Any
    reads: Any
    chain_order: int
    chain_n: int
    section: int
    section_direction: int
    stop_event: int
    stiff: int
    n_modes: int


class Values(NamedTuple):
    """A model's numbers at given parameters, and what limits steps. ``stick`` maps an event to the mode where it accumulates (-1)."""

    p: Any
    tau: Any
    event_delay: Any
    max_step: float
    rtol: float
    atol: float
    longest: float
    stick: Any


class Memory(NamedTuple):
    """The state of an integration; all of it is arrays that change in place.

    The past is a ring of steps, a power of two long: start, length, where the step ends (an event may cut it), the arc it belongs
    to, and the coefficients of its continuous extension for the states that are read delayed. ``shift`` is how much later the arc
    began for the tangent. ``pending`` are delayed events under way, ``breaking`` the breaking points to come, both in order of time.
    ``hits`` counts how often each segment has ended, ``side`` is the sign of its event function (0: just left its zero), the
    section's last. ``next_step`` is the length that each mode's next step may have.
    """

    clock: Any
    count: Any
    y: Any
    constant: Any
    past_time: Any
    past_length: Any
    past_end: Any
    past_arc: Any
    past_shift: Any
    past_value: Any
    past_coefficients: Any
    cursor: Any
    reading: Any
    pending_time: Any
    pending_event: Any
    pending_shift: Any
    breaking_time: Any
    breaking_level: Any
    accumulation: Any
    hits: Any
    side: Any
    next_step: Any


class Log(NamedTuple):
    """Steps and events of an integration, for those who want them; arrays of no length record nothing.

    ``n`` counts both; ``event_arc`` numbers the arc that an event begins.
    """

    n: Any
    time: Any
    length: Any
    end: Any
    mode: Any
    arc: Any
    value: Any
    coefficients: Any
    event_time: Any
    event_segment: Any
    event_arc: Any
    before: Any
    after: Any


class Returns(NamedTuple):
    """What is known of a motion's returns to a section while it is looked for a period.

    ``states`` (n_returns, 2 n: states and their slopes), ``times`` (n_returns,), ``hits`` (n_returns, n_segments: ends of segments up to
    then) and ``distances`` (n_returns, max_period + 1) from so many returns before are rings: return number i stands in row i modulo
    n_returns. ``running`` counts how often in a row the motion came back after so many, ``number`` the returns; ``stop`` is the time
    that the motion is under way to, NaN at a return.
    """

    states: Any
    times: Any
    hits: Any
    distances: Any
    running: Any
    number: Any
    stop: Any


class Work(NamedTuple):
    """Room for intermediate results; rows of ``dimension`` numbers unless they say otherwise.

    ``stages`` has 16 rows, ``extension`` 7, ``trial`` and ``slope`` 3; ``bernstein`` and ``stack`` 64 rows of 10 and 4.
    """

    stages: Any
    extension: Any
    trial: Any
    slope: Any
    xd: Any
    xd_slope: Any
    jacobian: Any
    gradient: Any
    after_reset: Any
    crossing: Any
    found_side: Any
    bernstein: Any
    stack: Any


# All of an integration in plain numbers and pointers: what System, Values and Memory hold under the same names, with lengths as n_...,
# the ring's length less one as mask, the log's arrays as log_... and event_..., and Work. Arrays of several dimensions lie row by row.
Core = namedtuple("Core", """
    field event reset history field_jacobian event_jacobian reset_jacobian n n_full dimension tangent n_pairs n_delays n_kept
    n_segments n_events pair_state pair_delay kept place segment_mode segment_event segment_direction segment_reset segment_to
    after reads chain_order chain_n section section_direction stop_event stiff p tau event_delay max_step rtol atol longest
    stick clock count y constant mask past_time past_length past_end past_arc past_shift past_value past_coefficients cursor
    reading pending_time pending_event pending_shift breaking_time breaking_level accumulation hits side next_step log_steps
    log_events log_n log_time log_length log_end log_mode log_arc log_value log_coefficients event_time event_segment
    event_arc event_before event_after stages extension trial slope xd xd_slope jacobian gradient after_reset crossing
    found_side bernstein stack
""")


# Places in Memory.clock.
T, T_START, ZENO_TIME, SHIFT, TURN = 0, 1, 2, 3, 4
N_CLOCK = 5
# Places in Memory.count.
MODE, FIRST, USED, ARC, N_STEPS, N_REJECTED, N_PENDING, N_BREAKING, FRESH, AT_ONCE, CONSTANT, READY, LAST_EVENT, UNRESOLVED = range(14)
N_COUNT = 14


@either
def new_memory(system, values):
    """Return the memory of an integration that has not begun."""
    room = 32
    while room < 4 * (len(values.tau) + 8):
        room *= 2
    n_past = len(system.kept) * (1 + system.tangent)
    n_events = len(system.after)
    dimension = system.n_full * (1 + system.tangent)
    accumulation = np.zeros((n_events, 4))
    accumulation[:, 0] = -np.inf
    reading = np.zeros(len(values.tau), np.int64)
    reading[:] = -1
    return Memory(
        np.zeros(N_CLOCK), np.zeros(N_COUNT, np.int64), np.zeros(dimension), np.zeros(system.n), np.zeros(room), np.zeros(room),
        np.zeros(room), np.zeros(room, np.int64), np.zeros(room), np.zeros((room, n_past)), np.zeros((room, N_COEFFICIENTS, n_past)),
        np.zeros(len(values.tau), np.int64), reading, np.zeros(room), np.zeros(room, np.int64), np.zeros(room), np.zeros(room),
        np.zeros(room, np.int64), accumulation, np.zeros(len(system.segment_mode), np.int64),
        np.zeros(len(system.segment_mode) + 1, np.int64), np.zeros(system.n_modes))  # fmt: skip


@either
def new_log(n, steps, events):
    """Return a log with room for so many steps and events."""
    return Log(np.zeros(2, np.int64), np.zeros(steps), np.zeros(steps), np.zeros(steps), np.zeros(steps, np.int64),
               np.zeros(steps, np.int64), np.zeros((steps, n)), np.zeros((steps, N_COEFFICIENTS, n)), np.zeros(events),
               np.zeros(events, np.int64), np.zeros(events, np.int64), np.zeros((events, n)), np.zeros((events, n)))  # fmt: skip


def new_returns(system, n, max_period):
    """Return room for ``n`` returns."""
    hits, running = np.zeros((n, len(system.segment_mode)), np.int64), np.zeros(max_period + 1, np.int64)
    return Returns(np.zeros((n, 2 * system.n)), np.zeros(n), hits, np.zeros((n, max_period + 1)), running, np.zeros(1, np.int64),
                   np.full(1, np.nan))  # fmt: skip


def new_work(system):
    """Return room for intermediate results."""
    n, m = system.n, len(system.pair_state)
    dimension = system.n_full * (1 + system.tangent)
    return Work(np.zeros(16 * dimension), np.zeros(N_COEFFICIENTS * dimension), np.zeros(3 * dimension), np.zeros(3 * dimension),
                np.zeros(m + 1), np.zeros(m + 1), np.zeros(n * (n + m + 1)), np.zeros(n + m + 2), np.zeros(n + 1),
                np.zeros(len(system.after) + 1, np.int64), np.zeros(len(system.segment_mode) + 1, np.int64), np.zeros(640),
                np.zeros(256))  # fmt: skip


@inner
def core(s, v, m, log, w):
    """Return an integration in plain numbers and pointers; all that it points to has to outlive it."""
    return Core(
        s.field, s.event, s.reset, s.history, s.field_jacobian, s.event_jacobian, s.reset_jacobian, s.n, s.n_full, len(m.y), s.tangent,
        len(s.pair_state), len(v.tau), len(s.kept), len(s.segment_mode), len(s.after), pointer(s.pair_state), pointer(s.pair_delay),
        pointer(s.kept), pointer(s.place), pointer(s.segment_mode), pointer(s.segment_event), pointer(s.segment_direction),
        pointer(s.segment_reset), pointer(s.segment_to), pointer(s.after), pointer(s.reads), s.chain_order, s.chain_n, s.section,
        s.section_direction, s.stop_event, s.stiff, pointer(v.p), pointer(v.tau), pointer(v.event_delay), v.max_step, v.rtol, v.atol,
        v.longest, pointer(v.stick), pointer(m.clock), pointer(m.count), pointer(m.y), pointer(m.constant), len(m.past_time) - 1,
        pointer(m.past_time), pointer(m.past_length), pointer(m.past_end), pointer(m.past_arc), pointer(m.past_shift),
        pointer(m.past_value), pointer(m.past_coefficients), pointer(m.cursor), pointer(m.reading), pointer(m.pending_time),
        pointer(m.pending_event), pointer(m.pending_shift), pointer(m.breaking_time), pointer(m.breaking_level),
        pointer(m.accumulation), pointer(m.hits), pointer(m.side), pointer(m.next_step), len(log.time), len(log.event_time), pointer(log.n),
        pointer(log.time), pointer(log.length), pointer(log.end), pointer(log.mode), pointer(log.arc), pointer(log.value),
        pointer(log.coefficients), pointer(log.event_time), pointer(log.event_segment), pointer(log.event_arc),
        pointer(log.before), pointer(log.after), pointer(w.stages), pointer(w.extension), pointer(w.trial), pointer(w.slope),
        pointer(w.xd), pointer(w.xd_slope), pointer(w.jacobian), pointer(w.gradient), pointer(w.after_reset), pointer(w.crossing),
        pointer(w.found_side), pointer(w.bernstein), pointer(w.stack))  # fmt: skip


@either
def _longer(a):
    b = np.zeros(2 * len(a), a.dtype)
    b[: a.shape[0]] = a
    return b


@either
def enlarged(m):
    """Return a memory with twice the room; the ring's steps lie again at their number modulo its size."""
    old, new = len(m.past_time), 2 * len(m.past_time)
    time, length, end = np.zeros(new), np.zeros(new), np.zeros(new)
    arc, shift = np.zeros(new, np.int64), np.zeros(new)
    value = np.zeros((new, m.past_value.shape[1]))
    coefficients = np.zeros((new, m.past_coefficients.shape[1], m.past_coefficients.shape[2]))
    for number in range(m.count[FIRST], m.count[FIRST] + m.count[USED]):
        i, j = number % old, number % new
        time[j], length[j], end[j] = m.past_time[i], m.past_length[i], m.past_end[i]
        arc[j], shift[j] = m.past_arc[i], m.past_shift[i]
        value[j] = m.past_value[i]
        coefficients[j] = m.past_coefficients[i]
    return Memory(m.clock, m.count, m.y, m.constant, time, length, end, arc, shift, value, coefficients, m.cursor, m.reading,
                  _longer(m.pending_time), _longer(m.pending_event), _longer(m.pending_shift), _longer(m.breaking_time),
                  _longer(m.breaking_level), m.accumulation, m.hits, m.side, m.next_step)  # fmt: skip
