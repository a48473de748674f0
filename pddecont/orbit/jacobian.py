"""The Jacobian of an orbit's equations in its unknowns.

Block pattern for two segments of two intervals each, an autonomous model and a delay longer than an interval. Rows are
equations, columns unknowns; # is a full block, + an identity or a single row, . holds zeros:

                                 base values                        durations     free
                        z_1,1   z_1,2 |  z_2,1   z_2,2              T_1   T_2     parameters
      collocation 1,1 (   #       .   |    .       #                 #     #          #     )  (1) (2)
      collocation 1,2 (   #       #   |    .       .                 #     #          #     )
      collocation 2,1 (   .       #   |    #       .                 #     #          #     )
      collocation 2,2 (   .       .   |    #       #                 #     #          #     )
      reset 1         (   .       #   |    +       .                 #     #          #     )  (3)
      reset 2         (   +       .   |    .       #                 #     #          #     )
      event 1         (   .       +   |    .       .                 #     #          #     )  (4)
      event 2         (   .       .   |    .       +                 #     #          #     )

    (1) An interval's own block, (degree * n_states) x ((degree + 1) * n_states): slopes at the collocation points less
        h df/dx; neighbouring intervals of a segment share a base point.
    (2) Its delayed reads, -h df/dx(t - tau): the base points of one interval for each point (direct), or all of a
        state's (chain, Chebyshev), in which case the matrix is full.
    (3) The state after the reset, and the segment's last base point.
    (4) The segment's last base point; a delayed event holds durations alone.

A forced model adds the start t_0 as a column after the durations and the period equation (ones in the columns of the
durations) as the last row.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import Matrix
from pddecont.delay import LocalWeights
from pddecont.orbit.assembly import Assembly, find_assembly
from pddecont.orbit.linearisation import Entries
from pddecont.orbit.orbit import Orbit, Reads
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.residual import Rows, find_elapsed_weights, phase_weights
from pddecont.orbit.signature import DelayedEventLink

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


class PeriodicColumns:
    """Columns of one period's unknowns: an earlier period is the same, so every read is of them."""

    def __init__(self, problem: OrbitProblem):
        self.problem, self.unknowns = problem, problem.unknowns
        mesh = problem.mesh
        moving_taus = problem.numeric.delays.function.structure(problem.free_index).moving
        n_before = mesh.n_segments + len(problem.numeric.model.delays)
        breaking = range(n_before, n_before + mesh.n_breaking)
        self.theta_components = [*range(mesh.n_segments), *breaking, *(mesh.n_segments + moving_taus).tolist()]
        self.shape = (Rows(problem.unknowns).size, problem.unknowns.size)
        self.moving_columns: Ints = np.arange(self.unknowns.moving.start, self.unknowns.moving.stop)
        self.equation_times: Array = np.ascontiguousarray(mesh.equation_times[:, self.theta_components])
        self.interval_lengths: Array = np.ascontiguousarray(mesh.length[:, self.theta_components])

    def delayed_derivatives(self, orbit: Orbit, reads: Reads) -> Array:
        """Return how what is read of the past moves with durations, breaking times and delays."""
        model = orbit.numeric.model
        slopes = np.zeros((len(model.read_symbols), orbit.mesh.n_equation_points, len(self.theta_components)))
        for (k, order), rows in model.read_groups.items():
            states = [model.delayed[i].state for i in rows]
            moves = reads.operators[k].theta_derivative(orbit.values[:, states], self.theta_components, order)
            slopes[rows] = moves.transpose(1, 0, 2)
        mesh, turns = orbit.mesh, np.zeros(len(self.theta_components))
        turns[: orbit.mesh.n_segments] = 1.0
        for i, integral in enumerate(reads.integrals):
            interval, wraps = integral.window.interval, integral.window.wraps
            first, last = int(np.min(wraps, initial=0)), int(np.max(wraps, initial=0))
            own = mesh.start[:, self.theta_components]
            starts = np.concatenate([own - w * turns for w in range(first, last + 1)])
            lengths = np.tile(self.interval_lengths, (last + 1 - first, 1))
            read = interval + (wraps - first) * mesh.n_intervals
            slopes[len(model.delayed) + i] = integral.moves(
                self.equation_times, starts, lengths, read, reads.h[interval]
            )
        return slopes

    def read_columns(self, weights: LocalWeights, points: Ints, state: int) -> Ints:
        """Return the unknowns that are read at ``points``, shape (n_points, degree + 1)."""
        result: Ints = self.unknowns.value_index[weights.columns[points], state]
        return result

    def state_after(self, s: int) -> Ints:
        """Return the unknowns at the start of the next segment; the last is followed by the first."""
        mesh = self.problem.mesh
        result: Ints = self.unknowns.value_index[mesh.first_base[(s + 1) % mesh.n_segments]]
        return result

    def find_elapsed_weights(self, link: DelayedEventLink) -> Array:
        """Return the weights of durations and breaking times between a delayed event and its source."""
        weights = find_elapsed_weights(self.problem, link)
        return np.concatenate([weights, np.zeros(self.problem.mesh.n_breaking)])

    def find_time_weights(self, coefficients: Array) -> Array:
        """Return the weights of durations, breaking times and moving delays in a sum of theta."""
        return coefficients[self.theta_components]

    def phase_entries(self, row: int) -> list[Entries]:
        """Return the start's column of a forced orbit, all base values of an autonomous one."""
        if self.unknowns.forced:
            return [Entries(row, self.unknowns.start.start, 1.0)]
        columns = np.arange(self.unknowns.values.stop)
        return [Entries(row, columns, lambda at: phase_weights(at.orbit.problem))]

    def period_entries(self, row: int) -> list[Entries]:
        """Return the sum of the durations less whole forcing periods; nothing for an autonomous model."""
        if not self.unknowns.forced:
            return []
        entries = [Entries(row, np.arange(self.unknowns.durations.start, self.unknowns.durations.stop), 1.0)]
        place, free = self.unknowns.free, self.problem.free_index
        if free:
            period = self.problem.numeric.period
            columns = np.arange(place.start, place.stop)
            entries.append(
                Entries(
                    row,
                    columns,
                    lambda at: -at.orbit.problem.n_periods * period.derivatives(at.orbit.parameters, free)[0],
                )
            )
        return entries


def make_jacobian(orbit: Orbit, places: dict[str, Assembly] | None = None) -> Matrix:
    """Return d residual / d x, shape (n_equations, n_unknowns).

    ``places`` holds those of the last Jacobian's entries, which are taken where they serve, and gets this one's.
    """
    problem, reads = orbit.problem, orbit.equation_reads
    kept = {} if places is None else places
    last = kept.get("last")
    kept["last"] = found = find_assembly("jacobian", problem, reads, lambda: PeriodicColumns(problem), last)
    return found.make_matrix(orbit, reads)
