"""The state of an integration as one row of numbers, which files keep, and integrations that go on from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.native.integrator import (
    FIRST,
    KNOWN_FROM,
    LAST_EVENT,
    LAST_EVENT_TIME,
    LAST_TURN,
    MODE,
    N_BREAKING,
    N_COEFFICIENTS,
    N_PENDING,
    PIECE_SIZE,
    PIECE_START,
    READY,
    SHIFT,
    T_START,
    USED,
    ZENO_TIME,
    T,
)
from pddecont.simulate.integrator import IntegratorState, ParameterValues, System, enlarge, make_state

Array = NDArray[np.float64]
# Floats are whole numbers up to here.
LARGEST_WHOLE = 2.0**53
# A return at a phase is at that phase whatever rounding made of it on the way.
PHASE_DIGITS = 12
NOT_THIS_MODEL = "the recorded state of the integration is not one of this model"


def pack(state: IntegratorState) -> Array:
    """Return all that an integration needs to go on, shape (n_numbers,).

    That is the clock, the counters, all variables, the past as far as delays reach, and what is under way. A tangent is
    not kept: the state has none.
    """
    first, used = int(state.count[FIRST]), int(state.count[USED])
    ring = np.arange(first, first + used) % len(state.past_time)
    pending, breaking = slice(int(state.count[N_PENDING])), slice(int(state.count[N_BREAKING]))
    parts = [
        state.clock,
        state.count,
        state.y,
        state.constant,
        state.reading,
        state.accumulation,
        state.segment_counts,
        state.side,
        state.next_step,
        state.past_time[ring],
        state.past_length[ring],
        state.past_end[ring],
        state.past_arc[ring],
        state.past_value[ring],
        state.past_coefficients[ring],
        state.pending_time[pending],
        state.pending_event[pending],
        state.breaking_time[breaking],
        state.breaking_level[breaking],
    ]
    # What only lags that vary, rates and integrals need is not kept of other models.
    if state.lag_time[PIECE_SIZE] > 0.0:
        parts += [state.lag_time, state.lag_count, state.breaking_size[breaking]]
        parts += [state.past_piece[ring], state.past_level[ring], state.past_size[ring]]
    return np.concatenate([np.ravel(part).astype(float) for part in parts])


def unpack(system: System, values: ParameterValues, row: Array) -> IntegratorState:
    """Return the state of an integration from what :func:`pack` returned; a tangent of ``system`` is zero.

    Raises
    ------
    ValueError
        If the row is not the state of an integration of this system: machine code would read and write anywhere with
        it.
    """
    state = make_state(system, values)
    left = np.array(row)

    def take(shape: tuple[int, ...]) -> Array:
        nonlocal left
        size = int(np.prod(shape))
        if size > len(left):
            raise ValueError("the recorded state of the integration is too short")
        part, left = left[:size], left[size:]
        return part.reshape(shape)

    state.clock[:] = take(state.clock.shape)
    state.count[:] = _check_whole(take(state.count.shape))
    state.y[: system.n_full] = take((system.n_full,))
    for target in (
        state.constant,
        state.reading,
        state.accumulation,
        state.segment_counts,
        state.side,
        state.next_step,
    ):
        part = take(target.shape)
        target[:] = part if target.dtype.kind == "f" else _check_whole(part)
    _check_counts(system, state, len(row))
    first, used, kept = int(state.count[FIRST]), int(state.count[USED]), len(system.kept)
    n_pending, n_breaking = int(state.count[N_PENDING]), int(state.count[N_BREAKING])
    # An empty past grows without its steps being copied.
    state.count[USED] = 0
    while len(state.past_time) <= max(used, n_pending, n_breaking) + 2:
        state = enlarge(state)
    state.count[USED] = used
    ring = np.arange(first, first + used) % len(state.past_time)
    for target in (state.past_time, state.past_length, state.past_end):
        target[ring] = take((used,))
    state.past_arc[ring] = _check_whole(take((used,)))
    state.past_value[ring, :kept] = take((used, kept))
    state.past_coefficients[ring, :, :kept] = take((used, N_COEFFICIENTS, kept))
    state.pending_time[:n_pending], state.pending_event[:n_pending] = (
        take((n_pending,)),
        _check_whole(take((n_pending,))),
    )
    state.breaking_time[:n_breaking], state.breaking_level[:n_breaking] = (
        take((n_breaking,)),
        _check_whole(take((n_breaking,))),
    )
    if system.is_general:
        state.lag_time[:], state.lag_count[:] = take(state.lag_time.shape), _check_whole(take(state.lag_count.shape))
        state.breaking_size[:n_breaking] = take((n_breaking,))
        for numbers in (state.past_piece, state.past_level):
            numbers[ring] = _check_whole(take((used,)))
        state.past_size[ring] = take((used,))
    if len(left) or np.any((state.pending_event < 0) | (state.pending_event >= max(1, len(system.after)))):
        raise ValueError(NOT_THIS_MODEL)
    state.count[READY] = 0
    state.clock[SHIFT] = 0.0
    return state


def _check_whole(part: Array) -> Array:
    """Return numbers that count or name something, or raise ValueError if they cannot."""
    if not np.all(np.abs(part) < LARGEST_WHOLE):
        raise ValueError(NOT_THIS_MODEL)
    return part


def _check_counts(system: System, state: IntegratorState, length: int) -> None:
    """Raise ValueError if numbers that count or name something cannot: capacities, the mode, the last event."""
    count = state.count
    sizes = count[[FIRST, USED, N_PENDING, N_BREAKING]]
    if np.any(sizes < 0) or np.any(sizes[1:] > length) or not 0 <= count[MODE] < system.n_modes:
        raise ValueError(NOT_THIS_MODEL)
    if not -1 <= count[LAST_EVENT] <= len(system.after):
        raise ValueError(NOT_THIS_MODEL)


def find_restart_time(numeric: NumericModel, before: Array, after: Array, t: float) -> float:
    """Return the time at which a motion goes on with parameters ``after`` instead of ``before``.

    It is within a forcing period, in the phase that ``t`` had before; 0 in an autonomous model.
    """
    if not numeric.model.forced:
        return 0.0
    turns = t / float(numeric.period.value(before)[0])
    return float(round(turns % 1.0, PHASE_DIGITS) % 1.0) * float(numeric.period.value(after)[0])


def read_time(state: IntegratorState) -> float:
    """Return how far an integration has come."""
    return float(state.clock[T])


def shift_time(state: IntegratorState, t: float) -> IntegratorState:
    """Return an integration set to the time ``t``, with all the times that it keeps."""
    back = read_time(state) - t
    for place in (T, T_START, ZENO_TIME, LAST_EVENT_TIME):
        state.clock[place] -= back
    for place in (PIECE_START, KNOWN_FROM, LAST_TURN):
        state.lag_time[place] -= back
    for times in (state.past_time, state.past_end, state.pending_time, state.breaking_time, state.accumulation[:, 0]):
        times -= back
    return state
