"""The linearised motion from one period to the next (design section 5.3).

X_k holds the base values, durations and start of period k and the state after the reset at its end. Each obeys

    sum over w of A_w X_{k-w}  +  (delayed values made by delay lines)  =  0

A_0 is the Jacobian with every read of an earlier period taken out: those stand in A_1, A_2, ... A period ends at its last event;
one without events lasts as long as the orbit's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation.linear import Factors, Matrix, factor, row_maxima, scale_matrix
from pddecont.delay.operator import DelayOperator, FullWeights, LocalWeights
from pddecont.errors import ConvergenceError
from pddecont.orbit.jacobian import Blocks, Equations, Evaluation
from pddecont.orbit.problem import OrbitProblem, Reads, read
from pddecont.stability.lags import LaggedMesh, deepest
from pddecont.stability.lines import PeriodLine, period_line

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


class LaggedBlocks(Blocks):
    """Places of all entries of all A_w: column w * n_columns + j belongs to unknown j of period k - w.

    ``lines`` holds the delay lines by number of the delay; ``reading`` collects how equations read the delayed values they make: by
    number of the delayed value, the equations, the sites and what gives the values.
    """

    def __init__(self, problem: OrbitProblem, operators: Sequence[DelayOperator], lines: Mapping[int, PeriodLine]):
        wraps = [int(np.max(op.weights.wraps)) for op in operators if isinstance(op.weights, LocalWeights)]
        self.n_lags = 2 + max([*wraps, *(w for _, _, w in problem.timers)], default=0) + deepest(problem.mesh)
        self.lines, self.lags = lines, LaggedMesh(problem.mesh, self.n_lags)
        self.n_columns = problem.layout.size + problem.layout.n_states
        self.reading: dict[int, list[tuple[Ints, Ints, Callable[[Evaluation], Array]]]] = {}
        super().__init__(problem, operators)

    def move(self, which: Sequence[int]) -> None:
        """Note how the places of reading move with the durations of all periods."""
        mesh, shape = self.mesh, (-1, self.n_lags * self.mesh.n_segments)
        durations = np.arange(self.layout.durations.start, self.layout.durations.stop)
        self.duration_columns = (np.arange(self.n_lags)[:, None] * self.n_columns + durations).ravel()
        self.times = self.lags.times(mesh.sites).reshape(shape)
        self.lengths = self.lags.length.reshape(shape)

    def delayed_slopes(self, sites: Reads) -> Array:
        """Return the derivatives of the delayed values in the durations of all periods, shape (n_delayed, n_sites, n_lags * S)."""
        n_delayed = len(self.numeric.model.delayed)
        slopes = [self.read_slopes(q, sites).reshape(self.times.shape) for q in range(n_delayed)]
        return np.stack(slopes) if slopes else np.zeros((0, *self.times.shape))

    def read_slopes(self, q: int, sites: Reads) -> Array:
        """Return the derivatives of delayed value ``q`` in the durations of all periods, shape (n_sites, n_lags, S)."""
        mesh, (state, delay) = self.mesh, self.numeric.model.delayed[q]
        if delay in self.lines:
            result = np.zeros((mesh.n_sites, self.n_lags, mesh.n_segments))
            result[:, 0] = self.lines[delay].slopes[:, self.lines[delay].states.index(state)]
            return result
        weights = sites.operators[delay].weights
        assert isinstance(weights, LocalWeights)
        slope = np.einsum("pb,pb->p", weights.weights @ mesh.basis.differentiate, sites.values[weights.columns, state])
        lengths = sites.h[weights.interval]
        return slope[:, None, None] * self.lags.sigma_slopes(mesh.sites, weights.interval, weights.sigma, weights.wraps, lengths)

    def reads(self, e: Equations) -> None:
        """Add what reads of delayed values contribute; those that a delay line gives are kept for it."""
        super().reads(e)
        for entry, (out, q) in enumerate(zip(*e.function.structure(self.problem.free_index).dxd, strict=True)):

            def values(at: Evaluation, entry: int = entry) -> Array:
                return at.factor(e) * at.derivatives(e).dxd[entry]

            if self.numeric.model.delayed[q][1] in self.lines:
                self.reading.setdefault(q, []).append((e.rows[out], e.points, values))

    def read_columns(self, weights: LocalWeights, points: Ints, state: int) -> Ints:
        """Return the columns that a read reaches: those of as many periods back as it wraps."""
        return super().read_columns(weights, points, state) + (weights.wraps[points] * self.n_columns)[:, None]

    def after(self, s: int) -> Ints:
        """Return the columns of the state that segment ``s`` is followed by; after the last, that of the next period."""
        if s + 1 == self.mesh.n_segments:
            return self.layout.size + np.arange(self.n)
        return super().after(s)

    def timer(self, row: int, s: int, source: int, wraps: int) -> None:
        """Add the equation of a delayed event: durations of as many periods as lie between."""
        weights = np.zeros((self.n_lags, self.mesh.n_segments))
        weights[1 : wraps + 1] = 1.0
        weights[0, : s + 1] += 1.0
        weights[wraps, : source + 1] -= 1.0
        self.add(row, self.duration_columns, weights.ravel())

    def phase(self, row: int) -> None:
        """Add the equation that fixes a period's phase."""
        self.add(row, self.layout.durations.start, 1.0)

    def period(self) -> None:
        """Add where a period starts: its time, and the state that the last one ended with."""
        rows = self.equations.size + np.arange(self.n)
        self.add(rows, self.layout.value_index[self.mesh.first_base[0]], 1.0)
        self.add(rows, self.n_columns + self.layout.size + np.arange(self.n), -1.0)
        if self.layout.forced:
            row, start = self.equations.period, self.layout.start.start
            self.add(row, start, 1.0)
            if self.problem.segments[0].event:
                self.add(row, self.n_columns + start, -1.0)
                self.add(row, self.n_columns + np.arange(self.layout.durations.start, self.layout.durations.stop), -1.0)


