"""Which of the modes that it may lead to an event leads to: digit by digit, as the states after it decide."""

from __future__ import annotations

from pddecont.native.arrays import Floats
from pddecont.native.calls import call
from pddecont.native.integrator.core import Core

# The digit of a switch above its surface; conditions know digits as bits.
ABOVE = 1

# What may be missing of a segment: a way whose digits are known, a way that no rule decides, and the rest.
WAY, UNDECIDED, REST = 0, 1, 2


def choose_way(c: Core, segment: int, t: float, y: Floats) -> int:
    """Return the segment that one turns out to be where the states after its reset are ``y``.

    ``c.xd`` holds the delayed values. It is -1 where no rule decides, or where the tables do not hold the segment or
    its mode yet; ``c.digits``, ``c.asked`` and ``c.landing`` then say what is missing.
    """
    if c.asked[2] == segment:
        c.asked[2] = -1
        return c.asked[3]
    for k in range(c.n_keys):
        c.digits[k] = c.leader_digits[segment * c.n_keys + k]
    c.asked[0], c.asked[1] = segment, WAY
    for decision in range(c.segment_decision_first[segment], c.segment_decision_end[segment]):
        option = _choose_option(c, decision, t, y)
        if option < 0:
            c.asked[1] = UNDECIDED
            _record_landing(c, t, y)
            return -1
        for i in range(c.decision_size[decision]):
            c.digits[c.decided[c.number_first[decision] + i]] = c.decided_digit[c.digit_first[option] + i]
    way = segment
    while way >= 0 and not _leads_there(c, way):
        way = c.segment_next_way[way]
    if way >= 0 and c.segment_to[way] >= 0:
        return way
    _record_landing(c, t, y)
    return -1


def _record_landing(c: Core, t: float, y: Floats) -> None:
    c.landing[0] = t
    for i in range(c.n):
        c.landing[i + 1] = y[i]


def ask_for_rest(c: Core, segment: int) -> int:
    """Return what a segment is where the motion rests; -1 where the tables do not hold its mode yet.

    ``c.asked`` then says what is missing.
    """
    resting = c.resting[segment]
    if c.segment_to[resting] >= 0:
        return resting
    c.asked[0], c.asked[1] = segment, REST
    return -1


def _choose_option(c: Core, decision: int, t: float, y: Floats) -> int:
    """Return the first option whose condition holds in the states ``y``; the last one, or -1 of an open decision."""
    bits = 0
    for k in range(c.n_digits):
        if c.digits[k] == ABOVE:
            bits |= 1 << k
    last = c.option_end[decision] - (1 - c.is_open[decision])
    for option in range(c.option_first[decision], last):
        c.gradient[0] = 0.0
        call(c.rule[option], c.rule_case[option] | bits, t, y, c.xd, c.p, c.gradient)
        if c.gradient[0] > 0.0:
            return option
    return -1 if c.is_open[decision] == 1 else last


def _leads_there(c: Core, way: int) -> bool:
    """Return whether a segment leads to the digits that were decided."""
    for k in range(c.n_keys):
        if c.way_digits[way * c.n_keys + k] != c.digits[k]:
            return False
    return True
