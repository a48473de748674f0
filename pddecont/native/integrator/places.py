"""Where the state of an integration keeps its times and numbers: places in arrays, by name."""

from __future__ import annotations

# Coefficients that the continuous extension of a step has beside its first value: DOP853 needs seven (Hairer, Norsett,
# Wanner, Solving Ordinary Differential Equations I, 1993, section II.6), Radau IIA uses three of them.
N_COEFFICIENTS = 7
# Places in IntegratorState.clock: the present time, the start, where events accumulate, how much later the present arc
# began for the tangent, and the time of the last event.
T, T_START, ZENO_TIME, SHIFT, LAST_EVENT_TIME = 0, 1, 2, 3, 4
N_CLOCK = 5
# Places in IntegratorState.count: the mode; the number of the oldest step in the past and how many it holds; the arc;
# steps made and rejected; delayed events and breaking points to come; 1 where an arc begins; events so far at one
# moment; 1 for a constant history; 1 if the last slope of the step before is the first of the next; the last event;
# 1 if a step was too long to resolve an event function.
(
    MODE,
    FIRST,
    USED,
    ARC,
    N_STEPS,
    N_REJECTED,
    N_PENDING,
    N_BREAKING,
    FRESH,
    SIMULTANEOUS,
    CONSTANT,
    READY,
    LAST_EVENT,
    UNRESOLVED,
) = range(14)
N_COUNT = 14
# Places in IntegratorState.lag_time: when the present piece began, how large its rate jumped there at most, the longest
# lag so far, from when on the past is known, the length of the step whose extension is held, what counts as zero of the
# function t - lag at the moment, and when a lag last passed from one piece to another.
PIECE_START, PIECE_SIZE, LONGEST, KNOWN_FROM, HELD_LENGTH, ZERO, LAST_TURN = range(7)
N_LAG_TIME = 7
# Places in IntegratorState.lag_count: the present piece, which derivative jumped where it began, 1 while an extension
# of the present step is held to be read, 1 where the step read itself, 1 within a step, 1 where the past was read
# farther back than it is known, a lag that is below zero (-1: none), and pieces changed at one time.
PIECE, PIECE_LEVEL, HELD, OVERLAPS, IN_STEP, UNKNOWN, ADVANCED, TURNS_AT_ONCE = range(8)
N_LAG_COUNT = 8
