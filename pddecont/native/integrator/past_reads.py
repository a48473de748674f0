"""Delayed values, rates and integrals in general: lags vary, and may be shorter than a step.

Lags are evaluated wherever something is read, in an order in which each follows what it depends on. What a step reads
of itself is an extension of it that is held: :mod:`overlap` repeats the step until that is its own.
"""

from __future__ import annotations

from pddecont.native.arrays import Floats
from pddecont.native.calls import call, offset
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.pieces import HISTORY, has_steps, stay_in_piece
from pddecont.native.integrator.places import (
    FIRST,
    HELD,
    HELD_LENGTH,
    IN_STEP,
    KNOWN_FROM,
    LONGEST,
    N_COEFFICIENTS,
    OVERLAPS,
    PIECE,
    UNKNOWN,
    USED,
    T,
)
from pddecont.native.integrator.quadrature import (
    DERIVATIVE_IN_LAG,
    INTEGRAND,
    TANGENT,
    evaluate_integrand_at,
    integrate_past,
)
from pddecont.native.integrator.ring import (
    evaluate_extension,
    evaluate_extension_derivative,
    evaluate_extension_slope,
    evaluate_history,
    time_tolerance,
)

# What is evaluated in turn.
LAG, VALUE, INTEGRAL = 0, 1, 2
# The past is kept as far as so many of the longest lags so far reach, and never fewer steps than this: a lag that grows
# faster ends the integration. Both are far more than lags that stay bounded need.
KEPT_LAGS, KEPT_STEPS = 4.0, 256


def read_past(c: Core, t: float, y: Floats, xd: Floats, part: int) -> None:
    """Write what is read at ``t`` to ``xd``: of the states (``part`` 0) or of the tangent (1).

    The tangent is read by the lags that the states were read by before.
    """
    for place in range(c.n_first_turns):
        _take_turn(c, t, y, xd, place, part)


def read_for_derivatives(c: Core, t: float, y: Floats, xd: Floats) -> None:
    """Write what only derivatives need of what is read at ``t`` to ``xd``, after :func:`read_past`."""
    for place in range(c.n_first_turns, c.n_turns):
        _take_turn(c, t, y, xd, place, 0)


def _take_turn(c: Core, t: float, y: Floats, xd: Floats, place: int, part: int) -> None:
    kind, i = c.turn_kind[place], c.turn_number[place]
    if kind == VALUE:
        xd[i] = _read_value(c, t, y, y, i, 0, part)
    elif kind == LAG:
        if part == 0:
            _evaluate_lag(c, t, y, xd, i)
    else:
        low, high = _find_limit(c, c.low[i]), _find_limit(c, c.high[i])
        xd[c.n_values + i] = integrate_past(c, t, y, i, low, high, INTEGRAND if part == 0 else TANGENT)


def read_past_slopes(c: Core, t: float, y: Floats, dy: Floats, slopes: Floats) -> None:
    """Write the time derivatives, by lags that stand still, of what is read at ``t``; ``dy`` are those of ``y``."""
    for place in range(c.n_first_turns):
        kind, i = c.turn_kind[place], c.turn_number[place]
        if kind == VALUE:
            slopes[i] = _read_value(c, t, y, dy, i, 1, 0)
        if kind != INTEGRAL:
            continue
        q = i
        low, high = _find_limit(c, c.low[q]), _find_limit(c, c.high[q])
        slope = integrate_past(c, t, y, q, low, high, DERIVATIVE_IN_LAG)
        slope += evaluate_integrand_at(c, t, y, q, low) - evaluate_integrand_at(c, t, y, q, high)
        slopes[c.n_values + q] = slope


def find_lag(c: Core, slot: int) -> float:
    """Return the lag of a slot, as it was evaluated last."""
    return c.tau[slot] if slot < c.n_delays else c.lag[slot - c.n_delays]


def _find_limit(c: Core, slot: int) -> float:
    return 0.0 if slot < 0 else find_lag(c, slot)


def _evaluate_lag(c: Core, t: float, y: Floats, xd: Floats, k: int) -> None:
    """Evaluate lag ``k`` of those that vary; within a step note the times that it reads, else choose its piece."""
    c.integrand[0] = 0.0
    call(c.lags, k, t, y, xd, c.p, c.integrand)
    c.lag[k] = c.integrand[0]
    there, slot = t - c.lag[k], c.n_delays + k
    if c.lag_count[IN_STEP] == 1:
        c.lag_least[k], c.lag_most[k] = min(c.lag_least[k], there), max(c.lag_most[k], there)
    else:
        c.reading[slot] = stay_in_piece(c, c.reading[slot], there)


