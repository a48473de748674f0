"""An integration that begins in the middle of a motion whose past is known."""

from __future__ import annotations

from math import inf

from pddecont.native.arrays import entry
from pddecont.native.integrator.breaking import (
    LEVELS,
    add_breaking_points,
    add_returns,
    drop_breaking_points,
    pass_breaking_points,
    queues_have_capacity,
)
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.event_sides import note_sides
from pddecont.native.integrator.history import choose_arcs
from pddecont.native.integrator.lag_crossing import choose_pieces
from pddecont.native.integrator.places import (
    ARC,
    FIRST,
    FRESH,
    KNOWN_FROM,
    LAST_EVENT,
    LAST_EVENT_TIME,
    MODE,
    N_BREAKING,
    N_STEPS,
    PIECE,
    PIECE_LEVEL,
    PIECE_SIZE,
    PIECE_START,
    READY,
    SHIFT,
    SIMULTANEOUS,
    T_START,
    UNRESOLVED,
    USED,
    T,
)
from pddecont.native.integrator.ring import time_tolerance
from pddecont.native.integrator.status import Status

# How far before the present time the arcs are chosen that the delays read, in tolerances of time.
JUST_BEFORE = 4.0


@entry
def begin_inside_arc(c: Core, t: float, begin: float, mode: int, arc: int) -> int:
    """Set an integration to time ``t`` inside an arc; return REACHED, or CAPACITY, which asks for a larger state.

    The states are in ``c.y`` already, the past, which starts at ``begin``, in its ring, and the delayed events
    under way in their queue. The jumps of the past come back as they would have; the sides of the event functions are
    those of the present states.
    """
    c.clock[T], c.clock[T_START], c.clock[SHIFT], c.clock[LAST_EVENT_TIME] = t, begin, 0.0, -inf
    c.count[MODE], c.count[ARC] = mode, arc
    c.count[READY] = c.count[SIMULTANEOUS] = c.count[UNRESOLVED] = c.count[N_BREAKING] = c.count[N_STEPS] = 0
    c.count[LAST_EVENT] = -1
    for event in range(c.n_events):
        row = 4 * event
        c.accumulation[row] = -inf
        for i in range(1, 4):
            c.accumulation[row + i] = 0.0
    if c.is_general == 1:
        if not queues_have_capacity(c, c.count[USED]):
            return Status.CAPACITY
        _begin_pieces(c, t, begin)
        note_sides(c, t)
        c.count[FRESH] = 0
        return Status.REACHED
    last = c.past_arc[c.count[FIRST] & c.mask]
    for number in range(c.count[FIRST], c.count[FIRST] + c.count[USED]):
        j = number & c.mask
        if not queues_have_capacity(c, 1):
            return Status.CAPACITY
        if c.past_arc[j] != last:
            add_breaking_points(c, c.past_time[j], 0)
            pass_breaking_points(c, c.past_time[j])
        last = c.past_arc[j]
    pass_breaking_points(c, t)
    choose_arcs(c, t - JUST_BEFORE * time_tolerance(t))
    note_sides(c, t)
    c.count[FRESH] = 0
    return Status.REACHED


def _begin_pieces(c: Core, t: float, begin: float) -> None:
    """Let every step of the past be a piece of its own, and choose those that are read at ``t``.

    Between the steps of a polynomial orbit derivatives jump by its error, within an arc by no more: such jumps come
    back once.
    """
    first, end = c.count[FIRST], c.count[FIRST] + c.count[USED]
    for number in range(first, end):
        j = number & c.mask
        starts_arc = number > first and c.past_arc[j] != c.past_arc[(number - 1) & c.mask]
        c.past_piece[j], c.past_size[j] = number - first, 1.0
        c.past_level[j] = 0 if starts_arc else LEVELS - 1
        if number > first:
            add_returns(c, c.past_time[j], c.past_level[j], c.past_size[j])
    drop_breaking_points(c, t)
    c.lag_count[PIECE], c.lag_time[PIECE_START] = end - first, t
    c.lag_count[PIECE_LEVEL], c.lag_time[PIECE_SIZE] = LEVELS - 1, 1.0
    c.lag_time[KNOWN_FROM] = begin
    choose_arcs(c, t - JUST_BEFORE * time_tolerance(t))
    choose_pieces(c, t)
