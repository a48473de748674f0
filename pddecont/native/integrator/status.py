"""Why an integration came back."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Why an integration came back, as a number that machine code returns."""

    REACHED = 0  # the time to stop at
    SECTION = 1  # a return to the section
    PAUSED = 2  # as many steps as were allowed
    CAPACITY = 3  # the arrays of the state are full: call again with a larger state
    LOG_FULL = 4  # the log is full: empty it and call again
    ZENO = 5  # events accumulate and nothing says which mode follows
    SLIDING = 6  # both vector fields point at the surface of an event
    STEP_TOO_SMALL = 7  # no step that time can resolve meets the tolerances
    NOT_FINITE = 8  # the solution or its slope is infinite or NaN
    REPELLED = 9  # both vector fields point away from a surface that the motion is on
    NEW_WAY = 10  # an event leads to where the tables have nothing yet: call again with larger ones
    ADVANCED = 11  # a lag is below zero
    PAST_UNKNOWN = 12  # a lag reaches farther back than the past is known
