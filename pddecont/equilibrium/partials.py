"""Partial derivatives of expressions in states and values of the past, as multilinear forms.

A function f(y_1 .. y_m) reads states, delayed values and integrals, and an integrand its lag: the y_a. Of each order
all partial derivatives that are not zero are one compiled function; the forms B(u, v) = sum d2f/(dy_a dy_b) u_a v_b and
C(u, v, w) sum over them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations_with_replacement, permutations
from math import factorial
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction, NumericModel
from pddecont.memo import cached_property
from pddecont.model import TIME

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Partials:
    """All partial derivatives of one order that are not zero.

    ``rows`` (n_entries,) are components of f, ``arguments`` (n_entries, order) the numbers of the y they are taken in,
    in ascending order; ``function`` has one output an entry.
    """

    rows: Ints
    arguments: Ints
    function: ArrayFunction

    def apply(self, values: Array, directions: Sequence[NDArray[Any]], n: int) -> NDArray[Any]:
        """Return the form of ``values`` (n_entries, n_points) at as many ``directions`` as the order.

        Directions have shape (n_arguments, n_points), the form (n, n_points).
        """
        order = self.arguments.shape[1]
        terms = np.zeros(values.shape, dtype=np.result_type(values, *directions))
        for chosen in permutations(range(order)):
            product = values.astype(terms.dtype)
            for place, direction in zip(chosen, directions, strict=True):
                product = product * direction[self.arguments[:, place]]
            terms += product
        result = np.zeros((n, values.shape[1]), dtype=terms.dtype)
        np.add.at(result, self.rows, terms / self._repeats[:, None])
        return result

    @cached_property
    def _repeats(self) -> Array:
        """How many permutations of each entry's arguments are the same."""
        found = []
        for row in self.arguments.tolist():
            counts = [row.count(a) for a in dict.fromkeys(row)]
            found.append(float(np.prod([factorial(c) for c in counts])))
        return np.array(found)


@dataclass(frozen=True, eq=False)
class ExpressionPartials:
    """Partial derivatives of expressions over a model up to the third order; each is made when first needed.

    Arguments are numbered through the states, what is read of the past, and t.
    """

    numeric: NumericModel
    exprs: tuple[sympy.Expr, ...]
    _made: dict[int, Partials] = field(default_factory=dict, repr=False)

    @cached_property
    def symbols(self) -> tuple[sympy.Symbol, ...]:
        """The arguments (n_arguments,)."""
        model = self.numeric.model
        return (*model.state_symbols, *model.read_symbols, TIME)

    @cached_property
    def used(self) -> Ints:
        """The numbers of the arguments that the expressions hold."""
        held = {s for expr in self.exprs for s in expr.free_symbols}
        return np.array([a for a, s in enumerate(self.symbols) if s in held], dtype=np.intp)

    def of_order(self, order: int) -> Partials:
        """Return the derivatives of an order; of the order 0 the values."""
        if order not in self._made:
            self._made[order] = self._make(order)
        return self._made[order]

    def _make(self, order: int) -> Partials:
        number = {s: a for a, s in enumerate(self.symbols)}
        diff = cache(lambda expr, a: expr.diff(self.symbols[a]))
        rows, arguments, exprs = [], [], []
        for row, expr in enumerate(self.exprs):
            read = sorted(number[s] for s in expr.free_symbols if s in number)
            for chosen in combinations_with_replacement(read, order):
                slope = expr
                for a in chosen:
                    slope = diff(slope, a)
                    if slope == 0:
                        break
                if slope != 0:
                    rows.append(row)
                    arguments.append(chosen)
                    exprs.append(sympy.sympify(slope))
        return Partials(
            np.array(rows, dtype=np.intp),
            np.array(arguments, dtype=np.intp).reshape(len(rows), order),
            self.numeric.function(exprs),
        )
