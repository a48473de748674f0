"""How far apart two orbits are, whatever their signatures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pddecont.orbit.error import measure_states
from pddecont.orbit.orbit import Orbit

Array = NDArray[np.float64]
# Places in every mesh interval at which orbits are compared.
SAMPLES = np.linspace(0.0, 1.0, 101)


def measure_distance(a: Orbit, b: Orbit) -> float:
    """Return the largest distance of a point of one orbit from the other one, relative to the sizes of ``b``'s states.

    Orbits are compared as sets of states (Hausdorff), so that neither phases nor segments matter, and by their periods.
    """
    sizes = measure_states(b.values)
    here, there = (_sample(orbit) / sizes for orbit in (a, b))
    apart = max(_farthest(here, there), _farthest(there, here))
    return max(apart, abs(a.period - b.period) / b.period)


def _sample(orbit: Orbit) -> Array:
    return orbit.mesh.interpolate(orbit.values, orbit.mesh.grid(SAMPLES))


def _farthest(points: Array, curve: Array) -> float:
    """Return the largest distance of ``points`` from the polygon through ``curve``, both (n, n_states)."""
    _, nearest = cKDTree(curve).query(points)
    best = np.linalg.norm(points - curve[nearest], axis=1)
    # Where two intervals meet a point stands twice: the polygon goes on from the one beside it.
    for first in (-2, -1, 0, 1):
        begin, end = (curve[(nearest + first + k) % len(curve)] for k in (0, 1))
        chord = end - begin
        length = np.sum(chord**2, axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            along = np.sum((points - begin) * chord, axis=1) / length
        along = np.clip(np.where(length > 0.0, along, 0.0), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(points - begin - along[:, None] * chord, axis=1))
    return float(np.max(best))
