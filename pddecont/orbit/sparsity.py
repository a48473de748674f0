"""The structure of a sparse matrix, found once from the places of its entries."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pddecont.continuation import Matrix

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
        key = self.columns * self.shape[0] + self.rows
        unique, inverse = np.unique(key, return_inverse=True)
        indptr = np.searchsorted(unique, np.arange(self.shape[1] + 1) * self.shape[0])
        return (unique % self.shape[0]).astype(np.intc), indptr.astype(np.intc), inverse

    def fill(self, values: Array) -> Matrix:
        """Return the sparse matrix (CSC) with these values (n_entries,)."""
        indices, indptr, inverse = self._order
        data = np.bincount(inverse, weights=values, minlength=len(indices))
        return sp.csc_matrix((data, indices, indptr), shape=self.shape)

    def fill_dense(self, values: Array) -> Array:
        """Return the full matrix with these values (n_entries,)."""
        size = self.shape[0] * self.shape[1]
        flat = np.bincount(self.rows * self.shape[1] + self.columns, weights=values, minlength=size)
        return np.asarray(flat, dtype=np.float64).reshape(self.shape)
