"""The residual's derivatives in all unknowns: places of entries found once a mesh, values filled in at every call.

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

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation.linear import Matrix
from pddecont.delay.operator import DelayOperator, FullWeights, LocalWeights
from pddecont.model.codegen import ArrayFunction, Derivatives
from pddecont.orbit.problem import OrbitProblem, Reads, read
from pddecont.orbit.residual import Rows, mode_sites, phase_weights, reset_sites, timer_weights

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Pattern:
    """A sparse matrix's structure, found once from the places of its entries; entries at one place add up."""

    shape: tuple[int, int]
    rows: Ints
    columns: Ints

    @cached_property
    def _order(self) -> tuple[NDArray[np.intc], NDArray[np.intc], Ints]:
        key = self.columns * self.shape[0] + self.rows
        unique, inverse = np.unique(key, return_inverse=True)
        indptr = np.searchsorted(unique, np.arange(self.shape[1] + 1) * self.shape[0])
        return (unique % self.shape[0]).astype(np.intc), indptr.astype(np.intc), inverse

    def fill(self, values: Array) -> sp.csc_matrix:
        """Return the matrix with these values."""
        indices, indptr, inverse = self._order
        data = np.bincount(inverse, weights=values, minlength=len(indices))
        return sp.csc_matrix((data, indices, indptr), shape=self.shape)


class Assembler:
    """Jacobian of one problem; keeps the places of its entries while the delayed reads stay in their intervals."""

    def __init__(self, problem: OrbitProblem, blocks: Blocks | None = None):
        self.problem = problem
        self.blocks = blocks

    def __call__(self, x: Array, sites: Reads | None = None) -> Matrix:
        """Return d residual / d x, shape (n_equations, n_unknowns); ``sites`` if the orbit has been read already."""
        problem = self.problem
        sites = sites or read(problem, x, problem.mesh.sites)
        if self.blocks is None or not self.blocks.fits(sites.operators):
            self.blocks = Blocks(problem, sites.operators)
        return self.blocks.matrix(problem, sites)


@dataclass(frozen=True, eq=False)
class Term:
    """Entries of one kind: where they stand among all entries, their shape, and what gives their values at an orbit."""

    place: slice
    shape: tuple[int, ...]
    values: Callable[[Evaluation], Array]


@dataclass(frozen=True, eq=False)
class DenseTerm:
    """Reads of all base values of one state: ``columns`` of the equations ``rows``, with their values at an orbit."""

    rows: Ints
    columns: Ints
    values: Callable[[Evaluation], Array]


@dataclass(frozen=True, eq=False)
class Equations:
    """Equations ``rows`` (n_out, n_points) that hold a factor times ``function`` at ``points``.

    The states there are read from the unknowns ``columns`` (n_points, n_base, n_states) with ``weights`` (n_points, n_base). The factor
    is minus the interval's length for a collocation equation, else ``sign``.
    """

    function: ArrayFunction
    points: Ints
    rows: Ints
    columns: Ints
    weights: Array
    sign: float = 0.0


