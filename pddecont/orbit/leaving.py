"""How fast an orbit leaves the surfaces at which both vector fields may point.

Where a segment ends at a surface that the next mode meets from its other side, the flow of that mode has to lead away.
If it leads straight back, both fields point at the surface (Filippov's criterion) and the motion slides along it.
"""

from __future__ import annotations

from pddecont.model import find_rate, may_slide, vanishes_identically
from pddecont.orbit.event_profiles import find_event_profile
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.signature import Signature
from pddecont.orbit.starts import read_starts
from pddecont.reasons import Reason, make_reason


def list_sliding_ends(signature: Signature) -> list[int]:
    """Return the segments that end at a surface where both fields may point at it, and the next one begins on it."""
    model, segments = signature.numeric.model, signature.segments
    return [
        s
        for s, segment in enumerate(segments)
        if segment.event
        and may_slide(model, segment)
        and vanishes_identically(model, segments, (s + 1) % len(segments), segment.event, at_end=False)
    ]


def find_leaving_rate(orbit: Orbit, s: int) -> float:
    """Return the rate at which the motion leaves the surface that segment ``s`` ends at, positive where it goes on.

    It is how fast the flow of the next mode changes the event function where that begins, counted in the direction in
    which the orbit arrived.
    """
    following = (s + 1) % len(orbit.signature)
    event, mode = orbit.signature.segments[s].event, orbit.signature.segments[following].mode
    reads, at = read_starts(orbit), [following]
    rate = orbit.numeric.function((find_rate(orbit.numeric.model, event, mode),))
    leaves = float(rate.value(reads.t[at], reads.x[:, at], reads.xd[:, at], orbit.parameters)[0, 0])
    return leaves if find_event_profile(orbit, event).end_slope(s) > 0.0 else -leaves


def explain_sliding(signature: Signature, s: int) -> Reason:
    """Return the reason that says that a motion slides along the surface that segment ``s`` ends at."""
    segment = signature.segments[s]
    return make_reason("slides", number=s + 1, segment=segment.name, event=segment.event)
