"""Grazing (GR): an event function touches zero inside a segment (design section 5.4).

The test function is the extremum of h that lies nearest to a new crossing: over segments that end at a rising event (h < 0
inside) the largest interior maximum, over those that end at a falling one minus the smallest interior minimum. It is
negative for an admissible orbit and zero where the orbit grazes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.admissibility import event_profiles, watched_events
from pddecont.orbit.extrema import Profile
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
KIND = "GR"


def clearance(problem: OrbitProblem, x: Array, profiles: dict[str, Profile] | None = None, event: str | None = None) -> float:
    """Return the grazing test function at the orbit ``x`` (NaN if no segment has an interior extremum).

    ``event`` restricts it to one event.
    """
    profiles = event_profiles(problem, x) if profiles is None else profiles
    extrema = {name: p.extrema() for name, p in profiles.items()}
    best = np.nan
    for s in range(len(problem.segments)):
        for name, direction, _ in watched_events(problem, s):
            if event in (None, name):
                for extremum in extrema[name]:
                    if extremum.segment == s and extremum.is_max == _from_below(profiles[name], s, direction):
                        best = np.fmax(best, extremum.value if extremum.is_max else -extremum.value)
    return float(best)


def _from_below(profile: Profile, s: int, direction: str) -> bool:
    """Whether the event would be met from h < 0 in segment ``s``."""
    if direction == "any":
        return bool(np.median(profile.values[profile.segment == s]) < 0.0)
    return direction == "rising"