class Evaluation:
    """An orbit at which a Jacobian is evaluated; what several terms need is computed once.

    ``problem`` may differ from that of the blocks in what leaves the places alone: values of fixed parameters, the phase's reference.

    ``h`` (n_sites,) are the lengths of the sites' intervals. ``xd_moving`` (n_delayed, n_sites, n_moving) says how the delayed values
    move with the durations and delays that move, ``to_free`` (n_moving delays, n_free) how those delays do with the free parameters.
    """

    def __init__(self, blocks: Blocks, problem: OrbitProblem, sites: Reads):
        self.blocks, self.problem, self.sites = blocks, problem, sites
        self.h = sites.h[blocks.mesh.sites.interval]
        self.to_free = blocks.numeric.delays.derivatives(sites.p, blocks.problem.free_index)[blocks.moving_delays]
        self.xd_moving = blocks.delayed_slopes(sites)
        self._derivatives: dict[int, Derivatives] = {}
        self._slopes: dict[int, Array] = {}

    def derivatives(self, e: Equations) -> Derivatives:
        """Return the function of ``e`` with its derivatives at its points."""
        if id(e) not in self._derivatives:
            s = self.sites
            self._derivatives[id(e)] = e.function.derivatives(s.t[e.points], s.x[:, e.points], s.xd[:, e.points], s.p,
                                                              self.blocks.problem.free_index)  # fmt: skip
        return self._derivatives[id(e)]

    def factor(self, e: Equations) -> Array | float:
        """Return what the function of ``e`` is multiplied by."""
        return e.sign or -self.h[e.points]

    def slopes(self, e: Equations) -> Array:
        """Return how the equations move with the durations and delays that move, shape (n_out, n_points, n_moving)."""
        if id(e) not in self._slopes:
            d, blocks, structure = self.derivatives(e), self.blocks, e.function.structure(self.blocks.problem.free_index)
            result = np.zeros((*e.rows.shape, blocks.times.shape[1]))
            if len(structure.dt):
                result[structure.dt] = d.dt[:, :, None] * blocks.times[e.points]
            for i, q, slope in zip(*structure.dxd, d.dxd, strict=True):
                result[i] += slope[:, None] * self.xd_moving[q, e.points]
            if e.sign:
                result *= e.sign
            else:
                result *= -self.h[e.points, None]
                result -= d.value[:, :, None] * blocks.lengths[blocks.mesh.sites.interval[e.points]]
            self._slopes[id(e)] = result
        return self._slopes[id(e)]


