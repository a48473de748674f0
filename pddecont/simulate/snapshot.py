"""The state of an integration as one row of numbers, to be kept in a file and gone on from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.model.codegen import NumericModel
from pddecont.simulate.kernel.tables import (
    FIRST,
    LAST_EVENT,
    MODE,
    N_BREAKING,
    N_COEFFICIENTS,
    N_PENDING,
    READY,
    SHIFT,
    T_START,
    TURN,
    USED,
    ZENO_TIME,
    Memory,
    System,
    T,
    Values,
    enlarged,
    new_memory,
)

Array = NDArray[np.float64]


def pack(memory: Memory) -> Array:
    """Return all that is needed to go on: clock, counters, variables, the past as far as delays reach, what is under way."""
    first, used = int(memory.count[FIRST]), int(memory.count[USED])
    ring = np.arange(first, first + used) % len(memory.past_time)
    pending, breaking = slice(int(memory.count[N_PENDING])), slice(int(memory.count[N_BREAKING]))
    parts = [memory.clock, memory.count, memory.y, memory.constant, memory.reading, memory.accumulation, memory.hits, memory.side,
             memory.next_step, memory.past_time[ring], memory.past_length[ring], memory.past_end[ring],
             memory.past_arc[ring], memory.past_value[ring], memory.past_coefficients[ring], memory.pending_time[pending],
             memory.pending_event[pending], memory.breaking_time[breaking], memory.breaking_level[breaking]]  # fmt: skip
    return np.concatenate([np.ravel(part).astype(float) for part in parts])


def unpack(system: System, values: Values, row: Array) -> Memory:
    """Return the state of an integration from :func:`pack`; with a tangent in ``system`` the tangent is zero.

    Raises
    ------
    ValueError
        If the row is not the state of an integration of this system: machine code would read and write anywhere with it.
    """
    memory = new_memory(system, values)
    left = np.array(row)

    def take(shape: tuple[int, ...]) -> Array:
        nonlocal left
        size = int(np.prod(shape))
        if size > len(left):
            raise ValueError("the recorded state of the integration is too short")
        part, left = left[:size], left[size:]
        return part.reshape(shape)

    memory.clock[:] = take(memory.clock.shape)
    memory.count[:] = _whole(take(memory.count.shape))
    memory.y[: system.n_full] = take((system.n_full,))
    for target in (memory.constant, memory.reading, memory.accumulation, memory.hits, memory.side, memory.next_step):
        part = take(target.shape)
        target[:] = part if target.dtype.kind == "f" else _whole(part)
    _check_counts(system, memory, len(row))
    first, used, kept = int(memory.count[FIRST]), int(memory.count[USED]), len(system.kept)
    n_pending, n_breaking = int(memory.count[N_PENDING]), int(memory.count[N_BREAKING])
    # An empty memory grows without its ring having to be moved.
    memory.count[USED] = 0
    while len(memory.past_time) <= max(used, n_pending, n_breaking) + 2:
        memory = enlarged(memory)
    memory.count[USED] = used
    ring = np.arange(first, first + used) % len(memory.past_time)
    for target in (memory.past_time, memory.past_length, memory.past_end):
        target[ring] = take((used,))
    memory.past_arc[ring] = _whole(take((used,)))
    memory.past_value[ring, :kept] = take((used, kept))
    memory.past_coefficients[ring, :, :kept] = take((used, N_COEFFICIENTS, kept))
    memory.pending_time[:n_pending], memory.pending_event[:n_pending] = take((n_pending,)), _whole(take((n_pending,)))
    memory.breaking_time[:n_breaking], memory.breaking_level[:n_breaking] = take((n_breaking,)), _whole(take((n_breaking,)))
    if len(left) or np.any((memory.pending_event < 0) | (memory.pending_event >= max(1, len(system.after)))):
        raise ValueError("the recorded state of the integration is not one of this model")
    memory.count[READY] = 0
    memory.clock[SHIFT] = 0.0
    return memory


def _whole(part: Array) -> Array:
    """Return numbers that count or name something, or raise if they cannot."""
    if not np.all(np.abs(part) < 2.0**53):
        raise ValueError("the recorded state of the integration is not one of this model")
    return part


def _check_counts(system: System, memory: Memory, length: int) -> None:
    """Check all numbers that count or name something: how much of each there is, the mode, events, steps read last."""
    count = memory.count
    sizes = count[[FIRST, USED, N_PENDING, N_BREAKING]]
    if np.any(sizes < 0) or np.any(sizes[1:] > length) or not 0 <= count[MODE] < system.n_modes:
        raise ValueError("the recorded state of the integration is not one of this model")
    if not -1 <= count[LAST_EVENT] <= len(system.after):
        raise ValueError("the recorded state of the integration is not one of this model")


def restart_time(numeric: NumericModel, before: Array, after: Array, t: float) -> float:
    """Return the time within one forcing period at which a motion goes on with other parameters: in the same phase."""
    if not numeric.model.forced:
        return 0.0
    turns = t / float(numeric.period.value(before)[0])
    # A return at a phase is at that phase, whatever rounding made of it on the way.
    return float(round(turns % 1.0, 12) % 1.0) * float(numeric.period.value(after)[0])


def moved(memory: Memory, t: float) -> Memory:
    """Return an integration whose clock, with all times it keeps, is set so that it stands at ``t``."""
    back = float(memory.clock[T]) - t
    for place in (T, T_START, ZENO_TIME, TURN):
        memory.clock[place] -= back
    for times in (memory.past_time, memory.past_end, memory.pending_time, memory.breaking_time, memory.accumulation[:, 0]):
        times -= back
    return memory
