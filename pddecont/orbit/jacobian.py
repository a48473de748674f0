"""The residual's derivatives in all unknowns: one pattern a mesh, refilled at every call.

Block pattern, with columns in the order of the unknowns (J intervals, S segments):

                    base values                    T_s   t_0   free
    collocation   [ diagonal blocks + delayed reads | full  full  full ]
    resets        [ one start, one end, its reads   | full  full  full ]
    events        [ one end, its reads              | full  full  full ]
    period        [                                 | ones        full ]

A delayed read touches one interval's base points (direct) or all base points of one state (chain). The matrix is
returned sparse in the first case and dense in the second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix
from pddecont.delay.operator import FullWeights, LocalWeights
from pddecont.model.codegen import Derivatives
from pddecont.orbit.problem import OrbitProblem, Reads, read
from pddecont.orbit.residual import Rows, end_point, mode_sites, phase_weights, timer_weights

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Triplets:
    """Entries of a matrix by row, column and value; entries at the same place add up."""

    rows: Ints
    columns: Ints
    values: Array


@dataclass(frozen=True, eq=False)
class Pattern:
    """A sparse matrix's structure, found once from the places of its entries."""

    shape: tuple[int, int]
    rows: Ints
    columns: Ints

    @cached_property
    def _order(self) -> tuple[Ints, Ints, Ints]:
        key = self.columns * self.shape[0] + self.rows
        unique, inverse = np.unique(key, return_inverse=True)
        indptr = np.searchsorted(unique, np.arange(self.shape[1] + 1) * self.shape[0])
        return unique % self.shape[0], indptr, inverse

    def fits(self, rows: Ints, columns: Ints) -> bool:
        """Whether entries at these places have this structure."""
        return np.array_equal(self.columns, columns) and np.array_equal(self.rows, rows)

    def fill(self, values: Array) -> sp.csc_matrix:
        """Return the matrix with these values."""
        indices, indptr, inverse = self._order
        data = np.bincount(inverse, weights=values, minlength=len(indices))
        return sp.csc_matrix((data, indices, indptr), shape=self.shape)


class Assembler:
    """Jacobian of one problem; keeps the pattern between calls while the delayed reads stay in their intervals."""

    def __init__(self, problem: OrbitProblem):
        self.problem = problem
        self.rows = Rows(problem.layout)
        self.pattern: Pattern | None = None

    def __call__(self, x: Array, sites: Reads | None = None) -> Matrix:
        """Return d residual / d x, shape (n_equations, n_unknowns); ``sites`` if the orbit has been read already."""
        problem = self.problem
        sites = sites or read(problem, x, problem.mesh.sites)
        blocks = Blocks(problem, self.rows, sites)
        triplets = blocks.assemble()
        shape = (self.rows.size, problem.layout.size)
        if blocks.dense:
            matrix = np.bincount(triplets.rows * shape[1] + triplets.columns, weights=triplets.values,
                                 minlength=shape[0] * shape[1]).reshape(shape)  # fmt: skip
            for rows, state, values in blocks.dense:
                columns = problem.layout.value_index[:, state]
                place = np.ix_(rows, columns)
                matrix[place] = matrix[place] + values
            return matrix
        if self.pattern is None or not self.pattern.fits(triplets.rows, triplets.columns):
            self.pattern = Pattern(shape, triplets.rows, triplets.columns)
        return self.pattern.fill(triplets.values)


