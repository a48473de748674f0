"""Numbers that are measured on an orbit: extrema and means of expressions, values at events, times in modes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction
from pddecont.collocation import MeshPoints
from pddecont.orbit.admissibility import find_closest_approach
from pddecont.orbit.extrema import make_profile
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.smooth_subintervals import find_smooth_subintervals

Array = NDArray[np.float64]


def measure_maximum(orbit: Orbit, function: ArrayFunction) -> float:
    """Return the largest value of an expression along an orbit."""
    return float(np.max(_find_levels(orbit, function)))


def measure_minimum(orbit: Orbit, function: ArrayFunction) -> float:
    """Return the smallest value of an expression along an orbit."""
    return float(np.min(_find_levels(orbit, function)))


def measure_amplitude(orbit: Orbit, function: ArrayFunction) -> float:
    """Return half the difference between an expression's largest and smallest values along an orbit."""
    return 0.5 * float(np.ptp(_find_levels(orbit, function)))


def _find_levels(orbit: Orbit, function: ArrayFunction) -> Array:
    """Return the values at which an expression along an orbit can be largest or smallest."""
    profile = make_profile(orbit, function)
    return np.array([*profile.values[:, 0], *profile.values[:, -1], *(e.value for e in profile.extrema)])


def measure_mean(orbit: Orbit, function: ArrayFunction) -> float:
    """Return the mean of an expression over an orbit's period, by Gauss quadrature."""
    mesh = orbit.mesh
    parts = find_smooth_subintervals(orbit, np.arange(mesh.n_intervals), delays=function.uses_delayed)
    reads = orbit.read(parts.grid(mesh, mesh.basis.nodes), delays=function.uses_delayed)
    values = function.value(reads.t, reads.x, reads.xd, orbit.parameters)[0].reshape(len(parts.interval), -1)
    h = parts.share * reads.h[parts.interval]
    return float(np.sum(h[:, None] * mesh.basis.weights * values) / np.sum(h))


def measure_time_in(orbit: Orbit, mode: str) -> float:
    """Return how long an orbit is in a mode during one period.

    Impacts that accumulate end where those do that the orbit does not follow: gaps go on to shrink as the last two do.
    """
    durations, signature = orbit.durations.copy(), orbit.signature
    for s in (s for s in signature.trailing if signature.segments[s].rests):
        left = durations[s] ** 2 / (durations[s - 1] - durations[s])
        durations[[s, (s + 1) % len(signature)]] += left, -left
    return float(sum(T for T, segment in zip(durations, signature.segments, strict=True) if segment.mode == mode))


def measure_at(orbit: Orbit, segment: str, function: ArrayFunction) -> float:
    """Return an expression at the end of the first segment of a name; NaN if the orbit has none.

    A name in the model file stands for all modes that such a segment may lead to.
    """
    found = [s for s, other in enumerate(orbit.signature.segments) if segment in (other.name, other.written)]
    if not found:
        return float("nan")
    interval = orbit.mesh.last_interval[found[:1]]
    reads = orbit.read(MeshPoints(interval, np.ones(1)), delays=function.uses_delayed)
    return float(function.value(reads.t, reads.x, reads.xd, orbit.parameters)[0, 0])


def measure_approach(orbit: Orbit, event: str) -> float:
    """Return an event function where it comes nearest to grazing; NaN if it has no extremum."""
    found = find_closest_approach(orbit, event)
    return float("nan") if found is None else found.extremum.value
