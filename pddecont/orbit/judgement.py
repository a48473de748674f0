"""Whether what a motion does across the end of a segment is what the orbit does there.

It has to meet the event that ends the segment, when it ends, and nothing else, and to be where the orbit is then. Where
an orbit lies so near to the border of what its signature can do that its own error decides, two answers are possible.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pddecont.orbit.admissibility import SIGNS
from pddecont.orbit.carried_events import list_carried_events, list_unlisted_carried_events
from pddecont.orbit.durations import measure_left_out
from pddecont.orbit.event_profiles import find_event_profile
from pddecont.orbit.examination import Examination, Window
from pddecont.orbit.guards import explain_guard, is_alternative, measure_guard
from pddecont.orbit.leaving import find_leaving_rate, list_sliding_ends
from pddecont.orbit.signature import Signature
from pddecont.orbit.verdict import DRIFTS, NOT_DONE, Verification
from pddecont.reasons import Reason, Scalar, make_reason
from pddecont.simulate import FailureReason, MotionFailure, MotionRecord

# How far simulation and orbit may be apart, relative to the size of the motion: what the errors of the simulation's
# steps add up to, and so many times the orbit's own estimated error.
SIMULATED, ESTIMATED = 1e-7, 30.0
# So many times as far as the orbit's error is carried to in the same time.
CARRIED = 30.0
# The part of its size by which an orbit is moved to see how far errors are carried, where its own error is smaller.
SMALLEST_MOVE = 1e-8
# A surface is touched if it is met more slowly than this times the root of what errors are, in sizes and periods.
SLOW = 10.0


def judge(examined: Examination, window: Window, record: MotionRecord | None, *, strict: bool) -> Verification:
    """Return whether what the motion does in a window is what the orbit does.

    An orbit at the border of what it does counts as a motion, unless ``strict``; how far it deviates nobody knows then.
    """
    if record is None:
        return replace(NOT_DONE, reason=make_reason("too_many_steps"))
    segment = examined.orbit.signature.segments[window.s]
    if record.failure is not None or not _meets(examined.orbit.signature, window.s, record.segments):
        if not strict and is_undecided(examined, window, record):
            return Verification(1)
        return Verification(0, reason=_describe(examined, window, record))
    deviation = max(measure_deviation(examined, window, record), measure_left_out(examined.orbit, window.s))
    if deviation <= find_allowed(examined) or deviation <= CARRIED * find_carried(examined, window, record, strict):
        return Verification(1, deviation)
    return Verification(0, deviation, make_reason(DRIFTS, number=window.s + 1, segment=segment.name))


def _meets(signature: Signature, s: int, found: Sequence[str]) -> bool:
    """Return whether a motion meets what ends segment ``s`` and nothing else.

    Of impacts that accumulate the motion may follow more than the orbit does, or fewer; whether those left out were
    negligible is seen where the motion is after them.
    """
    model, segment = signature.numeric.model, signature.segments[s]
    if s in signature.trailing or segment.rests:
        return {way.name for way in model.list_ways(segment)}.issuperset(found)
    return tuple(found) == ((segment.name,) if segment.event else ())


def find_allowed(examined: Examination) -> float:
    """Return how far simulation and orbit may be apart, if errors are not carried farther.

    A simulation is exact to a part of the states, whatever they move by.
    """
    return SIMULATED * examined.remoteness + ESTIMATED * examined.error


def measure_deviation(examined: Examination, window: Window, record: MotionRecord) -> float:
    """Return how far simulation and orbit are apart in a window."""
    apart = float(np.max(np.abs(record.states - window.target) / examined.sizes))
    if len(record.times):
        late = abs(float(record.times[0]) - examined.orbit.start - window.event) / examined.orbit.period
        apart = max(apart, late)
    return apart


def find_carried(examined: Examination, window: Window, record: MotionRecord, strict: bool) -> float:
    """Return how far apart motions are at the end of a window that begin as far apart as the orbit is wrong.

    A motion that goes another way than ``record`` says nothing of it. Where all do so, at a border that lies within
    the orbit's error, every distance is possible (infinity), unless ``strict``.
    """
    error = max(examined.error, SMALLEST_MOVE)
    farthest, at_border = 0.0, False
    for moved in (error, -error):
        other = examined.simulate(window, moved)
        if other is None:
            continue
        if other.failure is None and other.segments == record.segments:
            farthest = max(farthest, float(np.max(np.abs(other.states - record.states) / examined.sizes)))
        else:
            at_border = at_border or is_undecided(examined, window, other)
    return np.inf if farthest == 0.0 and at_border and not strict else farthest


def is_undecided(examined: Examination, window: Window, record: MotionRecord) -> bool:
    """Return whether the orbit lies at the border of what it does and what the motion does instead.

    Two events come at once, a surface is only touched, or the motion hardly leaves it, to the orbit's error: rounding
    decides which happens.
    """
    orbit = examined.orbit
    model, segment = orbit.numeric.model, orbit.signature.segments[window.s]
    if not segment.event:
        first = zip(record.times[:1].tolist(), record.segments[:1], strict=True)
        return any(_is_near(examined, model.segments[k].event, window.s, t - orbit.start) for t, k in first)
    if _touches(examined, window.s) and _misses_touch(examined, window, record):
        return True
    if record.failure is not None and record.failure.reason == FailureReason.SLIDING:
        return record.failure.event == segment.event and _hardly_leaves(examined, window.s)
    unexpected = find_unexpected(examined, window, record)
    if _is_hardly_carried(examined, segment.event if unexpected is None else model.segments[unexpected[1]].event):
        return True
    if unexpected is None:
        return _ends_before_event(examined, window, record)
    t, name = unexpected
    if is_alternative(orbit.signature, window.s, name):
        return abs(measure_guard(orbit, window.s)) <= find_allowed(examined)
    if abs(t - window.event) <= find_allowed(examined) * orbit.period:
        return True
    event = model.segments[name].event
    within = window.s if t < window.event else (window.s + 1) % len(orbit.signature)
    return model.events[event].function is not None and _is_near(examined, event, within, t)


def find_unexpected(examined: Examination, window: Window, record: MotionRecord) -> tuple[float, str] | None:
    """Return the first event in a window that is not the one at the segment's end; None if there is no other.

    It is given by its time after the orbit's start and the segment that it ended. Of several events like the expected
    one the nearest in time is that.
    """
    segment = examined.orbit.signature.segments[window.s]
    events = list(zip((record.times - examined.orbit.start).tolist(), record.segments, strict=True))
    alike = [k for k, (_, name) in enumerate(events) if segment.event and name == segment.name]
    expected = min(alike, key=lambda k: abs(events[k][0] - window.event), default=None)
    return next((event for k, event in enumerate(events) if k != expected), None)


def _ends_before_event(examined: Examination, window: Window, record: MotionRecord) -> bool:
    """Return whether the window ends so soon after the event that errors in time decide whether it holds the event.

    The motion has to be where the orbit is then.
    """
    allowed = find_allowed(examined)
    soon = window.end - window.event <= allowed * examined.orbit.period
    nothing = record.failure is None and not record.segments
    return soon and nothing and measure_deviation(examined, window, record) <= allowed


def _touches(examined: Examination, s: int) -> bool:
    """Return whether segment ``s`` meets the surface of its event so slowly that it may miss it."""
    orbit = examined.orbit
    event = orbit.signature.segments[s].event
    if orbit.numeric.model.events[event].function is None:
        return False
    profile = find_event_profile(orbit, event)
    largest = float(np.max(np.abs(profile.values)))
    rate = abs(profile.end_slope(s)) * orbit.period
    return bool(rate <= SLOW * np.sqrt(find_allowed(examined)) * largest)


def _hardly_leaves(examined: Examination, s: int) -> bool:
    """Return whether the motion leaves the surface that segment ``s`` ends at so slowly that it may be held there."""
    orbit = examined.orbit
    if s not in list_sliding_ends(orbit.signature):
        return False
    largest = float(np.max(np.abs(find_event_profile(orbit, orbit.signature.segments[s].event).values)))
    return abs(find_leaving_rate(orbit, s)) * orbit.period <= CARRIED * find_allowed(examined) * largest


def _is_hardly_carried(examined: Examination, event: str) -> bool:
    """Return whether a jump that comes back carries an event's function just to its zero, as far as errors tell."""
    orbit, allowed = examined.orbit, find_allowed(examined)
    found = [*list_carried_events(orbit), *list_unlisted_carried_events(orbit)]
    return any(carried.event == event and abs(carried.measure(orbit)) <= allowed for carried in found)


