"""Delayed values read from the orbit's own polynomials, wrapped by whole periods.

A point at time b @ theta reads at (b - lag) @ theta + w sum T_s. Which interval that lies in, and w, are decided once,
at the mesh's reference theta: while the unknowns move by less than a mesh interval the same polynomial is read,
slightly beyond its ends if need be, so that the delayed values are smooth functions of all unknowns and their
derivatives exact. A mesh whose breaking points change their order is renewed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh, MeshPoints
from pddecont.delay.interface import DelayOperator, LineStages, LocalWeights
from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property
from pddecont.native import compiled_assembly

Array = NDArray[np.float64]
# How far inside its interval a read at an edge is looked for, in periods: above rounding, below any interval.
NUDGE = 1e-11
# Intervals beyond its own that a polynomial is read at most; farther it says nothing.
FAR = 3.0
# Intervals beyond its own that a read may move before it is taken from where it lies: polynomials grow fast there.
BEYOND = 0.05


@dataclass(frozen=True)
class Direct:
    """Reads of the orbit itself; ``track`` says whether meshes follow the breaking points."""

    track: bool = True

    @property
    def tracks_breaking_points(self) -> bool:
        """Whether meshes follow the breaking points."""
        return self.track

    @property
    def stages(self) -> LineStages | None:
        """None: delayed values are values of the orbit itself."""
        return None

    @property
    def simulated_stages(self) -> tuple[int, int]:
        """(0, 0): a simulation reads the past itself."""
        return 0, 0

    def mesh_is_valid(self, mesh: Mesh, theta: Array, lags: Array, varying: Array) -> bool:
        """Return whether every value is still read from the piece in which it lies at ``theta``, near its interval.

        Collocation points of a mesh that does not track breaking points may pass an edge; a segment's end never may,
        since a state may jump there.
        """
        if mesh.reference_theta is None:
            return True
        moving = [] if mesh.reference_lags is None else list(enumerate(varying))
        return all(self._reads_alike(mesh, theta, reference_reads(mesh, lag), 0.0) for lag in lags) and all(
            self._reads_alike(mesh, theta, reference_varying_reads(mesh, k), own) for k, own in moving
        )

    def _reads_alike(self, mesh: Mesh, theta: Array, reads: Reads, lags: Array | float) -> bool:
        """Return whether points that read ``reads``, ``lags`` earlier, lie where they do at ``theta``, or near it."""
        starts, lengths = mesh.evaluate_edges(theta)
        with np.errstate(divide="ignore", invalid="ignore"):
            sigma = (reads.evaluate(theta) - lags - starts[reads.interval]) / lengths[reads.interval]
        if np.any(sigma < -BEYOND) or np.any(sigma > 1.0 + BEYOND):
            return False
        # What is read at a breaking time is an edge: rounding says on which side.
        held = slice(0 if self.track else mesh.n_collocation, mesh.n_collocation + mesh.n_segments)
        now = find_reads(mesh, theta, reads.lag, reads.points, lags)
        same_piece = mesh.piece[now.interval[held]] == mesh.piece[reads.interval[held]]
        return bool(np.all(same_piece & (now.wraps[held] == reads.wraps[held])))

    def operator(self, mesh: Mesh, theta: Array, lag: Array, points: MeshPoints, *, orders: int = 0) -> DelayOperator:
        """Return the operator that reads ``lag @ theta`` before ``points``, and as many derivatives there."""
        held = mesh.reference_theta is not None and points is mesh.equation_points
        reads = reference_reads(mesh, lag) if held else find_reads(mesh, theta, lag, points)
        return make_operator(mesh, theta, reads, 0.0, orders)

    def varying_operator(
        self, mesh: Mesh, theta: Array, lags: Array, points: MeshPoints, *, number: int, orders: int = 0
    ) -> DelayOperator:
        """Return the operator that reads ``lags`` (n_points,) before ``points``, of varying delay ``number``."""
        held = mesh.reference_lags is not None and points is mesh.equation_points
        reads = (
            reference_varying_reads(mesh, number)
            if held
            else find_reads(mesh, theta, np.zeros(len(theta)), points, lags)
        )
        return make_operator(mesh, theta, reads, lags, orders)


def make_operator(mesh: Mesh, theta: Array, reads: Reads, lags: Array | float, orders: int) -> DelayOperator:
    """Return the operator that reads ``reads``, ``lags`` earlier than their times, and so many derivatives there."""
    weights, matrix = _weigh(mesh, theta, reads, lags), mesh.basis.differentiate
    j, every_length = reads.interval, mesh.evaluate_edges(theta)[1]
    rates = [weights]
    for _ in range(orders):
        rates.append(rates[-1].differentiate(matrix, every_length[j]))

    def theta_derivative(values: Array, which: Sequence[int], order: int) -> Array:
        read = rates[order]
        result = _find_moves(mesh, every_length, reads, read, values, np.asarray(which, dtype=np.intp))
        if order:
            stretches = mesh.length[:, which][j] / every_length[j][:, None]
            result -= order * read.apply(values)[:, :, None] * stretches[:, None, :]
        return result

    return DelayOperator(weights, theta_derivative, tuple(rates[1:]))


def _weigh(mesh: Mesh, theta: Array, reads: Reads, lags: Array | float) -> LocalWeights:
    """Return what reads ``reads``, ``lags`` earlier than their times."""
    (starts, lengths), basis, points, n = mesh.evaluate_edges(theta), mesh.basis, reads.points, len(reads.points)
    earlier = np.zeros(n) + lags
    sigma, weights = np.empty(n), np.empty((n, basis.degree + 1))
    farthest = compiled_assembly.weigh_reads(
        starts,
        lengths,
        np.ascontiguousarray(points.interval),
        np.ascontiguousarray(points.sigma),
        n,
        float(reads.lag @ theta),
        earlier,
        mesh.period(theta),
        reads.wraps,
        reads.interval,
        basis.base,
        basis.barycentric,
        basis.degree + 1,
        sigma,
        weights,
    )
    if farthest < 0.0:
        raise ConvergenceError("a mesh interval has vanished")
    if farthest > FAR:
        raise ConvergenceError("a delayed value is read far outside its mesh interval")
    return LocalWeights(reads.columns, weights, reads.interval, sigma, reads.wraps)


def _find_moves(
    mesh: Mesh, lengths: Array, reads: Reads, weights: LocalWeights, values: Array, which: NDArray[np.intp]
) -> Array:
    """Return how what is read moves with its time, where that moves with the components ``which`` of theta.

    The shape is (n_points, n_quantities, len(which)); ``lengths`` (n_intervals,) are those of the mesh intervals.
    """
    n, m = weights.weights.shape
    base_values = np.ascontiguousarray(values)
    n_values, n_theta = base_values.shape[1], mesh.start.shape[1]
    result = np.empty((n, n_values, len(which)))
    compiled_assembly.move_reads(
        weights.weights,
        reads.columns,
        n,
        m,
        mesh.basis.differentiate,
        base_values,
        n_values,
        reads.times,
        mesh.start,
        mesh.length,
        n_theta,
        which,
        len(which),
        reads.interval,
        weights.sigma,
        lengths,
        np.empty(m),
        result,
    )
    return result


@dataclass(frozen=True, eq=False)
class Reads:
    """Where ``points`` of a mesh read, ``lag`` (n_theta,) before: ``wraps`` periods back, in which ``interval``.

    The lags of a delay that varies are to be taken from the times. ``columns`` (n_points, degree + 1) are the
    interval's base points.
    """

    mesh: Mesh
    points: MeshPoints
    lag: Array
    wraps: NDArray[np.intp]
    interval: NDArray[np.intp]
    columns: NDArray[np.intp]

    @cached_property
    def times(self) -> Array:
        """Coefficients of theta in the times that are read, moved into the orbit, shape (n_points, n_theta)."""
        times = self.mesh.times(self.points) - self.lag
        times[:, : self.mesh.n_segments] += self.wraps[:, None]
        return times

    def evaluate(self, theta: Array) -> Array:
        """Return the times that are read at ``theta``, moved into the orbit, shape (n_points,)."""
        times = self.mesh.evaluate_times(self.points, theta) - self.lag @ theta
        return np.asarray(times + self.wraps * self.mesh.period(theta))


def reference_varying_reads(mesh: Mesh, number: int) -> Reads:
    """Return where the equation points of a mesh read by varying delay ``number`` where it was made."""
    theta, lags = mesh.reference_theta, mesh.reference_lags
    assert theta is not None and lags is not None
    still = np.zeros(len(theta))
    return mesh.once(
        ("varying reads", number), lambda: find_reads(mesh, theta, still, mesh.equation_points, lags[number])
    )


def reference_reads(mesh: Mesh, lag: Array) -> Reads:
    """Return where the equation points of a mesh read at the theta that it was made for."""
    theta = mesh.reference_theta
    assert theta is not None
    return mesh.once(("reads", lag.tobytes()), lambda: find_reads(mesh, theta, lag, mesh.equation_points))


def find_reads(mesh: Mesh, theta: Array, lag: Array, points: MeshPoints, lags: Array | float = 0.0) -> Reads:
    """Return where ``points`` read at ``theta``; at an edge, on the side that the point itself is on.

    ``lags`` (n_points,) are added to ``lag @ theta``.
    """
    at = mesh.evaluate_times(points, theta) - lag @ theta - lags
    located, later = mesh.locate(theta, at, choose_by=at + NUDGE * mesh.period(theta) * points.side)
    return Reads(mesh, points, lag, -later, located.interval, mesh.base_index[located.interval])
