"""Grazing (GR): an event function touches zero inside a segment (design section 5.4).

The test function is the extremum of h that lies nearest to a new crossing: in segments that watch a rising event (h < 0
inside) the largest interior maximum, in those that watch a falling one minus the smallest interior minimum. It is
negative for an admissible orbit and zero where the orbit grazes. Along a branch each segment and event has its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.admissibility import approaches, closest_approach, event_profile, event_profiles
from pddecont.orbit.curve import Curve
from pddecont.orbit.extrema import Profile
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
KIND = "GR"


def clearance(problem: OrbitProblem, x: Array, profiles: dict[str, Profile] | None = None, *,
              leave_out: tuple[str, int, float] | None = None) -> float:  # fmt: skip
    """Return the grazing test function at the orbit ``x`` (NaN if no segment has an interior extremum).

    ``leave_out`` names one extremum that does not count by its event, segment and time.
    """
    found = closest_approach(problem, event_profiles(problem, x) if profiles is None else profiles, leave_out=leave_out)
    if found is None:
        return float("nan")
    extremum = found[1]
    return extremum.value if extremum.is_max else -extremum.value


def height(problem: OrbitProblem, x: Array, s: int, event: str) -> float:
    """Return the test function of one segment and event, so that none hides another (NaN if the segment has no extremum)."""
    heights: dict[tuple[int, str], float] = problem.once("heights", x, lambda: _heights(problem, x))
    return heights.get((s, event), float("nan"))


def _heights(problem: OrbitProblem, x: Array) -> dict[tuple[int, str], float]:
    heights: dict[tuple[int, str], float] = {}
    for height, name, extremum in approaches(problem, event_profiles(problem, x)):
        key = (extremum.segment, name)
        heights[key] = max(height, heights.get(key, -np.inf))
    return heights


@dataclass(frozen=True)
class Graze:
    """The condition that the extremum of an event function in ``segment``, near ``fraction`` of its duration, is zero."""

    event: str
    segment: int
    fraction: float
    is_max: bool
    kind: str = KIND

    def value(self, curve: Curve, x: Array) -> float:
        """Return the extremum (NaN if there is none)."""
        extrema = self._extrema(curve.problem, x)
        return min(extrema)[1] if extrema else float("nan")

    def framed(self, curve: Curve, x: Array) -> Graze:
        """Return the same condition with the extremum looked for where it is at ``x``."""
        extrema = self._extrema(curve.problem, x)
        return replace(self, fraction=min(extrema)[2]) if extrema else self

    def others(self, curve: Curve, x: Array) -> float:
        """Return how near the orbit comes to a second grazing (as :func:`clearance`; NaN if nothing else has an extremum)."""
        return clearance(curve.problem, x, leave_out=(self.event, self.segment, self._time(curve.problem, x)))

    def _time(self, problem: OrbitProblem, x: Array) -> float:
        durations = x[problem.layout.durations]
        extrema = self._extrema(problem, x)
        fraction = min(extrema)[2] if extrema else self.fraction
        return float(np.sum(durations[: self.segment]) + fraction * durations[self.segment])

    def _extrema(self, problem: OrbitProblem, x: Array) -> list[tuple[float, float, float]]:
        """Return (distance, value, fraction) of each extremum that could be the one meant."""
        durations = x[problem.layout.durations]
        begin = float(np.sum(durations[: self.segment]))
        found, closed = [], not problem.segments[0].event
        for e in event_profile(problem, x, self.event).extrema:
            if e.segment == self.segment and e.is_max == self.is_max:
                fraction = (e.time - begin) / float(durations[self.segment])
                apart = abs(fraction - self.fraction)
                found.append((min(apart, 1.0 - apart) if closed else apart, e.value, fraction))
        return found


def graze_at(problem: OrbitProblem, x: Array) -> Graze | None:
    """Return the grazing condition of the orbit's closest approach to an event (None if it has no interior extremum)."""
    found = closest_approach(problem, event_profiles(problem, x))
    if found is None:
        return None
    event, e = found
    durations = x[problem.layout.durations]
    fraction = (e.time - float(np.sum(durations[: e.segment]))) / float(durations[e.segment])
    return Graze(event, e.segment, fraction, e.is_max)
