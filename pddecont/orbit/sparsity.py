"""The structure of a sparse matrix, found once from the places of its entries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import Matrix, make_sparse, with_values
from pddecont.memo import cached_property
from pddecont.native import compiled_assembly

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class SparsityPattern:
    """Places of entries, ``rows`` and ``columns`` of shape (n_entries,); entries at one place add up."""

    shape: tuple[int, int]
    rows: Ints
    columns: Ints

    @cached_property
    def _order(self) -> tuple[NDArray[np.intc], NDArray[np.intc], Ints]:
        (n_rows, n_columns), n = self.shape, len(self.rows)
        counts, by_column, places = (np.empty(size, dtype=np.intp) for size in (n_rows + n_columns + 1, n, n))
        starts, indices = np.empty(n_columns + 1, dtype=np.intc), np.empty(n, dtype=np.intc)
        found = compiled_assembly.sort_entries(
            self.rows, self.columns, n, n_rows, n_columns, counts, by_column, starts, indices, places
        )
        return indices[:found].copy(), starts, places

    @cached_property
    def _empty(self) -> Matrix:
        indices, indptr, _ = self._order
        return make_sparse(np.zeros(len(indices)), indices, indptr, self.shape)

    def fill(self, values: Array) -> Matrix:
        """Return the sparse matrix (CSC) with these values (n_entries,)."""
        empty, places = self._empty, self._order[2]
        data = np.zeros(len(empty.indices))
        compiled_assembly.add_up(values, places, len(values), data)
        return with_values(empty, data)

    def fill_dense(self, values: Array) -> Array:
        """Return the full matrix with these values (n_entries,)."""
        size = self.shape[0] * self.shape[1]
        flat = np.bincount(self.rows * self.shape[1] + self.columns, weights=values, minlength=size)
        return np.asarray(flat, dtype=np.float64).reshape(self.shape)
