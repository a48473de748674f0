"""Whether what solves a system does so to rounding: tried with a right-hand side of random numbers.

Reference: Dixon, SIAM J. Numer. Anal. 20 (1983), for norms from random vectors.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# What is left of the equations, relative to the solutions, where rounding has not grown.
LEFT = 1e-13


def solves(matrix: Any, solve: Callable[[Array], Array], *, largest: float = np.inf, sums: Array | float = 1.0) -> bool:
    """Return whether ``solve`` leaves no more than rounding of a square system with largest entries of modulus 1.

    Nor is its solution for random numbers larger than ``largest``. ``sums`` (n,) are those of the moduli in each row,
    where rows hold so many entries that what is left of them is their sums' own rounding.
    """
    trial = _draw(matrix.shape[0])
    with np.errstate(all="ignore"):
        x = solve(trial)
        left, size = np.max(np.abs(matrix @ x - trial) / sums), np.abs(x).max()
    return bool(left <= LEFT * size and size <= largest)


@cache
def _draw(n: int) -> Array:
    """Return random numbers, shape (n,), the same each time."""
    return np.random.default_rng(3).standard_normal(n)
