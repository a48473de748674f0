"""Segments removed where one vanishes.

A point where a segment between two crossings of one event vanishes is a grazing of the shorter signature, and is solved
as one; between two different events both happen at once there. Both signatures meet in one orbit.

References: as in ``signature_insertion``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.chatter import end_rest, is_rest
from pddecont.bifurcation.crossing_rates import find_crossing_rate
from pddecont.bifurcation.extended_system import ExtendedEvaluation, solve_special_orbit
from pddecont.bifurcation.grazing import define_grazing
from pddecont.bifurcation.signature_insertion import INSIDE, STEP, set_duration
from pddecont.collocation import MeshRule
from pddecont.continuation import CurvePoint, find_tangent
from pddecont.errors import ConvergenceError
from pddecont.orbit import (
    INSTANT,
    Orbit,
    OrbitEvaluation,
    PeriodicOrbitSystem,
    SegmentSpan,
    find_event_profile,
    find_shortest,
    make_eventless,
    resegment,
)
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]
MEETING, VANISHING, RELEASED = "meeting", "vanishing", "released"
# A segment between two events that come to happen at once is followed down to this duration, in periods.
AT_ONCE = 1e-9
# Where equations do not determine an orbit so near, this is near enough.
NEARLY_AT_ONCE = 1e-6
# What is left of it then, in periods: the equations have no orbit with a segment of no duration.
RESIDUE = 2.0 * INSTANT
# A segment that vanishes is shortened by this factor at a time.
SHRINK = 0.3
# The duration, in periods, at which a segment of a special orbit has vanished: what is left of it changes the
# parameters by its square.
NOTHING = 1e-5
# Impacts so slow that in a period they would go less than this part of the way, and contacts not longer than SEVERAL
# times the one that vanishes, vanish with it.
TOGETHER, SEVERAL = 1e-5, 2.0
# At a point where a segment vanishes the branch has no direction: it ends, or goes on in other unknowns.
NO_DIRECTION = np.zeros(0)


def remove_segment(orbit: Orbit, rule: MeshRule, s: int) -> Orbit:
    """Return the orbit without what vanishes at the end of segment ``s``, as a guess.

    A soft segment s + 1 of small duration goes with both its events; a hard impact of small speed goes with its reset.

    Raises
    ------
    ConvergenceError
        If the orbit does not go on in the mode of segment ``s``.
    """
    fixed = orbit.with_free(())
    segments, ends = fixed.signature.segments, fixed.event_times
    S, period = len(segments), ends[-1]
    here, after = segments[s], segments[(s + 1) % S]
    n_merged = 2 if after.mode == here.mode else 3
    if n_merged == 3 and segments[(s + 2) % S].mode != here.mode:
        raise ConvergenceError(f"mode '{after.mode}' vanishes, but the orbit does not go on in mode '{here.mode}'")
    if n_merged > S:
        spans = [SegmentSpan(make_eventless(orbit.numeric.model, here.mode), ends[s + 1] - period, ends[s + 1])]
    else:
        order = [(s + k) % S for k in range(S)]
        begin = np.concatenate([[0.0], np.cumsum(np.diff(ends)[order])]) + ends[s]
        merged = SegmentSpan(segments[order[n_merged - 1]], begin[0], begin[n_merged])
        rest = [SegmentSpan(segments[order[k]], begin[k], begin[k + 1]) for k in range(n_merged, S)]
        spans = [merged, *rest]
    return resegment(fixed, spans, rule, fixed.problem.n_periods)


def make_shorter_system(at: OrbitEvaluation, rule: MeshRule, s: int) -> tuple[PeriodicOrbitSystem, Orbit]:
    """Return the system of orbits without what vanishes at the end of segment ``s``, and the orbit as a guess in it.

    What vanishes at once with it, by a symmetry of the orbit, goes too.
    """
    guess = remove_segment(at.orbit, rule, s)
    while True:
        others = [t for t in range(len(guess.signature)) if _vanishes_too(guess, t)]
        if not others:
            break
        guess = remove_segment(guess, rule, others[0])
    guess = guess.with_free(at.orbit.problem.free)
    return PeriodicOrbitSystem(guess.problem, at.system.sizes, rule), guess


def _vanishes_too(orbit: Orbit, s: int) -> bool:
    """Return whether the contact that follows segment ``s`` has no duration, or the impact no speed, to speak of."""
    segments, n = orbit.signature.segments, len(orbit.signature)
    here, after = segments[s], segments[(s + 1) % n]
    if not here.event or orbit.numeric.model.events[here.event].function is None or s in orbit.signature.trailing:
        return False
    if here.to == here.mode:
        largest = float(np.max(np.abs(find_event_profile(orbit, here.event).values)))
        return abs(find_crossing_rate(orbit, s)) * orbit.period < TOGETHER * largest
    short = orbit.durations[(s + 1) % n] < SEVERAL * INSIDE * orbit.period
    return bool(short and n > 2 and after.event == here.event and segments[(s + 2) % n].mode == here.mode)


@dataclass(frozen=True, eq=False)
class VanishedSegment:
    """Where a segment's duration reaches zero: the special orbit, and whether it is one of the shorter signature."""

    point: CurvePoint[OrbitEvaluation]
    reason: Reason
    shorter: bool


