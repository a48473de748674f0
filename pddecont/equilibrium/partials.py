"""Partial derivatives of a vector field in its states and delayed values, as multilinear forms.

The field f(y_1 .. y_m) of a mode reads states and delayed values y_a. Of each order all partial derivatives that are
not zero are one compiled function; the forms B(u, v) = sum d2f/(dy_a dy_b) u_a v_b and C(u, v, w) sum over them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations_with_replacement, permutations
from math import factorial
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction, NumericModel

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
        """Return the form of ``values`` (n_entries,) at as many ``directions`` (m,) as the order, shape (n,)."""
        order = self.arguments.shape[1]
        terms = np.zeros(len(values), dtype=np.result_type(values, *directions))
        for chosen in permutations(range(order)):
            product = values.astype(terms.dtype)
            for place, direction in zip(chosen, directions, strict=True):
                product = product * direction[self.arguments[:, place]]
            terms += product
        result = np.zeros(n, dtype=terms.dtype)
        np.add.at(result, self.rows, terms / self._repeats)
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
class FieldPartials:
    """Partial derivatives of the field of a ``mode`` up to the third order; each is made when first needed."""

    numeric: NumericModel
    mode: str

    @cached_property
    def states(self) -> Ints:
        """The state that each argument y_a is, now or some time ago (m,)."""
        model = self.numeric.model
        return np.array([*range(len(model.states)), *(d.state for d in model.delayed)], dtype=np.intp)

    @cached_property
    def delays(self) -> Ints:
        """The number of the delay of each argument (m,); -1 for present values."""
        model = self.numeric.model
        return np.array([*[-1] * len(model.states), *(d.delay for d in model.delayed)], dtype=np.intp)

    @cached_property
    def first(self) -> Partials:
        """The derivatives of the first order."""
        return self._make(1)

    @cached_property
    def second(self) -> Partials:
        """The derivatives of the second order."""
        return self._make(2)

    @cached_property
    def third(self) -> Partials:
        """The derivatives of the third order."""
        return self._make(3)

    def _make(self, order: int) -> Partials:
        model = self.numeric.model
        symbols = (*model.state_symbols, *model.delayed_symbols)
        number = {s: a for a, s in enumerate(symbols)}
        diff = cache(lambda expr, a: expr.diff(symbols[a]))
        rows, arguments, exprs = [], [], []
        for row, expr in enumerate(model.modes[self.mode]):
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
            np.array(arguments, dtype=np.intp).reshape(-1, order),
            self.numeric.function(exprs),
        )
