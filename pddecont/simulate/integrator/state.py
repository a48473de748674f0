"""The state of an integration: all that changes while it goes on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pddecont.native.integrator import (
    ADVANCED,
    FIRST,
    KNOWN_FROM,
    LAST_TURN,
    N_CLOCK,
    N_COEFFICIENTS,
    N_COUNT,
    N_LAG_COUNT,
    N_LAG_TIME,
    USED,
)
from pddecont.simulate.integrator.system import ParameterValues, System

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
# Steps that the past holds at first, and how many for each delay; both only save copies while the past grows.
FIRST_CAPACITY, CAPACITY_PER_DELAY = 32, 4


class IntegratorState(NamedTuple):
    """The state of an integration; all of it is arrays that change in place.

    Attributes
    ----------
    clock, count
        Times and numbers by the places that :mod:`pddecont.native.integrator.places` names (N_CLOCK,), (N_COUNT,).
    y
        States, variables of the chain, and the tangent of both (dimension,).
    constant
        The states that are the history if it is constant (n,).
    past_time, past_length, past_end, past_arc, past_shift, past_value, past_coefficients
        The past, a ring of steps whose length is a power of two: where a step begins, how long it was, where it ends
        (an event may cut it), the arc that it belongs to, how much later that arc began for the tangent, and the
        continuous extension of the states that are kept (capacity, n_kept), (capacity, N_COEFFICIENTS, n_kept).
    cursor, reading
        The step that each delay read last, and the arc that it reads in the present step (n_delays,); of a lag that
        varies its piece (n_delays + n_varying,). Those of integrals follow among the former.
    pending_time, pending_event, pending_shift
        Delayed events under way, in order of time (capacity,).
    breaking_time, breaking_level
        Breaking points to come, in order of time, and which derivative jumps there (capacity,).
    accumulation
        For each event the time of the last one, the gap before it, the ratio of the last two gaps, and how many
        ratios in a row were nearly equal (n_events, 4).
    segment_counts
        How often each segment has ended (n_segments,).
    side
        The sign of each segment's event function, and last the section's (n_segments + 1,); 0: it has just been zero.
    residue
        How far from zero its last event left each of these functions: so far they count as zero (n_segments + 1,).
    next_step
        The length that the next step may have in each mode (n_modes,); 0: none was made there.
    past_piece, past_level, past_size
        Of each step of the past its piece, between one jump in a derivative and the next, which derivative jumps where
        the piece begins, and how large at most its rate jumps there, relative to the jump at an event (capacity,).
    breaking_size
        The same of breaking points to come (capacity,).
    lag_time, lag_count
        Times and numbers of lags that vary, of rates and of integrals, by the places named there.
    resume
        1 if the events of the present moment are not all handled, the event that has to come next (-1: any), and the
        status to come back with when they are, and the segment
        after which a surface may repel the motion (-1: none) (4,).
    """

    clock: Array
    count: Integers  # type: ignore[assignment]
    y: Array
    constant: Array
    past_time: Array
    past_length: Array
    past_end: Array
    past_arc: Integers
    past_shift: Array
    past_value: Array
    past_coefficients: Array
    cursor: Integers
    reading: Integers
    pending_time: Array
    pending_event: Integers
    pending_shift: Array
    breaking_time: Array
    breaking_level: Integers
    accumulation: Array
    segment_counts: Integers
    side: Integers
    residue: Array
    next_step: Array
    resume: Integers
    past_piece: Integers
    past_level: Integers
    past_size: Array
    breaking_size: Array
    lag_time: Array
    lag_count: Integers


def make_state(system: System, values: ParameterValues, n_steps: int = 0) -> IntegratorState:
    """Return the state of an integration that has not begun, with room for ``n_steps`` steps in its past or more."""
    capacity = FIRST_CAPACITY
    while capacity < max(CAPACITY_PER_DELAY * (len(values.tau) + 8), n_steps):
        capacity *= 2
    n_past = len(system.kept) * (1 + system.tangent)
    n_events = len(system.after)
    dimension = system.n_full * (1 + system.tangent)
    accumulation = np.zeros((n_events, 4))
    accumulation[:, 0] = -np.inf
    n_slots = len(values.tau) + system.n_varying
    reading = np.zeros(n_slots, np.int64)
    reading[:] = -1
    lag_time = np.zeros(N_LAG_TIME)
    lag_time[KNOWN_FROM] = lag_time[LAST_TURN] = -np.inf
    lag_count = np.zeros(N_LAG_COUNT, np.int64)
    lag_count[ADVANCED] = -1
    return IntegratorState(
        np.zeros(N_CLOCK),
        np.zeros(N_COUNT, np.int64),
        np.zeros(dimension),
        np.zeros(system.n),
        np.zeros(capacity),
        np.zeros(capacity),
        np.zeros(capacity),
        np.zeros(capacity, np.int64),
        np.zeros(capacity),
        np.zeros((capacity, n_past)),
        np.zeros((capacity, N_COEFFICIENTS, n_past)),
        np.zeros(n_slots + system.n_integrals, np.int64),
        reading,
        np.zeros(capacity),
        np.zeros(capacity, np.int64),
        np.zeros(capacity),
        np.zeros(capacity),
        np.zeros(capacity, np.int64),
        accumulation,
        np.zeros(len(system.segment_mode), np.int64),
        np.zeros(len(system.segment_mode) + 1, np.int64),
        np.zeros(len(system.segment_mode) + 1),
        np.zeros(system.n_modes),
        np.zeros(4, np.int64),
        np.zeros(capacity, np.int64),
        np.zeros(capacity, np.int64),
        np.zeros(capacity),
        np.zeros(capacity),
        lag_time,
        lag_count,
    )


def _double(a: NDArray[Any]) -> NDArray[Any]:
    b = np.zeros(2 * len(a), a.dtype)
    b[: a.shape[0]] = a
    return b


def enlarge(state: IntegratorState) -> IntegratorState:
    """Return the state with twice the capacity; a step of the past is again at its number modulo the capacity."""
    old, new = len(state.past_time), 2 * len(state.past_time)
    time, length, end = np.zeros(new), np.zeros(new), np.zeros(new)
    arc, shift = np.zeros(new, np.int64), np.zeros(new)
    value = np.zeros((new, state.past_value.shape[1]))
    piece, level, size = np.zeros(new, np.int64), np.zeros(new, np.int64), np.zeros(new)
    coefficients = np.zeros((new, state.past_coefficients.shape[1], state.past_coefficients.shape[2]))
    for number in range(state.count[FIRST], state.count[FIRST] + state.count[USED]):
        i, j = number % old, number % new
        time[j], length[j], end[j] = state.past_time[i], state.past_length[i], state.past_end[i]
        arc[j], shift[j] = state.past_arc[i], state.past_shift[i]
        piece[j], level[j], size[j] = state.past_piece[i], state.past_level[i], state.past_size[i]
        value[j] = state.past_value[i]
        coefficients[j] = state.past_coefficients[i]
    return IntegratorState(
        state.clock,
        state.count,
        state.y,
        state.constant,
        time,
        length,
        end,
        arc,
        shift,
        value,
        coefficients,
        state.cursor,
        state.reading,
        _double(state.pending_time),
        _double(state.pending_event),
        _double(state.pending_shift),
        _double(state.breaking_time),
        _double(state.breaking_level),
        state.accumulation,
        state.segment_counts,
        state.side,
        state.residue,
        state.next_step,
        state.resume,
        piece,
        level,
        size,
        _double(state.breaking_size),
        state.lag_time,
        state.lag_count,
    )
