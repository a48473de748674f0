"""The linearised equations of a period solved in the order of time.

With the past and the durations given, each mesh interval follows from those before it: the matrix is block lower
triangular, but for a border of durations, breaking times and the start with the equations that fix them. Where blocks
are small going through them once costs less than a sparse factorisation before its first solution. Pivots are sought
inside a block alone; what is left of the equations shows whether that was enough.

Reference: Ascher, Mattheij, Russell (1995), section 7.2, for growth in such eliminations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import EquilibratedMatrix
from pddecont.native import compiled_assembly
from pddecont.orbit import OrbitProblem, Rows

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
# Unknowns of a mesh interval beyond which its own block is better kept sparse.
LARGEST_BLOCK = 64
# What is left of the equations, relative to the solutions, where rounding has not grown.
LEFT = 1e-13


@dataclass(frozen=True, eq=False)
class TimeOrder:
    """Blocks of a period's equations in the order of time: their first ``rows`` and ``columns``, and their ``sizes``.

    The matrix is of ``n_columns`` unknowns and as many equations.
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
    def rows_below(self) -> Ints:
        """The rows below all blocks."""
        return np.flatnonzero(self.block_of_row == len(self.sizes))

    @cached_property
    def columns_beside(self) -> Ints:
        """The columns beside all blocks, as many as rows below."""
        return np.flatnonzero(self._number(self.columns) == len(self.sizes))

    def _number(self, first: Ints) -> Ints:
        result = np.full(self.n_columns, len(self.sizes))
        for b, (start, size) in enumerate(zip(first.tolist(), self.sizes.tolist(), strict=True)):
            result[start : start + size] = b
        return result

    def solve(self, matrix: EquilibratedMatrix, b: Array) -> Array | None:
        """Return the solution of A x = b, shapes (n_columns, k), None where rounding errors have grown.

        ``matrix`` is the equilibrated one of A, sparse.
        """
        scaled, beside, below = matrix.matrix, self.columns_beside, self.rows_below
        q, width = len(beside), len(beside) + b.shape[1]
        right, solved = np.zeros((self.n_columns, width)), np.empty((self.n_columns, width))
        for i, (start, end) in enumerate(zip(scaled.indptr[beside], scaled.indptr[beside + 1], strict=True)):
            right[scaled.indices[start:end], i] = scaled.data[start:end]
        right[:, q:] = matrix.rows[:, None] * b
        given = right[:, q:].copy()
        done = compiled_assembly.eliminate_in_time(
            scaled.indptr,
            scaled.indices,
            scaled.data,
            self.rows,
            self.columns,
            self.sizes,
            len(self.sizes),
            self.block_of_row,
            width,
            right,
            solved,
            np.empty(int(np.max(self.sizes)) ** 2),
        )
        if not done:
            return None
        # What grows without bound is not finite, and no solution.
        with np.errstate(all="ignore"):
            try:
                y = np.linalg.solve(right[below, :q], right[below, q:])
            except np.linalg.LinAlgError:
                return None
            x = solved[:, q:] - solved[:, :q] @ y
            x[beside] = y
            # One sum of all solutions tells: the errors of none of them would vanish in it.
            weights = _draw_weights(b.shape[1])
            together = x @ weights
            left = np.max(np.abs(scaled @ together - given @ weights))
            return matrix.columns[:, None] * x if left <= LEFT * np.max(np.abs(together)) else None


def _draw_weights(n: int) -> Array:
    """Return random weights, shape (n,), the same each time."""
    return np.random.default_rng(3).standard_normal(n)


def order_in_time(problem: OrbitProblem) -> TimeOrder | None:
    """Return the blocks of one period's equations with the state after it; None where they are large.

    First stands the state that the period begins with, then interval after interval, and between segments the resets.
    """
    mesh, unknowns, n = problem.mesh, problem.unknowns, problem.unknowns.n_states
    rows, inside = Rows(unknowns), mesh.degree * n
    if inside > LARGEST_BLOCK:
        return None

    def find() -> TimeOrder:
        blocks = [(rows.size, 0, n)]
        for j, s in enumerate(mesh.segment.tolist()):
            blocks.append((j * inside, int(unknowns.value_index[mesh.base_index[j, 1], 0]), inside))
            if j == mesh.last_interval[s]:
                after = unknowns.value_index[mesh.first_base[s + 1], 0] if s + 1 < mesh.n_segments else unknowns.size
                blocks.append((rows.resets + s * n, int(after), n))
        first, columns, sizes = np.array(blocks).T.copy()
        return TimeOrder(first, columns, sizes, unknowns.size + n)

    return mesh.always(("order in time", unknowns.forced), find)
