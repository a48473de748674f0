"""Delayed values read from the orbit's own polynomials, wrapped by whole periods (design section 5.1).

A place at time b @ theta reads at (b - e_k) @ theta + w sum T_s. Which interval that lies in, and w, are decided once, at the
mesh's anchor: while the unknowns move by less than a mesh interval the same polynomial is read, slightly beyond its ends if
need be, so that the delayed values are smooth functions of all unknowns and their derivatives exact. A mesh whose breaking
points change their order is renewed (``orbit.meshing``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.operator import DelayOperator, LocalWeights
from pddecont.errors import ConvergenceError
from pddecont.orbit.mesh import Mesh, Places

Array = NDArray[np.float64]
NUDGE = 1e-11
FAR = 3.0


@dataclass(frozen=True)
class Direct:
    """Reads of the orbit itself; ``track`` says whether meshes follow the breaking points."""

    track: bool = True

    def operator(self, mesh: Mesh, theta: Array, tau_index: int, places: Places) -> DelayOperator:
        """Return the operator of the delay ``theta[tau_index]`` for reads at ``places``."""
        held = mesh.anchor is not None and places is mesh.sites
        reads = anchored(mesh, tau_index) if held else locate(mesh, theta, tau_index, places)
        j = reads.interval
        lengths = (mesh.length @ theta)[j]
        if not np.all(np.abs(lengths) > 0.0):
            raise ConvergenceError("a mesh interval has vanished")
        sigma = ((reads.times - mesh.start[j]) @ theta) / lengths
        if np.max(np.abs(sigma), initial=0.0) > FAR:
            raise ConvergenceError("a delayed value is read far outside its mesh interval")
        weights = mesh.basis.lagrange(sigma)
        columns = reads.columns

        def theta_derivative(values: Array, which: Sequence[int]) -> Array:
            slopes = np.matmul((weights @ mesh.basis.differentiate)[:, None], values[columns])[:, 0]
            moves = (reads.times - mesh.start[j] - sigma[:, None] * mesh.length[j])[:, which] / lengths[:, None]
            return slopes[:, :, None] * moves[:, None, :]

        return DelayOperator(LocalWeights(columns, weights, j, sigma, reads.wraps), theta_derivative)


@dataclass(frozen=True, eq=False)
class Where:
    """Where reads fall: ``times`` their coefficients of theta, ``wraps`` periods back, ``interval`` the mesh interval.

    ``columns`` (n_places, degree + 1) are the interval's base points.
    """

    times: Array
    wraps: NDArray[np.intp]
    interval: NDArray[np.intp]
    columns: NDArray[np.intp]


@lru_cache(maxsize=64)
def anchored(mesh: Mesh, tau_index: int) -> Where:
    """Return where the sites of a mesh read at the theta that it was made for."""
    assert mesh.anchor is not None
    return locate(mesh, mesh.anchor, tau_index, mesh.sites)


def locate(mesh: Mesh, theta: Array, tau_index: int, places: Places) -> Where:
    """Return where places read when delayed by ``theta[tau_index]``; at an edge, on the side that the place itself is on."""
    n = mesh.n_segments
    period = float(np.sum(theta[:n]))
    times = mesh.times(places)
    times[:, tau_index] -= 1.0
    inward = places.inward
    if inward is None:
        inward = np.where(places.sigma <= 0.0, 1.0, np.where(places.sigma >= 1.0, -1.0, 0.0))
    at = times @ theta + NUDGE * period * inward
    wraps = -np.floor(at / period).astype(np.intp)
    times[:, :n] += wraps[:, None]
    edges = mesh.start @ theta
    interval = np.searchsorted(edges, at + wraps * period, side="right") - 1
    interval = np.clip(interval, 0, mesh.n_intervals - 1)
    return Where(times, wraps, interval, mesh.base_index[interval])
