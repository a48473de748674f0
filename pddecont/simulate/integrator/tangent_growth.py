"""How fast the tangent of a motion grows: what largest Lyapunov exponents are made of."""

from __future__ import annotations

import math

import numpy as np

from pddecont.simulate.integrator.advance import advance
from pddecont.simulate.integrator.buffers import N_COEFFICIENTS, make_log
from pddecont.simulate.integrator.calls import entry, internal
from pddecont.simulate.integrator.core import make_core
from pddecont.simulate.integrator.poincare import STEPS
from pddecont.simulate.integrator.state import FIRST, LONGEST, N_PENDING, READY, SHIFT, USED, T
from pddecont.simulate.integrator.status import Status


@entry
def measure_growth(system, values, state, work, interval, logs, done):
    """Write the logarithm of the growth of the tangent over each of ``len(logs)`` intervals; return a status.

    CAPACITY asks for a larger state. ``done`` (2,) keeps for the next call how many intervals are done and when the
    present one ends (NaN: none is under way); it begins with (0, NaN).
    """
    log = make_log(0, 0, 0)
    if done[0] == 0.0 and math.isnan(done[1]):
        _rescale_tangent(system, values, state)
    for k in range(int(done[0]), len(logs)):
        if math.isnan(done[1]):
            done[1] = state.clock[T] + interval
        status = Status.SECTION
        while status == Status.SECTION:
            state.count[READY] = 0
            status = advance(make_core(system, values, state, log, work), done[1], STEPS)
        if status != Status.REACHED:
            return np.int64(status)
        logs[k] = _rescale_tangent(system, values, state)
        done[0], done[1] = k + 1.0, math.nan
        if not math.isfinite(logs[k]):
            break
    return np.int64(Status.REACHED)


@internal
def _rescale_tangent(system, values, state):
    """Make the tangent, with its past, of length 1; return the logarithm of the length that it had.

    Where lags vary more of the past is kept than they are known to read: its length is that of what they read.
    """
    full, kept = system.n_full, len(system.kept)
    mask = len(state.past_time) - 1
    length = 0.0
    for i in range(full):
        length = max(length, abs(state.y[full + i]))
    numbers = range(state.count[FIRST], state.count[FIRST] + state.count[USED])
    since = state.clock[T] - max(values.longest, state.lag_time[LONGEST]) if system.n_varying > 0 else -math.inf
    for number in numbers:
        for k in range(kept if state.past_end[number & mask] >= since else 0):
            length = max(length, abs(state.past_value[number & mask, kept + k]))
    if length == 0.0 or not math.isfinite(length):
        return -math.inf if length == 0.0 else math.inf
    for i in range(full):
        state.y[full + i] /= length
    for number in numbers:
        j = number & mask
        state.past_shift[j] /= length
        for k in range(kept):
            state.past_value[j, kept + k] /= length
            for i in range(N_COEFFICIENTS):
                state.past_coefficients[j, i, kept + k] /= length
    for k in range(state.count[N_PENDING]):
        state.pending_shift[k] /= length
    state.clock[SHIFT] /= length
    return math.log(length)
