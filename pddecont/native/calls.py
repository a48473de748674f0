"""What compiled functions call that is not theirs: a model's functions, and pointers into arrays.

Compiled, these are a call by an address and an addition to a pointer (calls.pxi); here they are what Python does for
the same, so that every compiled function runs as plain Python too. A model's functions have the signature
``void f(which, t, x, xd, p, out)``: ``which`` numbers the mode, event or reset.
"""

from __future__ import annotations

import ctypes

from pddecont.native.arrays import Floats

_POINTER = ctypes.POINTER(ctypes.c_double)
_SIGNATURE = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_double, *[_POINTER] * 4)


def call(address: int, which: int, t: float, x: Floats, xd: Floats, p: Floats, out: Floats) -> None:
    """Call the function of a model at ``address``; it writes to ``out``."""
    _SIGNATURE(int(address))(int(which), t, *(a.ctypes.data_as(_POINTER) for a in (x, xd, p, out)))


def offset(numbers: Floats, count: int) -> Floats:
    """Return the numbers from number ``count`` on."""
    return numbers[count:]
