"""The linearised motion from one period to the next.

X_k holds the base values, durations and start of period k and the state after the reset at its end. Each obeys

    sum over w of A_w X_{k-w}  +  (delayed values made by delay lines)  =  0

A_0 is the Jacobian with every read of an earlier period taken out: those stand in A_1, A_2, ... A period ends at its
last event; one without events lasts as long as the orbit's own.

Reference: Szalai, Stepan, Hogan, SIAM J. Sci. Comput. 28 (2006), for the map by collocation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation import EquilibratedMatrix, Matrix, ScaledFactors, equilibrate, leave_out_zeros, make_sparse
from pddecont.delay import FullWeights
from pddecont.errors import ConvergenceError
from pddecont.memo import cached_property
from pddecont.orbit import (
    Assembly,
    ColumnMap,
    Linearisation,
    Orbit,
    OrbitProblem,
    find_assembly,
    measure_orbit,
    order_in_time,
)
from pddecont.stability.characteristic import Characteristic, MapCharacteristic, PeriodCharacteristic
from pddecont.stability.lagged_columns import LaggedColumns, count_lags
from pddecont.stability.moving_edges import find_still_edges
from pddecont.stability.period_line import PeriodLine, make_period_line

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Coupling:
    """A delay line with the equations that read it: ``into[j]`` (n_rows, n_equation_points) for its quantity j."""

    line: PeriodLine
    into: tuple[Matrix, ...]

    @property
    def size(self) -> int:
        """Number of the line's states."""
        return int(np.prod(self.line.shape))


