"""Whether an orbit does what its signature says: each event crossed in its direction, none crossed unlisted."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.extrema import Extremum, Profile, profile
from pddecont.orbit.problem import INSTANT, OrbitProblem

Array = NDArray[np.float64]
RELATIVE_ZERO = 1e-9
SAME_TIME = 1e-6
TANGENT = 1e-6


def event_profiles(problem: OrbitProblem, x: Array) -> dict[str, Profile]:
    """Return the event functions along the orbit, by event, each over the segments that watch it."""
    watched = dict.fromkeys(event for s in range(len(problem.segments)) for event, _, _ in watched_events(problem, s))
    return {event: event_profile(problem, x, event) for event in watched}


def event_profile(problem: OrbitProblem, x: Array, event: str) -> Profile:
    """Return the function of ``event`` along the orbit, over the segments that watch it."""

    def along() -> Profile:
        watching = [s for s in range(len(problem.segments)) if any(event == e for e, _, _ in watched_events(problem, s))]
        return profile(problem, x, problem.numeric.event(event), segments=watching)

    found: Profile = problem.once(f"profile of {event}", x, along)
    return found


def watched_events(problem: OrbitProblem, s: int) -> Iterator[tuple[str, str, bool]]:
    """Yield (event, direction, whether it ends the segment) for the events with a function that segment ``s`` watches."""
    model = problem.numeric.model
    here = problem.segments[s]
    seen = set()
    for segment in model.segments.values():
        key = (segment.event, segment.direction)
        if segment.mode == here.mode and key not in seen and model.events[segment.event].function is not None:
            seen.add(key)
            yield segment.event, segment.direction, key == (here.event, here.direction)


def objections(problem: OrbitProblem, x: Array, profiles: dict[str, Profile] | None = None) -> list[str]:
    """Return what makes the orbit inadmissible, in words; an empty list for an admissible orbit."""
    profiles = event_profiles(problem, x) if profiles is None else profiles
    result = []
    durations = x[problem.layout.durations]
    for s, segment in enumerate(problem.segments):
        if durations[s] <= INSTANT * problem.period(x):
            result.append(f"segment {s + 1} ({segment.name}) has duration {durations[s]:.3g}")
            continue
        for event, direction, terminal in watched_events(problem, s):
            result += [f"segment {s + 1} ({segment.name}): {text}" for text in _crossings(profiles[event], s, event, direction, terminal)]
    return result


def _crossings(profile: Profile, s: int, event: str, direction: str, terminal: bool) -> Iterator[str]:
    start, end = profile.ends(s)
    interior = [e.value for e in profile.extrema if e.segment == s]
    levels = np.array([start, *interior, end])
    zero = RELATIVE_ZERO * max(float(np.max(np.abs(profile.values))), np.finfo(float).tiny)
    signs = np.where(np.abs(levels) <= zero, 0, np.sign(levels)).astype(int)
    if terminal:
        signs[-1] = 0
        came_from = next((int(sign) for sign in signs[-2::-1] if sign), 0)
        wrong = {"rising": 1, "falling": -1}.get(direction)
        # Where the surface is only touched, at the limit of orbits that cross it, the side says nothing.
        touched = abs(profile.end_slope(s)) * profile.duration(s) <= TANGENT * float(np.max(np.abs(profile.values)))
        if came_from and came_from == wrong and not touched:
            yield f"event '{event}' is crossed {'falling' if wrong == 1 else 'rising'} at its end, not {direction}"
    known = [int(sign) for sign in signs if sign]
    for before, after in pairwise(known):
        rises = after > before
        if before != after and (direction == "any" or rises == (direction == "rising")):
            yield f"event '{event}' is also crossed {'rising' if rises else 'falling'} inside"


def approaches(problem: OrbitProblem, profiles: dict[str, Profile]) -> list[tuple[float, str, Extremum]]:
    """Return (height, event, extremum) for each interior extremum that could become a crossing: zero at a touch, negative before.

    The height is h at a maximum below the surface and -h at a minimum above it.
    """
    found = []
    for s in range(len(problem.segments)):
        for name, direction, _ in watched_events(problem, s):
            if name in profiles:
                inside = [e for e in profiles[name].extrema if e.segment == s]
                found += [(height, name, e) for height, e in _near_crossings(profiles[name], s, direction, inside)]
    return found


def _near_crossings(profile: Profile, s: int, direction: str, inside: list[Extremum]) -> Iterator[tuple[float, Extremum]]:
    """Yield the extrema of one segment that could become a crossing in ``direction``, with their heights.

    A rising event is met from below, where maxima come near it. A segment may begin above, though, and fall through the surface once,
    which is no event; until then a minimum that dips below makes it rise again. Falling events are the same upside down.
    """
    if direction == "any":
        below = from_below(profile, s, direction)
        yield from ((e.value if below else -e.value, e) for e in inside if e.is_max == below)
        return
    sign = 1.0 if direction == "rising" else -1.0
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


def closest_approach(problem: OrbitProblem, profiles: dict[str, Profile], only: str | None = None, *,
                     leave_out: tuple[str, int, float] | None = None) -> tuple[str, Extremum] | None:  # fmt: skip
    """Return the event and the interior extremum of its function that is nearest to a new crossing (None: no extremum).

    ``only`` restricts it to one event; ``leave_out`` is the event, segment and time of an extremum that does not count.
    """
    period = sum(float(np.sum(p.h)) for p in list(profiles.values())[:1])
    found = [a for a in approaches(problem, profiles) if only in (None, a[1]) and not _is(a[2], a[1], leave_out, period)]
    best = max(found, key=lambda a: a[0], default=None)
    return None if best is None else best[1:]


def _is(extremum: Extremum, event: str, named: tuple[str, int, float] | None, period: float) -> bool:
    return named is not None and (event, extremum.segment) == named[:2] and abs(extremum.time - named[2]) < SAME_TIME * period


def from_below(profile: Profile, s: int, direction: str) -> bool:
    """Whether the event is crossed from h < 0 in segment ``s``."""
    if direction == "any":
        return bool(np.median(profile.values[profile.segment == s]) < 0.0)
    return direction == "rising"
