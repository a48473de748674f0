"""How a branch ends."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from pddecont.reasons import NO_REASON, Reason


class End(StrEnum):
    """Why a branch ends; test functions may end one with a code of their own."""

    RANGE = "range"
    MAX_POINTS = "max_points"
    STEP_TOO_SMALL = "step_too_small"
    IMPOSSIBLE = "impossible"
    LIMIT = "limit"
    SPECIAL = "special"
    INVALID = "invalid"
    SHRINKS = "shrinks"
    HALVED = "halved"
    CLOSED = "closed"
    ASYMPTOTE = "asymptote"


@dataclass(frozen=True)
class Termination:
    """How one direction of a branch ended.

    ``end`` is a member of :class:`End` or a test function's own code, ``detail`` says more of it, and ``n_unexplained``
    counts the changes of whole numbers along the branch that no special point accounts for.
    """

    end: str
    detail: Reason = NO_REASON
    n_unexplained: int = 0
