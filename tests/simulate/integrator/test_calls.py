"""Machine code calls functions by address and reads arrays by pointer."""

import ctypes

import numba
import numpy as np

from pddecont.simulate.integrator.calls import call, offset, pointer

POINTER = ctypes.POINTER(ctypes.c_double)


@numba.njit
def shifted_sum(array, start, n):
    p, total = offset(pointer(array), start), 0
    for i in range(n):
        total += p[i]
    p[0] = 7
    return total


def test_a_pointer_reads_and_writes_the_array_from_its_offset():
    for array in (np.arange(10.0), np.arange(10)):
        assert shifted_sum(array, 3, 4) == 3 + 4 + 5 + 6
        assert list(array[:5]) == [0, 1, 2, 7, 4]


@numba.njit
def call_at(address, which, t, x, xd, p, out):
    call(address, which, t, pointer(x), pointer(xd), pointer(p), pointer(out))


def test_a_function_is_called_by_its_address():
    @ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_double, *[POINTER] * 4)
    def function(which, t, x, xd, p, out):
        out[0], out[1] = which + 10 * t, x[1] + 100 * xd[0] + 10000 * p[2]

    out = np.zeros(2)
    address = ctypes.cast(function, ctypes.c_void_p).value
    call_at(address, 3, 0.5, np.array([1.0, 2.0]), np.array([3.0]), np.array([0.0, 0.0, 4.0]), out)
    assert list(out) == [8.0, 40302.0]
