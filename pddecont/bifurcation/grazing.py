"""Grazing (GR): an event function touches zero inside a segment.

The test function is the extremum of h that lies nearest to a new crossing: in segments that watch a rising event (h < 0
inside) the largest interior maximum, in those that watch a falling one minus the smallest interior minimum. It is
negative for an admissible orbit and zero where the orbit grazes. Along a branch each segment and event has its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation
from pddecont.bifurcation.kinds import CurveTest, OrbitTest, SpecialPointKind
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.signature_insertion import enter_signature
from pddecont.bifurcation.user_function import UserFunction
from pddecont.continuation import BranchPoint, BranchState, CurvePoint, End, TestFunction
from pddecont.errors import ConvergenceError
from pddecont.orbit import (
    Orbit,
    OrbitEvaluation,
    find_approaches,
    find_closest_approach,
    find_event_profile,
    name_grazing,
)
from pddecont.reasons import Reason, make_reason

LABEL = "GR"
GRAZING_TOO = "grazing"


def measure_grazing_gap(orbit: Orbit, *, leave_out: tuple[str, int, float] | None = None) -> float:
    """Return the grazing test function of an orbit (NaN if no segment has an interior extremum).

    ``leave_out`` names one extremum that does not count by its event, segment and time.
    """
    found = find_closest_approach(orbit, leave_out=leave_out)
    return float("nan") if found is None else found.gap


def _gaps(orbit: Orbit) -> dict[tuple[int, str], float]:
    """Return the test function of each segment and event, so that none hides another."""
    gaps: dict[tuple[int, str], float] = {}
    for a in find_approaches(orbit):
        key = (a.extremum.segment, a.event)
        gaps[key] = max(a.gap, gaps.get(key, -np.inf))
    return gaps


@dataclass(frozen=True)
class GrazingFunction:
    """The extremum of an event function in ``segment``, near ``fraction`` of its duration."""

    event: str
    segment: int
    fraction: float
    is_max: bool
    kind: str = LABEL

    def evaluate(self, at: OrbitEvaluation) -> float:
        """Return the extremum (NaN if there is none)."""
        extrema = self._find_extrema(at.orbit)
        return min(extrema)[1] if extrema else float("nan")

    def update_at(self, at: OrbitEvaluation) -> GrazingFunction:
        """Return the same function with the extremum looked for where it is at an orbit."""
        extrema = self._find_extrema(at.orbit)
        return replace(self, fraction=min(extrema)[2]) if extrema else self

    def other_gap(self, orbit: Orbit) -> float:
        """Return how near an orbit comes to a second grazing (NaN if nothing else has an extremum)."""
        extrema = self._find_extrema(orbit)
        fraction = min(extrema)[2] if extrema else self.fraction
        time = float(orbit.event_times[self.segment] + fraction * orbit.durations[self.segment])
        return measure_grazing_gap(orbit, leave_out=(self.event, self.segment, time))

    def _find_extrema(self, orbit: Orbit) -> list[tuple[float, float, float]]:
        """Return (distance, value, fraction) of each extremum that could be the one meant."""
        begin, duration = float(orbit.event_times[self.segment]), float(orbit.durations[self.segment])
        found, closed = [], not orbit.signature.has_events
        for e in find_event_profile(orbit, self.event).extrema:
            if e.segment == self.segment and e.is_max == self.is_max:
                fraction = (e.time - begin) / duration
                apart = abs(fraction - self.fraction)
                found.append((min(apart, 1.0 - apart) if closed else apart, e.value, fraction))
        return found


def define_grazing(orbit: Orbit) -> GrazingFunction | None:
    """Return the grazing of an orbit's closest approach to an event (None if it has no interior extremum)."""
    found = find_closest_approach(orbit)
    if found is None:
        return None
    e = found.extremum
    fraction = (e.time - float(orbit.event_times[e.segment])) / float(orbit.durations[e.segment])
    return GrazingFunction(found.event, e.segment, fraction, e.is_max)


def _branch_tests(at: OrbitEvaluation, settings: BranchSettings) -> list[OrbitTest]:
    return make_grazing_tests(at, LABEL)


def make_grazing_tests(at: OrbitEvaluation, label: str) -> list[OrbitTest]:
    """Return the test of each segment and event that it watches, for points that have the label."""

    def test(s: int, event: str) -> OrbitTest:
        def value(point: CurvePoint[OrbitEvaluation]) -> float:
            orbit = point.at.orbit
            return orbit.once("grazing gaps", lambda: _gaps(orbit)).get((s, event), float("nan"))

        def holds(point: CurvePoint[OrbitEvaluation]) -> bool:
            return (name_grazing(point.at.orbit, s, event) or LABEL) == label

        return TestFunction(label, value, End.SPECIAL, holds=holds)

    signature = at.orbit.signature
    pairs = dict.fromkeys((s, w.event) for s in range(len(signature)) for w in signature.list_watched_events(s))
    return [test(*pair) for pair in pairs]


def _second_grazing(at: ExtendedEvaluation, settings: BranchSettings) -> list[CurveTest]:
    """Return the test for a (second) grazing along a curve of special points."""
    defining = at.system.defining
    if isinstance(defining, GrazingFunction):

        def value(point: CurvePoint[ExtendedEvaluation]) -> float:
            own = point.at.system.defining
            assert isinstance(own, GrazingFunction)
            return own.other_gap(point.at.orbit)

        return [TestFunction(DOUBLE_GRAZING.label, value)]
    if isinstance(defining, UserFunction):
        return []
    label, reason = DOUBLE_GRAZING.label, make_reason(GRAZING_TOO)
    return [TestFunction(label, lambda point: measure_grazing_gap(point.at.orbit), reason=reason)]


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    defining = define_grazing(at.orbit)
    if defining is None:
        raise ConvergenceError("no event function has an extremum inside a segment on this mesh; refine 'mesh'")
    return defining


def _good_side(defining: DefiningFunction) -> float:
    return 1.0 if isinstance(defining, GrazingFunction) and not defining.is_max else -1.0


def _go_on(
    last: BranchPoint[OrbitEvaluation], before: BranchState[OrbitEvaluation], settings: BranchSettings
) -> CurvePoint[OrbitEvaluation]:
    return enter_signature(last.state.point.at, settings.rule)


GRAZING = SpecialPointKind(
    LABEL, "grazing", on_branches=True, branch_tests=_branch_tests, define=_define, good_side=_good_side, go_on=_go_on
)
DOUBLE_GRAZING = SpecialPointKind("GG", "double grazing", on_curves=True, curve_tests=_second_grazing)
