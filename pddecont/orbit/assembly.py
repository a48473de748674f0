"""Derivatives of an orbit's equations: places of entries found once a mesh, values filled in at every call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import Matrix
from pddecont.delay import FullWeights, LocalWeights
from pddecont.memo import cached_property
from pddecont.model import DelayedValue
from pddecont.native import compiled_assembly
from pddecont.orbit.equations import (
    DelayedEventEquation,
    Equation,
    FunctionEquations,
    PeriodEquation,
    PhaseEquation,
    SlopeEquations,
    StateAfter,
    TimeEquation,
    list_equations,
)
from pddecont.orbit.linearisation import ColumnMap, Entries, Linearisation
from pddecont.orbit.orbit import Orbit, Reads
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.sparsity import SparsityPattern

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# From so many unknowns on places are not kept with meshes: those of several are large.
MANY = 2000


@dataclass(frozen=True, eq=False)
class Term:
    """Entries of one kind: where they stand among all entries, and what writes their values there, one by one."""

    place: slice
    fill: Callable[[Linearisation, Array], None]


@dataclass(frozen=True, eq=False)
class ReadTerm:
    """Entries of values that are read from single mesh intervals: where they stand, and who reads what.

    ``points`` (n,) of the equations read each of ``reads``; entries are those of the reads one after the other, each of
    shape (n, degree + 1).
    """

    place: slice
    points: Ints
    reads: tuple[DelayedValue, ...]


@dataclass(frozen=True, eq=False)
class DenseTerm:
    """Reads of all base values of one state: ``columns`` of the equations ``rows``, and what gives their values."""

    rows: Ints
    columns: Ints
    values: Callable[[Linearisation], Array]


def find_assembly(
    kind: str,
    problem: OrbitProblem,
    reads: Reads,
    make_columns: Callable[[], ColumnMap],
    last: Assembly | None = None,
    fits: Callable[[ColumnMap], bool] = lambda columns: True,
) -> Assembly:
    """Return the places of the entries of a matrix of some ``kind``.

    Those of the last one on a mesh of the same layout serve again if its columns are such as ``fits`` says, and only
    what is read of the past is looked for. Many places, which no mesh keeps, are those of ``last`` if they serve.
    """
    few, key = problem.unknowns.size < MANY and can_move(reads), (kind, problem.signature, problem.links, problem.free)
    kept: dict[str, Assembly] = problem.mesh.alike(key, dict) if few else {}
    last = kept.get("last", last)
    if last is not None and last.is_laid_out_for(problem) and fits(last.columns):
        last = last.move_to(problem, reads, make_columns)
    else:
        last = None
    kept["last"] = found = last or Assembly(problem, reads, make_columns())
    return found


def can_move(reads: Reads) -> bool:
    """Return whether what is read has as many entries wherever it lies: there are no integrals and full operators."""
    return not reads.integrals and not any(isinstance(operator.weights, FullWeights) for operator in reads.operators)


class Assembly:
    """Places of a matrix's entries, for one mesh, one set of free parameters and reads in the same intervals."""

    def __init__(self, problem: OrbitProblem, reads: Reads, columns: ColumnMap):
        self.problem, self.operators, self.columns = problem, tuple(reads.operators), columns
        self.integrals = tuple(reads.integrals)
        # Durations are unknowns themselves, delays move with free parameters.
        self.moving_taus = problem.numeric.delays.function.structure(problem.free_index).moving
        self.terms: list[Term] = []
        self.read_terms: list[ReadTerm] = []
        self.dense_terms: list[DenseTerm] = []
        self.functions: list[FunctionEquations] = []
        self._places: list[tuple[slice, tuple[int, ...], Ints | int, Ints | int]] = []
        self._known: list[tuple[slice, Array | float]] = []
        self._size = 0
        for equation in list_equations(problem):
            self._add_equation(equation)
        self.constant = np.zeros(self._size)
        for place, values in self._known:
            self.constant[place] = values
        self.entry_rows, self.entry_columns = (np.empty(self._size, dtype=np.intp) for _ in range(2))
        for place, shape, row, column in self._places:
            self.entry_rows[place].reshape(shape)[...] = row
            self.entry_columns[place].reshape(shape)[...] = column
        self._places = []

    @property
    def has_full_reads(self) -> bool:
        """Whether a delayed value reads all base values."""
        return any(isinstance(operator.weights, FullWeights) for operator in self.operators)

    def reads_as(self, reads: Reads) -> bool:
        """Return whether ``reads`` of the past are of the same unknowns."""
        delays = zip(self.operators, reads.operators, strict=True)
        integrals = zip(self.integrals, reads.integrals, strict=True)
        return all(a.reads_as(b) for a, b in delays) and all(a.reads_as(b) for a, b in integrals)

    def is_laid_out_for(self, problem: OrbitProblem) -> bool:
        """Return whether another problem has the same equations of as many unknowns, on a mesh of the same layout."""
        own = self.problem
        same = own.mesh.has_layout_of(problem.mesh) and own.signature is problem.signature
        return same and (own.free, own.links) == (problem.free, problem.links)

    def move_to(self, problem: OrbitProblem, reads: Reads, make_columns: Callable[[], ColumnMap]) -> Assembly | None:
        """Return the places for a problem with these equations on a mesh of this layout, which reads the past anywhere.

        None where there are more or fewer entries then, as with integrals over the past.
        """
        same = self.problem.mesh.has_base_points_of(problem.mesh)
        if same and self.reads_as(reads):
            return self
        if self.integrals or self.has_full_reads or not can_move(reads):
            return None
        moved = copy(self)
        moved.problem, moved.columns = problem, self.columns if same else make_columns()
        moved.operators, moved.entry_columns = tuple(reads.operators), self.entry_columns.copy()
        vars(moved).pop("pattern", None)
        for term in self.read_terms:
            moved.entry_columns[term.place] = moved._find_read_columns(term.points, term.reads).ravel()
        return moved

    def _find_read_columns(self, points: Ints, reads: Sequence[DelayedValue]) -> Ints:
        """Return the columns that values are read from at ``points``, shape (n_reads, n_points, degree + 1)."""
        columns = []
        for read in reads:
            weights = self.operators[read.delay].weights
            assert isinstance(weights, LocalWeights)
            columns.append(self.columns.read_columns(weights, points, read.state))
        return np.stack(columns)

    @cached_property
    def pattern(self) -> SparsityPattern:
        """Places of all entries but those of full delay operators."""
        return SparsityPattern(self.columns.shape, self.entry_rows, self.entry_columns)

    def linearise(self, orbit: Orbit, reads: Reads) -> Linearisation:
        """Return what values are evaluated at: an orbit, read at the points where equations hold.

        Its problem may differ from this one's in what leaves the places of entries alone: values of fixed parameters,
        the phase's reference.
        """
        return Linearisation(self.columns, self.problem.free_index, orbit, reads)

    def evaluate(self, at: Linearisation) -> Array:
        """Return the values of all entries but those of full delay operators."""
        result = self.constant.copy()
        for term in self.terms:
            term.fill(at, result[term.place])
        return result

    def make_matrix(self, orbit: Orbit, reads: Reads) -> Matrix:
        """Return the matrix at an orbit: sparse, or full where a delayed value reads all base values."""
        at = self.linearise(orbit, reads)
        values = self.evaluate(at)
        if not self.has_full_reads:
            return self.pattern.fill(values)
        matrix = self.pattern.fill_dense(values)
        self.add_full_reads(matrix, at)
        return matrix

    def add_full_reads(self, matrix: Array, at: Linearisation) -> None:
        """Add the entries of full delay operators to a matrix."""
        for term in self.dense_terms:
            place = np.ix_(term.rows, term.columns)
            matrix[place] = matrix[place] + term.values(at)

    def _add(self, entries: Entries) -> None:
        values = entries.values
        if not callable(values):
            place, shape = self._add_places(entries.rows, entries.columns)
            self._known.append((place, np.broadcast_to(values, shape).ravel() if np.ndim(values) else values))
            return

        def fill(at: Linearisation, out: Array) -> None:
            out.reshape(shape)[...] = values(at)

        place, shape = self._add_places(entries.rows, entries.columns)
        self.terms.append(Term(place, fill))

    def _add_places(self, rows: Ints | int, columns: Ints | int) -> tuple[slice, tuple[int, ...]]:
        """Add entries that are zero; return where they stand among all, and the shape of ``rows`` and ``columns``."""
        entries = np.broadcast(rows, columns)
        place, self._size = slice(self._size, self._size + entries.size), self._size + entries.size
        self._places.append((place, entries.shape, rows, columns))
        return place, entries.shape

    def _add_equation(self, equation: Equation) -> None:
        unknowns, mesh = self.problem.unknowns, self.problem.mesh
        match equation:
            case SlopeEquations(rows):
                base = unknowns.value_index[mesh.base_index]
                self._add(Entries(rows[:, :, None, :], base[:, None, :, :], mesh.basis.slopes[None, :, :, None]))
            case FunctionEquations():
                self.functions.append(equation)
                self._add_function(equation)
            case StateAfter(rows, segment):
                self._add(Entries(rows, self.columns.state_after(segment), 1.0))
            case DelayedEventEquation():
                self._add_delayed_event(equation)
            case TimeEquation(row, coefficients):
                self._add_time(row, self.columns.find_time_weights(coefficients))
            case PhaseEquation(row):
                for entries in self.columns.phase_entries(row):
                    self._add(entries)
            case PeriodEquation(row):
                for entries in self.columns.period_entries(row):
                    self._add(entries)

    def _add_function(self, e: FunctionEquations) -> None:
        """Add the derivatives of a function's equations: states, reads, times, start, free parameters."""
        unknowns, structure = self.problem.unknowns, e.function.structure(self.problem.free_index)
        n_moving = len(self.columns.moving_columns)
        if len(structure.dx[0]):
            self._add_states(e)
        self._add_reads(e)
        # The length of its interval moves a collocation equation, whatever the function reads.
        moving = structure.moved if e.sign else np.arange(len(e.rows))
        if len(moving):
            rows = e.rows[moving][:, :, None]
            self._add(Entries(rows, self.columns.moving_columns, lambda at: at.moves(e)[moving, :, :n_moving]))
        if unknowns.forced and len(structure.dt):
            self._add(
                Entries(e.rows[structure.dt], unknowns.start.start, lambda at: at.factor(e) * at.derivatives(e).dt)
            )
        if unknowns.n_free:
            self._add_free(e, moving)

    def _add_free(self, e: FunctionEquations, moving: Ints) -> None:
        """Add the columns of the free parameters, which the function may hold itself and the delays that move."""
        place = self.problem.unknowns.free
        out, free = e.function.structure(self.problem.free_index).dp
        if len(out):
            columns = place.start + free[:, None]
            self._add(Entries(e.rows[out], columns, lambda at: at.factor(e) * at.derivatives(e).dp))
        if len(moving) and len(self.moving_taus):
            n_moving = len(self.columns.moving_columns)
            self._add(
                Entries(
                    e.rows[moving][:, :, None],
                    np.arange(place.start, place.stop),
                    lambda at: at.moves(e)[moving][:, :, n_moving:] @ at.tau_derivatives,
                )
            )

    def _add_states(self, e: FunctionEquations) -> None:
        """Add the derivatives of a function in the states at its points."""
        out, state = e.function.structure(self.problem.free_index).dx
        columns = self.problem.unknowns.value_index.T[state][:, e.base]
        place, (n_slopes, n, m) = self._add_places(e.rows[out][:, :, None], columns)
        weights = np.ascontiguousarray(e.weights)

        def fill(at: Linearisation, values: Array) -> None:
            compiled_assembly.spread_slopes(at.derivatives(e).dx, n_slopes, at.factor(e), weights, n, m, values)

        self.terms.append(Term(place, fill))

    def _add_reads(self, e: FunctionEquations) -> None:
        """Add the delayed reads of a function: its slopes times the weights at its points."""
        outputs, numbers = e.function.structure(self.problem.free_index).dxd
        delayed = self.problem.numeric.model.delayed
        local = []
        for entry, (out, q) in enumerate(zip(outputs.tolist(), numbers.tolist(), strict=True)):
            if q >= len(delayed):
                self._add_integral(e, entry, out, q - len(delayed))
            elif isinstance(self.operators[delayed[q].delay].weights, FullWeights):
                self._add_full_read(e, entry, out, delayed[q])
            else:
                local.append(entry)
        if local:
            self._add_local_reads(e, np.array(local), outputs, tuple(delayed[q] for q in numbers[local]))

    def _add_local_reads(
        self, e: FunctionEquations, entries: Ints, outputs: Ints, reads: tuple[DelayedValue, ...]
    ) -> None:
        """Add what is read from single mesh intervals: ``reads``, one for each of the slopes numbered ``entries``."""
        columns = self._find_read_columns(e.points, reads)
        place, (n_slopes, n, m) = self._add_places(e.rows[outputs[entries]][:, :, None], columns)
        kinds = self.problem.numeric.model.read_kinds
        which = np.array([kinds.index((read.delay, read.derivative)) for read in reads])
        points = np.ascontiguousarray(e.points)
        every = len(entries) == len(outputs)

        def fill(at: Linearisation, values: Array) -> None:
            slopes, weights = at.derivatives(e).dxd, at.read_weights
            slopes = slopes if every else slopes[entries]
            compiled_assembly.spread_over_reads(
                slopes, which, n_slopes, at.factor(e), points, n, weights, weights.shape[1], m, values
            )

        self.terms.append(Term(place, fill))
        self.read_terms.append(ReadTerm(place, points, reads))

    def _add_full_read(self, e: FunctionEquations, entry: int, out: int, read: DelayedValue) -> None:
        """Add what is read from all base values of a state."""

        def values(at: Linearisation) -> Array:
            slope = at.factor(e) * at.derivatives(e).dxd[entry]
            weights = at.reads.operators[read.delay].weights_of(read.derivative).weights
            return np.asarray(slope[:, None] * weights[e.points])

        self.dense_terms.append(DenseTerm(e.rows[out], self.problem.unknowns.value_index[:, read.state], values))

    def _add_integral(self, e: FunctionEquations, entry: int, out: int, number: int) -> None:
        """Add what an integral over the past reads: the function's slope times the weights of the pairs."""
        operator = self.integrals[number]
        place = np.full(self.problem.mesh.n_equation_points, -1)
        place[e.points] = np.arange(len(e.points))
        pairs = np.flatnonzero(place[operator.window.point] >= 0)
        at_point = place[operator.window.point[pairs]]
        for state in operator.state_weights:

            def values(at: Linearisation, state: int = state) -> Array:
                slope = (at.factor(e) * at.derivatives(e).dxd[entry])[at_point]
                return np.asarray(slope[:, None] * at.reads.integrals[number].state_weights[state][pairs])

            columns = self.columns.read_columns(operator.pairs, pairs, state)
            self._add(Entries(e.rows[out][at_point][:, None], columns, values))

    def _add_time(self, row: int, weights: Array) -> None:
        """Add a sum of durations, breaking times, and delays where those depend on free parameters."""
        n_moving, place = len(self.columns.moving_columns), self.problem.unknowns.free
        self._add(Entries(row, self.columns.moving_columns, weights[:n_moving]))
        if len(self.moving_taus):
            columns = np.arange(place.start, place.stop)
            self._add(Entries(row, columns, lambda at: weights[n_moving:] @ at.tau_derivatives))

    def _add_delayed_event(self, e: DelayedEventEquation) -> None:
        """Add the equation of a delayed event: durations, and its delay where that depends on free parameters."""
        self._add(Entries(e.row, self.columns.moving_columns, self.columns.find_elapsed_weights(e.link)))
        place, free = self.problem.unknowns.free, self.problem.free_index
        if free and e.link.find_varying(self.problem.numeric.model) is None:
            delay = e.link.make_delay(self.problem.signature)
            columns = np.arange(place.start, place.stop)
            self._add(Entries(e.row, columns, lambda at: -delay.derivatives(at.orbit.parameters, free)[0]))
