"""Recorded orbits as smooth curves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MAX_DEGREE, make_basis
from pddecont.errors import ResultsError
from pddecont.results import Step

Array = NDArray[np.float64]
# Points of a curve in one mesh interval: one over the whole width of a picture looks smooth.
PER_INTERVAL = 64


def interpolate_segments(step: Step, row: int, what: str = "states") -> list[tuple[Array, Array]]:
    """Return (times, values) of each segment of a recorded orbit, from its own polynomials between the base points.

    ``what`` is ``states`` or ``delayed``. Shapes: times (n,), values (n, n_states) or (n, n_delayed).
    """
    orbit = step.orbit(row)
    # A recorded mesh begins with its degree.
    degree = int(orbit["mesh"][0])
    result = []
    for number in np.unique(orbit["segment"]):
        inside = orbit["segment"] == number
        result.append(_interpolate(orbit["time"][inside], orbit[what][inside], degree))
    return result


def interpolate_values(orbit: Mapping[str, Any], values: Array) -> Array:
    """Return what has a value at each base point of an orbit, shape (n_base,), between them, in order, shape (n,)."""
    degree, segment, times = int(orbit["mesh"][0]), orbit["segment"], orbit["time"]
    found = [
        _interpolate(times[segment == number], values[segment == number, None], degree)[1][:, 0]
        for number in np.unique(segment)
    ]
    return np.concatenate(found)


def _interpolate(times: Array, values: Array, degree: int) -> tuple[Array, Array]:
    """Return the polynomials through base points at times (n_base,), ``degree`` + 1 an interval, at finer times."""
    if not 1 <= degree <= min(MAX_DEGREE, len(times) - 1):
        raise ResultsError(f"a mesh of degree {degree} does not go with {len(times)} base points")
    n_intervals = (len(times) - 1) // degree
    sigma = np.linspace(0.0, 1.0, PER_INTERVAL, endpoint=False)
    basis = make_basis(degree).lagrange(sigma)
    base = degree * np.arange(n_intervals)[:, None] + np.arange(degree + 1)
    fine = np.einsum("pb,jbn->jpn", basis, values[base]).reshape(-1, values.shape[1])
    left, right = times[base[:, 0]], times[base[:, -1]]
    fine_times = (left[:, None] + sigma * (right - left)[:, None]).ravel()
    return np.append(fine_times, times[-1]), np.vstack([fine, values[-1]])