class Blocks:
    """Places of a Jacobian's entries, for one mesh, one set of free parameters and reads in the same intervals.

    ``times`` (n_sites, n_moving) and ``lengths`` (n_intervals, n_moving) say how sites and mesh intervals move with the durations
    and the delays that move; the first of these columns belong to the unknowns ``duration_columns``, the rest to the free parameters.
    """

    def __init__(self, problem: OrbitProblem, operators: Sequence[DelayOperator]):
        self.problem, self.operators = problem, tuple(operators)
        self.equations = Rows(problem.layout)
        self.mesh, self.layout, self.numeric = problem.mesh, problem.layout, problem.numeric
        self.n = self.numeric.n_states
        self.shape = (self.equations.size, problem.layout.size)
        # Unknown part of theta: durations are unknowns themselves, delays move with free parameters.
        self.moving_delays = self.numeric.delays.function.structure(problem.free_index).moving
        self.terms: list[Term] = []
        self.dense: list[DenseTerm] = []
        self._rows: list[Ints] = []
        self._columns: list[Ints] = []
        self._constant: list[Array] = []
        self._size = 0
        self.move([*range(self.mesh.n_segments), *(self.mesh.n_segments + self.moving_delays).tolist()])
        self.collocation()
        self.ends()
        self.period()
        self.template = np.concatenate(self._constant)
        self.rows, self.columns = np.concatenate(self._rows), np.concatenate(self._columns)

    def move(self, which: Sequence[int]) -> None:
        """Find how times move with the components ``which`` of theta."""
        self.which = which
        self.duration_columns = np.arange(self.layout.durations.start, self.layout.durations.stop)
        self.times, self.lengths = self.mesh.site_times[:, which], self.mesh.length[:, which]

    def serves(self, problem: OrbitProblem, operators: Sequence[DelayOperator]) -> bool:
        """Whether another problem's entries stand in the same places: same mesh, signature, free parameters and reads."""
        own = self.problem
        same = own.mesh is problem.mesh and (own.segments, own.free, own.timers) == (problem.segments, problem.free, problem.timers)
        return same and own.numeric is problem.numeric and self.fits(operators)

    def fits(self, operators: Sequence[DelayOperator]) -> bool:
        """Whether delayed values read with ``operators`` are read from the same unknowns."""
        pairs = [(a.weights, b.weights) for a, b in zip(self.operators, operators, strict=True)]
        return all(isinstance(a, FullWeights) if isinstance(b, FullWeights) else isinstance(a, LocalWeights) and a.reads_as(b)
                   for a, b in pairs)  # fmt: skip

    @cached_property
    def pattern(self) -> Pattern:
        """Places of all entries but those of full delay operators."""
        return Pattern(self.shape, self.rows, self.columns)

    def values(self, at: Evaluation) -> Array:
        """Return the values of all entries but those of full delay operators."""
        result = self.template.copy()
        for term in self.terms:
            result[term.place].reshape(term.shape)[...] = term.values(at)
        return result

    def matrix(self, problem: OrbitProblem, sites: Reads) -> Matrix:
        """Return the Jacobian at an orbit."""
        at = Evaluation(self, problem, sites)
        values = self.values(at)
        if not any(isinstance(op.weights, FullWeights) for op in self.operators):
            return self.pattern.fill(values)
        size = self.shape[0] * self.shape[1]
        matrix = np.asarray(np.bincount(self.rows * self.shape[1] + self.columns, weights=values, minlength=size), dtype=np.float64)
        matrix = matrix.reshape(self.shape)
        self.add_dense(matrix, at)
        return matrix

    def add_dense(self, matrix: Array, at: Evaluation) -> None:
        """Add the entries of full delay operators to a matrix."""
        for term in self.dense:
            place = np.ix_(term.rows, term.columns)
            matrix[place] = matrix[place] + term.values(at)

    def delayed_slopes(self, sites: Reads) -> Array:
        """Return the derivatives of the delayed values in the components of theta that move, shape (n_delayed, n_sites, n_moving)."""
        delayed = self.numeric.model.delayed
        slopes = np.zeros((len(delayed), self.mesh.n_sites, len(self.which)))
        for k, operator in enumerate(sites.operators):
            reads = [i for i, (_, delay) in enumerate(delayed) if delay == k]
            states = [delayed[i][0] for i in reads]
            slopes[reads] = np.moveaxis(operator.theta_derivative(sites.values[:, states], self.which), 1, 0)
        return slopes

    def add(self, rows: Ints | int, columns: Ints | int, values: Callable[[Evaluation], Array] | Array | float) -> None:
        """Add entries, rows and columns broadcast against each other; the values fit into their common shape."""
        r, c = np.broadcast_arrays(np.asarray(rows), np.asarray(columns))
        place, self._size = slice(self._size, self._size + r.size), self._size + r.size
        self._rows.append(r.ravel())
        self._columns.append(c.ravel())
        if callable(values):
            self.terms.append(Term(place, r.shape, values))
            self._constant.append(np.zeros(r.size))
        else:
            self._constant.append(np.broadcast_to(values, r.shape).ravel())

    def function(self, e: Equations) -> None:
        """Add all entries of a function's equations."""
        layout, structure = self.layout, e.function.structure(self.problem.free_index)
        collocates = not e.sign
        if len(structure.dx[0]):
            out, state = structure.dx
            self.add(e.rows[out][:, :, None], np.moveaxis(e.columns, 2, 0)[state],
                     lambda at: (at.factor(e) * at.derivatives(e).dx)[:, :, None] * e.weights)  # fmt: skip
        self.reads(e)
        moving = np.arange(len(e.rows)) if collocates else structure.moved
        if len(moving):
            self.add(e.rows[moving][:, :, None], self.duration_columns,
                     lambda at: at.slopes(e)[moving][:, :, : len(self.duration_columns)])  # fmt: skip
        if layout.forced and len(structure.dt):
            self.add(e.rows[structure.dt], layout.start.start, lambda at: at.factor(e) * at.derivatives(e).dt)
        if layout.n_free:
            self.free(e, moving)

    def free(self, e: Equations, moving: Ints) -> None:
        """Add the columns of the free parameters, which the function may hold itself and the delays that move."""
        structure, first = e.function.structure(self.problem.free_index), self.layout.free.start
        out, free = structure.dp
        if len(out):
            self.add(e.rows[out], first + free[:, None], lambda at: at.factor(e) * at.derivatives(e).dp)
        if len(moving) and len(self.moving_delays):
            n = len(self.duration_columns)
            self.add(e.rows[moving][:, :, None], np.arange(first, self.layout.free.stop),
                     lambda at: at.slopes(e)[moving][:, :, n:] @ at.to_free)  # fmt: skip

    def reads(self, e: Equations) -> None:
        """Add the delayed reads of a function: its slopes times the weights at its points."""
        for entry, (out, q) in enumerate(zip(*e.function.structure(self.problem.free_index).dxd, strict=True)):
            state, delay = self.numeric.model.delayed[q]
            weights = self.operators[delay].weights

            def values(at: Evaluation, entry: int = entry, delay: int = delay) -> Array:
                return (at.factor(e) * at.derivatives(e).dxd[entry])[:, None] * at.sites.operators[delay].weights.weights[e.points]

            if isinstance(weights, FullWeights):
                self.dense.append(DenseTerm(e.rows[out], self.layout.value_index[:, state], values))
            else:
                self.add(e.rows[out][:, None], self.read_columns(weights, e.points, state), values)

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
        for mode, points in mode_sites(self.problem):
            interval, node = np.divmod(points, mesh.degree)
            # -h df/dx at the node, spread over the interval's base points
            self.function(Equations(self.numeric.mode(mode), points, all_rows[points].T, columns[interval], mesh.basis.values[node]))

    def ends(self) -> None:
        """Add the resets and what ends each segment."""
        problem, n, S = self.problem, self.n, self.mesh.n_segments
        timed = {s: (source, wraps) for s, source, wraps in problem.timers}
        all_rows = (self.equations.resets + np.arange(S * n)).reshape(S, n)
        for s in range(S):
            self.add(all_rows[s], self.after(s), 1.0)
        for reset, which in reset_sites(problem):
            self.at_ends(self.numeric.reset(reset), which, all_rows[which].T, -1.0)
        for s, segment in enumerate(problem.segments):
            row = self.equations.events + s
            if s in timed:
                self.timer(row, s, *timed[s])
            elif segment.event:
                self.at_ends(self.numeric.event(segment.event), np.array([s]), np.array([[row]]), 1.0)
            else:
                self.phase(row)

    def at_ends(self, function: ArrayFunction, segments: Ints, rows: Ints, sign: float) -> None:
        """Add ``sign`` times a function at the ends of some segments."""
        ends = self.layout.value_index[self.mesh.last_base[segments]][:, None, :]
        self.function(Equations(function, self.mesh.n_collocation + segments, rows, ends, np.ones((len(segments), 1)), sign))

    def after(self, s: int) -> Ints:
        """Return the unknowns that hold the state after the reset at the end of segment ``s``, shape (n_states,)."""
        return self.layout.value_index[self.mesh.first_base[(s + 1) % self.mesh.n_segments]]

    def timer(self, row: int, s: int, source: int, wraps: int) -> None:
        """Add the equation of a delayed event at the end of segment ``s``."""
        self.add(row, self.duration_columns, timer_weights(self.problem, s, source, wraps))
        if self.layout.n_free:
            delay, free = self.numeric.event_delay(self.problem.segments[s].event), self.problem.free_index
            self.add(row, np.arange(self.layout.free.start, self.layout.free.stop),
                     lambda at: -delay.derivatives(at.sites.p, free)[0])  # fmt: skip

    def phase(self, row: int) -> None:
        """Add the phase condition of an orbit without events."""
        if self.layout.forced:
            self.add(row, self.layout.start.start, 1.0)
        else:
            self.add(row, np.arange(self.layout.values.stop), lambda at: phase_weights(at.problem))

    def period(self) -> None:
        """Add the period of a forced orbit."""
        if not self.layout.forced:
            return
        row, layout, free = self.equations.period, self.layout, self.problem.free_index
        self.add(row, self.duration_columns, 1.0)
        if layout.n_free:
            self.add(row, np.arange(layout.free.start, layout.free.stop),
                     lambda at: -at.problem.n_periods * self.numeric.period.derivatives(at.sites.p, free)[0])  # fmt: skip