@dataclass(frozen=True, eq=False)
class MonodromyOperator:
    """The linear map from a history to the history one period later.

    ``present`` is A_0, ``past`` the columns of A_1, A_2, ... that are not zero, ``kept[w - 1]`` which unknowns of
    period k - w the history keeps, ``assembly`` where all entries stand. ``sizes`` (n_columns,) are typical sizes of a
    period's unknowns; ``wide`` holds A_0, A_1, ... side by side (without delay lines).
    """

    problem: OrbitProblem
    present: EquilibratedMatrix
    past: tuple[Matrix, ...]
    kept: tuple[Ints, ...]
    couplings: tuple[Coupling, ...]
    assembly: Assembly
    sizes: Array
    wide: Matrix

    @cached_property
    def size(self) -> int:
        """Number of components of a history."""
        return sum(map(len, self.kept)) + sum(c.size for c in self.couplings)

    @property
    def rank(self) -> int | None:
        """How many multipliers at most are not zero: of an orbit without memory as many as states; None of others."""
        remembers = self.problem.numeric.model.read_symbols or self.problem.links or self.couplings
        return None if remembers else self.problem.unknowns.n_states

    @cached_property
    def factors(self) -> ScaledFactors:
        """The factors of A_0.

        Raises
        ------
        ConvergenceError
            If it is singular: the map is not defined.
        """
        return self.present.factor()

    def step(self, histories: Array) -> tuple[Array, Array]:
        """Return the next periods X (n_columns, k) and the histories one period later, for ``histories`` (size, k)."""
        parts, lines = self._split(histories)
        rhs = self.past[0] @ parts[0]
        for A, y in zip(self.past[1:], parts[1:], strict=True):
            rhs = A @ y + rhs
        for c, y in zip(self.couplings, lines, strict=True):
            made = c.line.from_start(y)
            for q, into in enumerate(c.into):
                rhs = rhs + into @ made[:, q]
        x = self.factors.solve(-rhs)
        unknowns, mesh = self.problem.unknowns, self.problem.mesh
        values = x[unknowns.values].reshape(mesh.n_base, unknowns.n_states, -1)
        after = []
        for c, y in zip(self.couplings, lines, strict=True):
            inputs = mesh.interpolate_at_nodes(values[:, list(c.line.states)])
            after.append(c.line.end(y, inputs, x[unknowns.durations]))
        recent = [x[self.kept[0]]]
        for w in range(1, len(self.kept)):
            recent.append(parts[w - 1][np.searchsorted(self.kept[w - 1], self.kept[w])])
        return x, np.concatenate([*recent, *(y.reshape(-1, x.shape[1]) for y in after)])

    def _split(self, histories: Array) -> tuple[list[Array], list[Array]]:
        ends = np.cumsum([*map(len, self.kept), *(c.size for c in self.couplings)])
        pieces = np.split(histories, ends[:-1])
        n = len(self.kept)
        lines = [y.reshape(*c.line.shape, -1) for y, c in zip(pieces[n:], self.couplings, strict=True)]
        return pieces[:n], lines

    @cached_property
    def history_sizes(self) -> Array:
        """Typical sizes of a history's components, shape (size,)."""
        states = self.sizes[: self.problem.unknowns.n_states]
        lines = [np.broadcast_to(states[list(c.line.states)], c.line.shape).ravel() for c in self.couplings]
        return np.concatenate([*(self.sizes[places] for places in self.kept), *lines])

    def apply_scaled(self, history: Array) -> Array:
        """Return one history (size,) in units of its sizes a period later."""
        return self.apply(history * self.history_sizes) / self.history_sizes

    @cached_property
    def scaled_matrix(self) -> Array:
        """The map as a matrix, shape (size, size), of histories in units of their sizes."""
        if self.couplings:
            return self.step(np.diag(self.history_sizes))[1] / self.history_sizes[:, None]
        # All that is asked for of A_0 are these solutions: it is eliminated in the order of time where that does.
        factors = self.present.factor(order_in_time(self.problem, goes_on=True))
        rhs = np.concatenate([A.toarray() for A in self.past], axis=1)
        rhs *= self.history_sizes
        rhs *= -factors.rows[:, None]
        following = [factors.solve_raw(rhs)[self.kept[0]]]
        first = 0
        for before, places in pairwise(self.kept):
            # What was a period back is now one more, and has the same size.
            rows = np.zeros((len(places), self.size))
            rows[np.arange(len(places)), first + np.searchsorted(before, places)] = 1.0
            following.append(rows)
            first += len(before)
        return np.concatenate(following)

    @cached_property
    def characteristic(self) -> Characteristic:
        """The matrix whose determinant is zero at the inverse multipliers."""
        if self.couplings:
            return MapCharacteristic(self.scaled_matrix)
        return _characteristic_of(self.wide, self.sizes)

    def apply(self, history: Array) -> Array:
        """Return one history (size,) a period later."""
        return np.asarray(self.step(np.reshape(history, (-1, 1)))[1][:, 0])

    def to_matrix(self) -> Array:
        """Return the map as a matrix, shape (size, size)."""
        return self.step(np.eye(self.size))[1]


