"""Delayed events that an orbit's events start: when each comes, and whether it happens though no segment ends at it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.model import list_clocks, list_transitions
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.signature import Signature
from pddecont.reasons import Reason, make_reason


@dataclass(frozen=True)
class Clock:
    """The clock of delayed event ``event``, started where segment ``source`` ends, at whose time no segment ends."""

    event: str
    source: int

    def find_time(self, orbit: Orbit) -> float:
        """Return when the delayed event comes, in [0, period) after the orbit's start."""
        delay = float(orbit.numeric.event_delay(self.event).value(orbit.parameters)[0])
        return float((orbit.event_times[self.source + 1] + delay) % orbit.period)

    def measure(self, orbit: Orbit) -> float:
        """Return how far, in periods, the delayed event comes inside a time whose mode it ends; negative: outside.

        It happens if this is positive, and does nothing if it is negative.
        """
        time, period = self.find_time(orbit), orbit.period
        happens = _find_modes_ended(orbit.signature, self.event)
        borders = orbit.event_times[:-1][happens != np.roll(happens, 1)]
        away = np.abs(time - borders)
        distance = float(np.min(np.minimum(away, period - away)) / period)
        return distance if happens[orbit.find_segment(time)] else -distance

    def explain(self, orbit: Orbit) -> Reason:
        """Return the reason that says where the delayed event happens, on the border of that or inside."""
        time, signature = self.find_time(orbit), orbit.signature
        happens = _find_modes_ended(signature, self.event)
        s = orbit.find_segment(time)
        if not happens[s]:
            # Just outside: of the two neighbours the nearer one that it ends.
            beside = [k for k in ((s - 1) % len(signature), (s + 1) % len(signature)) if happens[k]]
            s = min(beside, key=lambda k: _measure_gap(orbit, time, k), default=s)
        ended = list_transitions(signature.numeric.model, signature.segments[s].mode).expiries
        instead = next((segment.name for segment in ended if segment.event == self.event), "")
        name = signature.names[s]
        return make_reason("happens", number=s + 1, segment=name, event=self.event, instead=instead, time=time)


def list_unlisted_clocks(orbit: Orbit) -> list[Clock]:
    """Return the clocks of an orbit at whose times no segment ends, but may.

    One that runs as long as another from the same event on comes with it at every parameter, and tells nothing.
    """
    signature, model = orbit.signature, orbit.numeric.model
    segments, links = signature.segments, [link for link in orbit.problem.links if link.lag is None]
    known = {(link.source, model.events[segments[link.segment].event].delay) for link in links}
    found = [
        Clock(event, source)
        for source, segment in enumerate(segments)
        if segment.event
        for event in list_clocks(model, segment.event)
        if (source, model.events[event].delay) not in known
    ]
    return [clock for clock in found if 0 < np.sum(_find_modes_ended(signature, clock.event)) < len(segments)]


def list_started_events(orbit: Orbit) -> list[tuple[float, float, str]]:
    """Return the delayed events that an orbit's events start: (time, time of the start, event) in order of time.

    Times count from the orbit's start; those are listed that matter to motions that start within a period of it.
    """
    found: list[tuple[float, float, str]] = []
    for s, segment in enumerate(orbit.signature.segments):
        for name in list_clocks(orbit.numeric.model, segment.event) if segment.event else ():
            delay = float(orbit.numeric.event_delay(name).value(orbit.parameters)[0])
            turns = np.arange(-int(np.ceil(delay / orbit.period)) - 2, 2) * orbit.period
            found += [(t + delay, t, name) for t in (orbit.event_times[s + 1] + turns).tolist()]
    return sorted(found)


def _find_modes_ended(signature: Signature, event: str) -> NDArray[np.bool_]:
    """Return of each segment whether its mode ends at a delayed event (n_segments,)."""
    model = signature.numeric.model
    return np.array([event in list_transitions(model, s.mode).delayed_events for s in signature.segments])


def _measure_gap(orbit: Orbit, time: float, s: int) -> float:
    """Return how far a time is from a segment, around the period."""
    away = np.abs(time - orbit.event_times[[s, s + 1]])
    return float(np.min(np.minimum(away, orbit.period - away)))
