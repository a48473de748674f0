"""Segments that end where a delay that varies reads a jump, which carries an event function over its zero.

As for a constant delay an equation cannot ask for a zero there: the segment ends where its end less the delay is the
time of the jump. Which jump that is shows in an orbit, or a guess of one, alone.
"""

from __future__ import annotations

from dataclasses import replace

from pddecont.model import list_carriers
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.signature import AT_JUMP, DelayedEventLink


def link_varying_jumps(orbit: Orbit) -> Orbit:
    """Return the orbit with the links of segments that end so, found from what its delays are at their ends."""
    model, problem = orbit.numeric.model, orbit.problem
    if not model.varying or problem.delay.stages is not None:
        return orbit
    linked = {link.segment for link in problem.links}
    found = [
        _find_link(orbit, s)
        for s, segment in enumerate(orbit.signature.segments)
        if segment.event and s not in linked and model.events[segment.event].after is None
    ]
    links = tuple(link for link in found if link is not None)
    return Orbit(replace(problem, links=(*problem.links, *links)), orbit.x) if links else orbit


def _find_link(orbit: Orbit, s: int) -> DelayedEventLink | None:
    model, segments = orbit.numeric.model, orbit.signature.segments
    ends, n_constant = orbit.event_times[1:], len(model.delays)
    for a, other in enumerate(segments):
        for lag in list_carriers(model, segments[s].event, other.reset):
            if lag < n_constant:
                continue
            delay = float(orbit.equation_reads.lags[lag - n_constant, orbit.mesh.n_collocation + s])
            turns = (ends[a] + delay - ends[s]) / orbit.period
            if delay > 0.0 and abs(turns - round(turns)) < AT_JUMP:
                return DelayedEventLink(s, a, round(turns), lag)
    return None
