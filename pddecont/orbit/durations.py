"""How long segments have to last, and what is left out of impacts that accumulate.

Below some duration rounding decides on its sign, or a segment has vanished.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshPoints
from pddecont.model import list_alternatives
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


def measure_left_out(orbit: Orbit, s: int) -> float:
    """Return what the impacts after segment ``s`` change that an orbit does not follow, relative to its first impact.

    It rests at once instead of flying on with the speed of its last impact; the states at rest differ by the square.
    """
    signature = orbit.signature
    if not signature.segments[s].rests:
        return 0.0
    followed = list_alternatives(orbit.numeric.model, signature.segments[s])[0]
    first = signature.trailing.get(s, s)
    last = _measure_changes(orbit, followed.reset, s) - _measure_changes(orbit, signature.segments[s].reset, s)
    sizes = np.abs(_measure_changes(orbit, followed.reset, first))
    changed = sizes > 0.0
    return float(np.max(np.abs(last[changed]) / sizes[changed], initial=0.0)) ** 2


def _measure_changes(orbit: Orbit, reset: str, s: int) -> Array:
    """Return by how much a reset changes each state at the end of segment ``s`` (n_states,)."""
    mesh = orbit.mesh
    reads = orbit.read(MeshPoints(mesh.last_interval[[s]], np.ones(1)))
    after = orbit.numeric.reset(reset).value(reads.t, reads.x, reads.xd, orbit.parameters)
    changes: Array = (after - reads.x)[:, 0]
    return changes
