"""Delayed values: from the ring of past steps, from the history before the start, or from the last stage of a chain."""

from __future__ import annotations

from pddecont.native.arrays import Floats
from pddecont.native.calls import offset
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.past_reads import drop_past, read_past, read_past_slopes
from pddecont.native.integrator.places import (
    ARC,
    FIRST,
    N_COEFFICIENTS,
    PIECE,
    PIECE_LEVEL,
    PIECE_SIZE,
    SHIFT,
    T_START,
    USED,
)
from pddecont.native.integrator.ring import (
    evaluate_extension,
    evaluate_extension_slope,
    evaluate_history,
    find_step_before,
    time_tolerance,
)


def choose_arcs(c: Core, middle: float) -> bool:
    """Choose the arc that each delay reads in a step with its middle at ``middle``; return whether any is another one.

    A step lies between two breaking points, so all that it reads of one delay lies in one arc. Choosing it once, by the
    step's middle, says on which side of a jump the step reads, whatever rounding does to the times. Arc -1 is the
    history.
    """
    changed = False
    for k in range(c.n_delays):
        t = middle - c.tau[k]
        arc = -1
        if c.tau[k] == 0.0:
            arc = c.count[ARC]
        elif c.count[USED] > 0 and t >= c.clock[T_START]:
            number = find_step_before(c, t, c.cursor[k])
            c.cursor[k] = number
            arc = c.past_arc[number & c.mask]
        if arc != c.reading[k]:
            c.reading[k] = arc
            changed = True
    return changed


def find_step_in_arc(c: Core, t: float, k: int) -> int:
    """Return the number of the step that delay ``k`` reads at ``t``, in the arc that was chosen for it.

    Times outside the arc read the polynomials at its ends.
    """
    first, end = c.count[FIRST], c.count[FIRST] + c.count[USED]
    arc = c.reading[k]
    number = min(max(c.cursor[k], first), end - 1)
    while number > first and c.past_arc[number & c.mask] > arc:
        number -= 1
    while number + 1 < end and c.past_arc[number & c.mask] < arc:
        number += 1
    while number + 1 < end and c.past_arc[(number + 1) & c.mask] == arc and c.past_time[(number + 1) & c.mask] <= t:
        number += 1
    while number > first and c.past_arc[(number - 1) & c.mask] == arc and c.past_time[number & c.mask] > t:
        number -= 1
    c.cursor[k] = number
    return number


def interpolate_state(c: Core, s: float, y: Floats, n: int) -> None:
    """Write the first ``n`` variables at ``s`` in [0, 1] of the present step to ``y``."""
    for i in range(n):
        y[i] = evaluate_extension(c.y[i], offset(c.extension, i), c.dimension, s)


def _locate_in_arc(c: Core, t: float, k: int) -> tuple[int, float]:
    """Return the place in the ring of the step that delay ``k`` reads at ``t``, and where in the step."""
    j = find_step_in_arc(c, t, k) & c.mask
    return j, (t - c.past_time[j]) / c.past_length[j]


def read_delayed(c: Core, t: float, y: Floats, xd: Floats, part: int) -> None:
    """Write what is read of the past at ``t`` to ``xd``: of the states (``part`` 0) or of the tangent (1)."""
    if c.is_general == 1:
        read_past(c, t, y, xd, part)
    else:
        read_states(c, t, y, xd, part)


def read_states(c: Core, t: float, y: Floats, xd: Floats, part: int) -> None:
    """Write the delayed values at ``t`` to ``xd``, all of them states constant delays ago."""
    base = part * c.n_full
    n_past = c.n_kept * (1 + c.tangent)
    for i in range(c.n_pairs):
        state, k = c.pair_state[i], c.pair_delay[i]
        if c.tau[k] == 0.0:
            xd[i] = y[base + state]
        elif c.chain_n > 0:
            xd[i] = y[base + c.n + (i * c.chain_n + c.chain_n - 1) * c.chain_order]
        elif c.reading[k] < 0:
            xd[i] = 0.0 if part == 1 else evaluate_history(c, 0, t - c.tau[k], state)
        else:
            j, s = _locate_in_arc(c, t - c.tau[k], k)
            column = part * c.n_kept + c.place[state]
            xd[i] = evaluate_extension(
                c.past_value[j * n_past + column],
                offset(c.past_coefficients, j * N_COEFFICIENTS * n_past + column),
                n_past,
                s,
            )


def read_delayed_slopes(c: Core, t: float, y: Floats, dy: Floats, slopes: Floats) -> None:
    """Write the time derivatives of the delayed values at ``t`` to ``slopes``; ``dy`` are those of ``y``."""
    if c.is_general == 1:
        read_past_slopes(c, t, y, dy, slopes)
        return
    n_past = c.n_kept * (1 + c.tangent)
    for i in range(c.n_pairs):
        state, k = c.pair_state[i], c.pair_delay[i]
        if c.tau[k] == 0.0:
            slopes[i] = dy[state]
        elif c.chain_n > 0:
            slopes[i] = dy[c.n + (i * c.chain_n + c.chain_n - 1) * c.chain_order]
        elif c.reading[k] < 0:
            slopes[i] = evaluate_history(c, 1, t - c.tau[k], state)
        else:
            j, s = _locate_in_arc(c, t - c.tau[k], k)
            first = offset(c.past_coefficients, j * N_COEFFICIENTS * n_past + c.place[state])
            slopes[i] = evaluate_extension_slope(first, n_past, s) / c.past_length[j]


def record_step(c: Core, t: float, length: float, end: float) -> None:
    """Add the step just made to the past and drop the steps that no delay reaches any more."""
    if c.n_kept == 0 or c.chain_n > 0:
        return
    if c.n_varying > 0:
        drop_past(c, end)
    else:
        while c.count[USED] > 1 and c.past_end[c.count[FIRST] & c.mask] < end - c.longest - time_tolerance(end):
            c.count[FIRST] += 1
            c.count[USED] -= 1
    j = (c.count[FIRST] + c.count[USED]) & c.mask
    c.past_time[j], c.past_length[j], c.past_end[j] = t, length, end
    c.past_arc[j], c.past_shift[j] = c.count[ARC], c.clock[SHIFT]
    c.past_piece[j], c.past_level[j] = c.lag_count[PIECE], c.lag_count[PIECE_LEVEL]
    c.past_size[j] = c.lag_time[PIECE_SIZE]
    n_past = c.n_kept * (1 + c.tangent)
    for k in range(c.n_kept):
        for part in range(1 + c.tangent):
            source, column = part * c.n_full + c.kept[k], part * c.n_kept + k
            c.past_value[j * n_past + column] = c.y[source]
            for i in range(N_COEFFICIENTS):
                c.past_coefficients[(j * N_COEFFICIENTS + i) * n_past + column] = c.extension[i * c.dimension + source]
    c.count[USED] += 1


def past_has_capacity(c: Core) -> bool:
    """Return whether a step still fits into the ring."""
    return c.count[USED] + 2 < c.mask + 1