def linearise_period(orbit: Orbit, last: Assembly | None = None) -> MonodromyOperator:
    """Return the linearised map of an orbit, its parameters fixed.

    The places of entries of a ``last`` map are taken where they serve.

    Raises
    ------
    ConvergenceError
        If a delay is negative, or the map is not defined.
    """
    reads, still = orbit.equation_reads, find_still_edges(orbit)
    orbit = orbit.with_free(())
    if any(np.min(weights.wraps) < 0 for weights in reads.list_local_weights()):
        raise ConvergenceError("a delay is negative here, and an orbit that reads its future has no multipliers")
    lines = {
        k: make_period_line(orbit, k) for k, op in enumerate(reads.operators) if isinstance(op.weights, FullWeights)
    }
    if lines:
        operators = [
            replace(op, weights=FullWeights(lines[k].weights)) if k in lines else op
            for k, op in enumerate(reads.operators)
        ]
        reads = replace(reads, operators=operators)
    problem = orbit.problem
    if lines:
        assembly = Assembly(problem, reads, LaggedColumns(problem, reads, lines, still))
    else:
        n_lags = count_lags(problem, reads, still)

        def make_columns() -> LaggedColumns:
            return LaggedColumns(problem, reads, {}, still)

        def fits(columns: ColumnMap) -> bool:
            return isinstance(columns, LaggedColumns) and (columns.n_lags, columns.lags.still) == (n_lags, still)

        assembly = find_assembly("map", problem, reads, make_columns, last, fits)
    columns = assembly.columns
    assert isinstance(columns, LaggedColumns)
    at, n = assembly.linearise(orbit, reads), columns.n_columns
    # A delayed value that nothing depends on just now makes no history.
    wide = leave_out_zeros(assembly.pattern.fill(assembly.evaluate(at)))
    sizes = _measure_columns(orbit)
    end = wide.indptr[n]
    present = make_sparse(wide.data[:end], wide.indices[:end], wide.indptr[: n + 1], (n, n))
    if lines:
        present = present.toarray()
        assembly.add_full_reads(present, at)
    kept = _find_kept(wide, n)
    past = tuple(_take_period(wide, n, w + 1, places) for w, places in enumerate(kept))
    couplings = tuple(
        Coupling(line, tuple(_read_by(assembly, at, n, q) for q in line.numbers)) for line in lines.values()
    )
    equilibrated = equilibrate(present, sizes)
    return MonodromyOperator(orbit.problem, equilibrated, past, kept, couplings, assembly, sizes, wide)


def _find_kept(wide: Matrix, n: int) -> tuple[Ints, ...]:
    """Return which of the ``n`` unknowns of each earlier period are still read by this one or a later one."""
    used = np.diff(wide.indptr).reshape(-1, n)[1:] > 0
    deepest = 1 + int(np.max(np.flatnonzero(np.any(used, axis=1)), initial=0))
    later = np.logical_or.accumulate(used[:deepest][::-1], axis=0)[::-1]
    return tuple(np.flatnonzero(places) for places in later)


def _take_period(wide: Matrix, n: int, w: int, places: Ints) -> Matrix:
    """Return columns ``places`` of the ``n`` of period k - w, of which all that are not zero must be among them."""
    starts = wide.indptr[w * n : (w + 1) * n + 1]
    inside, chosen = slice(starts[0], starts[-1]), np.concatenate([starts[places], starts[-1:]]) - starts[0]
    return make_sparse(wide.data[inside], wide.indices[inside], chosen, (n, len(places)))


def _measure_columns(orbit: Orbit) -> Array:
    """Return the typical size of each unknown of a period, so that units do not matter."""
    unknowns, size = orbit.problem.unknowns, measure_orbit(orbit)
    result = np.full(unknowns.size + unknowns.n_states, size.period)
    result[unknowns.value_index] = size.states
    result[unknowns.size :] = size.states
    return result


def _characteristic_of(wide: Matrix, sizes: Array) -> PeriodCharacteristic:
    entries, n = wide.tocoo(), len(sizes)
    powers, columns = np.divmod(entries.col.astype(np.intp), n)
    return PeriodCharacteristic(n, entries.row.astype(np.intp), columns, powers, entries.data * sizes[columns])


def _read_by(assembly: Assembly, at: Linearisation, n_rows: int, q: int) -> Matrix:
    """Return how the equations depend on delayed value ``q`` at the equation points, as a sparse matrix."""
    rows, points, values = [np.zeros(0, dtype=np.intp)], [np.zeros(0, dtype=np.intp)], [np.zeros(0)]
    for e in assembly.functions:
        for entry, (out, number) in enumerate(zip(*e.function.structure(()).dxd, strict=True)):
            if number == q:
                rows.append(e.rows[out])
                points.append(e.points)
                values.append(at.factor(e) * at.derivatives(e).dxd[entry])
    places = (np.concatenate(rows), np.concatenate(points))
    shape = (n_rows, assembly.problem.mesh.n_equation_points)
    return sp.csr_matrix((np.concatenate(values), places), shape=shape)
