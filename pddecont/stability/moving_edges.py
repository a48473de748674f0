"""Which breaking points a perturbed motion moves, and which may stand still.

An event that comes earlier makes what follows from it come earlier too, also when a delay reads it periods later. How
far a mesh edge moves with the durations of earlier periods is a choice, though: the base values on it change by the
slope of the orbit times the way it moves, and a perturbation stays a continuous piecewise polynomial as long as that
slope does not jump. Only edges at which the slope jumps have to move: events, and what a jump of the state makes of the
vector field one delay later. All others stand still, since motions of the mesh are paid for: with a multiplier mu the
duration w periods ago is mu^-w times as large as the present one, and so are the rounding and collocation errors of
whatever it moves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshPoints
from pddecont.orbit import Orbit

Array = NDArray[np.float64]
Edge = tuple[float, ...]
# The vector field jumps where it changes by more than this part of its largest value.
JUMP = 1e-11


def find_still_edges(orbit: Orbit) -> frozenset[Edge]:
    """Return the coefficients of the breaking points at which an orbit's slope does not jump."""
    mesh, S = orbit.mesh, orbit.mesh.n_segments

    def find_returned() -> list[tuple[int, int]]:
        starts = np.array([piece.start for piece in mesh.pieces])
        returned = np.flatnonzero(starts[:, S:].any(axis=1))
        return list(zip(returned.tolist(), _find_levels(orbit, starts[returned]), strict=True))

    levels = mesh.always(("levels of edges", orbit.signature), find_returned)
    if not levels:
        return frozenset()
    returned, doubtful = [i for i, _ in levels], [i for i, level in levels if level == 1]
    jumps = (
        set(doubtful) if not doubtful else {i for i, j in zip(doubtful, _find_jumps(orbit, doubtful), strict=True) if j}
    )
    return frozenset(tuple(mesh.pieces[i].start.tolist()) for i in returned if i not in jumps)


def _find_levels(orbit: Orbit, edges: Array) -> list[int]:
    """Return the lowest derivative of the solution that can jump at each of ``edges`` some delays after an event."""
    S, jumps = orbit.mesh.n_segments, orbit.signature.discontinuity_sources.jumps
    if not orbit.signature.discontinuity_sources.are_sums or not len(edges):
        return [1] * len(edges)
    events, delays = edges[:, :S], np.rint(edges[:, S:].sum(axis=1)).astype(np.intp)
    ended = np.rint((events - events.min(axis=1, keepdims=True)).sum(axis=1)).astype(np.intp)
    levels: list[int] = (np.array(jumps)[(ended - 1) % len(jumps)] + delays).tolist()
    return levels


def _find_jumps(orbit: Orbit, pieces: list[int]) -> list[bool]:
    """Return whether the vector field jumps where each of some pieces starts, inside its segment."""
    mesh, problem = orbit.mesh, orbit.problem
    after = np.searchsorted(mesh.piece, pieces)
    n = len(pieces)
    sides = MeshPoints(np.concatenate([after - 1, after]), np.repeat([1.0, 0.0], n))
    points, reads = orbit.read(sides), orbit.equation_reads
    result = []
    for k in range(n):
        field = problem.numeric.mode(problem.segments[mesh.segment[after[k]]].mode)
        both = [k, n + k]
        left, right = field.value(points.t[both], points.x[:, both], points.xd[:, both], orbit.parameters).T
        at = np.flatnonzero(mesh.segment[mesh.equation_points.interval] == mesh.segment[after[k]])
        largest = np.max(np.abs(field.value(reads.t[at], reads.x[:, at], reads.xd[:, at], orbit.parameters)), axis=1)
        result.append(bool(np.any(np.abs(right - left) > JUMP * largest)))
    return result
