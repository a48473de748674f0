"""The linearised motion from one period to the next (design section 5.3).

X_k holds the base values, durations and start of period k and the state after the reset at its end. Each obeys

    sum over w of A_w X_{k-w}  +  (delayed values made by delay lines)  =  0

A_0 is the Jacobian with every read of an earlier period taken out: those stand in A_1, A_2, ... A period ends at its last event;
one without events lasts as long as the orbit's own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation.linear import Factors, Matrix, factor, row_maxima, scale_matrix
from pddecont.delay.operator import FullWeights, LocalWeights
from pddecont.orbit.jacobian import Blocks, Triplets
from pddecont.orbit.problem import OrbitProblem, Reads, read
from pddecont.orbit.residual import Rows
from pddecont.stability.lags import LaggedMesh, deepest
from pddecont.stability.lines import PeriodLine, period_line

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


class _LaggedBlocks(Blocks):
    """Entries of all A_w: column w * n_columns + j belongs to unknown j of period k - w.

    ``lines`` holds the delay lines by number of the delay; ``reading`` collects how equations read the delayed values they make.
    """

    def __init__(self, problem: OrbitProblem, rows: Rows, sites: Reads, lines: Mapping[int, PeriodLine], n_lags: int):
        self.lines, self.n_lags = lines, n_lags
        self.n_columns = problem.layout.size + problem.layout.n_states
        self.lags = LaggedMesh(problem.mesh, n_lags)
        self.reading: dict[int, list[Triplets]] = {}
        super().__init__(problem, rows, sites)

    def move(self, which: Sequence[int]) -> None:
        """Note how the places of reading move with the durations of all periods."""
        mesh, shape = self.mesh, (-1, self.n_lags * self.mesh.n_segments)
        durations = np.arange(self.layout.durations.start, self.layout.durations.stop)
        self.duration_columns = (np.arange(self.n_lags)[:, None] * self.n_columns + durations).ravel()
        self.times = self.lags.times(mesh.sites).reshape(shape)
        self.lengths = self.lags.length.reshape(shape)
        self.xd_moving = np.zeros((len(self.numeric.model.delayed), *self.times.shape))
        for q in range(len(self.xd_moving)):
            self.xd_moving[q] = self.read_slopes(q).reshape(shape)

    def read_slopes(self, q: int) -> Array:
        """Return the derivatives of delayed value ``q`` in the durations of all periods, shape (n_sites, n_lags, S)."""
        mesh, (state, delay) = self.mesh, self.numeric.model.delayed[q]
        if delay in self.lines:
            result = np.zeros((mesh.n_sites, self.n_lags, mesh.n_segments))
            result[:, 0] = self.lines[delay].slopes[:, self.lines[delay].states.index(state)]
            return result
        weights = self.sites.operators[delay].weights
        assert isinstance(weights, LocalWeights)
        slope = np.einsum("pb,pb->p", weights.weights @ mesh.basis.differentiate, self.sites.values[weights.columns, state])
        lengths = self.sites.h[weights.interval]
        return slope[:, None, None] * self.lags.sigma_slopes(mesh.sites, weights.interval, weights.sigma, weights.wraps, lengths)

    def reads(self, rows: Ints, points: Ints, dxd: Array) -> None:
        """Add what reads of delayed values contribute; those that a delay line gives are kept for it."""
        super().reads(rows, points, dxd)
        for q, (_, delay) in enumerate(self.numeric.model.delayed):
            if delay in self.lines:
                r, c, v = np.broadcast_arrays(rows, points, dxd[:, q])
                self.reading.setdefault(q, []).append(Triplets(r.ravel(), c.ravel(), v.ravel()))

    def read_columns(self, weights: LocalWeights, points: Ints, state: int) -> Ints:
        """Return the columns that a read reaches: those of as many periods back as it wraps."""
        return super().read_columns(weights, points, state) + (weights.wraps[points] * self.n_columns)[:, None]

    def after(self, s: int) -> Ints:
        """Return the columns of the state that segment ``s`` is followed by; after the last, that of the next period."""
        if s + 1 == self.mesh.n_segments:
            return self.layout.size + np.arange(self.n)
        return super().after(s)

    def timer(self, row: Ints, s: int, source: int, wraps: int) -> None:
        """Add the equation of a delayed event: durations of as many periods as lie between."""
        weights = np.zeros((self.n_lags, self.mesh.n_segments))
        weights[1 : wraps + 1] = 1.0
        weights[0, : s + 1] += 1.0
        weights[wraps, : source + 1] -= 1.0
        self.add(row, self.duration_columns, weights.ravel())

    def phase(self, row: Ints) -> None:
        """Add the equation that fixes a period's phase."""
        self.add(row, self.layout.durations.start, np.ones(1))

    def period(self) -> None:
        """Add where a period starts: its time, and the state that the last one ended with."""
        rows = self.equations.size + np.arange(self.n)
        self.add(rows, self.layout.value_index[self.mesh.first_base[0]], np.ones(self.n))
        self.add(rows, self.n_columns + self.layout.size + np.arange(self.n), -np.ones(self.n))
        if self.layout.forced:
            row, start = self.equations.period, self.layout.start.start
            self.add(row, start, np.ones(1))
            if self.problem.segments[0].event:
                self.add(row, self.n_columns + start, -np.ones(1))
                self.add(row, self.n_columns + np.arange(self.layout.durations.start, self.layout.durations.stop),
                         -np.ones(self.mesh.n_segments))  # fmt: skip


@dataclass(frozen=True, eq=False)
class Coupling:
    """A delay line with the equations that read it: ``into[j]`` (n_rows, n_sites) for its quantity j."""

    line: PeriodLine
    into: tuple[sp.csr_matrix, ...]


