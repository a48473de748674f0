"""Where multipliers may lie: eigenvalues of the map from history to history, by dense methods or Arnoldi's.

The shift of a long history is far from normal, so that eigenvalues computed of it may be none of the orbit's. They are
first guesses, corrected and counted on the characteristic matrix.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse.linalg
from numpy.typing import NDArray

from pddecont.continuation import find_largest
from pddecont.stability.monodromy import MonodromyOperator

Complex = NDArray[np.complex128]
# Histories up to this size are mapped whole; those with delay lines, whose own multipliers crowd, up to the second.
DENSE, DENSE_LINES = 160, 1200
# Arnoldi's method finds little in larger histories that reach back over more periods than this: mostly shifts.
DEEP = 3
MAX_RESTARTS = 30
# Directions that are given room at most, and room besides.
MOST_LASTING, SPARE = 400, 24


def find_candidates(monodromy: MonodromyOperator, n: int) -> Complex:
    """Return at least ``n`` leading eigenvalues of a map by falling modulus, as far as there are any to be found."""
    size = monodromy.size
    if not size:
        return np.zeros(0, dtype=complex)
    if is_mapped_whole(monodromy, n):
        return _sort(scipy.linalg.eigvals(monodromy.scaled_matrix))[: 2 * n + 2]
    return np.zeros(0, dtype=complex) if is_deep(monodromy) else find_eigenpairs(monodromy, n)[0]


def find_eigenpairs(monodromy: MonodromyOperator, n: int) -> tuple[Complex, Complex]:
    """Return ``n`` leading eigenvalues of a map by falling modulus, or as many as are found, by Arnoldi's method.

    With them their vectors, histories in units of their sizes, as columns (size, n).
    """
    size = monodromy.size
    # Arnoldi's method wants room for several times as many vectors as values. About as many directions as there are
    # states last longer than a period: with room for all of them it need not start again.
    n_lasting = min(monodromy.problem.unknowns.n_states, MOST_LASTING)
    n_vectors = min(size - 1, max(3 * n, n_lasting + n + SPARE))
    operator = scipy.sparse.linalg.LinearOperator((size, size), matvec=monodromy.apply_scaled, dtype=float)
    # Any vector to start from, but the same each time.
    start = np.random.default_rng(1).standard_normal(size)
    values, vectors, _ = find_largest(operator, n, n_vectors=n_vectors, start=start, tol=0.0, max_restarts=MAX_RESTARTS)
    order = np.argsort(-np.abs(values), kind="stable")
    return values[order], vectors[:, order]


def is_mapped_whole(monodromy: MonodromyOperator, n: int) -> bool:
    """Return whether all eigenvalues of a map are computed where ``n`` are wanted."""
    return monodromy.size <= max(DENSE_LINES if monodromy.couplings else DENSE, n + 2)


def is_deep(monodromy: MonodromyOperator) -> bool:
    """Return whether a map is that of a long history, of many periods, whose eigenvalues say little."""
    return len(monodromy.kept) > DEEP and monodromy.size > DENSE


def _sort(values: Complex) -> Complex:
    return np.asarray(values[np.argsort(-np.abs(values), kind="stable")])
