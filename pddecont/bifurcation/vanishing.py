"""Vanishing (VS): a segment or an impact of the signature dies out.

Three things end a signature besides grazing: an event is met ever more slowly until it is only touched (a hard impact
of speed zero), a segment between two crossings of one event shrinks to nothing (a soft contact), or two different
events come to happen at once. The test function of the first is the smallest rate at which an orbit crosses the event
functions that end its segments, positive in the direction listed; a duration that falls to zero is a boundary of the
branch; an event that the signature does not list is watched where a segment begins and ends, since it may come in there
without a grazing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.crossing_rates import find_crossing_rate, find_crossing_rates, find_smallest_crossing_rate
from pddecont.bifurcation.extended_system import DefiningFunction
from pddecont.bifurcation.grazing import define_grazing
from pddecont.bifurcation.kinds import OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.signature_removal import MEETING, find_way_off, make_shorter_system
from pddecont.continuation import BranchPoint, BranchState, CurvePoint, End, TestFunction
from pddecont.errors import ConvergenceError
from pddecont.model import vanishes_identically
from pddecont.orbit import (
    Orbit,
    OrbitEvaluation,
    PeriodicOrbitSystem,
    Signature,
    find_event_profile,
    find_shortest,
    list_guarded,
    make_profile,
    measure_guard,
    solve_orbit,
)
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]
LABEL = "VS"
TANGENTIAL = "tangential"
# An event function or a rate below this is zero, where it is asked which of several things a recorded point is.
SLOW = 1e-6
# A segment shorter than this, in periods, has vanished.
SHORT = 1e-6
# Values of an event function below this part of its largest are rounding.
ROUNDING = 64.0 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class MeetingFunction:
    """The function of an event that segment ``s`` does not end with, at the segment's end (or start).

    It is NaN where the orbit does not cross the event there in a direction that counts.
    """

    s: int
    event: str
    direction: str
    at_end: bool
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return the event function at the segment's end."""
        return self.evaluate_orbit(at.orbit)

    def evaluate_orbit(self, orbit: Orbit) -> float:
        """Return the same of an orbit."""
        profile = find_event_profile(orbit, self.event)
        value = profile.ends(self.s)[self.at_end]
        slope = profile.end_slope(self.s) if self.at_end else profile.start_slope(self.s)
        counts = {"rising": slope > 0.0, "falling": slope < 0.0}.get(self.direction, True)
        return value if counts else float("nan")

    def update_at(self, at: OrbitEvaluation) -> MeetingFunction:
        """Return the same function."""
        return self


def list_meetings(signature: Signature) -> list[MeetingFunction]:
    """Return the functions of each event that a segment watches and does not end with, at its start and end.

    Those that are zero for every orbit of the signature are left out.
    """
    model, segments = signature.numeric.model, signature.segments
    found = []
    for s, segment in enumerate(segments):
        if not segment.event:
            continue
        for watched in signature.list_watched_events(s):
            for at_end, made_by in ((True, segment.event), (False, segments[s - 1].event)):
                # An event lies at zero at the end that it makes itself.
                if watched.event != made_by and not vanishes_identically(
                    model, segments, s, watched.event, at_end=at_end
                ):
                    found.append(MeetingFunction(s, watched.event, watched.direction, at_end))
    return found


@dataclass(frozen=True, eq=False)
class TangencyFunction:
    """The rate at which segment ``s`` meets its event."""

    s: int
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return the rate."""
        return find_crossing_rate(at.orbit, self.s)

    def update_at(self, at: OrbitEvaluation) -> TangencyFunction:
        """Return the same function."""
        return self


@dataclass(frozen=True, eq=False)
class CoincidenceFunction:
    """The duration of segment ``s`` between two different events, less the little that is left of it."""

    s: int
    duration: float
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return the duration less what is left of it."""
        return float(at.orbit.durations[self.s] - self.duration)

    def update_at(self, at: OrbitEvaluation) -> CoincidenceFunction:
        """Return the same function."""
        return self


def _value_of(meeting: MeetingFunction) -> Callable[[CurvePoint[OrbitEvaluation]], float]:
    def value(point: CurvePoint[OrbitEvaluation]) -> float:
        # Along what sticks, the event that it began with stays at zero, to rounding of either sign.
        return float("nan") if _sticks(point.at.orbit, meeting) else meeting.evaluate(point.at)

    return value


