"""The linear delay equation of an equilibrium as an ordinary one, whose eigenvalues lie next to characteristic roots.

States whose past is read carry it along (``history``): v = (x, z_j for each state j that is read),

    x' = A_0 x + sum_k A_k y_k,    y_kj = C_k z_j + d_k x_j,    z_j' = F z_j + g x_j

and each entry of a term that reads integrals adds such a y of its own to its row. Where rates of the past are read y_k
is a derivative of the profile.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.continuation import factor
from pddecont.equilibrium.characteristic import CharacteristicMatrix
from pddecont.equilibrium.history import HistorySystem
from pddecont.memo import cached_property

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Generator:
    """The equations' matrix: as blocks, made whole only where it is small."""

    matrix: CharacteristicMatrix
    history: HistorySystem

    @cached_property
    def read(self) -> NDArray[np.intp]:
        """Numbers of the states whose past is read."""
        found = [
            np.unique(abs(m).nonzero()[1])
            for m, tau in zip(self.matrix.delayed, self.matrix.delays, strict=True)
            if tau > 0.0
        ]
        found += [term.columns for term in self.matrix.distributed]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *found])).astype(np.intp)

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.matrix.n + len(self.read) * len(self.history.g)

    def make_whole(self) -> Array:
        """Return the whole matrix, shape (size, size)."""
        n, n_z, matrix, history = self.matrix.n, len(self.history.g), self.matrix, self.history
        whole = np.zeros((self.size, self.size))
        whole[:n, :n] = _to_dense(matrix.present)
        for k, through in enumerate(matrix.delayed):
            dense = _to_dense(through)
            whole[:n, :n] += history.d[k] * dense
            whole[:n, n:] += np.einsum("ij,z->ijz", dense[:, self.read], history.C[k]).reshape(n, -1)
        for term, (C, d) in zip(matrix.distributed, history.integrals, strict=True):
            np.add.at(whole, (term.rows, term.columns), d)
            past = n + np.searchsorted(self.read, term.columns)[:, None] * n_z + np.arange(n_z)
            np.add.at(whole, (term.rows[:, None], past), C)
        for place, j in enumerate(self.read.tolist()):
            rows = slice(n + place * n_z, n + (place + 1) * n_z)
            whole[rows, rows], whole[rows, j] = history.F, history.g
        return whole

    def invert_shifted(self, shift: complex) -> scipy.sparse.linalg.LinearOperator:
        """Return the inverse of the matrix less ``shift`` I; pasts are eliminated, one matrix of states is left."""
        n, n_z, m = self.matrix.n, len(self.history.g), len(self.read)
        history = self.history
        past = scipy.linalg.lu_factor(history.F - shift * np.eye(n_z)) if n_z else None
        through = scipy.linalg.lu_solve(past, history.g.astype(complex)) if n_z else np.zeros(0)
        # Delta itself with the history's own transfer factors in place of H.
        reduced: Any = self.matrix.present - shift * self.matrix.unit
        for k, block in enumerate(self.matrix.delayed):
            reduced = reduced + (history.d[k] - complex(history.C[k] @ through)) * block
        for term, (C, d) in zip(self.matrix.distributed, history.integrals, strict=True):
            part = sp.csc_matrix((d - C @ through, (term.rows, term.columns)), shape=(n, n))
            reduced = reduced + (part if self.matrix.is_sparse else part.toarray())
        solve: Any = factor(reduced.astype(complex))

        def apply(v: Complex) -> Complex:
            v = np.asarray(v, dtype=complex).ravel()
            free = scipy.linalg.lu_solve(past, v[n:].reshape(m, n_z).T) if n_z else np.zeros((0, m))
            right = v[:n].copy()
            for k, block in enumerate(self.matrix.delayed):
                given = np.zeros(n, dtype=complex)
                given[self.read] = history.C[k] @ free
                right -= block @ given
            for term, (C, _) in zip(self.matrix.distributed, history.integrals, strict=True):
                read = free[:, np.searchsorted(self.read, term.columns)]
                np.subtract.at(right, term.rows, np.einsum("ez,ze->e", C, read))
            x = solve(right)
            z = free - np.outer(through, x[self.read])
            return np.concatenate([x, z.T.ravel()])

        return scipy.sparse.linalg.LinearOperator((self.size, self.size), matvec=apply, dtype=complex)


def _to_dense(matrix: Any) -> Array:
    return matrix if isinstance(matrix, np.ndarray) else np.asarray(matrix.toarray())
