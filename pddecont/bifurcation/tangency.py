"""Vanishing (VS): a segment or an impact of the signature dies out (design section 5.4).

Three things end a signature besides grazing: an event is met ever more slowly until it is only touched (a hard impact of speed zero),
a segment between two crossings of one event shrinks to nothing (a soft contact), or two different events come to happen at once.
The test function of the first is the smallest rate at which an orbit crosses the event functions that end its segments, positive in
the direction listed; a duration that falls to zero is met on the way (``Followed.forbids``); an event that the signature does not
list is watched where a segment begins and ends, since it may come in there without a grazing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.held import held
from pddecont.orbit.admissibility import event_profile, event_profiles, from_below, watched_events
from pddecont.orbit.curve import Curve
from pddecont.orbit.extrema import Profile
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
KIND = "VS"
# Between the names of two events in the note of a point where they happen at once.
MEETS = " meets "


def crossing_rates(problem: OrbitProblem, x: Array, profiles: dict[str, Profile] | None = None) -> Array:
    """Return each segment's rate of crossing its event, positive in the direction listed; NaN where it has none.

    An event of any direction is crossed from the side on which the segment lies.
    """
    profiles = event_profiles(problem, x) if profiles is None else profiles
    rates = np.full(len(problem.segments), np.nan)
    for s, segment in enumerate(problem.segments):
        if segment.event in profiles:
            slope = profiles[segment.event].end_slope(s)
            rates[s] = slope if from_below(profiles[segment.event], s, segment.direction) else -slope
    return rates


def rate(problem: OrbitProblem, x: Array, s: int) -> float:
    """Return the rate at which segment ``s`` crosses its event at its end, positive in the direction listed."""
    segment = problem.segments[s]
    along = event_profile(problem, x, segment.event)
    return along.end_slope(s) if from_below(along, s, segment.direction) else -along.end_slope(s)


def crossing_rate(problem: OrbitProblem, x: Array, profiles: dict[str, Profile] | None = None) -> float:
    """Return the smallest rate at the orbit ``x`` (NaN if no segment ends at an event function)."""
    rates = crossing_rates(problem, x, profiles)
    return float(np.nanmin(rates)) if np.any(np.isfinite(rates)) else float("nan")


@dataclass(frozen=True)
class Meeting:
    """The condition that segment ``s`` has an event it does not end with just at its end (or start).

    The value is that of the event function, NaN where the orbit does not cross it there in a direction that counts.
    """

    s: int
    event: str
    direction: str
    at_end: bool
    kind: str = KIND

    def value(self, curve: Curve, x: Array) -> float:
        """Return the event function at the segment's end."""
        return self.at(curve.problem, x)

    def at(self, problem: OrbitProblem, x: Array) -> float:
        """Return the same for an orbit."""
        along = event_profile(problem, x, self.event)
        value = along.ends(self.s)[self.at_end]
        slope = along.end_slope(self.s) if self.at_end else along.start_slope(self.s)
        counts = {"rising": slope > 0.0, "falling": slope < 0.0}.get(self.direction, True)
        return value if counts else float("nan")

    def framed(self, curve: Curve, x: Array) -> Meeting:
        """Return the same condition."""
        return self


def meetings(problem: OrbitProblem) -> list[Meeting]:
    """Return the conditions for each event with a function that a segment of the signature watches and does not end with.

    Those that every orbit of the signature fulfils are left out (:func:`held`).
    """
    model, segments = problem.numeric.model, problem.segments
    found = []
    for s, segment in enumerate(segments):
        if not segment.event:
            continue
        for event, direction, _ in watched_events(problem, s):
            # An event lies at zero at the end that it makes itself.
            found += [Meeting(s, event, direction, at_end) for at_end, made_by in ((True, segment.event), (False, segments[s - 1].event))
                      if event != made_by and not held(model, segments, s, event, at_end=at_end)]  # fmt: skip
    return found


@dataclass(frozen=True, eq=False)
class Tangency:
    """The condition that segment ``s`` meets its event with rate zero."""

    s: int
    kind: str = KIND

    def value(self, curve: Curve, x: Array) -> float:
        """Return the rate."""
        return rate(curve.problem, x, self.s)

    def framed(self, curve: Curve, x: Array) -> Tangency:
        """Return the same condition."""
        return self


@dataclass(frozen=True, eq=False)
class Coincidence:
    """The condition that segment ``s`` between two different events has (almost) no duration."""

    s: int
    duration: float
    kind: str = KIND

    def value(self, curve: Curve, x: Array) -> float:
        """Return the duration less what is left of it."""
        return float(x[curve.problem.layout.durations][self.s] - self.duration)

    def framed(self, curve: Curve, x: Array) -> Coincidence:
        """Return the same condition."""
        return self