def vanish_segment(point: CurvePoint[OrbitEvaluation], rule: MeshRule) -> VanishedSegment:
    """Return the point at which the shortest segment of an orbit vanishes as the branch goes on.

    Raises
    ------
    ConvergenceError
        If it cannot be reached.
    """
    s = find_shortest(point.at.orbit)
    signature = point.at.orbit.signature
    before, segment = signature.segments[s - 1], signature.segments[s]
    if is_rest(signature, s):
        reason = make_reason(RELEASED, event=before.event, segment=segment.name)
        return VanishedSegment(replace(end_rest(point, s), direction=NO_DIRECTION), reason, False)
    same = before.event == segment.event
    if not same:
        reason = make_reason(MEETING, event=before.event, other=segment.event)
        return VanishedSegment(replace(_let_meet(point, s), direction=NO_DIRECTION), reason, False)
    last = INSIDE * point.at.orbit.period
    while point.at.orbit.durations[s] > last:
        point = set_duration(point.at.system, point.x, s, max(last, SHRINK * float(point.at.orbit.durations[s])))
    shorter, guess = make_shorter_system(point.at, rule, (s - 1) % len(signature))
    defining = define_grazing(guess)
    if defining is None:
        raise ConvergenceError(f"segment {segment.name} vanishes, but the orbit without it touches nothing")
    special, solution = solve_special_orbit(shorter, guess.x, defining)
    found = CurvePoint(special.inner, solution.at.inner, solution, NO_DIRECTION)
    return VanishedSegment(found, make_reason(VANISHING, segment=segment.name), True)


def _let_meet(point: CurvePoint[OrbitEvaluation], s: int) -> CurvePoint[OrbitEvaluation]:
    """Return the orbit at which the two events at the ends of segment ``s`` happen at once.

    It lies on the line through two orbits with short segments; the error is of the order of the square of the duration.
    """
    # The last of impacts that accumulate would be too near to one another to be told apart.
    accumulate = bool(point.at.orbit.signature.trailing)
    last = (NEARLY_AT_ONCE if accumulate else AT_ONCE) * point.at.orbit.period
    if point.at.orbit.durations[s] <= last:
        point = set_duration(point.at.system, point.x, s, last / SHRINK)
    longer = point
    try:
        while point.at.orbit.durations[s] > last:
            shorter = set_duration(point.at.system, point.x, s, SHRINK * float(point.at.orbit.durations[s]))
            longer, point = point, shorter
    except ConvergenceError:
        if point.at.orbit.durations[s] > NEARLY_AT_ONCE * point.at.orbit.period:
            raise
    if longer is point or accumulate:
        return point
    long, short = (float(p.at.orbit.durations[s]) for p in (longer, point))
    on = (short - RESIDUE * point.at.orbit.period) / (long - short)
    system = point.system
    x = point.x + on * (point.x - system.interpolate_from(longer.system, longer.x))
    return replace(point, at=system.at(x))


def shrink_segment(at: ExtendedEvaluation) -> tuple[CurvePoint[ExtendedEvaluation], str]:
    """Return the point of a curve in two parameters whose shortest segment has vanished, and that segment's name.

    Raises
    ------
    ConvergenceError
        If it cannot be reached.
    """
    s = find_shortest(at.orbit)
    last = NOTHING * at.orbit.period
    while True:
        point = set_duration(at.system, at.x, s, max(last, SHRINK * float(at.orbit.durations[s])))
        at = point.at
        if at.orbit.durations[s] <= last * (1.0 + 1e-9):
            return replace(point, direction=NO_DIRECTION), at.orbit.signature.names[s]


def find_way_off(system: PeriodicOrbitSystem, at: OrbitEvaluation) -> Array:
    """Return the tangent at a grazing orbit along which it comes free."""
    towards = np.zeros(len(at.x))
    towards[at.orbit.problem.unknowns.free.start] = 1.0
    direction = find_tangent(at, system.scaling, towards)
    defining = define_grazing(at.orbit)
    if defining is None:
        raise ConvergenceError("the orbit without the segment that vanishes touches nothing")
    low, high = (defining.evaluate(system.at(at.x + k * STEP * direction)) for k in (-1.0, 1.0))
    sign = 1.0 if defining.is_max else -1.0
    return direction if sign * (high - low) < 0.0 else -direction
