"""Whether an orbit does what its signature says: each event crossed in its direction, none crossed unlisted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pddecont.orbit.carried_events import list_carried_events, list_unlisted_carried_events
from pddecont.orbit.clocks import list_unlisted_clocks
from pddecont.orbit.durations import find_instants
from pddecont.orbit.event_profiles import find_event_profile, find_event_profiles
from pddecont.orbit.extrema import Extremum, Profile
from pddecont.orbit.guards import explain_guard, list_guarded, measure_guard
from pddecont.orbit.leaving import explain_sliding, find_leaving_rate, list_sliding_ends
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.repulsion import list_repellers
from pddecont.orbit.signature import WatchedEvent
from pddecont.orbit.verdict import Verifier
from pddecont.reasons import NO_REASON, Reason, make_reason

# An event function below this part of its largest modulus is zero.
RELATIVE_ZERO = 1e-9
# Two extrema closer than this, in periods, are one.
SAME_TIME = 1e-6
# An event function that moves by less than this part of its modulus in a segment's duration is touched, not crossed.
TANGENT = 1e-6
BACKWARDS = "crossed_backwards"
SIGNS = {"rising": 1, "falling": -1}


def find_violation(orbit: Orbit, referee: Verifier | None, *, strict: bool = False) -> Reason:
    """Return why an orbit is no motion of the model; no reason for one that is.

    A simulation that does all that the orbit does decides; where it does not, or there is none, so do the crossings of
    event functions. ``strict`` leaves no room for the orbit's errors.
    """
    if referee is not None and referee.verify(orbit, strict=True).verified == 1:
        return NO_REASON
    for violation in find_violations(orbit):
        return violation
    if referee is None:
        return NO_REASON
    verification = referee.verify(orbit, strict=strict)
    return verification.reason if verification.verified == 0 else NO_REASON


def find_violations(orbit: Orbit) -> list[Reason]:
    """Return what makes an orbit inadmissible; an empty list for an admissible orbit."""
    return orbit.once("violations", lambda: list(_find_violations(orbit)))


def _find_violations(orbit: Orbit) -> Iterator[Reason]:
    yield from _find_crossing_violations(orbit)
    if np.all(orbit.durations > find_instants(orbit)):
        yield from _find_unlisted(orbit)


def _find_unlisted(orbit: Orbit) -> Iterator[Reason]:
    """Yield what the motion does that no segment says: events that others make, other modes, sliding."""
    for clock in list_unlisted_clocks(orbit):
        if clock.measure(orbit) > RELATIVE_ZERO:
            yield clock.explain(orbit)
    for carried in list_carried_events(orbit):
        if carried.measure(orbit) < -RELATIVE_ZERO:
            yield carried.explain(orbit)
    for carried in list_unlisted_carried_events(orbit):
        if carried.measure(orbit) > RELATIVE_ZERO:
            yield carried.explain(orbit)
    for s in list_guarded(orbit.signature):
        if measure_guard(orbit, s) < -RELATIVE_ZERO:
            yield explain_guard(orbit.signature, s)
    for repeller in list_repellers(orbit):
        if repeller.measure(orbit) < -RELATIVE_ZERO:
            yield repeller.explain(orbit)
    for s in list_sliding_ends(orbit.signature):
        largest = float(np.max(np.abs(find_event_profile(orbit, orbit.signature.segments[s].event).values)))
        if find_leaving_rate(orbit, s) * orbit.period < -TANGENT * largest:
            yield explain_sliding(orbit.signature, s)


def _find_crossing_violations(orbit: Orbit) -> Iterator[Reason]:
    profiles = find_event_profiles(orbit)
    carried = {event.segment for event in list_carried_events(orbit)}
    instants = find_instants(orbit)
    for s, name in enumerate(orbit.signature.names):
        duration = float(orbit.durations[s])
        if duration <= instants[s]:
            yield make_reason("no_duration", number=s + 1, segment=name, duration=duration)
            continue
        for watched in orbit.signature.list_watched_events(s):
            for code, direction in _find_crossings(profiles[watched.event], s, watched):
                if code == BACKWARDS and s in carried:
                    # It ends by no crossing; whether the jump makes its event is asked of the jump.
                    continue
                yield make_reason(
                    code, number=s + 1, segment=name, event=watched.event, crossed=direction, listed=watched.direction
                )


def _find_crossings(profile: Profile, s: int, watched: WatchedEvent) -> Iterator[tuple[str, str]]:
    """Yield (code, direction) of each crossing of an event in a segment that should not be there."""
    start, end = profile.ends(s)
    levels = np.array([start, *profile.inner_levels(s), end])
    largest = float(np.max(np.abs(profile.values)))
    zero = RELATIVE_ZERO * max(largest, np.finfo(float).tiny)
    signs = np.where(np.abs(levels) <= zero, 0, np.sign(levels)).astype(int)
    if watched.terminal:
        signs[-1] = 0
        came_from = next((int(sign) for sign in signs[-2::-1] if sign), 0)
        wrong = SIGNS.get(watched.direction)
        # Where the surface is only touched, at the limit of orbits that cross it, the side says nothing.
        touched = abs(profile.end_slope(s)) * profile.duration(s) <= TANGENT * largest
        if came_from and came_from == wrong and not touched:
            yield BACKWARDS, "falling" if wrong == 1 else "rising"
    known = [int(sign) for sign in signs if sign]
    for before, after in pairwise(known):
        rises = after > before
        if before != after and (watched.direction == "any" or rises == (watched.direction == "rising")):
            yield "also_crossed", "rising" if rises else "falling"


@dataclass(frozen=True)
class ClosestApproach:
    """An interior extremum of an event function that could become a crossing.

    ``gap`` is negative before the event's surface is touched and zero where it is: the function itself at a maximum
    below the surface, minus it at a minimum above.
    """

    gap: float
    event: str
    extremum: Extremum


def find_approaches(orbit: Orbit) -> list[ClosestApproach]:
    """Return each interior extremum of an event function that could become a crossing."""
    return orbit.once("approaches", lambda: _find_approaches(orbit))


def _find_approaches(orbit: Orbit) -> list[ClosestApproach]:
    profiles, found = find_event_profiles(orbit), []
    for s in range(len(orbit.signature)):
        for watched in orbit.signature.list_watched_events(s):
            profile = profiles[watched.event]
            inside = [e for e in profile.extrema if e.segment == s]
            found += [
                ClosestApproach(gap, watched.event, e)
                for gap, e in _find_near_crossings(profile, s, watched.direction, inside)
            ]
    return found


def _find_near_crossings(
    profile: Profile, s: int, direction: str, inside: list[Extremum]
) -> Iterator[tuple[float, Extremum]]:
    """Yield the extrema of one segment that could become a crossing in ``direction``, with their gaps.

    A rising event is met from below, where maxima come near it. A segment may begin above, though, and fall through the
    surface once, which is no event; until then a minimum that dips below makes it rise again. Falling events are the
    same upside down.
    """
    if direction == "any":
        below = is_met_from_below(profile, s, direction)
        yield from ((e.value if below else -e.value, e) for e in inside if e.is_max == below)
        return
    sign = float(SIGNS[direction])
    if not inside:
        return
    start, end = (sign * value for value in profile.ends(s))
    zero = RELATIVE_ZERO * float(np.max(np.abs(profile.values)))
    levels = [sign * e.value for e in inside]
    if profile.closed:
        above = sign * float(np.median(profile.values)) > 0.0
    else:
        # From the surface itself the segment goes to the side of its first extremum.
        above = (start if abs(start) > zero else levels[0]) > 0.0
    for e, level, following in zip(inside, levels, [*levels[1:], end], strict=True):
        top = e.is_max == (sign > 0.0)
        if above and not top and level < 0.0 and following <= zero:
            above = False
        elif above and not top:
            yield -level, e
        elif not above and top:
            yield level, e


def find_closest_approach(
    orbit: Orbit, event: str | None = None, *, leave_out: tuple[str, int, float] | None = None
) -> ClosestApproach | None:
    """Return the interior extremum of an event function that is nearest to a new crossing (None: no extremum).

    ``event`` restricts it to one event; ``leave_out`` is the event, segment and time of an extremum that does not
    count.
    """

    def counts(a: ClosestApproach) -> bool:
        same = leave_out is not None and (a.event, a.extremum.segment) == leave_out[:2]
        left_out = same and abs(a.extremum.time - leave_out[2]) < SAME_TIME * orbit.period  # type: ignore[index]
        return event in (None, a.event) and not left_out

    return max((a for a in find_approaches(orbit) if counts(a)), key=lambda a: a.gap, default=None)


def is_met_from_below(profile: Profile, s: int, direction: str) -> bool:
    """Return whether an event is crossed from h < 0 in segment ``s``."""
    if direction == "any":
        return bool(np.median(profile.values[profile.segment == s]) < 0.0)
    return direction == "rising"
