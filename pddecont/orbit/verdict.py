"""What a simulation says of an orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from pddecont.orbit.orbit import Orbit
from pddecont.reasons import NO_REASON, Reason

# Code of the reason that a simulation ends elsewhere than the orbit, after the same events.
DRIFTS = "drifts"


@dataclass(frozen=True)
class Verification:
    """What the simulation of an orbit said.

    Attributes
    ----------
    verified
        1: it is a motion of the model; 0: it is none; -1: not done.
    deviation
        The farthest that simulation and orbit were apart, in states relative to their sizes and times of events
        relative to the period; NaN where it was not done, or the simulation went another way, at a border
        of what the orbit does too.
    reason
        What the motion does instead, or why nothing was done.
    """

    verified: int
    deviation: float = float("nan")
    reason: Reason = NO_REASON


NOT_DONE = Verification(-1)


class Verifier(Protocol):
    """Whoever says whether an orbit is a motion of the model."""

    def verify(self, orbit: Orbit, *, strict: bool = False) -> Verification:
        """Return whether it is; ``strict`` leaves no room for the orbit's errors."""
        ...