def _misses_touch(examined: Examination, window: Window, record: MotionRecord) -> bool:
    """Return whether all that goes wrong in a window is that the surface at its event is missed, or met once more.

    What a motion does after it has missed a surface is another matter; nothing else may happen before.
    """
    orbit = examined.orbit
    segment = orbit.signature.segments[window.s]
    near = window.event - np.sqrt(find_allowed(examined)) * orbit.period
    events = [(float(t) - orbit.start, name) for t, name in zip(record.times, record.segments, strict=True)]
    failure = record.failure
    stops = [t for t, _ in events[:1]]
    stops += [failure.time - orbit.start] if failure is not None and np.isfinite(failure.time) else []
    if any(t < near for t in stops):
        return False
    if not events or events[0][1] != segment.name:
        return True
    if len(events) > 1:
        return orbit.numeric.model.segments[events[1][1]].event == segment.event
    return failure is None or failure.event == segment.event


def _is_near(examined: Examination, event: str, s: int, t: float) -> bool:
    """Return whether the function of ``event`` goes beyond zero in segment ``s`` by no more than errors do, near ``t``.

    The time counts from the orbit's start.
    """
    orbit = examined.orbit
    watched = {w.event: w for w in orbit.signature.list_watched_events(s)}
    if event not in watched:
        return False
    profile = find_event_profile(orbit, event)
    allowed = find_allowed(examined)
    levels = [(e.time, e.value) for e in profile.extrema if e.segment == s]
    if watched[event].direction in SIGNS:
        # What is crossed by no more than this is touched; where the event itself ends or began the segment it is zero.
        made_by = orbit.signature.segments[s - 1].event, orbit.signature.segments[s].event
        ends = zip(orbit.event_times[[s, s + 1]].tolist(), profile.ends(s), made_by, strict=True)
        levels += [(time, value) for time, value, other in ends if other != event]
    largest = float(np.max(np.abs(profile.values)))
    # A parabola that goes beyond zero by so much has its zeros as near to its top as the square root says.
    near = SLOW * np.sqrt(allowed) * orbit.period
    away = [min((t - time) % orbit.period, (time - t) % orbit.period) for time, _ in levels]
    return any(gap <= near and abs(value) <= allowed * largest for gap, (_, value) in zip(away, levels, strict=True))


def _describe(examined: Examination, window: Window, record: MotionRecord) -> Reason:
    """Return what the motion does in a window instead of what the orbit does."""
    orbit = examined.orbit
    segment = orbit.signature.segments[window.s]
    where: dict[str, Scalar] = {"number": window.s + 1, "segment": segment.name}
    if record.failure is not None:
        return _describe_failure(record.failure, where)
    unexpected = find_unexpected(examined, window, record)
    if unexpected is None:
        return Reason("missing", {"event": segment.event, **where})
    t, name = unexpected
    if is_alternative(orbit.signature, window.s, name):
        return explain_guard(orbit.signature, window.s)
    number = (window.s + int(t >= window.event)) % len(orbit.signature)
    return make_reason(
        "happens",
        number=number + 1,
        segment=orbit.signature.names[number],
        event=orbit.numeric.model.segments[name].event,
        instead=name,
        time=t,
    )


def _describe_failure(failure: MotionFailure, where: dict[str, Scalar]) -> Reason:
    code = "slides" if failure.reason == FailureReason.SLIDING else "halts"
    values: dict[str, Scalar] = {"event": failure.event or "", "mode": failure.mode or "", "why": failure.reason.value}
    return Reason(code, {**where, **values})
