"""Events made by jumps that come back: a reset moves a state, and where it is read later an event function is carried
over its zero without passing it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.model import list_carriers, list_transitions
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.signature import WatchedEvent
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Carrier:
    """The jump at the end of segment ``source``, read by an event function through the delay number ``lag``.

    ``segment`` is the one that ends there, of an event that the signature lists; None for one that it does not.
    """

    event: str
    direction: str
    source: int
    lag: int
    segment: int | None

    def find_time(self, orbit: Orbit) -> float:
        """Return when the jump comes back, in [0, period) after the orbit's start."""
        delay = float(orbit.numeric.delays.value(orbit.parameters)[self.lag])
        return float((orbit.event_times[self.source + 1] + delay) % orbit.period)

    def find_segment(self, orbit: Orbit) -> int:
        """Return the segment in which the jump comes back."""
        if self.segment is not None:
            return self.segment
        found = int(np.searchsorted(orbit.event_times, self.find_time(orbit), side="right")) - 1
        return min(found, len(orbit.signature) - 1)

    def measure(self, orbit: Orbit) -> float:
        """Return how far the jump carries the event function beyond its zero; negative if it does not.

        Where the segment in which it comes back does not watch the event, it does not.
        """
        s = self.find_segment(orbit)
        if all((w.event, w.direction) != (self.event, self.direction) for w in orbit.signature.list_watched_events(s)):
            return -1.0
        before, after = self._evaluate(orbit, s)
        if self.direction == "any":
            return -float(np.sign(before)) * after
        return min(after, -before) if self.direction == "rising" else min(-after, before)

    def _evaluate(self, orbit: Orbit, s: int) -> tuple[float, float]:
        """Return the event function before and after the jump, relative to the two together."""
        n = len(orbit.signature)
        end = orbit.event_times[[s + 1]] if self.segment is not None else np.array([self.find_time(orbit)])
        reads = orbit.read(orbit.mesh.locate(orbit.theta, end, segment=s)[0])
        function = orbit.numeric.event(self.event)
        sides = (self.source, orbit.event_times[self.source + 1]), ((self.source + 1) % n, None)
        values = []
        for k, time in sides:
            at = orbit.event_times[k] if time is None else time
            states = orbit.mesh.interpolate(orbit.values, orbit.mesh.locate(orbit.theta, np.array([at]), segment=k)[0])
            xd = reads.xd.copy()
            for i, read in enumerate(orbit.numeric.model.delayed):
                if read.delay == self.lag:
                    xd[i] = states[:, read.state]
            values.append(float(function.value(reads.t, reads.x, xd, orbit.parameters)[0, 0]))
        size = abs(values[0]) + abs(values[1])
        return (values[0] / size, values[1] / size) if size else (0.0, 0.0)

    def explain(self, orbit: Orbit) -> Reason:
        """Return the reason that says that a listed event does not happen, or that one which is not listed does."""
        s = self.find_segment(orbit)
        name = orbit.signature.names[s]
        if self.segment is not None:
            return make_reason("missing", event=self.event, number=s + 1, segment=name)
        ends = list_transitions(orbit.numeric.model, orbit.signature.segments[s].mode).surfaces
        instead = ends[self.event, self.direction].name if (self.event, self.direction) in ends else ""
        time = self.find_time(orbit)
        return make_reason("happens", number=s + 1, segment=name, event=self.event, instead=instead, time=time)


def list_carriers_listed(orbit: Orbit) -> list[Carrier]:
    """Return the jumps that end segments of an orbit; none where a delay line has smoothed them."""
    if orbit.problem.delay.stages is not None:
        return []
    segments = orbit.signature.segments
    return [
        Carrier(segments[link.segment].event, segments[link.segment].direction, link.source, link.lag, link.segment)
        for link in orbit.problem.links
        if link.lag is not None
    ]


def list_carriers_unlisted(orbit: Orbit) -> list[Carrier]:
    """Return the jumps that may carry an event function over its zero though no segment of an orbit ends there."""
    if orbit.problem.delay.stages is not None:
        return []
    signature, model = orbit.signature, orbit.numeric.model
    tau = orbit.numeric.delays.value(orbit.parameters)
    known = {(link.source, link.lag) for link in orbit.problem.links}
    watched: dict[tuple[str, str], WatchedEvent] = {
        (w.event, w.direction): w for s in range(len(signature)) for w in signature.list_watched_events(s)
    }
    return [
        Carrier(event, direction, source, lag, None)
        for source, segment in enumerate(signature.segments)
        if segment.event
        for event, direction in watched
        for lag in list_carriers(model, event, segment.reset)
        if tau[lag] > 0.0 and (source, lag) not in known
    ]