class Blocks:
    """Collects the entries of one Jacobian.

    ``times`` (n_sites, n_moving) and ``lengths`` (n_intervals, n_moving) say how sites and mesh intervals move with the durations
    and the delays that move, ``xd_moving`` (n_delayed, n_sites, n_moving) how the delayed values do; the first of these columns
    belong to the unknowns ``duration_columns``, the rest to the free parameters through ``to_free``.
    """

    def __init__(self, problem: OrbitProblem, rows: Rows, sites: Reads):
        self.problem, self.equations, self.sites = problem, rows, sites
        self.mesh, self.layout, self.numeric = problem.mesh, problem.layout, problem.numeric
        self.n = self.numeric.n_states
        self.parts: list[Triplets] = []
        self.dense: list[tuple[Ints, int, Array]] = []
        # Unknown part of theta: durations are unknowns themselves, delays move with free parameters.
        self.delay_slopes = self.numeric.delays.derivatives(sites.p, problem.free_index)
        moving = np.flatnonzero(np.any(self.delay_slopes != 0.0, axis=1))
        self.to_free = self.delay_slopes[moving]
        self.move([*range(self.mesh.n_segments), *(self.mesh.n_segments + moving).tolist()])

    def move(self, which: Sequence[int]) -> None:
        """Find how times and delayed values move with the components ``which`` of theta."""
        self.duration_columns = np.arange(self.layout.durations.start, self.layout.durations.stop)
        self.times, self.lengths = self.mesh.site_times[:, which], self.mesh.length[:, which]
        self.xd_moving = self.delayed_slopes(which)

    def delayed_slopes(self, which: Sequence[int]) -> Array:
        """Return the derivatives of the delayed values in components of theta, shape (n_delayed, n_sites, len(which))."""
        delayed = self.numeric.model.delayed
        slopes = np.zeros((len(delayed), self.mesh.n_sites, len(which)))
        for k, operator in enumerate(self.sites.operators):
            reads = [i for i, (_, delay) in enumerate(delayed) if delay == k]
            states = [delayed[i][0] for i in reads]
            slopes[reads] = np.moveaxis(operator.theta_derivative(self.sites.values[:, states], which), 1, 0)
        return slopes

    def add(self, rows: Ints | int, columns: Ints | int, values: Array) -> None:
        """Add entries; the three are broadcast against each other."""
        r, c, v = np.broadcast_arrays(np.asarray(rows), np.asarray(columns), values)
        self.parts.append(Triplets(r.ravel(), c.ravel(), v.ravel()))

    def assemble(self) -> Triplets:
        """Return all entries, but those of full delay operators (``dense``)."""
        self.collocation()
        self.ends()
        self.period()
        return Triplets(*(np.concatenate([getattr(p, f) for p in self.parts]) for f in ("rows", "columns", "values")))

    def others(self, rows: Ints, points: Ints, d: Derivatives, factor: Array, extra: Array) -> None:
        """Add the columns of durations, start and free parameters for ``factor`` * function at ``points``.

        ``rows`` (n_out, n_points) are the equations, ``factor`` (n_points,) multiplies the function, ``extra`` (n_points,
        n_moving) is the factor's own derivative.
        """
        layout, n_durations = self.layout, len(self.duration_columns)
        slope = d.dt[:, :, None] * self.times[points] + np.einsum("oqc,qcr->ocr", d.dxd, self.xd_moving[:, points])
        slope = factor[:, None] * slope + d.value[:, :, None] * extra
        self.add(rows[:, :, None], self.duration_columns, slope[:, :, :n_durations])
        if layout.forced:
            self.add(rows, layout.start.start, factor * d.dt)
        if layout.n_free:
            columns = np.arange(layout.free.start, layout.free.stop)
            at_free = factor[:, None] * np.moveaxis(d.dp, 1, 2) + slope[:, :, n_durations:] @ self.to_free
            self.add(rows[:, :, None], columns, at_free)

    def reads(self, rows: Ints, points: Ints, dxd: Array) -> None:
        """Add the delayed reads: ``dxd`` (n_out, n_delayed, n_points) times the weights at ``points``."""
        for q, (state, delay) in enumerate(self.numeric.model.delayed):
            weights = self.sites.operators[delay].weights
            for i in range(len(rows)):
                if not np.any(dxd[i, q]):
                    continue
                if isinstance(weights, FullWeights):
                    self.dense.append((rows[i], state, dxd[i, q][:, None] * weights.weights[points]))
                elif isinstance(weights, LocalWeights):
                    columns = self.read_columns(weights, points, state)
                    self.add(rows[i][:, None], columns, dxd[i, q][:, None] * weights.weights[points])

    def read_columns(self, weights: LocalWeights, points: Ints, state: int) -> Ints:
        """Return the unknowns that are read at ``points``, shape (n_points, degree + 1)."""
        return self.layout.value_index[weights.columns[points], state]

    def collocation(self) -> None:
        """Add the collocation equations."""
        mesh, n = self.mesh, self.n
        all_rows = np.arange(self.equations.n_collocation).reshape(mesh.n_collocation, n)
        columns = self.layout.value_index[mesh.base_index]  # (J, m + 1, n)
        row_blocks = all_rows.reshape(mesh.n_intervals, mesh.degree, n)
        self.add(row_blocks[:, :, None, :], columns[:, None, :, :], mesh.basis.slopes[None, :, :, None])
        h = np.repeat(self.sites.h, mesh.degree)
        h_moving = np.repeat(self.lengths, mesh.degree, axis=0)
        for mode, points in mode_sites(self.problem):
            s = self.sites
            d = self.numeric.mode(mode).derivatives(s.t[points], s.x[:, points], s.xd[:, points], s.p, self.problem.free_index)
            interval, node = np.divmod(points, mesh.degree)
            rows = all_rows[points].T
            # -h df/dx at the node, spread over the interval's base points; only entries that can be non-zero
            for i, k in np.argwhere(np.any(d.dx != 0.0, axis=2)):
                block = (-h[points] * d.dx[i, k])[:, None] * mesh.basis.values[node]
                self.add(rows[i][:, None], columns[interval, :, k], block)
            self.reads(rows, points, -h[points] * d.dxd)
            self.others(rows, points, d, -h[points], -h_moving[points])

    def ends(self) -> None:
        """Add the resets and what ends each segment."""
        mesh, n = self.mesh, self.n
        timed = {s: (source, wraps) for s, source, wraps in self.problem.timers}
        for s, segment in enumerate(self.problem.segments):
            at_end = end_point(self.problem, self.sites, s)
            point = np.array([mesh.n_collocation + s])
            end = self.layout.value_index[mesh.last_base[s]]
            rows = (self.equations.resets + s * n + np.arange(n))[:, None]
            self.add(rows[:, 0], self.after(s), np.ones(n))
            d = self.numeric.reset(segment.reset).derivatives(*at_end, self.problem.free_index)
            self.condition(rows, point, end, d, -1.0)
            row = np.array([[self.equations.events + s]])
            if s in timed:
                self.timer(row, s, *timed[s])
            elif segment.event:
                self.condition(row, point, end, self.numeric.event(segment.event).derivatives(*at_end, self.problem.free_index), 1.0)
            else:
                self.phase(row)

    def after(self, s: int) -> Ints:
        """Return the unknowns that hold the state after the reset at the end of segment ``s``, shape (n_states,)."""
        return self.layout.value_index[self.mesh.first_base[(s + 1) % self.mesh.n_segments]]

    def timer(self, row: Ints, s: int, source: int, wraps: int) -> None:
        """Add the equation of a delayed event at the end of segment ``s``."""
        self.add(row, self.duration_columns, timer_weights(self.problem, s, source, wraps))
        if self.layout.n_free:
            delay = self.numeric.event_delay(self.problem.segments[s].event)
            slope = delay.derivatives(self.sites.p, self.problem.free_index)[0]
            self.add(row, np.arange(self.layout.free.start, self.layout.free.stop), -slope)

    def phase(self, row: Ints) -> None:
        """Add the phase condition of an orbit without events."""
        if self.layout.forced:
            self.add(row, self.layout.start.start, np.ones(1))
        else:
            self.add(row, np.arange(self.layout.values.stop), phase_weights(self.problem))

    def condition(self, rows: Ints, point: Ints, end: Ints, d: Derivatives, sign: float) -> None:
        """Add ``sign`` times a function of a segment's end."""
        self.add(rows, end, sign * d.dx[:, :, 0])
        self.reads(rows, point, sign * d.dxd)
        self.others(rows, point, d, np.full(1, sign), np.zeros((1, self.times.shape[1])))

    def period(self) -> None:
        """Add the period of a forced orbit."""
        if not self.layout.forced:
            return
        row, layout = self.equations.period, self.layout
        self.add(row, self.duration_columns, np.ones(self.mesh.n_segments))
        if layout.n_free:
            slope = self.numeric.period.derivatives(self.sites.p, self.problem.free_index)[0]
            self.add(row, np.arange(layout.free.start, layout.free.stop), -self.problem.n_periods * slope)
