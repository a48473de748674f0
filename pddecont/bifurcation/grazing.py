"""Grazing (GR): an event function touches zero inside a segment (design section 5.4).

The test function is the extremum of h that lies nearest to a new crossing: over segments that end at a rising event (h < 0
inside) the largest interior maximum, over those that end at a falling one minus the smallest interior minimum. It is
negative for an admissible orbit and zero where the orbit grazes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.admissibility import closest_approach, event_profiles
from pddecont.orbit.extrema import Profile
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
KIND = "GR"


def clearance(problem: OrbitProblem, x: Array, profiles: dict[str, Profile] | None = None) -> float:
    """Return the grazing test function at the orbit ``x`` (NaN if no segment has an interior extremum)."""
    found = closest_approach(problem, event_profiles(problem, x) if profiles is None else profiles)
    if found is None:
        return float("nan")
    extremum = found[1]
    return extremum.value if extremum.is_max else -extremum.value
