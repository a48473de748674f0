"""Systems of equations solved in the order of time.

With the past and the durations given, each mesh interval follows from those before it: the matrix is block lower
triangular, but for a border of durations, breaking times and parameters with the equations that fix them, and for what
comes round: the end of a period, which its beginning reads. Both are unknowns of a small full system. Where blocks are
small that costs less than a sparse factorisation. Pivots are sought inside a block alone; what is left of the equations
shows whether that was enough.

Reference: Ascher, Mattheij, Russell (1995), section 7.2, for growth in such eliminations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from pddecont.continuation.trial import solves
from pddecont.memo import cached_property
from pddecont.native import compiled_assembly
from pddecont.native.assembly import Blocks, Border

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Unknowns of the small system beyond which a sparse factorisation is better.
WIDEST = 128


@dataclass(frozen=True, eq=False)
class TimeOrder:
    """Blocks of equations in the order of time: their first ``rows`` and ``columns``, and their ``sizes``.

    The matrix is of ``n_columns`` unknowns and as many equations; those in no block make its border.
    """

    rows: Ints
    columns: Ints
    sizes: Ints
    n_columns: int

    @cached_property
    def block_of_row(self) -> Ints:
        """The number of each row's block, shape (n_columns,); of the rows below all of them one more than there are."""
        return self._number(self.rows)

    @cached_property
    def block_of_column(self) -> Ints:
        """The number of each column's block, shape (n_columns,)."""
        return self._number(self.columns)

    @cached_property
    def rows_below(self) -> Ints:
        """The rows below all blocks."""
        return np.flatnonzero(self.block_of_row == len(self.sizes))

    @cached_property
    def columns_beside(self) -> Ints:
        """The columns beside all blocks, as many as rows below."""
        return np.flatnonzero(self.block_of_column == len(self.sizes))

    @cached_property
    def n_entries(self) -> int:
        """Number of entries of all blocks."""
        return int(self.sizes @ self.sizes)

    @cached_property
    def n_inside(self) -> int:
        """Number of rows of all blocks."""
        return int(np.sum(self.sizes))

    def _number(self, first: Ints) -> Ints:
        result = np.full(self.n_columns, len(self.sizes))
        for b, (start, size) in enumerate(zip(first.tolist(), self.sizes.tolist(), strict=True)):
            result[start : start + size] = b
        return result


@dataclass(frozen=True, eq=False)
class FactoredBlocks:
    """The blocks of a matrix with their ``factors`` (n_entries,) and ``pivots`` (n_inside,), one after the other."""

    blocks: Blocks
    factors: Array
    pivots: Ints

    def solve(self, right: Array) -> Array:
        """Return the blocks' solutions (n, k) for ``right`` (n, k), whose rows below end as what those leave there."""
        solved = np.zeros(right.shape)
        compiled_assembly.solve_in_time(self.blocks, self.factors, self.pivots, right.shape[1], right, solved)
        return solved


@dataclass(frozen=True, eq=False)
class TimeFactors:
    """A matrix factored in the order of time: its blocks, and the small system of what comes round and of the border.

    ``above`` (n, size) are the blocks' solutions for the columns of the small system, ``small`` its factors (size,
    size) with the ``exchanged`` rows (size,) of LAPACK, ``border`` the same for compiled code.
    """

    inside: FactoredBlocks
    border: Border
    above: Array
    small: Array
    exchanged: NDArray[np.intc]

    def solve(self, b: Array) -> Array:
        """Return the solutions for ``b``, shape (n,) or (n, k)."""
        if b.ndim > 1:
            return self._solve_many(b)
        x, right, unknown = np.empty(len(b)), np.array(b, dtype=np.float64), np.empty(len(self.small))
        inside = self.inside
        compiled_assembly.solve_bordered(inside.blocks, inside.factors, inside.pivots, self.border, right, unknown, x)
        return x

    def _solve_many(self, b: Array) -> Array:
        right, border = np.array(b, dtype=np.float64, order="C"), self.border
        x = self.inside.solve(right)
        if not len(self.small):
            return x
        given = np.concatenate([x[border.wrapped], right[border.below]])
        unknown, _ = lapack.dgetrs(self.small, self.exchanged, given)
        x -= self.above @ unknown
        x[border.beside] = unknown[border.n_wrapped :]
        return x


def factor_in_time(matrix: Any, order: TimeOrder) -> Callable[[Array], Array] | None:
    """Return what solves with a square sparse matrix (CSC) whose rows have largest entries of modulus 1.

    It takes right-hand sides of shape (n,) or (n, k). None where that does not do: blocks or the whole are singular or
    nearly so, too much comes round, or rounding errors have grown.
    """
    found = _factor(matrix, order)
    if found is None:
        return None
    return found.solve if solves(matrix, found.solve) else None


def _factor(matrix: Any, order: TimeOrder) -> TimeFactors | None:
    """Return a matrix factored, well or not; None where a pivot is zero or too much comes round."""
    blocks = Blocks(
        starts=matrix.indptr,
        indices=matrix.indices,
        data=matrix.data,
        rows=order.rows,
        columns=order.columns,
        sizes=order.sizes,
        n_blocks=len(order.sizes),
        block_of_row=order.block_of_row,
    )
    n, beside, below = order.n_columns, order.columns_beside, order.rows_below
    columns = np.empty(n, dtype=np.intp)
    n_wrapped = compiled_assembly.find_wrapped(blocks, columns)
    wrapped, size = columns[:n_wrapped], n_wrapped + len(beside)
    if size > WIDEST:
        return None
    inside = FactoredBlocks(blocks, np.empty(order.n_entries), np.empty(order.n_inside, dtype=np.intp))
    if not compiled_assembly.factor_in_time(blocks, inside.factors, inside.pivots):
        return None
    right, chosen = np.zeros((n, size)), np.concatenate([wrapped, beside])
    compiled_assembly.take_columns(blocks, chosen, size, order.block_of_column, right)
    above = inside.solve(right)
    small = np.concatenate([above[wrapped], right[below]])
    small.reshape(-1)[: n_wrapped * size : size + 1] += 1.0
    lu, exchanged, singular = lapack.dgetrf(small) if size else (small, np.zeros(0, dtype=np.intc), 0)
    if singular:
        return None
    border = Border(
        n=n,
        wrapped=wrapped,
        n_wrapped=n_wrapped,
        beside=beside,
        below=below,
        n_beside=len(beside),
        above=np.ascontiguousarray(above.T),
        small=np.ascontiguousarray(lu.T),
        exchanged=exchanged,
    )
    return TimeFactors(inside, border, above, lu, exchanged)
