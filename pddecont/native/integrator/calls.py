"""What compiled functions call that is not theirs: a model's functions, and pointers into arrays.

Compiled, these are a call by an address and an addition to a pointer (calls.pxi); here they are what Python does for
the same, so that every function of the integrator runs as plain Python too. A model's functions have the signature
``void f(which, t, x, xd, p, out)``: ``which`` numbers the mode, event or reset.
"""

from __future__ import annotations

import ctypes

from pddecont.native.arrays import Floats, Integers

_POINTER = ctypes.POINTER(ctypes.c_double)
_SIGNATURE = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_double, *[_POINTER] * 4)


def call(address: int, which: int, t: float, x: Floats, xd: Floats, p: Floats, out: Floats) -> None:
    """Call the function of a model at ``address``; it writes to ``out``."""
    _SIGNATURE(int(address))(int(which), t, *(a.ctypes.data_as(_POINTER) for a in (x, xd, p, out)))


def offset(numbers: Floats, count: int) -> Floats:
    """Return the numbers from number ``count`` on."""
    return numbers[count:]


def factorise(matrix: Floats, pivots: Integers, n: int) -> bool:
    """Write the factors of a matrix (n, n) in its place, and the rows that they exchange; return whether it has any."""
    import numpy as np
    import scipy.linalg

    square = matrix[: n * n].reshape(n, n)
    try:
        factors, rows = scipy.linalg.lu_factor(square, check_finite=False)
    except np.linalg.LinAlgError:
        return False
    square[:], pivots[:n] = factors, rows
    return bool(np.all(np.diag(factors) != 0.0))


def solve_factorised(matrix: Floats, pivots: Integers, n: int, right: Floats) -> None:
    """Write the solution of the linear system with a matrix that :func:`factorise` left in the place of its right."""
    import scipy.linalg

    right[:n] = scipy.linalg.lu_solve((matrix[: n * n].reshape(n, n), pivots[:n]), right[:n], check_finite=False)
