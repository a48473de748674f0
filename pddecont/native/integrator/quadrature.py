"""Integrals over the past: Patterson's rules over its steps, each cut at the limits, halved where need be.

A rule of 7 points has those of Gauss's of 3 among its own, one of 15 has those 7. A part that is short beside all that
is integrated over is done where the first two agree, any other where the last two do.

Reference: Patterson, Math. Comp. 22 (1968), 847-856.
"""

from __future__ import annotations

from math import isfinite

import numpy as np

from pddecont.native.arrays import Floats
from pddecont.native.calls import call, offset
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.places import (
    FIRST,
    HELD,
    HELD_LENGTH,
    IN_STEP,
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
# Nodes of Patterson's rule of 15 points on [-1, 1] that are not negative: those of the rules of 3 and 7 points first.
# Computed to 60 digits from what defines them, as are the weights of the three.
NODES = np.array(
    [
        0.0,
        0.774596669241483377035853079956480,
        0.434243749346802558002071502844628,
        0.960491268708020283423507092629080,
        0.223386686428966881628203986843998,
        0.621102946737226402940687443816595,
        0.888459232872256998890420167258503,
        0.993831963212755022208512841307951,
    ]
)
OF_3 = np.array([0.888888888888888888888888888888889, 0.555555555555555555555555555555556])
OF_7 = np.array(
    [
        0.450916538658474142345110087045571,
        0.268488089868333440728569280666710,
        0.401397414775962222905051818618432,
        0.104656226026467265193823857192073,
    ]
)
OF_15 = np.array(
    [
        0.225510499798206687386422549155949,
        0.134415255243784220359768964802492,
        0.200628529376989021033931873331359,
        0.051603282997079739696920120567861,
        0.219156858401587496403693161643774,
        0.171511909136391380787353165019717,
        0.092927195315124537685894222654169,
        0.017001719629940260339027417402654,
    ]
)
# Nodes, not negative, of the rules of 3 and 7 points.
N_3, N_7 = 2, 4
# Where two rules agree so well, relative to the integral of the absolute value, the better one is exact to rounding. A
# part is halved no more often than this: below it a kernel is not smooth.
AGREED, MAX_HALVINGS = 1e-11, 20
# Parts no longer than this share of all that is integrated over begin with 7 points: no kernel is looked at in fewer
# places than by 15 points in one part.
SHORT = 0.25
# Sums over whole steps that are kept while a step is tried, after their number, and the numbers each is kept with.
N_SUMS, SUM_WIDTH = 64, 5
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
        total += _integrate_part(c, t, q, begin, min(end, start), what, FROM_HISTORY, high - low)
    if c.count[USED] > 0 and end > start and begin < now:
        last = c.count[FIRST] + c.count[USED]
        slot = c.n_delays + c.n_varying + q
        number = find_step_before(c, max(begin, start), c.cursor[slot])
        c.cursor[slot] = number
        if number < last and c.past_time[number & c.mask] < max(begin, start):
            j = number & c.mask
            right = min(end, c.past_end[j])
            if right > begin:
                total += _integrate_part(c, t, q, max(begin, start), right, what, j, high - low)
            number += 1
        beyond = number
        while beyond < last and c.past_end[beyond & c.mask] <= end:
            beyond += 1
        total += _integrate_steps(c, t, q, number, beyond, what, high - low)
        if beyond < last and c.past_time[beyond & c.mask] < end:
            j = beyond & c.mask
            total += _integrate_part(c, t, q, c.past_time[j], end, what, j, high - low)
    if end > now:
        left, source = max(begin, now), FROM_PRESENT
        if end > now + time_tolerance(t):
            c.lag_count[OVERLAPS] = 1
        if c.lag_count[HELD] == 1:
            source = FROM_HELD
        elif c.count[USED] > 0 and _last_piece(c) == c.lag_count[PIECE]:
            source = (c.count[FIRST] + c.count[USED] - 1) & c.mask
        total += _integrate_part(c, t, q, left, end, what, source, high - low)
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


def forget_sums(c: Core) -> None:
    """Let the sums over whole steps that were kept be made anew: another step is tried."""
    c.sums[0] = 0.0


def _integrate_steps(c: Core, t: float, q: int, first: int, beyond: int, what: int, window: float) -> float:
    """Return the integral over the whole steps from number ``first`` on to that before ``beyond``.

    A step that reads itself is repeated, and so is its past: while a step is tried what was found is kept.
    """
    if beyond <= first:
        return 0.0
    n_kept = 0
    while c.lag_count[IN_STEP] == 1 and n_kept < c.sums[0]:
        kept = offset(c.sums, 1 + SUM_WIDTH * n_kept)
        if kept[0] == t and kept[1] == 3 * q + what and kept[2] == first and kept[3] == beyond:
            return kept[4]
        n_kept += 1
    total = 0.0
    for number in range(first, beyond):
        j = number & c.mask
        total += _integrate_part(c, t, q, c.past_time[j], c.past_end[j], what, j, window)
    if c.lag_count[IN_STEP] == 1 and n_kept < N_SUMS:
        new = offset(c.sums, 1 + SUM_WIDTH * n_kept)
        new[0], new[1], new[2], new[3], new[4] = t, 3.0 * q + what, first, beyond, total
        c.sums[0] = n_kept + 1.0
    return total


def _integrate_part(
    c: Core, t: float, q: int, left: float, right: float, what: int, source: int, window: float
) -> float:
    """Return the integral over times from ``left`` to ``right``, which one polynomial, or the history, holds.

    ``window`` is the length of all that is integrated over.
    """
    total, size, top = 0.0, 0.0, 0
    panels = c.panels
    panels[0], panels[1], panels[2] = left, right, 0.0
    while top >= 0:
        a, b, depth = panels[3 * top], panels[3 * top + 1], panels[3 * top + 2]
        top -= 1
        middle, half = 0.5 * (a + b), 0.5 * (b - a)
        by_3, by_7, by_15, absolute_7, absolute_15 = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(N_7):
            for side in range(1 if i == 0 else 2):
                value = _evaluate(c, t, q, middle + half * NODES[i] * (1.0 if side == 0 else -1.0), what, source)
                if i < N_3:
                    by_3 += OF_3[i] * value
                by_7 += OF_7[i] * value
                by_15 += OF_15[i] * value
                absolute_7 += OF_7[i] * abs(value)
                absolute_15 += OF_15[i] * abs(value)
        if b - a <= SHORT * window and half * abs(by_7 - by_3) <= AGREED * max(size, half * absolute_7):
            size = max(size, half * absolute_7)
            total += half * by_7
            continue
        for i in range(N_7, 8):
            for side in range(2):
                value = _evaluate(c, t, q, middle + half * NODES[i] * (1.0 if side == 0 else -1.0), what, source)
                by_15 += OF_15[i] * value
                absolute_15 += OF_15[i] * abs(value)
        size = max(size, half * absolute_15)
        # Infinity and NaN end here too.
        if half * abs(by_7 - by_15) > AGREED * size and depth < MAX_HALVINGS and isfinite(absolute_15):
            panels[3 * top + 3], panels[3 * top + 4], panels[3 * top + 5] = middle, b, depth + 1.0
            panels[3 * top + 6], panels[3 * top + 7], panels[3 * top + 8] = a, middle, depth + 1.0
            top += 2
        else:
            total += half * by_15
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
