"""Which period's durations a time on the orbit depends on.

On the orbit all periods are alike, and the time of a breaking point is an integer combination c of the durations
T_1..T_S. For a perturbed motion each period has its own: an event w periods ago at the end of segment s lies at

    (T_1 + .. + T_s of period k - w)  -  sum over l = 1..w of (T_1 + .. + T_S of period k - l)

after the start of period k. Since c is ``s`` ones and zeros less w in each place, c tells w and s. Here such a time is
an array of shape (..., n_lags, S): coefficients of the durations of periods k, k - 1, ...
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints
from pddecont.stability.moving_edges import Edge

Array = NDArray[np.float64]


def spread_over_lags(coefficients: Array, n_lags: int) -> Array:
    """Return an edge's durations by period: ``coefficients`` (S,) to shape (n_lags, S)."""
    result = np.zeros((n_lags, len(coefficients)))
    wraps = max(0, -round(float(np.min(coefficients))))
    result[1 : wraps + 1] = -1.0
    result[wraps] += coefficients + wraps
    return result


def find_deepest_lag(mesh: Mesh, still: Collection[Edge] = ()) -> int:
    """Return how many periods back the events lie whose breaking points the mesh follows, those ``still`` left out."""
    S = mesh.n_segments
    edges = (edge for piece in mesh.pieces for edge in (piece.start, piece.end) if tuple(edge.tolist()) not in still)
    return max(0, *(-round(float(np.min(edge[:S]))) for edge in edges))


@dataclass(frozen=True, eq=False)
class LaggedMesh:
    """A mesh whose edges know which period's durations move them; those in ``still`` stand still."""

    mesh: Mesh
    n_lags: int
    still: Collection[Edge] = ()

    @cached_property
    def _edges(self) -> tuple[Array, Array]:
        starts, lengths = [], []
        for piece in self.mesh.pieces:
            a, b = (self._spread(edge) for edge in (piece.start, piece.end))
            cuts = piece.cuts[:, None, None]
            starts.append(a + cuts[:-1] * (b - a))
            lengths.append(np.diff(cuts, axis=0) * (b - a))
        return np.concatenate(starts), np.concatenate(lengths)

    def _spread(self, edge: Array) -> Array:
        S = self.mesh.n_segments
        if tuple(edge.tolist()) in self.still:
            return np.zeros((self.n_lags, S))
        return spread_over_lags(edge[:S], self.n_lags)

    @property
    def start(self) -> Array:
        """Left edges, shape (n_intervals, n_lags, S)."""
        return self._edges[0]

    @property
    def length(self) -> Array:
        """Lengths, shape (n_intervals, n_lags, S)."""
        return self._edges[1]

    def times(self, points: MeshPoints) -> Array:
        """Return the times of ``points``, shape (n_points, n_lags, S)."""
        return np.asarray(self.start[points.interval] + points.sigma[:, None, None] * self.length[points.interval])

    def sigma_derivatives(
        self, at: MeshPoints, interval: NDArray[np.intp], sigma: Array, wraps: NDArray[np.intp], lengths: Array
    ) -> Array:
        """Return how the fractions ``sigma`` move at which ``at``, less a fixed delay, read ``interval``.

        ``wraps`` counts the periods back, ``lengths`` (n_points,) are those intervals' own; the result has shape
        (n_points, n_lags, S).
        """
        moves = self.times(at)
        lag = np.arange(self.n_lags)
        moves += ((lag >= 1) & (lag <= wraps[:, None]))[:, :, None]
        read = self.start[interval] + sigma[:, None, None] * self.length[interval]
        for w in np.unique(wraps):
            here = wraps == w
            moves[here, w:] -= read[here, : self.n_lags - w]
        return np.asarray(moves / lengths[:, None, None])
