"""Stretches of mesh intervals on which the orbit's delayed values are polynomials: what is interpolated or integrated along it.

A mesh has edges where the solution's derivatives jump. A delayed value that only an event or a monitor reads may jump elsewhere, a delay
after an edge of any interval; there each interval is cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.direct import Direct
from pddecont.orbit.mesh import Mesh, Places
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]
# Cuts nearer than this to an edge, relative to the interval, are none.
APART = 1e-9


@dataclass(frozen=True, eq=False)
class Stretches:
    """Parts of mesh intervals in order of time: ``interval`` and sigma from ``low`` to ``high``, each of shape (n_stretches,)."""

    interval: NDArray[np.intp]
    low: Array
    high: Array

    def places(self, mesh: Mesh, sigma: Array) -> Places:
        """Return the places at the same ``sigma`` (k,), from 0 to 1, of every stretch; at its ends they are read from within it."""
        if np.all(self.high - self.low == 1.0):
            return mesh.grid(sigma, self.interval)
        at = self.low[:, None] + np.outer(self.high - self.low, sigma)
        inward = np.where(sigma <= 0.0, 1.0, np.where(sigma >= 1.0, -1.0, 0.0))
        return Places(np.repeat(self.interval, len(sigma)), at.ravel(), inward=np.tile(inward, len(self.interval)))

    def share(self) -> Array:
        """Return how much of its interval each stretch is."""
        return self.high - self.low


def stretches(problem: OrbitProblem, x: Array, intervals: NDArray[np.intp], *, delays: bool) -> Stretches:
    """Return the stretches of some mesh intervals; whole intervals unless ``delays`` are read, from the orbit itself."""
    whole = Stretches(intervals, np.zeros(len(intervals)), np.ones(len(intervals)))
    if not delays or not isinstance(problem.delay, Direct):
        return whole
    mesh, theta = problem.mesh, problem.theta(x)
    starts, lengths = mesh.start @ theta, mesh.length @ theta
    period = float(np.sum(theta[: mesh.n_segments]))
    echoes = ((starts[:, None] + theta[mesh.n_segments :]) % period).ravel()
    where = np.clip(np.searchsorted(starts, echoes, side="right") - 1, 0, mesh.n_intervals - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        sigma = (echoes - starts[where]) / lengths[where]
    kept = (sigma > APART) & (sigma < 1.0 - APART) & np.isin(where, intervals)
    interval = np.concatenate([where[kept], intervals])
    low = np.concatenate([sigma[kept], np.zeros(len(intervals))])
    order = np.lexsort([low, interval])
    interval, low = interval[order], low[order]
    # Two cuts at one place are one.
    apart = np.append(True, (np.diff(interval) != 0) | (np.diff(low) > APART))
    interval, low = interval[apart], low[apart]
    last = np.append(np.diff(interval) != 0, True)
    return Stretches(interval, low, np.where(last, 1.0, np.append(low[1:], 1.0)))
