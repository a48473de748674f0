"""Where lags that vary pass from one piece of the past to another: there jumps come back, and steps end.

With the read time t - lag(t) and a jump at xi, the jump comes back where t - lag(t) = xi. That is a zero of a function
along the continuous extension as an event is, looked for at both ends of the piece that a lag reads, so that a lag may
pass a jump back and forth, or touch it.

Reference: Guglielmi, Hairer, Computing breaking points in implicit delay differential equations, Adv. Comput. Math. 29
(2008).
"""

from __future__ import annotations

from math import isfinite

from pddecont.native.integrator.breaking import come_back
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_functions import evaluate_event_slope
from pddecont.native.integrator.event_location import find_first_crossing
from pddecont.native.integrator.pieces import find_begin, find_end, find_jump, find_neighbour
from pddecont.native.integrator.places import ADVANCED, LAST_TURN, MODE, PIECE, TURNS_AT_ONCE, UNKNOWN, ZERO
from pddecont.native.integrator.rhs import evaluate_rhs
from pddecont.native.integrator.ring import time_tolerance
from pddecont.native.integrator.status import Status
from pddecont.native.integrator.variational import jump_at_lag

# Beyond the range of times that the stages of a step read, a lag reads no more than this part of it: between two
# stages, a fifth of a step apart or less, a read time that turns goes beyond both by a twenty-fifth of the range.
BEYOND = 0.25
# What a lag passes: the end of its piece, its beginning, or the present.
NOTHING, END, BEGIN, PRESENT = 0, 1, 2, 3
# More ends passed at one moment than lags that stand still on one pass by rounding.
MAX_TURNS_AT_ONCE = 50


def find_read_event(c: Core, k: int) -> int:
    """Return the number of the event function t - lag of lag ``k``; that of the lag itself comes next."""
    return c.n_events + 2 * k


def choose_pieces(c: Core, t: float) -> None:
    """Choose the pieces that lags read from ``t`` on where a motion may have jumped: where two meet, by the slope."""
    for _turn in range(c.n_varying + 1):
        evaluate_rhs(c, c.count[MODE], t, c.y, c.fresh_slope)
        evaluate_rhs(c, c.count[MODE], t, c.y, c.fresh_slope)
        changed = False
        for k in range(c.n_varying):
            slot, there = c.n_delays + k, t - c.lag[k]
            piece, tolerance = c.reading[slot], time_tolerance(t)
            at_end = abs(there - find_end(c, piece)) <= tolerance
            at_begin = abs(there - find_begin(c, piece)) <= tolerance
            if not at_end and not at_begin:
                continue
            slope, _ = evaluate_event_slope(c, find_read_event(c, k), c.count[MODE], t, c.y)
            if (at_end and slope > 0.0) or (at_begin and slope < 0.0):
                c.reading[slot] = find_neighbour(c, piece, at_end and slope > 0.0)
                changed = True
        if not changed:
            return


def check_lags(c: Core, t: float) -> int:
    """Return REACHED, or why no step can begin at ``t``: a lag is below zero, or reads what is not known."""
    for k in range(c.n_varying):
        if c.lag[k] < -time_tolerance(t):
            c.lag_count[ADVANCED] = k
            return Status.ADVANCED
    return Status.PAST_UNKNOWN if c.lag_count[UNKNOWN] == 1 else Status.REACHED


def find_lag_crossing(c: Core, t: float, h: float) -> tuple[int, float, int]:
    """Return the lag that first passes the end of what it reads in the present step (-1: none), where, and what."""
    lag, earliest, passed = -1, 2.0, NOTHING
    for k in range(c.n_varying):
        piece, event = c.reading[c.n_delays + k], find_read_event(c, k)
        for what in range(END, BEGIN + 1):
            end = find_end(c, piece) if what == END else find_begin(c, piece)
            if not _may_reach(c, k, end):
                continue
            s = _find_crossing(c, event, 1 if what == END else -1, t, h, end)
            if 0.0 <= s < earliest:
                lag, earliest, passed = k, s, what
        # A lag below zero reads the future, beyond the present step's beginning.
        if piece == c.lag_count[PIECE] and c.lag_most[k] >= t:
            s = _find_crossing(c, event + 1, -1, t, h, 0.0)
            if 0.0 <= s < earliest:
                lag, earliest, passed = k, s, PRESENT
    return lag, earliest, passed


def _may_reach(c: Core, k: int, end: float) -> bool:
    """Return whether the times that lag ``k`` read in the present step may reach the end of a piece."""
    if not isfinite(end):
        return False
    margin = BEYOND * (c.lag_most[k] - c.lag_least[k]) + time_tolerance(end)
    return c.lag_least[k] - margin <= end <= c.lag_most[k] + margin


def _find_crossing(c: Core, event: int, direction: int, t: float, h: float, zero: float) -> float:
    """Return where in the present step an event function of a lag passes the value ``zero``; -1 if nowhere."""
    c.lag_time[ZERO] = zero
    s, _ = find_first_crossing(c, event, direction, t, h, -direction, 0.0)
    return s


def pass_lag(c: Core, k: int, passed: int, t: float) -> int:
    """Let lag ``k`` read beyond the end of its piece from ``t`` on, where a jump comes back; return a status."""
    slot = c.n_delays + k
    if passed == PRESENT:
        c.lag_count[ADVANCED] = k
        return Status.ADVANCED
    again = abs(t - c.lag_time[LAST_TURN]) <= time_tolerance(t)
    c.lag_count[TURNS_AT_ONCE] = c.lag_count[TURNS_AT_ONCE] + 1 if again else 0
    c.lag_time[LAST_TURN] = t
    if c.lag_count[TURNS_AT_ONCE] > MAX_TURNS_AT_ONCE:
        return Status.STEP_TOO_SMALL
    piece = c.reading[slot]
    target = find_neighbour(c, piece, passed == END)
    later = max(piece, target)
    level, size = find_jump(c, later)
    if c.tangent == 1:
        jump_at_lag(c, k, slot, target, later, t)
    c.reading[slot] = target
    come_back(c, slot, t, level, size)
    return Status.REACHED
