"""Where derivatives of an orbit's equations are evaluated, and which columns they go to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import Derivatives
from pddecont.delay import LocalWeights
from pddecont.native import compiled_assembly
from pddecont.orbit.equations import FunctionEquations
from pddecont.orbit.orbit import Orbit, Reads
from pddecont.orbit.signature import DelayedEventLink

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Entries:
    """Entries of a matrix; rows and columns broadcast against each other, values fit into their common shape."""

    rows: Ints | int
    columns: Ints | int
    values: Callable[[Linearisation], Array] | Array | float


class ColumnMap(Protocol):
    """Which columns the unknowns stand in, and how times move with them.

    ``moving_columns`` are those of durations and breaking times (n_moving,); ``equation_times`` (n_equation_points,
    n_moving + n_taus) and ``interval_lengths`` (n_intervals, n_moving + n_taus) say how equation points and mesh
    intervals move with them and with the n_taus delays that depend on free parameters.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the matrix."""
        ...

    @property
    def moving_columns(self) -> Ints:
        """Columns of the durations and breaking times that move times."""
        ...

    @property
    def equation_times(self) -> Array:
        """How equation points move."""
        ...

    @property
    def interval_lengths(self) -> Array:
        """How the lengths of mesh intervals move."""
        ...

    def delayed_derivatives(self, orbit: Orbit, reads: Reads) -> Array:
        """Return how delayed values move, shape (n_delayed, n_equation_points, n_moving + n_taus)."""
        ...

    def read_columns(self, weights: LocalWeights, points: Ints, state: int) -> Ints:
        """Return the columns that are read at ``points`` of a delayed state, shape (n_points, degree + 1)."""
        ...

    def state_after(self, s: int) -> Ints:
        """Return the columns of the state after the reset at the end of segment ``s``, shape (n_states,)."""
        ...

    def find_elapsed_weights(self, link: DelayedEventLink) -> Array:
        """Return the weights of ``moving_columns`` in the time from a delayed event's source to the event."""
        ...

    def find_time_weights(self, coefficients: Array) -> Array:
        """Return the weights of ``moving_columns`` and of delays that move in a sum (n_theta,) of theta."""
        ...

    def phase_entries(self, row: int) -> list[Entries]:
        """Return the entries of the phase equation."""
        ...

    def period_entries(self, row: int) -> list[Entries]:
        """Return the entries of the period equation."""
        ...


class Linearisation:
    """An orbit at which derivatives are evaluated; what several terms need is computed once.

    ``free`` numbers the free parameters. ``h`` (n_equation_points,) are the lengths of the points' intervals.
    ``tables`` (n_reads + 1, n_equation_points, n_moving + n_taus) says how what is read of the past moves with
    durations and delays, and how times do, ``tau_derivatives`` (n_taus, n_free) how those delays do with the free
    parameters.
    """

    def __init__(self, columns: ColumnMap, free: tuple[int, ...], orbit: Orbit, reads: Reads):
        self.columns, self.free, self.orbit, self.reads = columns, free, orbit, reads
        self.h = reads.h[orbit.mesh.equation_points.interval]
        delays = orbit.numeric.delays
        self.tau_derivatives = delays.derivatives(orbit.parameters, free)[delays.function.structure(free).moving]
        self.tables = np.concatenate([columns.delayed_derivatives(orbit, reads), columns.equation_times[None]])
        self._factors: dict[FunctionEquations, Array] = {}
        self._moves: dict[FunctionEquations, Array] = {}

    def derivatives(self, e: FunctionEquations) -> Derivatives:
        """Return the function of ``e`` with its derivatives at its points.

        Those in parameters are in the free ones of the orbit that is read: all matrices at it have them in common.
        """
        r, p = self.reads, self.orbit.parameters
        return r.once(e, lambda: e.function.derivatives(r.t[e.points], r.x[:, e.points], r.xd[:, e.points], p, r.free))

    def factor(self, e: FunctionEquations) -> Array:
        """Return what the function of ``e`` is multiplied by, shape (n_points,)."""
        if e not in self._factors:
            self._factors[e] = np.full(len(e.points), e.sign) if e.sign else -self.h[e.points]
        return self._factors[e]

    @property
    def read_weights(self) -> Array:
        """Weights of all that is read from single mesh intervals, shape (n_kinds, n_equation_points, degree + 1).

        The kinds are the model's (``read_kinds``); what is read from all base values has none.
        """
        return self.reads.once("weights", self._find_read_weights)

    def _find_read_weights(self) -> Array:
        mesh, kinds = self.orbit.mesh, self.orbit.numeric.model.read_kinds
        result = np.zeros((len(kinds), mesh.n_equation_points, mesh.degree + 1))
        for i, (delay, order) in enumerate(kinds):
            weights = self.reads.operators[delay].weights_of(order)
            if isinstance(weights, LocalWeights):
                result[i] = weights.weights
        return result

    def moves(self, e: FunctionEquations) -> Array:
        """Return how equations move with durations and delays, shape (n_out, n_points, n_moving + n_taus)."""
        if e not in self._moves:
            d, structure, n = self.derivatives(e), e.function.structure(self.free), len(e.points)
            n_tables, n_points, n_moving = self.tables.shape
            result, points = np.zeros((*e.rows.shape, n_moving)), np.ascontiguousarray(e.points)
            times = np.full(len(structure.dt), n_tables - 1)
            for rates, out, which in ((d.dt, structure.dt, times), (d.dxd, *structure.dxd)):
                compiled_assembly.add_moves(
                    rates, out, which, len(out), points, n, self.tables, n_points, n_moving, result
                )
            if e.sign:
                result *= e.sign
            else:
                interval = self.orbit.mesh.equation_points.interval[e.points]
                lengths = self.columns.interval_lengths
                compiled_assembly.stretch_moves(
                    d.value, len(d.value), self.factor(e), interval, n, lengths, n_moving, result
                )
            self._moves[e] = result
        return self._moves[e]
