"""Pieces of the past: between two jumps in a derivative of low order a motion is smooth, and lags that vary read it so.

A lag reads one piece in a step, continued beyond its ends if need be; where t - lag passes an end, the step is cut and
the next one reads the neighbour. Pieces are numbered in order; -1 is the history before the start.
"""

from __future__ import annotations

from math import inf

from pddecont.native.integrator.core import Core
from pddecont.native.integrator.places import FIRST, PIECE, PIECE_LEVEL, PIECE_SIZE, PIECE_START, T_START, USED
from pddecont.native.integrator.ring import find_step_before, time_tolerance

# The piece of the history before the start.
HISTORY = -1


def find_first_step(c: Core, piece: int) -> int:
    """Return the number of the first step in the ring that belongs to ``piece`` or a later one; one past the last."""
    low, high = c.count[FIRST], c.count[FIRST] + c.count[USED]
    while low < high:
        middle = (low + high) // 2
        if c.past_piece[middle & c.mask] < piece:
            low = middle + 1
        else:
            high = middle
    return low


def find_begin(c: Core, piece: int) -> float:
    """Return when a piece begins; minus infinity for the history."""
    if piece == HISTORY:
        return -inf
    number = find_first_step(c, piece)
    if number == c.count[FIRST] + c.count[USED]:
        return c.lag_time[PIECE_START]
    return c.past_time[number & c.mask]


def find_end(c: Core, piece: int) -> float:
    """Return when a piece ends; infinity for the present one."""
    if piece >= c.lag_count[PIECE]:
        return inf
    number = find_first_step(c, piece + 1)
    if number == c.count[FIRST] + c.count[USED]:
        return c.lag_time[PIECE_START]
    return c.past_time[number & c.mask]


def find_neighbour(c: Core, piece: int, later: bool) -> int:
    """Return the piece after one (``later``) or before it; a piece may have no steps."""
    if later:
        number = find_first_step(c, piece + 1)
        if number == c.count[FIRST] + c.count[USED]:
            return c.lag_count[PIECE]
        return c.past_piece[number & c.mask]
    number = find_first_step(c, piece) - 1
    if number < c.count[FIRST]:
        return HISTORY
    return c.past_piece[number & c.mask]


def find_jump(c: Core, piece: int) -> tuple[int, float]:
    """Return which derivative jumps where a piece begins, and how large at most its rate jumps there."""
    number = find_first_step(c, piece)
    if number == c.count[FIRST] + c.count[USED]:
        return c.lag_count[PIECE_LEVEL], c.lag_time[PIECE_SIZE]
    j = number & c.mask
    return c.past_level[j], c.past_size[j]


def find_piece(c: Core, t: float) -> int:
    """Return the piece that holds the time ``t``; of two that meet there the later one."""
    if t < c.clock[T_START]:
        return HISTORY
    if c.count[USED] == 0 or t >= c.lag_time[PIECE_START]:
        return c.lag_count[PIECE]
    guess = c.count[FIRST]
    return c.past_piece[find_step_before(c, t, guess) & c.mask]


def stay_in_piece(c: Core, piece: int, t: float) -> int:
    """Return the piece that is read at ``t`` outside steps: ``piece`` as long as its ends hold ``t``."""
    tolerance = time_tolerance(t)
    if find_begin(c, piece) - tolerance <= t <= find_end(c, piece) + tolerance:
        return piece
    return find_piece(c, t)


def begin_piece(c: Core, t: float, level: int, size: float) -> None:
    """Let a piece begin at ``t``, where the derivative of order ``level`` jumps.

    Lags that are zero go on to read the present.
    """
    if c.lag_time[PIECE_START] == t and not has_steps(c, c.lag_count[PIECE]):
        c.lag_count[PIECE_LEVEL] = min(c.lag_count[PIECE_LEVEL], level)
        c.lag_time[PIECE_SIZE] = max(c.lag_time[PIECE_SIZE], size)
        return
    before = c.lag_count[PIECE]
    c.lag_count[PIECE] = before + 1
    c.lag_time[PIECE_START], c.lag_count[PIECE_LEVEL], c.lag_time[PIECE_SIZE] = t, level, size
    for k in range(c.n_varying):
        if c.reading[c.n_delays + k] == before and abs(c.lag[k]) <= time_tolerance(t):
            c.reading[c.n_delays + k] = before + 1


def has_steps(c: Core, piece: int) -> bool:
    """Return whether the last step in the ring belongs to ``piece`` (the present one)."""
    if c.count[USED] == 0:
        return False
    return c.past_piece[(c.count[FIRST] + c.count[USED] - 1) & c.mask] == piece
