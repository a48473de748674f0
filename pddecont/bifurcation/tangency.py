"""Vanishing transversality (VS): the event that ends a segment turns tangential (design section 5.4).

The test function is the smallest rate at which an orbit crosses the event functions that end its segments, positive in the
direction listed. Beyond its zero the event is met from the wrong side and the signature is no longer that of a motion.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.admissibility import event_profiles
from pddecont.orbit.extrema import Profile
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
KIND = "VS"


def crossing_rate(problem: OrbitProblem, x: Array, profiles: dict[str, Profile] | None = None) -> float:
    """Return the test function at the orbit ``x`` (NaN if no segment ends at an event function)."""
    profiles = event_profiles(problem, x) if profiles is None else profiles
    rates = []
    for s, segment in enumerate(problem.segments):
        if segment.event in profiles and segment.direction != "any":
            rate = profiles[segment.event].end_slope(s)
            rates.append(rate if segment.direction == "rising" else -rate)
    return float(min(rates)) if rates else float("nan")
