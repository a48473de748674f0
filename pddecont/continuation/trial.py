"""Whether what solves a system does so to rounding: tried with a right-hand side of random numbers.

Reference: Dixon, SIAM J. Numer. Anal. 20 (1983), for norms from random vectors.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# What is left of the equations, relative to the solutions, where rounding has not grown.
LEFT = 1e-13
# How large solutions for a right-hand side of random numbers are at most. Beyond that equations are nearly singular, as
# where many segments are about to vanish, and pivots sought in the whole matrix keep small unknowns apart.
LARGEST = 1e6


def solves(matrix: Any, solve: Callable[[Array], Array], *, sums: Array | float = 1.0) -> bool:
    """Return whether ``solve`` leaves no more than rounding of a square system that is not nearly singular.

    Its rows have entries of modulus 1 at most. ``sums`` (n,) are those of the moduli in each row, where rows hold so
    many entries that what is left of them is their sums' own rounding.
    """
    trial = _draw(matrix.shape[0])
    with np.errstate(all="ignore"):
        x = solve(trial)
        left, size = np.max(np.abs(matrix @ x - trial) / sums), np.abs(x).max()
    return bool(left <= LEFT * size and size <= LARGEST)


@lru_cache(maxsize=64)
def _draw(n: int) -> Array:
    """Return random numbers, shape (n,), the same each time."""
    return np.random.default_rng(3).standard_normal(n)