@dataclass(frozen=True, eq=False)
class Coupling:
    """A delay line with the equations that read it: ``into[j]`` (n_rows, n_sites) for its quantity j."""

    line: PeriodLine
    into: tuple[sp.csr_matrix, ...]


@dataclass(frozen=True, eq=False)
class Period:
    """The linear map from a history to the next period.

    ``present`` holds the factors of A_0, ``past`` the columns of A_1, A_2, ... that are not zero, ``kept[w - 1]`` which unknowns of
    period k - w the history keeps, ``blocks`` where all entries stand.
    """

    problem: OrbitProblem
    present: Factors
    past: tuple[sp.csc_matrix, ...]
    kept: tuple[Ints, ...]
    couplings: tuple[Coupling, ...]
    blocks: LaggedBlocks

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


def linearise(problem: OrbitProblem, x: Array, blocks: LaggedBlocks | None = None) -> Period:
    """Return the linearised map of the orbit ``x``, its parameters fixed; ``blocks`` of an earlier one are used where they fit."""
    problem, x = problem.with_free(x, ())
    sites = read(problem, x, problem.mesh.sites)
    if any(np.min(op.weights.wraps) < 0 for op in sites.operators if isinstance(op.weights, LocalWeights)):
        raise ConvergenceError("a delay is negative here, and an orbit that reads its future has no multipliers")
    lines = {k: _line(problem, sites, k) for k, op in enumerate(sites.operators) if isinstance(op.weights, FullWeights)}
    operators = [replace(op, weights=FullWeights(lines[k].weights)) if k in lines else op for k, op in enumerate(sites.operators)]
    if blocks is None or lines or not blocks.serves(problem, operators):
        blocks = LaggedBlocks(problem, operators, lines)
    at = Evaluation(blocks, problem, replace(sites, operators=operators))
    n, values = blocks.n_columns, blocks.values(at)
    wide = sp.coo_matrix((values, (blocks.rows, blocks.columns)), shape=(n, n * blocks.n_lags)).tocsc()
    present = wide[:, :n]
    if lines:
        present = present.toarray()
        blocks.add_dense(present, at)
    used = [np.flatnonzero(np.diff(wide.indptr[w * n : (w + 1) * n + 1])) for w in range(1, blocks.n_lags)]
    while len(used) > 1 and not len(used[-1]):
        used.pop()
    kept = tuple(np.unique(np.concatenate(used[w:])) for w in range(len(used)))
    past = tuple(wide[:, (w + 1) * n + columns] for w, columns in enumerate(kept))
    couplings = tuple(Coupling(line, tuple(_read_by(blocks, at, q) for q in line.numbers)) for line in lines.values())
    return Period(problem, _scaled_factors(present), past, kept, couplings, blocks)


def _line(problem: OrbitProblem, sites: Reads, delay: int) -> PeriodLine:
    numbers = tuple(q for q, (_, k) in enumerate(problem.numeric.model.delayed) if k == delay)
    states = tuple(problem.numeric.model.delayed[q][0] for q in numbers)
    return period_line(problem, sites.theta, delay, states, numbers, problem.mesh.at_nodes(sites.values[:, list(states)]))


def _read_by(blocks: LaggedBlocks, at: Evaluation, q: int) -> sp.csr_matrix:
    """Return how the equations depend on delayed value ``q`` at the sites."""
    parts = blocks.reading.get(q, [])
    rows, points = (np.concatenate([np.zeros(0, dtype=np.intp), *(part[i] for part in parts)]) for i in range(2))
    values = np.concatenate([np.zeros(0), *(part[2](at) for part in parts)])
    return sp.csr_matrix((values, (rows, points)), shape=(blocks.n_columns, blocks.mesh.n_sites))


def _scaled_factors(matrix: Matrix) -> Factors:
    scale = 1.0 / row_maxima(matrix)
    factors = factor(scale_matrix(matrix, scale, np.ones(len(scale))))
    return Factors(lambda b: factors.solve(scale[:, None] * b))
