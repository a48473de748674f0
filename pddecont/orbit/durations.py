"""How long segments have to last: below that rounding decides on the sign of a duration, or a segment has vanished."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.orbit.orbit import Orbit
from pddecont.orbit.problem import INSTANT
from pddecont.orbit.signature import Signature

Array = NDArray[np.float64]


def find_instants(orbit: Orbit) -> Array:
    """Return the durations of an orbit's segments that are rounding, shape (n_segments,)."""
    return make_instant_matrix(orbit.signature) @ orbit.durations


def make_instant_matrix(signature: Signature) -> Array:
    """Return what times the durations gives those that are rounding (n_segments, n_segments): parts of the period.

    Between impacts that accumulate they are parts of the segment that ends with the first one.
    """
    n = len(signature)
    matrix = np.full((n, n), INSTANT)
    for s, first in signature.trailing.items():
        matrix[s] = 0.0
        matrix[s, first] = INSTANT
    return matrix


def find_shortest(orbit: Orbit) -> int:
    """Return the segment of an orbit that lasts shortest, of impacts that accumulate the first one's."""
    durations = orbit.durations.copy()
    durations[list(orbit.signature.trailing)] = np.inf
    return int(np.argmin(durations))
