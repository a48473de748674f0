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
    ClosestApproach,
    Orbit,
    OrbitEvaluation,
    find_approaches,
    find_closest_approach,
    find_event_profile,
    name_grazing,
)
from pddecont.reasons import Reason, Scalar, make_reason

LABEL = "GR"
# Codes of double grazings: the orbit that is special otherwise grazes too; one that grazes does so elsewhere too.
GRAZING_TOO, GRAZING_TWICE = "grazing", "grazing_twice"


def measure_grazing_gap(orbit: Orbit) -> float:
    """Return the grazing test function of an orbit (NaN if no segment has an interior extremum)."""
    return _measure_gap(find_closest_approach(orbit))


def _measure_gap(approach: ClosestApproach | None) -> float:
    return float("nan") if approach is None else approach.gap


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

    def find_other(self, orbit: Orbit) -> ClosestApproach | None:
        """Return where an orbit is nearest to a second grazing (None if nothing else has an extremum)."""
        extrema = self._find_extrema(orbit)
        fraction = min(extrema)[2] if extrema else self.fraction
        time = float(orbit.event_times[self.segment] + fraction * orbit.durations[self.segment])
        return find_closest_approach(orbit, leave_out=(self.event, self.segment, time))

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
    return None if found is None else _define_at(orbit, found)


def _define_at(orbit: Orbit, approach: ClosestApproach) -> GrazingFunction:
    e = approach.extremum
    fraction = (e.time - float(orbit.event_times[e.segment])) / float(orbit.durations[e.segment])
    return GrazingFunction(approach.event, e.segment, fraction, e.is_max)


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
            return _measure_gap(own.find_other(point.at.orbit))

        return [TestFunction(DOUBLE_GRAZING.label, value, explain=_name_both)]
    if isinstance(defining, UserFunction):
        return []
    label, reason = DOUBLE_GRAZING.label, make_reason(GRAZING_TOO)
    return [TestFunction(label, lambda point: measure_grazing_gap(point.at.orbit), reason=reason)]


def _name_both(point: CurvePoint[ExtendedEvaluation]) -> Reason:
    """Return what is said of a point of a curve of grazings at which another extremum grazes too."""
    orbit, own = point.at.orbit, point.at.system.defining
    assert isinstance(own, GrazingFunction)
    other, own = own.find_other(orbit), own.update_at(point.at.inner)
    assert other is not None, "it is zero"
    return _pack_both(_define_at(orbit, other), own)


def _pack_both(grazing: GrazingFunction, own: GrazingFunction) -> Reason:
    """Return as a reason the grazing that begins, and the curve's own."""
    both = (("", grazing), ("own_", own))
    values: dict[str, Scalar] = {}
    for prefix, one in both:
        values |= {f"{prefix}event": one.event, f"{prefix}number": one.segment + 1}
        values |= {f"{prefix}part": one.fraction, f"{prefix}is_max": one.is_max}
    return make_reason(GRAZING_TWICE, **values)


def exchange(reason: Reason) -> Reason:
    """Return what is recorded of a double grazing as it is seen from the curve of the other one."""
    own = {key: value for key, value in reason.values.items() if key.startswith("own_")}
    other = {f"own_{key}": value for key, value in reason.values.items() if key not in own}
    return make_reason(reason.code, **{key.removeprefix("own_"): value for key, value in own.items()}, **other)


def _define(at: OrbitEvaluation, settings: BranchSettings, reason: Reason) -> DefiningFunction:
    if reason.code == GRAZING_TWICE:
        v = reason.values
        return GrazingFunction(str(v["event"]), int(v["number"]) - 1, float(v["part"]), bool(v["is_max"]))
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
DOUBLE_GRAZING = SpecialPointKind(
    "GG", "double grazing", on_curves=True, curve_tests=_second_grazing, meets=(LABEL, LABEL)
)
