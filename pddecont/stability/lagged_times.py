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

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints
from pddecont.delay import LocalWeights
from pddecont.memo import cached_property
from pddecont.native import compiled_assembly
from pddecont.stability.moving_edges import Edge

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


def spread_over_lags(coefficients: Array, n_lags: int, n_segments: int) -> Array:
    """Return what moves edges by period: ``coefficients`` (..., S + J) to shape (..., n_lags, S + J)."""
    lag, wraps = np.arange(n_lags), count_wraps(coefficients, n_segments)[..., None]
    whole = np.zeros(coefficients.shape)
    whole[..., :n_segments] = wraps
    result = np.where((lag == wraps)[..., None], (coefficients + whole)[..., None, :], 0.0)
    result[..., :n_segments] -= ((lag >= 1) & (lag <= wraps))[..., None]
    return result


def count_wraps(coefficients: Array, n_segments: int) -> Ints:
    """Return how many periods back the events or breaking times lie that edges (..., n_theta) come from."""
    least = np.min(coefficients[..., :n_segments], axis=-1)
    return np.asarray(np.maximum(0, -np.rint(least).astype(np.intp)))


def take_moving(coefficients: Array, mesh: Mesh) -> Array:
    """Return the coefficients (..., n_theta) of what moves with a motion: durations and breaking times."""
    n = coefficients.shape[-1] - mesh.n_breaking
    return np.concatenate([coefficients[..., : mesh.n_segments], coefficients[..., n:]], axis=-1)


def find_deepest_lag(mesh: Mesh, still: Collection[Edge] = ()) -> int:
    """Return how many periods back the events lie whose breaking points the mesh follows, those ``still`` left out."""

    def find() -> int:
        edges = (edge for piece in mesh.pieces for edge in (piece.start, piece.end))
        moving = [edge for edge in edges if not still or tuple(edge.tolist()) not in still]
        sources = np.array([*moving, *(b.source for b in mesh.breaking)])
        return int(np.max(count_wraps(sources, mesh.n_segments), initial=0)) if len(sources) else 0

    return mesh.always(("deepest lag", frozenset(still)), find)


@dataclass(frozen=True, eq=False)
class LaggedMesh:
    """A mesh whose edges know which period's durations move them; those in ``still`` stand still."""

    mesh: Mesh
    n_lags: int
    still: Collection[Edge] = ()

    @cached_property
    def _edges(self) -> tuple[Array, Array]:
        pieces, of = self.mesh.pieces, self.mesh.piece
        edges = self._spread([*(piece.start for piece in pieces), *(piece.end for piece in pieces)])
        starts, ends = edges[: len(pieces)], edges[len(pieces) :]
        widths = ends - starts
        cuts = np.concatenate([piece.cuts[:-1] for piece in pieces])[:, None, None]
        parts = np.concatenate([piece.cuts[1:] - piece.cuts[:-1] for piece in pieces])[:, None, None]
        return starts[of] + cuts * widths[of], parts * widths[of]

    def _spread(self, edges: list[Array]) -> Array:
        moving = take_moving(np.array(edges), self.mesh)
        result = spread_over_lags(moving, self.n_lags, self.mesh.n_segments)
        if self.still:
            result[[tuple(edge.tolist()) in self.still for edge in edges]] = 0.0
        return result

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

    def move_reads(self, slopes: Array, times: Array, weights: LocalWeights, widths: Array) -> Array:
        """Return ``slopes`` (n_points,) times how the fractions move at which points read their intervals.

        The points move by ``times`` (n_points, n_lags, S + J) and read ``weights`` a fixed delay before; the intervals
        are ``widths`` (n_intervals,) wide. The result has the shape of ``times``.
        """
        n, n_lags, n_moving = times.shape
        result = np.empty(times.shape)
        compiled_assembly.move_lagged_reads(
            slopes,
            times,
            n,
            n_lags,
            n_moving,
            self.mesh.n_segments,
            weights.interval,
            weights.sigma,
            weights.wraps,
            self.start,
            self.length,
            widths,
            result,
        )
        return result

    def stretch_rates(self, rates: Array, weights: LocalWeights, result: Array) -> None:
        """Take off ``result`` (n_points, n_lags, S + J) the ``rates`` (n_points,) times how the lengths read move."""
        n, n_lags, n_moving = result.shape
        compiled_assembly.stretch_lagged_rates(
            rates, n, n_lags, n_moving, weights.interval, weights.wraps, self.length, result
        )
