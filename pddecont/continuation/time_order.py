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
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from pddecont.native import compiled_assembly
from pddecont.native.assembly import Blocks

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Unknowns of the small system beyond which a sparse factorisation is better.
WIDEST = 128
# What is left of the equations, relative to the solutions, where rounding has not grown.
LEFT = 1e-13
# How large solutions for a right-hand side of random numbers are at most. Beyond that equations are nearly singular, as
# where many segments are about to vanish, and pivots sought in the whole matrix keep small unknowns apart.
LARGEST = 1e6


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


def factor_in_time(matrix: Any, order: TimeOrder) -> Callable[[Array], Array] | None:
    """Return what solves with a square sparse matrix (CSC) whose rows have largest entries of modulus 1.

    It takes right-hand sides of shape (n,) or (n, k). None where that does not do: blocks or the whole are singular or
    nearly so, too much comes round, or rounding errors have grown.
    """
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
    n = order.n_columns
    found = np.empty(n, dtype=np.intp)
    n_wrapped = compiled_assembly.find_wrapped(blocks, found)
    wrapped, beside, below = found[:n_wrapped], order.columns_beside, order.rows_below
    size = n_wrapped + len(beside)
    if size > WIDEST:
        return None
    factors, pivots = np.empty(order.n_entries), np.empty(order.n_inside, dtype=np.intp)
    if not compiled_assembly.factor_in_time(blocks, factors, pivots):
        return None

    def eliminate(right: Array) -> Array:
        """Return the solutions of the blocks; what they leave stays in the rows of ``right`` below."""
        solved = np.zeros(right.shape)
        compiled_assembly.solve_in_time(blocks, factors, pivots, right.shape[1], right, solved)
        return solved

    right = np.zeros((n, size))
    chosen = np.concatenate([wrapped, beside])
    compiled_assembly.take_columns(blocks, chosen, size, order.block_of_column, right)
    above = eliminate(right)
    small = np.concatenate([above[wrapped], right[below]])
    small.reshape(-1)[: n_wrapped * size : size + 1] += 1.0
    lu, exchanged, singular = lapack.dgetrf(small) if size else (small, np.zeros(0, dtype=np.intc), 0)
    if singular:
        return None
    above_by_column, lu_by_column = np.ascontiguousarray(above.T), np.ascontiguousarray(lu.T)

    def solve(b: Array) -> Array:
        if b.ndim > 1:
            return solve_many(b)
        x, right, border = np.empty(n), np.array(b, dtype=np.float64), np.empty(size)
        compiled_assembly.solve_bordered(
            blocks,
            factors,
            pivots,
            wrapped,
            n_wrapped,
            beside,
            below,
            len(beside),
            above_by_column,
            lu_by_column,
            exchanged,
            n,
            right,
            border,
            x,
        )
        return x

    def solve_many(b: Array) -> Array:
        right = np.array(b, dtype=np.float64, order="C")
        solved = eliminate(right)
        if not size:
            return solved
        unknown, _ = lapack.dgetrs(lu, exchanged, np.concatenate([solved[wrapped], right[below]]))
        x: Array = solved - above @ unknown
        x[beside] = unknown[n_wrapped:]
        return x

    trial = _draw(n)
    with np.errstate(all="ignore"):
        x = solve(trial)
        left, largest = np.abs(matrix @ x - trial).max(), np.abs(x).max()
    return solve if left <= LEFT * largest and largest <= LARGEST else None


@cache
def _draw(n: int) -> Array:
    """Return random numbers, shape (n,), the same each time."""
    return np.random.default_rng(3).standard_normal(n)
