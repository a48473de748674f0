"""Events made by jumps that come back.

A reset moves a state, and where that is read later an event function is carried over its zero without passing it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshPoints
from pddecont.model import list_carriers, list_transitions
from pddecont.orbit.orbit import Orbit
from pddecont.reasons import Reason, make_reason

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CarriedEvent:
    """An event that the jump at the end of segment ``source`` may make, read through the delay number ``lag``.

    ``segment`` is the one that it ends; None for an event that the signature does not list there. Through a delay that
    varies a jump comes back at ``breaking``, the number of a breaking time; None for a constant one.
    """

    event: str
    direction: str
    source: int
    lag: int
    segment: int | None
    breaking: int | None = None

    def find_time(self, orbit: Orbit) -> float:
        """Return when the jump comes back, within a period after the orbit's start."""
        if self.segment is not None:
            return float(orbit.event_times[self.segment + 1])
        if self.breaking is not None:
            return float(orbit.theta[len(orbit.theta) - orbit.mesh.n_breaking + self.breaking])
        delay = float(orbit.numeric.delays.value(orbit.parameters)[self.lag])
        return float((orbit.event_times[self.source + 1] + delay) % orbit.period)

    def find_segment(self, orbit: Orbit) -> int:
        """Return the segment in which the jump comes back."""
        return orbit.find_segment(self.find_time(orbit)) if self.segment is None else self.segment

    def measure(self, orbit: Orbit) -> float:
        """Return how far the jump carries the event function beyond its zero, relative to the jump; negative: short.

        Where the segment in which it comes back does not watch the event, it does not.
        """
        watched = orbit.signature.list_watched_events(self.find_segment(orbit))
        if all((w.event, w.direction) != (self.event, self.direction) for w in watched):
            return -1.0
        before, after = self._evaluate(orbit)
        if self.direction == "any":
            return -float(np.sign(before)) * after
        return min(after, -before) if self.direction == "rising" else min(-after, before)

    def _evaluate(self, orbit: Orbit) -> tuple[float, float]:
        """Return the event function before and after the jump, relative to the two together."""
        source, following = self.source, (self.source + 1) % len(orbit.signature)
        reads = orbit.read(_locate(orbit, self.find_time(orbit), self.find_segment(orbit)))
        values = []
        for s, time in ((source, orbit.event_times[source + 1]), (following, orbit.event_times[following])):
            states = orbit.mesh.interpolate(orbit.values, _locate(orbit, float(time), s))[0]
            xd = reads.xd.copy()
            for i, read in enumerate(orbit.numeric.model.delayed):
                if read.delay == self.lag:
                    xd[i] = states[read.state]
            function = orbit.numeric.event(self.event)
            values.append(float(function.value(reads.t, reads.x, xd, orbit.parameters)[0, 0]))
        size = abs(values[0]) + abs(values[1]) or 1.0
        return values[0] / size, values[1] / size

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


def list_carried_events(orbit: Orbit) -> list[CarriedEvent]:
    """Return the events that jumps make at the ends of an orbit's segments; none where a delay line smooths them."""
    segments = orbit.signature.segments
    return [
        CarriedEvent(
            segments[link.segment].event, segments[link.segment].direction, link.source, link.lag, link.segment
        )
        for link in orbit.problem.links
        if link.lag is not None and orbit.problem.delay.stages is None
    ]


def list_unlisted_carried_events(orbit: Orbit) -> list[CarriedEvent]:
    """Return the events that jumps may make though no segment of an orbit ends there."""
    if orbit.problem.delay.stages is not None:
        return []
    signature, model = orbit.signature, orbit.numeric.model
    tau = orbit.numeric.delays.value(orbit.parameters)
    known = {(link.source, link.lag) for link in orbit.problem.links}
    surfaces = dict.fromkeys(
        (w.event, w.direction) for s in range(len(signature)) for w in signature.list_watched_events(s)
    )
    return [
        CarriedEvent(event, direction, source, lag, None, breaking)
        for source, segment in enumerate(signature.segments)
        if segment.event
        for event, direction in surfaces
        for lag in list_carriers(model, event, segment.reset)
        if (source, lag) not in known
        for breaking in _list_returns(orbit, source, lag, tau)
    ]


def _list_returns(orbit: Orbit, source: int, lag: int, tau: Array) -> list[int | None]:
    """Return at which breaking times the jump at the end of a segment is read; None for one constant delay later."""
    if lag < len(tau):
        return [None] if tau[lag] > 0.0 else []
    end = np.zeros(len(orbit.theta))
    end[: source + 1] = 1.0
    found: list[int | None] = []
    for number, b in enumerate(orbit.mesh.breaking):
        # The same end some periods before.
        before = end - b.source
        n = len(orbit.signature)
        if b.delay == lag and np.ptp(before[:n]) == 0.0 and not np.any(before[n:]):
            found.append(number)
    return found


def _locate(orbit: Orbit, time: float, s: int) -> MeshPoints:
    return orbit.mesh.locate(orbit.theta, np.array([time]), segment=s)[0]
