"""Delay lines over one period: from their states at its start to the delayed values in it and their states at its end.

On a periodic orbit a delay line is eliminated (``delay.delay_line``). Between periods its states carry the history:
stage i of n obeys

    u_i = R u_{i-1} + S y_i + K_i dT,        end_i = F u_{i-1} + E y_i + L_i dT

with u at the collocation points, y_i the stage's states at the period's start, dT the changes of the durations. R, S,
E, F are the same for all stages; K_i and L_i hold how the orbit's own stage i changes with the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.delay import LineOnMesh, MatrixPowers
from pddecont.memo import cached_property
from pddecont.orbit import Orbit

Array = NDArray[np.float64]


@dataclass(eq=False)
class PeriodLine:
    """The line of one delay.

    ``states`` are the orbit's states that run through it, ``numbers`` those of their delayed values, ``inputs``
    (n_collocation, n_quantities) their values on the orbit; ``open`` and ``closed`` are one stage from given states and
    on the periodic orbit. ``slopes`` (n_points, n_quantities, S) holds the derivatives of the delayed values in the
    durations.
    """

    states: tuple[int, ...]
    numbers: tuple[int, ...]
    open: LineOnMesh
    closed: LineOnMesh
    n_stages: int
    inputs: Array

    def __post_init__(self) -> None:
        line, mesh, size = self.open, self.open.mesh, self.open.size
        nothing = np.zeros((mesh.n_intervals, mesh.degree * size, size))
        started = line.solve(nothing, np.eye(size))
        self.start_to_nodes, self.start_to_points = line.output_at_nodes(started), line.output_at_points(started)
        self.start_to_end = started[-1, -1]
        self.nodes_to_end = line.response[-1, -1]
        self._find_duration_derivatives()

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of the line's states: (n_stages, size, n_quantities)."""
        return self.n_stages, self.open.size, self.inputs.shape[1]

    @cached_property
    def weights(self) -> Array:
        """From base values to delayed values at the points, the line empty at the start; shape (n_points, n_base)."""
        powers = MatrixPowers(self.open.to_nodes, self.n_stages)
        return self.open.through_nodes(powers.from_left(self.open.to_points, self.n_stages - 1))

    def _find_duration_derivatives(self) -> None:
        """Find what the durations (first components of theta) change in each stage and in the delayed values."""
        line, S = self.open, self.open.mesh.n_segments
        n_quantities = self.inputs.shape[1]
        self.at_nodes = np.empty((self.n_stages, line.mesh.n_collocation, n_quantities, S))
        self.at_end = np.empty((self.n_stages, line.size, n_quantities, S))
        u, total = self.inputs, np.zeros((line.mesh.n_collocation, n_quantities * S))
        for i in range(self.n_stages):
            states = self.closed.response @ u
            terms = [line.slope_terms(states, line.log_rho_derivative(c)) for c in range(S)]
            moved = np.stack([line.solve(term) for term in terms], axis=-1)
            moved = moved.reshape(*moved.shape[:3], -1)
            self.at_nodes[i] = line.output_at_nodes(moved).reshape(-1, n_quantities, S)
            self.at_end[i] = moved[-1, -1].reshape(-1, n_quantities, S)
            if i + 1 == self.n_stages:
                total = line.to_points @ total + line.output_at_points(moved)
            else:
                total = line.to_nodes @ total + line.output_at_nodes(moved)
            u = self.closed.output_at_nodes(states)
        self.slopes = total.reshape(-1, n_quantities, S)

    def from_start(self, y: Array) -> Array:
        """Return the delayed values that states at the start make.

        Shapes: ``y`` (*shape, k), the result (n_points, n_quantities, k).
        """
        columns = y.reshape(*y.shape[:2], -1)
        u = np.zeros((self.open.mesh.n_collocation, columns.shape[2]))
        for i in range(self.n_stages - 1):
            u = self.open.to_nodes @ u + self.start_to_nodes @ columns[i]
        result: Array = (self.open.to_points @ u + self.start_to_points @ columns[-1]).reshape(-1, *y.shape[2:])
        return result

    def end(self, y: Array, inputs: Array, durations: Array) -> Array:
        """Return the line's states at the end of the period, same shape as ``y`` (*shape, k).

        ``inputs`` (n_collocation, n_quantities, k) and ``durations`` (S, k) are the period's changes.
        """
        columns = y.reshape(*y.shape[:2], -1)
        u, result = inputs.reshape(len(inputs), -1), np.empty_like(columns)
        for i in range(self.n_stages):
            moved = (self.at_end[i] @ durations).reshape(columns.shape[1], -1)
            result[i] = self.nodes_to_end @ u + self.start_to_end @ columns[i] + moved
            at_nodes = (self.at_nodes[i] @ durations).reshape(len(u), -1)
            u = self.open.to_nodes @ u + self.start_to_nodes @ columns[i] + at_nodes
        return result.reshape(y.shape)


def make_period_line(orbit: Orbit, delay: int) -> PeriodLine:
    """Return the line of delay number ``delay`` of an orbit whose delays are delay lines."""
    mesh, stages = orbit.mesh, orbit.problem.delay.stages
    assert stages is not None, "the delay is read from the orbit itself"
    numbers = tuple(q for q, read in enumerate(orbit.numeric.model.delayed) if read.delay == delay)
    states = tuple(orbit.numeric.model.delayed[q].state for q in numbers)
    open_, closed = (
        LineOnMesh(
            stages.line, mesh, orbit.theta, orbit.problem.lags[delay], stages.n, mesh.equation_points, periodic=periodic
        )
        for periodic in (False, True)
    )
    inputs = mesh.interpolate_at_nodes(orbit.values[:, list(states)])
    return PeriodLine(states, numbers, open_, closed, stages.n, inputs)
