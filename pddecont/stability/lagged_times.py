"""Which period's durations and breaking times a time on the orbit depends on.

On the orbit all periods are alike, and the time of a breaking point is an integer combination c of the durations
T_1..T_S. For a perturbed motion each period has its own: an event w periods ago at the end of segment s lies at

    (T_1 + .. + T_s of period k - w)  -  sum over l = 1..w of (T_1 + .. + T_S of period k - l)

after the start of period k. Since c is ``s`` ones and zeros less w in each place, c tells w and s. A breaking time b of
a delay that varies, w periods ago, counts from the start of period k - w; its own coefficient is one more in c. Here
such a time is an array of shape (..., n_lags, S + J): coefficients of what moves the edges of periods k, k - 1, ...
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints
from pddecont.stability.moving_edges import Edge

Array = NDArray[np.float64]


def spread_over_lags(coefficients: Array, n_lags: int, n_segments: int) -> Array:
    """Return what moves an edge by period: ``coefficients`` (S + J,) to shape (n_lags, S + J)."""
    result = np.zeros((n_lags, len(coefficients)))
    wraps = count_wraps(coefficients, n_segments)
    result[1 : wraps + 1, :n_segments] = -1.0
    result[wraps] += coefficients
    result[wraps, :n_segments] += wraps
    return result


def count_wraps(coefficients: Array, n_segments: int) -> int:
    """Return how many periods back the event or breaking time lies that an edge (n_theta,) comes from."""
    return max(0, -round(float(np.min(coefficients[:n_segments]))))


def take_moving(coefficients: Array, mesh: Mesh) -> Array:
    """Return the coefficients (..., n_theta) of what moves with a motion: durations and breaking times."""
    n = coefficients.shape[-1] - mesh.n_breaking
    return np.concatenate([coefficients[..., : mesh.n_segments], coefficients[..., n:]], axis=-1)


def find_deepest_lag(mesh: Mesh, still: Collection[Edge] = ()) -> int:
    """Return how many periods back the events lie whose breaking points the mesh follows, those ``still`` left out."""
    edges = (edge for piece in mesh.pieces for edge in (piece.start, piece.end) if tuple(edge.tolist()) not in still)
    sources = (b.source for b in mesh.breaking)
    return max(0, *(count_wraps(edge, mesh.n_segments) for edge in chain(edges, sources)))


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
        moving = take_moving(edge, self.mesh)
        if tuple(edge.tolist()) in self.still:
            return np.zeros((self.n_lags, len(moving)))
        return spread_over_lags(moving, self.n_lags, self.mesh.n_segments)

    @property
    def start(self) -> Array:
        """Left edges, shape (n_intervals, n_lags, S + J)."""
        return self._edges[0]

    @property
    def length(self) -> Array:
        """Lengths, shape (n_intervals, n_lags, S + J)."""
        return self._edges[1]

    def times(self, points: MeshPoints) -> Array:
        """Return the times of ``points``, shape (n_points, n_lags, S + J)."""
        return np.asarray(self.start[points.interval] + points.sigma[:, None, None] * self.length[points.interval])

    def sigma_derivatives(
        self, at: MeshPoints, interval: NDArray[np.intp], sigma: Array, wraps: NDArray[np.intp], lengths: Array
    ) -> Array:
        """Return how the fractions ``sigma`` move at which ``at``, less a fixed delay, read ``interval``.

        ``wraps`` counts the periods back, ``lengths`` (n_points,) are those intervals' own; the result has shape
        (n_points, n_lags, S + J).
        """
        moves = self.times(at)
        lag = np.arange(self.n_lags)
        moves[:, :, : self.mesh.n_segments] += ((lag >= 1) & (lag <= wraps[:, None]))[:, :, None]
        read = self.start[interval] + sigma[:, None, None] * self.length[interval]
        for w in np.unique(wraps):
            here = wraps == w
            moves[here, w:] -= read[here, : self.n_lags - w]
        return np.asarray(moves / lengths[:, None, None])
