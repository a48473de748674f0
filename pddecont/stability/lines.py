"""Delay lines over one period: from their states at its start to the delayed values in it and their states at its end.

On a periodic orbit a delay line is eliminated (``delay.line``). Between periods its states carry the history: stage i of n obeys

    u_i = R u_{i-1} + S y_i + K_i dT,        end_i = F u_{i-1} + E y_i + L_i dT

with u at the collocation points, y_i the stage's states at the period's start, dT the changes of the durations. R, S, E, F are the
same for all stages; K_i and L_i hold how the orbit's own stage i changes with the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.chain import Chain, Powers, taylor_step
from pddecont.delay.chebyshev import Chebyshev, profile_line
from pddecont.delay.line import LineOnMesh
from pddecont.orbit.problem import OrbitProblem

Array = NDArray[np.float64]


@dataclass(eq=False)
class PeriodLine:
    """The line of one delay.

    ``states`` are the orbit's states that run through it, ``numbers`` those of their delayed values, ``inputs`` (n_collocation,
    n_quantities) their values on the orbit; ``open`` and ``closed`` are one stage from given states and on the periodic orbit.
    ``slopes`` (n_places, n_quantities, S) holds the derivatives of the delayed values in the durations.
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
        self.start_to_nodes, self.start_to_places = line.at_nodes(started), line.at_places(started)
        self.start_to_end = started[-1, -1]
        self.nodes_to_end = line.response[-1, -1]
        self._durations()

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of the line's states: (n_stages, size, n_quantities)."""
        return self.n_stages, self.open.size, self.inputs.shape[1]

    @cached_property
    def weights(self) -> Array:
        """From base values to delayed values at the places, the line empty at the start; shape (n_places, n_base)."""
        powers = Powers(self.open.to_nodes, self.n_stages)
        return self.open.through_nodes(powers.from_left(self.open.to_places, self.n_stages - 1))

    def _durations(self) -> None:
        """Find what the durations (first components of theta) change in each stage and in the delayed values."""
        line, S = self.open, self.open.mesh.n_segments
        n_quantities = self.inputs.shape[1]
        self.at_nodes = np.empty((self.n_stages, line.mesh.n_collocation, n_quantities, S))
        self.at_end = np.empty((self.n_stages, line.size, n_quantities, S))
        u, total = self.inputs, np.zeros((line.mesh.n_collocation, n_quantities * S))
        for i in range(self.n_stages):
            states = self.closed.response @ u
            moved = np.stack([line.solve(line.moved(states, line.relative(c))) for c in range(S)], axis=-1)
            moved = moved.reshape(*moved.shape[:3], -1)
            self.at_nodes[i] = line.at_nodes(moved).reshape(-1, n_quantities, S)
            self.at_end[i] = moved[-1, -1].reshape(-1, n_quantities, S)
            if i + 1 == self.n_stages:
                total = line.to_places @ total + line.at_places(moved)
            else:
                total = line.to_nodes @ total + line.at_nodes(moved)
            u = self.closed.at_nodes(states)
        self.slopes = total.reshape(-1, n_quantities, S)

    def from_start(self, y: Array) -> Array:
        """Return the delayed values that states at the start make, (n_places, n_quantities, k) for ``y`` (*shape, k)."""
        columns = y.reshape(*y.shape[:2], -1)
        u = np.zeros((self.open.mesh.n_collocation, columns.shape[2]))
        for i in range(self.n_stages - 1):
            u = self.open.to_nodes @ u + self.start_to_nodes @ columns[i]
        return (self.open.to_places @ u + self.start_to_places @ columns[-1]).reshape(-1, *y.shape[2:])

    def end(self, y: Array, inputs: Array, durations: Array) -> Array:
        """Return the line's states at the end of the period, same shape as ``y`` (*shape, k).

        ``inputs`` (n_collocation, n_quantities, k) and ``durations`` (S, k) are the period's changes.
        """
        columns = y.reshape(*y.shape[:2], -1)
        u, result = inputs.reshape(len(inputs), -1), np.empty_like(columns)
        for i in range(self.n_stages):
            moved = (self.at_end[i] @ durations).reshape(columns.shape[1], -1)
            result[i] = self.nodes_to_end @ u + self.start_to_end @ columns[i] + moved
            u = self.open.to_nodes @ u + self.start_to_nodes @ columns[i] + (self.at_nodes[i] @ durations).reshape(len(u), -1)
        return result.reshape(y.shape)


def period_line(problem: OrbitProblem, theta: Array, delay: int, states: tuple[int, ...], numbers: tuple[int, ...],
                inputs: Array) -> PeriodLine:  # fmt: skip
    """Return the line of delay number ``delay``; the rest as in :class:`PeriodLine`."""
    mesh, method = problem.mesh, problem.delay
    if isinstance(method, Chain):
        line, n_stages = taylor_step(method.order), method.n
    else:
        assert isinstance(method, Chebyshev)
        line, n_stages = profile_line(method.n), 1
    open_, closed = (LineOnMesh(line, mesh, theta, mesh.n_segments + delay, n_stages, mesh.sites, periodic=p) for p in (False, True))
    return PeriodLine(states, numbers, open_, closed, n_stages, inputs)
