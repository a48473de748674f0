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
    best, nearest = cKDTree(curve).query(points)
    chords = np.roll(curve, -1, axis=0) - curve
    squares = np.einsum("ij,ij->i", chords, chords)
    # Where two intervals meet a point stands twice: the polygon goes on from the one beside it.
    for first in (-2, -1, 0, 1):
        which = (nearest + first) % len(curve)
        away, chord, square = points - curve[which], chords[which], squares[which]
        with np.errstate(invalid="ignore", divide="ignore"):
            along = np.einsum("ij,ij->i", away, chord) / square
        along = np.clip(np.where(square > 0.0, along, 0.0), 0.0, 1.0)
        away -= along[:, None] * chord
        best = np.minimum(best, np.sqrt(np.einsum("ij,ij->i", away, away)))
    return float(np.max(best))
