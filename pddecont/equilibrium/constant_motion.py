"""Motions of one mode that do not move: the vector field where all delayed values are the present ones.

Rates of the past are zero there, and integrals those of their integrands at the present states.

In a mode that slides along surfaces u_j = 0 the field keeps the motion on them, wherever it is: of the equations f = 0
as many depend on the others. With one unknown mu_j each, zero at the solution,

    f(x, ..., x; p) + sum_j mu_j grad u_j = 0,    u_j(x; p) = 0

determine a pseudo-equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sp
import sympy
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction, Derivatives, NumericModel, Structure
from pddecont.delay import DelayMethod
from pddecont.equilibrium.characteristic import DENSE, CharacteristicMatrix
from pddecont.equilibrium.distributed import DistributedTerm
from pddecont.equilibrium.partials import ExpressionPartials
from pddecont.equilibrium.quadrature import Kernel, find_panels
from pddecont.equilibrium.rest_reads import RestReads
from pddecont.memo import cached_property
from pddecont.model import keep_reads, list_held

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# A lag that is negative by no more than this part of the longest one is zero, to rounding.
ZERO = 1e-9


@dataclass(frozen=True, eq=False)
class ConstantMotion:
    """A mode of an autonomous model, its delays discretised by ``method``; states x (n_states,), parameters p."""

    numeric: NumericModel
    mode: str
    method: DelayMethod
    _partials: dict[tuple[sympy.Expr, ...], ExpressionPartials] = field(default_factory=dict, init=False, repr=False)

    @property
    def partials(self) -> ExpressionPartials:
        """The partial derivatives of the vector field."""
        return self.find_partials(self.numeric.model.modes[self.mode])

    def find_partials(self, exprs: tuple[sympy.Expr, ...]) -> ExpressionPartials:
        """Return the partial derivatives of expressions over the model; they are kept."""
        return self._partials.setdefault(exprs, ExpressionPartials(self.numeric, exprs))

    @cached_property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the events whose surfaces the mode slides along."""
        return list_held(self.numeric.model, self.mode)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return self.numeric.n_states

    @cached_property
    def reads(self) -> RestReads:
        """What is read of the past at rest."""
        return RestReads(self.numeric)

    def rate(self, x: Array, p: Array) -> Array:
        """Return f(x, x, ..., x; p), shape (n_states,); zero at an equilibrium."""
        return self.numeric.mode(self.mode).value(np.zeros(1), x[:, None], self.read(x, p)[:, None], p)[:, 0]

    def differentiate(self, x: Array, p: Array, free: tuple[int, ...]) -> tuple[Array, Any, Array]:
        """Return f, its derivatives in x (n_states, n_states), and in the parameters numbered ``free``."""
        n, values = len(x), self.read(x, p)
        where, d = self._derive(self.numeric.mode(self.mode), x, values, p, free)
        read = self._sum_reads(where.dxd, d.dxd[:, 0], x, values, p)
        rows = np.concatenate([where.dx[0], read[0]])
        columns = np.concatenate([where.dx[1], read[1]])
        in_p = np.zeros((n, len(free)))
        in_p[where.dp] = d.dp[:, 0]
        return d.value[:, 0], fill(n, rows, columns, np.concatenate([d.dx[:, 0], read[2]])), in_p

    def measure_event(self, event: str, x: Array, p: Array, free: tuple[int, ...] = ()) -> tuple[float, Array, Array]:
        """Return an event function at rest, its derivatives in x (n_states,) and in parameters (n_free,)."""
        values, in_x, in_p = self.measure(self.numeric.event(event), x, p, free)
        return float(values[0]), in_x[0], in_p[0]

    def measure(
        self, function: ArrayFunction, x: Array, p: Array, free: tuple[int, ...] = ()
    ) -> tuple[Array, Array, Array]:
        """Return a function at rest (n_out,), its derivatives in x (n_out, n_states) and parameters (n_out, n_free)."""
        values = self.read(x, p)
        where, d = self._derive(function, x, values, p, free)
        in_x, in_p = np.zeros((function.n_out, len(x))), np.zeros((function.n_out, len(free)))
        in_x[where.dx] = d.dx[:, 0]
        rows, columns, entries = self._sum_reads(where.dxd, d.dxd[:, 0], x, values, p)
        np.add.at(in_x, (rows, columns), entries)
        in_p[where.dp] = d.dp[:, 0]
        return d.value[:, 0], in_x, in_p

    def linearise(self, x: Array, p: Array) -> CharacteristicMatrix:
        """Return the characteristic matrix at a state that stays: delays that vary have their lags there."""
        model, n, values = self.numeric.model, len(x), self.read(x, p)
        where, d = self._derive(self.numeric.mode(self.mode), x, values, p)
        present = fill(n, where.dx[0], where.dx[1], d.dx[:, 0])
        groups = self._group_reads(where.dxd[1])
        numbers = {group: k for k, group in enumerate(groups)}
        # Integrals stand behind the delayed values.
        of_read = [numbers.get((v.delay, v.derivative), -1) for v in model.delayed] + [-1] * len(model.integrals)
        rows, read = where.dxd
        group = np.array(of_read, dtype=np.intp)[read]
        delayed = [
            fill(n, rows[group == k], self.reads.states[read[group == k]], d.dxd[group == k, 0])
            for k in range(len(groups))
        ]
        delays = self.reads.find_lags(x, values, p)[[delay for delay, _ in groups]]
        orders = np.array([order for _, order in groups], dtype=np.intp)
        terms = self._distribute(where.dxd, d.dxd[:, 0], x, values, p)
        return CharacteristicMatrix(present, tuple(delayed), delays, self.method, orders, tuple(terms))

    def read(self, x: Array, p: Array) -> Array:
        """Return what a motion that stays at ``x`` reads of the past, shape (n_reads,)."""
        return self.reads.find_values(x, p)

    @cached_property
    def lag_numbers(self) -> list[int]:
        """The delays by which the field, or an event that ends the mode, reads, numbered through those that vary."""
        model = self.numeric.model
        if not model.varying:
            return []
        events = (model.events[s.event].function for s in model.list_segments(self.mode) if s.event)
        functions = [*model.modes[self.mode], *(h for h in events if h is not None)]
        kept = keep_reads(model, {symbol for f in functions for symbol in f.free_symbols}).varying
        return [k for k, delay in enumerate(model.varying) if delay in kept]

    @cached_property
    def lags(self) -> ArrayFunction:
        """These delays as a function of what is read."""
        return self.numeric.function([self.numeric.model.varying[k] for k in self.lag_numbers])

    def find_negative_lag(self, x: Array, p: Array) -> tuple[str, float] | None:
        """Return a delay that is negative at rest, with its lag; None where none is."""
        if not self.lag_numbers:
            return None
        lags = self.measure(self.lags, x, p)[0]
        worst = int(np.argmin(lags))
        if not lags[worst] < -ZERO * float(np.max(np.abs(lags))):
            return None
        return str(self.numeric.model.varying[self.lag_numbers[worst]]), float(lags[worst])

    def _derive(
        self, function: ArrayFunction, x: Array, values: Array, p: Array, free: tuple[int, ...] = ()
    ) -> tuple[Structure, Derivatives]:
        """Return a function's derivatives at rest, where it reads ``values``."""
        return function.structure(free), function.derivatives(np.zeros(1), x[:, None], values[:, None], p, free)

    def _sum_reads(
        self, places: tuple[Ints, Ints], slopes: Array, x: Array, values: Array, p: Array
    ) -> tuple[Ints, Ints, Array]:
        """Return rows, columns and entries of derivatives in x through what is read, of the ``slopes`` in that."""
        rows, read = places
        kept = np.append(self.reads.is_value, np.zeros(len(self.numeric.model.integrals), dtype=bool))[read]
        found = [(rows[kept], self.reads.states[read[kept]], slopes[kept])]
        for term in self._distribute(places, slopes, x, values, p):
            found.append((term.rows, term.columns, term.transform(0.0)[0].real))
        in_rows, columns, entries = zip(*found, strict=True)
        return np.concatenate(in_rows), np.concatenate(columns), np.concatenate(entries)

    def _distribute(
        self, places: tuple[Ints, Ints], slopes: Array, x: Array, values: Array, p: Array
    ) -> list[DistributedTerm]:
        """Return the linear terms of the integrals that a function reads, with ``slopes`` in what it reads."""
        rows, numbers = places[0], places[1] - len(self.reads.states)
        found = []
        for number in np.unique(numbers[numbers >= 0]).tolist():
            chosen = numbers == number
            low, high = self.reads.find_limits(number, x, values, p)
            columns = self.reads.list_integrated(number)
            if low != high and len(columns):
                kernel = self._make_kernel(number, slopes[chosen], x, p)
                places_of = np.repeat(rows[chosen], len(columns)), np.tile(columns, int(np.sum(chosen)))
                found.append(DistributedTerm(*places_of, kernel, find_panels(kernel, low, high)))
        return found

    def _make_kernel(self, number: int, slopes: Array, x: Array, p: Array) -> Kernel:
        """Return the derivatives in states of rows that have ``slopes`` in an integral, over lags."""
        in_states = self.reads.find_integrand_slopes(number, x, p)
        return lambda s: (slopes[:, None, None] * in_states(s)).reshape(-1, len(s))

    def _group_reads(self, read: Ints) -> list[tuple[int, int]]:
        """Return the delays, and how often states are differentiated, of the values that a function may read.

        Constant delays without rates are all among them, others those that occur among the numbers ``read``.
        """
        model, occurring = self.numeric.model, set(read.tolist())
        return sorted(
            {
                (v.delay, v.derivative)
                for k, v in enumerate(model.delayed)
                if k in occurring or (v.delay < len(model.delays) and not v.derivative)
            }
        )


def fill(n: int, rows: NDArray[np.intp], columns: NDArray[np.intp], values: Array) -> Any:
    """Return a matrix (n, n) of entries, which are added where they meet: an array, or sparse if it is large."""
    if n > DENSE:
        return sp.csc_matrix((values, (rows, columns)), shape=(n, n))
    matrix = np.zeros((n, n))
    np.add.at(matrix, (rows, columns), values)
    return matrix
