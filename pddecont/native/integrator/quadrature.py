"""Integrals over the past: Gauss-Kronrod quadrature over its steps, each cut at the limits, halved where need be.

Reference: Piessens, de Doncker-Kapenga, Überhuber, Kahaner, QUADPACK (1983), rule QK15.
"""

from __future__ import annotations

from math import isfinite

import numpy as np

from pddecont.native.integrator.calls import call, offset
from pddecont.native.integrator.core import Core, Floats
from pddecont.native.integrator.places import (
    FIRST,
    HELD,
    HELD_LENGTH,
    KNOWN_FROM,
    N_COEFFICIENTS,
    OVERLAPS,
    PIECE,
    T_START,
    UNKNOWN,
    USED,
    T,
)
from pddecont.native.integrator.ring import evaluate_extension, evaluate_history, find_step_before, time_tolerance

# What is integrated: g, its derivative in the lag, and that in the states times the tangent.
INTEGRAND, DERIVATIVE_IN_LAG, TANGENT = 0, 1, 2
# Nodes of Kronrod's rule of 15 points on [-1, 1] that are not negative, its weights, and those of Gauss's rule of 7
# points at every second node.
NODES = np.array(
    [
        0.0,
        0.207784955007898467600689403773245,
        0.405845151377397166906606412076961,
        0.586087235467691130294144691693013,
        0.741531185599394439863864773280788,
        0.864864423359769072789712788640926,
        0.949107912342758524526189684047851,
        0.991455371120812639206854697526329,
    ]
)
KRONROD = np.array(
    [
        0.209482141084727828012999174891714,
        0.204432940075298892414161999234649,
        0.190350578064785409913256402421014,
        0.169004726639267902826583426598550,
        0.140653259715525918745189590510238,
        0.104790010322250183839876322541518,
        0.063092092629978553290700663189204,
        0.022935322010529224963732008058970,
    ]
)
GAUSS = np.array(
    [
        0.417959183673469387755102040816327,
        0.0,
        0.381830050505118944950369775488975,
        0.0,
        0.279705391489276667901467771423780,
        0.0,
        0.129484966168869693270611432679082,
        0.0,
    ]
)
# Where both rules agree so well, relative to the integral of the absolute value, that of 15 points is exact to
# rounding. A part is halved no more often than this: below it a kernel is not smooth.
AGREED, MAX_HALVINGS = 1e-11, 20
# Where the states of a part come from, besides steps of the ring, by number: the history, the extension of the present
# step that is held, and the present states.
FROM_HISTORY, FROM_HELD, FROM_PRESENT = -1, -2, -3


def integrate_past(c: Core, t: float, y: Floats, q: int, low: float, high: float, what: int) -> float:
    """Return the integral of integrand ``q``, or of what :data:`INTEGRAND` and others name, over lags low to high."""
    sign = 1.0
    if high < low:
        low, high, sign = high, low, -1.0
    begin, end, total = t - high, t - low, 0.0
    if begin < c.lag_time[KNOWN_FROM] - time_tolerance(t):
        c.lag_count[UNKNOWN] = 1
    start, now = c.clock[T_START], c.clock[T]
    if begin < start:
        total += _integrate_part(c, t, q, begin, min(end, start), what, FROM_HISTORY)
    if c.count[USED] > 0 and end > start and begin < now:
        last = c.count[FIRST] + c.count[USED]
        slot = c.n_delays + c.n_varying + q
        number = find_step_before(c, max(begin, start), c.cursor[slot])
        c.cursor[slot] = number
        while number < last and c.past_time[number & c.mask] < end:
            j = number & c.mask
            left, right = max(begin, c.past_time[j]), min(end, c.past_end[j])
            if right > left:
                total += _integrate_part(c, t, q, left, right, what, j)
            number += 1
    if end > now:
        left, source = max(begin, now), FROM_PRESENT
        if end > now + time_tolerance(t):
            c.lag_count[OVERLAPS] = 1
        if c.lag_count[HELD] == 1:
            source = FROM_HELD
        elif c.count[USED] > 0 and _last_piece(c) == c.lag_count[PIECE]:
            source = (c.count[FIRST] + c.count[USED] - 1) & c.mask
        total += _integrate_part(c, t, q, left, end, what, source)
    return sign * total


