"""Derivatives of an orbit's equations: places of entries found once a mesh, values filled in at every call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import Matrix
from pddecont.delay import FullWeights
from pddecont.model import DelayedValue
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


@dataclass(frozen=True, eq=False)
class Term:
    """Entries of one kind: where they stand among all entries, their shape, and what gives their values."""

    place: slice
    shape: tuple[int, ...]
    values: Callable[[Linearisation], Array]


@dataclass(frozen=True, eq=False)
class DenseTerm:
    """Reads of all base values of one state: ``columns`` of the equations ``rows``, and what gives their values."""

    rows: Ints
    columns: Ints
    values: Callable[[Linearisation], Array]


class Assembly:
    """Places of a matrix's entries, for one mesh, one set of free parameters and reads in the same intervals."""

    def __init__(self, problem: OrbitProblem, reads: Reads, columns: ColumnMap):
        self.problem, self.operators, self.columns = problem, tuple(reads.operators), columns
        self.integrals = tuple(reads.integrals)
        # Durations are unknowns themselves, delays move with free parameters.
        self.moving_taus = problem.numeric.delays.function.structure(problem.free_index).moving
        self.terms: list[Term] = []
        self.dense_terms: list[DenseTerm] = []
        self.functions: list[FunctionEquations] = []
        self._rows: list[Ints] = []
        self._columns: list[Ints] = []
        self._constant: list[Array] = []
        self._size = 0
        for equation in list_equations(problem):
            self._add_equation(equation)
        self.constant = np.concatenate(self._constant)
        self.entry_rows, self.entry_columns = np.concatenate(self._rows), np.concatenate(self._columns)

    @property
    def has_full_reads(self) -> bool:
        """Whether a delayed value reads all base values."""
        return any(isinstance(operator.weights, FullWeights) for operator in self.operators)

    def reads_as(self, reads: Reads) -> bool:
        """Return whether ``reads`` of the past are of the same unknowns."""
        delays = zip(self.operators, reads.operators, strict=True)
        integrals = zip(self.integrals, reads.integrals, strict=True)
        return all(a.reads_as(b) for a, b in delays) and all(a.reads_as(b) for a, b in integrals)

    def serves(self, problem: OrbitProblem, reads: Reads) -> bool:
        """Return whether another problem's entries stand in the same places."""
        own = self.problem
        same = own.mesh is problem.mesh and own.signature is problem.signature
        return same and (own.free, own.links) == (problem.free, problem.links) and self.reads_as(reads)

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
            result[term.place].reshape(term.shape)[...] = term.values(at)
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
        r, c = np.broadcast_arrays(np.asarray(entries.rows), np.asarray(entries.columns))
        place, self._size = slice(self._size, self._size + r.size), self._size + r.size
        self._rows.append(r.ravel())
        self._columns.append(c.ravel())
        if callable(entries.values):
            self.terms.append(Term(place, r.shape, entries.values))
            self._constant.append(np.zeros(r.size))
        else:
            self._constant.append(np.broadcast_to(entries.values, r.shape).ravel())

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
            out, state = structure.dx
            columns = np.moveaxis(unknowns.value_index[e.base], 2, 0)[state]
            self._add(
                Entries(
                    e.rows[out][:, :, None],
                    columns,
                    lambda at: (at.factor(e) * at.derivatives(e).dx)[:, :, None] * e.weights,
                )
            )
        self._add_reads(e)
        # The length of its interval moves a collocation equation, whatever the function reads.
        moving = structure.moved if e.sign else np.arange(len(e.rows))
        if len(moving):
            rows = e.rows[moving][:, :, None]
            self._add(Entries(rows, self.columns.moving_columns, lambda at: at.moves(e)[moving][:, :, :n_moving]))
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

    def _add_reads(self, e: FunctionEquations) -> None:
        """Add the delayed reads of a function: its slopes times the weights at its points."""
        for entry, (out, q) in enumerate(zip(*e.function.structure(self.problem.free_index).dxd, strict=True)):
            delayed = self.problem.numeric.model.delayed
            if q >= len(delayed):
                self._add_integral(e, entry, int(out), int(q) - len(delayed))
                continue
            read = delayed[q]
            weights = self.operators[read.delay].weights

            def values(at: Linearisation, entry: int = entry, read: DelayedValue = read) -> Array:
                slope = at.factor(e) * at.derivatives(e).dxd[entry]
                reading = at.reads.operators[read.delay].weights_of(read.derivative)
                result: Array = slope[:, None] * reading.weights[e.points]
                return result

            if isinstance(weights, FullWeights):
                columns = self.problem.unknowns.value_index[:, read.state]
                self.dense_terms.append(DenseTerm(e.rows[out], columns, values))
            else:
                columns = self.columns.read_columns(weights, e.points, read.state)
                self._add(Entries(e.rows[out][:, None], columns, values))

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