@dataclass(frozen=True, eq=False)
class Period:
    """The linear map from a history to the next period.

    ``present`` holds the factors of A_0, ``past`` the columns of A_1, A_2, ... that are not zero, ``kept[w - 1]`` which unknowns of
    period k - w the history keeps.
    """

    problem: OrbitProblem
    present: Factors
    past: tuple[sp.csc_matrix, ...]
    kept: tuple[Ints, ...]
    couplings: tuple[Coupling, ...]

    @cached_property
    def size(self) -> int:
        """Number of components of a history."""
        return sum(map(len, self.kept)) + sum(int(np.prod(c.line.shape)) for c in self.couplings)

    def step(self, histories: Array) -> tuple[Array, Array]:
        """Return the next periods X (n_columns, k) and the histories (size, k) one period later, for ``histories`` (size, k)."""
        parts, lines = self._split(histories)
        rhs = sum((A @ y for A, y in zip(self.past, parts, strict=True)), np.zeros((self.past[0].shape[0], histories.shape[1])))
        for c, y in zip(self.couplings, lines, strict=True):
            made = c.line.from_start(y)
            for q, into in enumerate(c.into):
                rhs = rhs + into @ made[:, q]
        x = self.present.solve(-rhs)
        layout, mesh = self.problem.layout, self.problem.mesh
        values = x[layout.values].reshape(mesh.n_base, layout.n_states, -1)
        after = [c.line.end(y, mesh.at_nodes(values[:, list(c.line.states)]), x[layout.durations])
                 for c, y in zip(self.couplings, lines, strict=True)]  # fmt: skip
        recent = [x[self.kept[0]]]
        for w in range(1, len(self.kept)):
            recent.append(parts[w - 1][np.searchsorted(self.kept[w - 1], self.kept[w])])
        return x, np.concatenate([*recent, *(y.reshape(-1, x.shape[1]) for y in after)])

    def _split(self, histories: Array) -> tuple[list[Array], list[Array]]:
        ends = np.cumsum([*map(len, self.kept), *(int(np.prod(c.line.shape)) for c in self.couplings)])
        pieces = np.split(histories, ends[:-1])
        n = len(self.kept)
        return pieces[:n], [y.reshape(*c.line.shape, -1) for y, c in zip(pieces[n:], self.couplings, strict=True)]

    def one(self, history: Array) -> Array:
        """Return one history (size,) a period later."""
        return self.step(np.reshape(history, (-1, 1)))[1][:, 0]

    def matrix(self) -> Array:
        """Return the map as a matrix, shape (size, size)."""
        return self.step(np.eye(self.size))[1]


def linearise(problem: OrbitProblem, x: Array) -> Period:
    """Return the linearised map of the orbit ``x``, its parameters fixed."""
    problem, x = problem.with_free(x, ())
    sites = read(problem, x, problem.mesh.sites)
    lines = {k: _line(problem, sites, k) for k, op in enumerate(sites.operators) if isinstance(op.weights, FullWeights)}
    operators = [replace(op, weights=FullWeights(lines[k].weights)) if k in lines else op for k, op in enumerate(sites.operators)]
    wraps = [int(np.max(op.weights.wraps)) for op in operators if isinstance(op.weights, LocalWeights)]
    n_lags = 2 + max([*wraps, *(w for _, _, w in problem.timers)], default=0) + deepest(problem.mesh)
    blocks = _LaggedBlocks(problem, Rows(problem.layout), replace(sites, operators=operators), lines, n_lags)
    entries, n = blocks.assemble(), blocks.n_columns
    lag, column = np.divmod(entries.columns, n)
    A = [sp.csc_matrix((entries.values[lag == w], (entries.rows[lag == w], column[lag == w])), shape=(n, n)) for w in range(n_lags)]
    present = A[0].toarray() if blocks.dense else A[0]
    for rows, state, values in blocks.dense:
        place = np.ix_(rows, problem.layout.value_index[:, state])
        present[place] = present[place] + values
    used = [np.flatnonzero(np.diff(matrix.indptr)) for matrix in A[1:]]
    while len(used) > 1 and not len(used[-1]):
        used.pop()
    kept = [np.unique(np.concatenate(used[w:])) for w in range(len(used))]
    past = [sp.csc_matrix(matrix[:, columns]) for matrix, columns in zip(A[1:], kept, strict=False)]
    couplings = [Coupling(line, tuple(_read_by(blocks, n, q) for q in line.numbers)) for line in lines.values()]
    return Period(problem, _scaled_factors(present), tuple(past), tuple(kept), tuple(couplings))


def _line(problem: OrbitProblem, sites: Reads, delay: int) -> PeriodLine:
    numbers = tuple(q for q, (_, k) in enumerate(problem.numeric.model.delayed) if k == delay)
    states = tuple(problem.numeric.model.delayed[q][0] for q in numbers)
    return period_line(problem, sites.theta, delay, states, numbers, problem.mesh.at_nodes(sites.values[:, list(states)]))


def _read_by(blocks: _LaggedBlocks, n_rows: int, q: int) -> sp.csr_matrix:
    """Return how the equations depend on delayed value ``q`` at the sites."""
    parts = blocks.reading.get(q, [])
    rows, columns, values = (np.concatenate([np.zeros(0, dtype=t), *(getattr(p, f) for p in parts)])
                             for f, t in (("rows", np.intp), ("columns", np.intp), ("values", float)))  # fmt: skip
    return sp.csr_matrix((values, (rows, columns)), shape=(n_rows, blocks.mesh.n_sites))


def _scaled_factors(matrix: Matrix) -> Factors:
    scale = 1.0 / row_maxima(matrix)
    factors = factor(scale_matrix(matrix, scale, np.ones(len(scale))))
    return Factors(lambda b: factors.solve(scale[:, None] * b))
