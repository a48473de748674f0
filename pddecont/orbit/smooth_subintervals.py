"""Parts of mesh intervals on which the orbit's delayed values are polynomials: what is interpolated or integrated.

A mesh has edges where the solution's derivatives jump. A delayed value that only an event or a monitor reads may jump
elsewhere, a delay after an edge of any interval; there each interval is cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints, find_inner_side
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.preimages import PreimageSearch

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Cuts nearer than this to an edge, relative to the interval, are none.
APART = 1e-9


@dataclass(frozen=True, eq=False)
class Subintervals:
    """Parts of mesh intervals in order of time, from sigma ``low`` to ``high``; shape (n_parts,) each."""

    interval: Ints
    low: Array
    high: Array

    @property
    def share(self) -> Array:
        """How much of its interval each part is."""
        return self.high - self.low

    def grid(self, mesh: Mesh, sigma: Array) -> MeshPoints:
        """Return the points at the same ``sigma`` (k,), from 0 to 1, of every part; ends are read from within."""
        if np.all(self.share == 1.0):
            return mesh.grid(sigma, self.interval)
        at = self.low[:, None] + np.outer(self.share, sigma)
        repeated = np.repeat(self.interval, len(sigma))
        return MeshPoints(repeated, at.ravel(), inward=np.tile(find_inner_side(sigma), len(self.interval)))


def find_smooth_subintervals(orbit: Orbit, intervals: Ints, *, delays: bool) -> Subintervals:
    """Return the smooth parts of some mesh intervals; whole ones unless ``delays`` are read from the orbit itself."""
    whole = Subintervals(intervals, np.zeros(len(intervals)), np.ones(len(intervals)))
    if not delays or orbit.problem.delay.stages is not None:
        return whole
    mesh, theta = orbit.mesh, orbit.theta
    n_constant = len(orbit.numeric.model.delays)
    starts, delays_now = mesh.start @ theta, theta[mesh.n_segments : mesh.n_segments + n_constant]
    echoes = (starts[:, None] + delays_now).ravel()
    if orbit.numeric.model.varying:
        search = PreimageSearch(orbit)
        numbers = range(n_constant, n_constant + len(orbit.numeric.model.varying))
        # Between breaking points what is read bends by no more than the orbit's error.
        edges = np.array([float(piece.start @ theta) for piece in mesh.pieces])
        later = [b for k in numbers for times in search.find(k, edges) for b, _ in times]
        echoes = np.concatenate([echoes, later])
    cuts, _ = mesh.locate(theta, echoes)
    kept = (cuts.sigma > APART) & (cuts.sigma < 1.0 - APART) & np.isin(cuts.interval, intervals)
    interval = np.concatenate([cuts.interval[kept], intervals])
    low = np.concatenate([cuts.sigma[kept], np.zeros(len(intervals))])
    order = np.lexsort([low, interval])
    interval, low = interval[order], low[order]
    # Two cuts at one place are one.
    apart = np.append(True, (np.diff(interval) != 0) | (np.diff(low) > APART))
    interval, low = interval[apart], low[apart]
    last = np.append(np.diff(interval) != 0, True)
    return Subintervals(interval, low, np.where(last, 1.0, np.append(low[1:], 1.0)))