def _sticks(orbit: Orbit, meeting: MeetingFunction) -> bool:
    """Return whether nothing but rounding is left of an event function all along the segment that ends in a meeting."""
    s = meeting.s if meeting.at_end else (meeting.s - 1) % len(orbit.signature)
    watched = find_event_profile(orbit, meeting.event)
    nothing = ROUNDING * float(np.max(np.abs(watched.values)))
    if not abs(watched.ends(meeting.s)[meeting.at_end]) <= nothing:
        return False
    along = make_profile(orbit, orbit.numeric.event(meeting.event), segments=(s,))
    return bool(np.max(np.abs(along.values)) <= nothing)


def _holds_for(meeting: MeetingFunction) -> Callable[[CurvePoint[OrbitEvaluation]], bool]:
    def holds(point: CurvePoint[OrbitEvaluation]) -> bool:
        # Where the condition changes by which a segment has begun, that is what happens.
        orbit = point.at.orbit
        before = (meeting.s - 1) % len(orbit.signature)
        return meeting.at_end or before not in list_guarded(orbit.signature) or abs(measure_guard(orbit, before)) > SLOW

    return holds


def _branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
    """Return the tests for events that are only touched, and for events that come in where a segment ends."""

    def rate(point: CurvePoint[OrbitEvaluation]) -> float:
        return find_smallest_crossing_rate(point.at.orbit)

    tests: list[OrbitTest] = [TestFunction(LABEL, rate, End.SPECIAL, make_reason(TANGENTIAL))]
    segments = at.orbit.signature.segments
    for meeting in list_meetings(at.orbit.signature):
        present = segments[meeting.s if meeting.at_end else meeting.s - 1].event
        reason = make_reason(MEETING, event=present, other=meeting.event)
        tests.append(TestFunction(LABEL, _value_of(meeting), End.SPECIAL, reason, holds=_holds_for(meeting)))
    return tests


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    """Return what vanishes at an orbit: a segment, a difference between two events, a rate, or nothing but a touch."""
    orbit = at.orbit
    s = find_shortest(orbit)
    if orbit.durations[s] < SHORT * np.sum(orbit.durations):
        return CoincidenceFunction(s, float(orbit.durations[s]))
    if reason.code == MEETING:
        met = [(abs(m.evaluate_orbit(orbit)), m) for m in list_meetings(orbit.signature)]
        near = [pair for pair in met if pair[0] < SLOW]
        if near:
            return min(near, key=lambda pair: pair[0])[1]
    rates = np.abs(find_crossing_rates(orbit))
    if np.any(rates < SLOW * np.nanmax(rates, initial=0.0)) or np.nanmin(rates, initial=1.0) < SLOW:
        return TangencyFunction(int(np.nanargmin(rates)))
    grazing = define_grazing(orbit)
    if grazing is None:
        raise ConvergenceError("no event function has an extremum inside a segment on this mesh; refine 'mesh'")
    return grazing


def _go_on(
    last: BranchPoint[OrbitEvaluation], before: BranchState[OrbitEvaluation], settings: BranchSettings
) -> CurvePoint[OrbitEvaluation] | None:
    """Return the orbit without the impact that died; None where two events meet, in whichever order they follow."""
    if last.reason.code == MEETING:
        return None
    at = last.state.point.at
    s = int(np.nanargmin(np.abs(find_crossing_rates(at.orbit))))
    shorter, guess = make_shorter_system(at, settings.rule, s)
    solved = solve_orbit(guess.with_free(()), settings.rule).at.orbit.with_free(at.orbit.problem.free)
    system = PeriodicOrbitSystem(solved.problem, shorter.sizes, settings.rule)
    found = system.at(solved.x)
    return CurvePoint(system, found, None, find_way_off(system, found))


VANISHING = SpecialPointKind(
    LABEL,
    "vanishing segment",
    on_branches=True,
    on_curves=True,
    branch_tests=_branch_tests,
    define=_define,
    good_side=lambda _: 1.0,
    go_on=_go_on,
)
