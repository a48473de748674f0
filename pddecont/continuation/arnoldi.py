"""Some eigenvalues of an operator by ARPACK, to the same last bit every time.

Reference: Lehoucq, Sorensen, Yang, ARPACK Users' Guide (1998).
"""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import scipy.sparse.linalg
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
# Upon an invariant subspace it begins again with numbers drawn by chance, which newer versions let one choose.
TAKES_NUMBERS = "rng" in inspect.signature(scipy.sparse.linalg.eigs).parameters


def find_largest(
    operator: Any, k: int, *, n_vectors: int, start: NDArray[Any], tol: float, max_restarts: int | None = None
) -> tuple[Complex, Complex, bool]:
    """Return ``k`` eigenvalues of largest modulus, their vectors as columns, and whether as many were found.

    ``n_vectors`` is how many vectors are kept, ``start`` the first one.
    """
    options: dict[str, Any] = {"rng": np.random.default_rng(0)} if TAKES_NUMBERS else {}
    try:
        values, vectors = scipy.sparse.linalg.eigs(
            operator, k=k, ncv=n_vectors, v0=start, tol=tol, maxiter=max_restarts, **options
        )
    except scipy.sparse.linalg.ArpackNoConvergence as exc:
        return exc.eigenvalues, exc.eigenvectors, False
    return values, vectors, True
