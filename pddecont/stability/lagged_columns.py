"""Columns of the unknowns of several periods, for the linearised motion from one period to the next.

Column w * n_columns + j belongs to unknown j of period k - w. A period's columns are its base values, durations and
start, and the state after the reset at its end.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from pddecont.delay import LocalWeights
from pddecont.orbit import DelayedEventLink, Entries, Orbit, OrbitProblem, Reads, Rows
from pddecont.stability.lagged_times import LaggedMesh, find_deepest_lag, spread_over_lags, take_moving
from pddecont.stability.moving_edges import Edge
from pddecont.stability.period_line import PeriodLine

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


def count_lags(problem: OrbitProblem, reads: Reads, still: Collection[Edge]) -> int:
    """Return of how many periods the equations of one hold unknowns."""
    wraps = [int(np.max(weights.wraps)) for weights in reads.list_local_weights()]
    linked = [link.wraps for link in problem.links]
    return 2 + max([*wraps, *linked], default=0) + find_deepest_lag(problem.mesh, still)


class LaggedColumns:
    """Columns of ``n_lags`` periods; every read goes to the period that it reaches back to.

    ``lines`` holds the delay lines by number of the delay: their history is kept by the lines' own states. Mesh edges
    in ``still`` do not move with the durations.
    """

    def __init__(
        self, problem: OrbitProblem, reads: Reads, lines: Mapping[int, PeriodLine], still: Collection[Edge] = ()
    ):
        mesh, unknowns = problem.mesh, problem.unknowns
        self.n_lags = count_lags(problem, reads, still)
        self.problem, self.unknowns, self.lines = problem, unknowns, lines
        self.lags = LaggedMesh(mesh, self.n_lags, still)
        self.n_columns = unknowns.size + unknowns.n_states
        self.shape = (self.n_columns, self.n_columns * self.n_lags)
        moving = np.arange(unknowns.moving.start, unknowns.moving.stop)
        self.moving_columns: Ints = (np.arange(self.n_lags)[:, None] * self.n_columns + moving).ravel()
        flat = (-1, self.n_lags * len(moving))
        self.equation_times: Array = self.lags.times(mesh.equation_points).reshape(flat)
        self.interval_lengths: Array = self.lags.length.reshape(flat)

    def delayed_derivatives(self, orbit: Orbit, reads: Reads) -> Array:
        """Return how delayed values move with the durations and breaking times of all periods."""
        n_delayed = len(orbit.numeric.model.delayed)
        moves = [self._derivatives_of(q, orbit, reads).reshape(self.equation_times.shape) for q in range(n_delayed)]
        moves += [self._integral_moves(i, reads) for i in range(len(reads.integrals))]
        return np.stack(moves) if moves else np.zeros((0, *self.equation_times.shape))

    def _integral_moves(self, number: int, reads: Reads) -> Array:
        """Return the derivatives of an integral over the past, shape (n_equation_points, n_lags * (S + J))."""
        integral, lags = reads.integrals[number], self.lags
        interval, wraps = integral.window.interval, integral.window.wraps
        first, last = int(np.min(wraps, initial=0)), int(np.max(wraps, initial=0))
        n_segments, lag = self.problem.mesh.n_segments, np.arange(self.n_lags)
        starts, lengths = np.zeros((2, last + 1 - first, *lags.start.shape))
        for w in range(first, last + 1):
            starts[w - first, :, :, :n_segments] -= ((lag >= 1) & (lag <= w))[:, None]
            starts[w - first, :, w:] += lags.start[:, : self.n_lags - w]
            lengths[w - first, :, w:] = lags.length[:, : self.n_lags - w]
        flat, read = (-1, self.equation_times.shape[1]), interval + (wraps - first) * len(lags.start)
        h = reads.h[interval]
        return integral.moves(self.equation_times, starts.reshape(flat), lengths.reshape(flat), read, h)

    def _derivatives_of(self, q: int, orbit: Orbit, reads: Reads) -> Array:
        """Return the derivatives of delayed value ``q``, shape (n_equation_points, n_lags, S + J)."""
        mesh, read = orbit.mesh, orbit.numeric.model.delayed[q]
        if read.delay in self.lines:
            line = self.lines[read.delay]
            result = np.zeros((mesh.n_equation_points, self.n_lags, mesh.n_segments))
            result[:, 0] = line.slopes[:, line.states.index(read.state)]
            return result
        weights = reads.operators[read.delay].weights_of(read.derivative)
        assert isinstance(weights, LocalWeights)
        values = orbit.values[weights.columns, read.state]
        slopes = np.einsum("pb,pb->p", weights.weights @ mesh.basis.differentiate, values)
        times = self.equation_times.reshape(mesh.n_equation_points, self.n_lags, -1)
        result = self.lags.move_reads(slopes, times, weights, reads.h)
        if read.derivative:
            rates = np.einsum("pb,pb->p", weights.weights, values) * read.derivative / reads.h[weights.interval]
            self.lags.stretch_rates(rates, weights, result)
        return result

    def read_columns(self, weights: LocalWeights, points: Ints, state: int) -> Ints:
        """Return the columns that a read reaches: those of as many periods back as it wraps."""
        now = self.unknowns.value_index[weights.columns[points], state]
        return np.asarray(now + (weights.wraps[points] * self.n_columns)[:, None])

    def state_after(self, s: int) -> Ints:
        """Return the columns of the state that segment ``s`` is followed by; after the last, a state of its own."""
        mesh = self.problem.mesh
        if s + 1 == mesh.n_segments:
            return self.unknowns.size + np.arange(self.unknowns.n_states)
        result: Ints = self.unknowns.value_index[mesh.first_base[s + 1]]
        return result

    def find_elapsed_weights(self, link: DelayedEventLink) -> Array:
        """Return the weights of the durations of as many periods as lie between a delayed event and its source."""
        mesh = self.problem.mesh
        weights = np.zeros((self.n_lags, mesh.n_segments + mesh.n_breaking))
        weights[1 : link.wraps + 1, : mesh.n_segments] = 1.0
        weights[0, : link.segment + 1] += 1.0
        weights[link.wraps, : link.source + 1] -= 1.0
        return weights.ravel()

    def find_time_weights(self, coefficients: Array) -> Array:
        """Return the weights of what moves the edges of all periods in a sum of theta: b less its source."""
        mesh = self.problem.mesh
        moving = take_moving(coefficients, mesh)
        n = len(moving) - mesh.n_breaking
        own = np.zeros(len(moving))
        # The breaking time itself is the last one of its sum with the coefficient one: its source comes before it.
        own[n + int(np.flatnonzero(moving[n:] == 1.0)[-1])] = 1.0
        source = spread_over_lags(own - moving, self.n_lags, mesh.n_segments)
        source[0] -= own
        return np.asarray(-source.ravel())

    def phase_entries(self, row: int) -> list[Entries]:
        """Return the entry of a period that lasts as long as the orbit's own."""
        return [Entries(row, self.unknowns.durations.start, 1.0)]

    def period_entries(self, row: int) -> list[Entries]:
        """Return where a period starts: the state that the last one ended with, and its time."""
        unknowns, n = self.unknowns, self.unknowns.n_states
        rows = Rows(unknowns).size + np.arange(n)
        entries = [
            Entries(rows, unknowns.value_index[self.problem.mesh.first_base[0]], 1.0),
            Entries(rows, self.n_columns + unknowns.size + np.arange(n), -1.0),
        ]
        if unknowns.forced:
            start = unknowns.start.start
            entries.append(Entries(row, start, 1.0))
            if self.problem.signature.has_events:
                durations = np.arange(unknowns.durations.start, unknowns.durations.stop)
                entries.append(Entries(row, self.n_columns + start, -1.0))
                entries.append(Entries(row, self.n_columns + durations, -1.0))
        return entries
