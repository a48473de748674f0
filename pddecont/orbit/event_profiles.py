"""Event functions along an orbit, over the segments that watch them."""

from __future__ import annotations

from pddecont.orbit.extrema import Profile, make_profile
from pddecont.orbit.orbit import Orbit


def find_event_profiles(orbit: Orbit) -> dict[str, Profile]:
    """Return the event functions along an orbit, by event, each over the segments that watch it."""
    signature = orbit.signature
    events = dict.fromkeys(w.event for s in range(len(signature)) for w in signature.list_watched_events(s))
    return {event: find_event_profile(orbit, event) for event in events}


def find_event_profile(orbit: Orbit, event: str) -> Profile:
    """Return the function of ``event`` along an orbit, over the segments that watch it."""
    signature = orbit.signature

    def find() -> Profile:
        watching = [s for s in range(len(signature)) if any(event == w.event for w in signature.list_watched_events(s))]
        return make_profile(orbit, orbit.numeric.event(event), segments=watching)

    return orbit.once(("event profile", event), find)