def _read_value(c: Core, t: float, y: Floats, dy: Floats, i: int, more: int, part: int) -> float:
    """Return delayed value ``i``, differentiated ``more`` times again; at no lag at all ``y``, or ``dy``.

    The tangent has its own variables in ``y``.
    """
    state, slot, order = c.pair_state[i], c.pair_delay[i], c.pair_derivative[i] + more
    lag, first = find_lag(c, slot), part * c.n_full
    varies = slot >= c.n_delays
    if lag == 0.0 or (varies and abs(lag) <= time_tolerance(t)):
        if order == 0:
            return y[first + state]
        if c.pair_derivative[i] == 0 and more == 1:
            return dy[first + state]
    there, piece = t - lag, c.reading[slot]
    if there < c.lag_time[KNOWN_FROM] - time_tolerance(t):
        c.lag_count[UNKNOWN] = 1
    if piece == HISTORY:
        return 0.0 if part == 1 else evaluate_history(c, order, there, state)
    if varies and piece == c.lag_count[PIECE]:
        if there > c.clock[T] + time_tolerance(t):
            c.lag_count[OVERLAPS] = 1
        if c.lag_count[HELD] == 1 and there >= c.clock[T]:
            return _evaluate_held(c, first + state, there, order)
        if not has_steps(c, piece):
            return c.y[first + state] if order == 0 else c.fresh_slope[first + state] if order == 1 else 0.0
    n_past, column = c.n_kept * (1 + c.tangent), part * c.n_kept + c.place[state]
    j = find_step(c, there, slot) & c.mask
    value, length = c.past_value[j * n_past + column], c.past_length[j]
    coefficients = offset(c.past_coefficients, j * N_COEFFICIENTS * n_past + column)
    s = (there - c.past_time[j]) / length
    if order == 0:
        return evaluate_extension(value, coefficients, n_past, s)
    if order == 1:
        return evaluate_extension_slope(coefficients, n_past, s) / length
    return evaluate_extension_derivative(value, coefficients, n_past, s, order) / length**order


def _evaluate_held(c: Core, variable: int, t: float, order: int) -> float:
    """Return a variable, or its derivative, on the extension of the present step that is held."""
    length = c.lag_time[HELD_LENGTH]
    s = (t - c.clock[T]) / length
    held = offset(c.held, variable)
    return evaluate_extension_derivative(c.y[variable], held, c.dimension, s, order) / length**order


def find_step(c: Core, t: float, slot: int) -> int:
    """Return the number of the step that a lag reads at ``t``, in the arc, or the piece, that was chosen for it.

    Times outside read the polynomials at its ends.
    """
    first, end = c.count[FIRST], c.count[FIRST] + c.count[USED]
    part, chosen = c.past_arc if slot < c.n_delays else c.past_piece, c.reading[slot]
    number = min(max(c.cursor[slot], first), end - 1)
    while number > first and part[number & c.mask] > chosen:
        number -= 1
    while number + 1 < end and part[number & c.mask] < chosen:
        number += 1
    while number + 1 < end and part[(number + 1) & c.mask] == chosen and c.past_time[(number + 1) & c.mask] <= t:
        number += 1
    while number > first and part[(number - 1) & c.mask] == chosen and c.past_time[number & c.mask] > t:
        number -= 1
    c.cursor[slot] = number
    return number


def drop_past(c: Core, end: float) -> None:
    """Drop the steps that lags do not reach any more unless they grow; note from when on the past is known."""
    for k in range(c.n_varying):
        c.lag_time[LONGEST] = max(c.lag_time[LONGEST], c.lag[k])
    longest = max(c.longest, KEPT_LAGS * c.lag_time[LONGEST])
    while c.count[USED] > KEPT_STEPS and c.past_end[c.count[FIRST] & c.mask] < end - longest - time_tolerance(end):
        c.count[FIRST] += 1
        c.count[USED] -= 1
        c.lag_time[KNOWN_FROM] = c.past_time[c.count[FIRST] & c.mask]