def evaluate_integrand_at(c: Core, t: float, y: Floats, q: int, lag: float) -> float:
    """Return integrand ``q`` at one lag."""
    there = t - lag
    if lag == 0.0:
        for i in range(c.n):
            c.inside[i] = y[i]
    else:
        source = FROM_PRESENT
        if there < c.clock[T_START]:
            source = FROM_HISTORY
        elif there >= c.clock[T] and c.lag_count[HELD] == 1:
            source = FROM_HELD
        elif c.count[USED] > 0:
            source = find_step_before(c, there, c.cursor[c.n_delays + c.n_varying + q]) & c.mask
        _read_states(c, there, 0, source)
    c.integrand[0] = 0.0
    call(c.integrands, 2 * q, lag, c.inside, c.inside, c.p, c.integrand)
    return c.integrand[0]


def _last_piece(c: Core) -> int:
    return c.past_piece[(c.count[FIRST] + c.count[USED] - 1) & c.mask]


def _integrate_part(c: Core, t: float, q: int, left: float, right: float, what: int, source: int) -> float:
    """Return the integral over times from ``left`` to ``right``, which one polynomial, or the history, holds."""
    total, size, top = 0.0, 0.0, 0
    panels = c.panels
    panels[0], panels[1], panels[2] = left, right, 0.0
    while top >= 0:
        a, b, depth = panels[3 * top], panels[3 * top + 1], panels[3 * top + 2]
        top -= 1
        middle, half = 0.5 * (a + b), 0.5 * (b - a)
        gauss, kronrod, absolute = 0.0, 0.0, 0.0
        for i in range(8):
            for side in range(1 if i == 0 else 2):
                there = middle + half * NODES[i] * (1.0 if side == 0 else -1.0)
                value = _evaluate(c, t, q, there, what, source)
                gauss += GAUSS[i] * value
                kronrod += KRONROD[i] * value
                absolute += KRONROD[i] * abs(value)
        size = max(size, half * absolute)
        # Infinity and NaN end here too.
        if half * abs(gauss - kronrod) > AGREED * size and depth < MAX_HALVINGS and isfinite(absolute):
            panels[3 * top + 3], panels[3 * top + 4], panels[3 * top + 5] = middle, b, depth + 1.0
            panels[3 * top + 6], panels[3 * top + 7], panels[3 * top + 8] = a, middle, depth + 1.0
            top += 2
        else:
            total += half * kronrod
    return total


def _evaluate(c: Core, t: float, q: int, there: float, what: int, source: int) -> float:
    """Return what is integrated at the time ``there``."""
    _read_states(c, there, 0, source)
    for i in range(c.n + 1):
        c.integrand[i] = 0.0
    if what == INTEGRAND:
        call(c.integrands, 2 * q, t - there, c.inside, c.inside, c.p, c.integrand)
        return c.integrand[0]
    call(c.integrands, 2 * q + 1, t - there, c.inside, c.inside, c.p, c.integrand)
    if what == DERIVATIVE_IN_LAG:
        return c.integrand[0]
    _read_states(c, there, 1, source)
    total = 0.0
    for i in range(c.n_kept):
        total += c.integrand[1 + c.kept[i]] * c.inside[c.kept[i]]
    return total


def _read_states(c: Core, there: float, part: int, source: int) -> None:
    """Write the states that are kept, or their tangent, at the time ``there`` to ``c.inside``."""
    n_past = c.n_kept * (1 + c.tangent)
    for i in range(c.n_kept):
        state = c.kept[i]
        variable, column = part * c.n_full + state, part * c.n_kept + i
        if source == FROM_HISTORY:
            c.inside[state] = 0.0 if part == 1 else evaluate_history(c, 0, there, state)
        elif source == FROM_PRESENT:
            c.inside[state] = c.y[variable]
        elif source == FROM_HELD:
            s = (there - c.clock[T]) / c.lag_time[HELD_LENGTH]
            c.inside[state] = evaluate_extension(c.y[variable], offset(c.held, variable), c.dimension, s)
        else:
            value, coefficients = (
                c.past_value[source * n_past + column],
                offset(c.past_coefficients, source * N_COEFFICIENTS * n_past + column),
            )
            s = (there - c.past_time[source]) / c.past_length[source]
            c.inside[state] = evaluate_extension(value, coefficients, n_past, s)
