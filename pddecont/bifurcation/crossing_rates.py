"""How fast an orbit crosses the event functions that end its segments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit import Orbit, find_event_profile, is_met_from_below

Array = NDArray[np.float64]


def find_crossing_rate(orbit: Orbit, s: int) -> float:
    """Return the rate at which segment ``s`` crosses its event at its end, positive in the direction listed.

    An event of any direction is crossed from the side on which the segment lies.
    """
    segment = orbit.signature.segments[s]
    profile = find_event_profile(orbit, segment.event)
    slope = profile.end_slope(s)
    return slope if is_met_from_below(profile, s, segment.direction) else -slope


def find_crossing_rates(orbit: Orbit) -> Array:
    """Return each segment's rate of crossing its event, shape (n_segments,); NaN where it ends at no event function.

    Where impacts accumulate it counts relative to the rate with which the segment began: all become slow together.
    """
    events = orbit.numeric.model.events
    ends = [segment.event and events[segment.event].function is not None for segment in orbit.signature.segments]
    rates = np.array([find_crossing_rate(orbit, s) if ends[s] else np.nan for s in range(len(ends))])
    for s in orbit.signature.trailing:
        rates[s] /= abs(find_event_profile(orbit, orbit.signature.segments[s].event).start_slope(s))
    return rates


def find_smallest_crossing_rate(orbit: Orbit) -> float:
    """Return the smallest rate of an orbit (NaN if no segment ends at an event function)."""
    rates = find_crossing_rates(orbit)
    return float(np.nanmin(rates)) if np.any(np.isfinite(rates)) else float("nan")
