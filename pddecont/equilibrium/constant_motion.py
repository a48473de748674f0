"""Motions of one mode that do not move: the vector field where all delayed values are the present ones.

In a mode that slides along surfaces u_j = 0 the field keeps the motion on them, wherever it is: of the equations f = 0
as many depend on the others. With one unknown mu_j each, zero at the solution,

    f(x, ..., x; p) + sum_j mu_j grad u_j = 0,    u_j(x; p) = 0

determine a pseudo-equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod
from pddecont.equilibrium.characteristic import DENSE, CharacteristicMatrix
from pddecont.equilibrium.partials import FieldPartials

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ConstantMotion:
    """A mode of an autonomous model, its delays discretised by ``method``; states x (n_states,), parameters p."""

    numeric: NumericModel
    mode: str
    method: DelayMethod
    partials: FieldPartials = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "partials", FieldPartials(self.numeric, self.mode))

    @cached_property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the events whose surfaces the mode slides along."""
        derived = self.numeric.model.derived
        return () if derived is None else derived.list_surfaces(self.mode)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return self.numeric.n_states

    def rate(self, x: Array, p: Array) -> Array:
        """Return f(x, x, ..., x; p), shape (n_states,); zero at an equilibrium."""
        return self.numeric.mode(self.mode).value(np.zeros(1), x[:, None], self.read(x)[:, None], p)[:, 0]

    def differentiate(self, x: Array, p: Array, free: tuple[int, ...]) -> tuple[Array, Any, Array]:
        """Return f, its derivatives in x (n_states, n_states), and in the parameters numbered ``free``."""
        function, n = self.numeric.mode(self.mode), len(x)
        where, d = (
            function.structure(free),
            function.derivatives(np.zeros(1), x[:, None], self.read(x)[:, None], p, free),
        )
        states, moves = self._delayed_states, self._is_value
        kept = moves[where.dxd[1]]
        rows = np.concatenate([where.dx[0], where.dxd[0][kept]])
        columns = np.concatenate([where.dx[1], states[where.dxd[1][kept]]])
        in_p = np.zeros((n, len(free)))
        in_p[where.dp] = d.dp[:, 0]
        return d.value[:, 0], fill(n, rows, columns, np.concatenate([d.dx[:, 0], d.dxd[kept, 0]])), in_p

    def measure_event(self, event: str, x: Array, p: Array, free: tuple[int, ...] = ()) -> tuple[float, Array, Array]:
        """Return an event function at rest, its derivatives in x (n_states,) and in parameters (n_free,)."""
        function = self.numeric.event(event)
        where, d = (
            function.structure(free),
            function.derivatives(np.zeros(1), x[:, None], self.read(x)[:, None], p, free),
        )
        slopes, in_p = np.zeros(len(x)), np.zeros(len(free))
        slopes[where.dx[1]] = d.dx[:, 0]
        kept = self._is_value[where.dxd[1]]
        np.add.at(slopes, self._delayed_states[where.dxd[1][kept]], d.dxd[kept, 0])
        in_p[where.dp[1]] = d.dp[:, 0]
        return float(d.value[0, 0]), slopes, in_p

    def linearise(self, x: Array, p: Array) -> CharacteristicMatrix:
        """Return the characteristic matrix at a state that stays."""
        function, model, n = self.numeric.mode(self.mode), self.numeric.model, len(x)
        where, d = function.structure(), function.derivatives(np.zeros(1), x[:, None], self.read(x)[:, None], p)
        present = fill(n, where.dx[0], where.dx[1], d.dx[:, 0])
        groups = sorted({(v.delay, v.derivative) for v in model.delayed})
        of_value = np.array([groups.index((v.delay, v.derivative)) for v in model.delayed], dtype=np.intp)
        delayed = []
        for k in range(len(groups)):
            chosen = of_value[where.dxd[1]] == k
            columns = self._delayed_states[where.dxd[1][chosen]]
            delayed.append(fill(n, where.dxd[0][chosen], columns, d.dxd[chosen, 0]))
        delays = self.numeric.delays.value(p)[[delay for delay, _ in groups]]
        orders = np.array([order for _, order in groups], dtype=np.intp)
        return CharacteristicMatrix(present, tuple(delayed), delays, self.method, orders)

    def read(self, x: Array) -> Array:
        """Return the delayed values of a motion that stays at ``x``, shape (n_delayed,)."""
        return np.where(self._is_value, x[self._delayed_states], 0.0)

    @cached_property
    def _delayed_states(self) -> NDArray[np.intp]:
        return np.array([v.state for v in self.numeric.model.delayed], dtype=np.intp)

    @cached_property
    def _is_value(self) -> NDArray[np.bool_]:
        """Which delayed values are values, not rates."""
        return np.array([v.derivative == 0 for v in self.numeric.model.delayed], dtype=bool)


def fill(n: int, rows: NDArray[np.intp], columns: NDArray[np.intp], values: Array) -> Any:
    """Return a matrix (n, n) of entries, which are added where they meet: an array, or sparse if it is large."""
    if n > DENSE:
        return sp.csc_matrix((values, (rows, columns)), shape=(n, n))
    matrix = np.zeros((n, n))
    np.add.at(matrix, (rows, columns), values)
    return matrix
