"""What is called by its address, and linear systems, as plain Python does them."""

import ctypes

import numpy as np
import pytest

from pddecont.native import calls
from pddecont.native.integrator.calls import factorise, solve_factorised

POINTER = ctypes.POINTER(ctypes.c_double)


def test_numbers_from_a_place_on_are_those_of_the_array():
    numbers = np.arange(5.0)
    calls.offset(numbers, 2)[0] = 7.0
    assert list(numbers) == [0, 1, 7, 3, 4]


def test_a_function_is_called_by_its_address():
    @ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_double, *[POINTER] * 4)
    def function(which, t, x, xd, p, out):
        out[0], out[1] = which + 10 * t, x[1] + 100 * xd[0] + 10000 * p[2]

    out = np.zeros(2)
    address = ctypes.cast(function, ctypes.c_void_p).value
    calls.call(address, 3, 0.5, np.array([1.0, 2.0]), np.array([3.0]), np.array([0.0, 0.0, 4.0]), out)
    assert list(out) == [8.0, 40302.0]


def test_a_linear_system_is_solved_in_place():
    rng = np.random.default_rng(0)
    matrix, right, pivots = rng.normal(size=(4, 4)), rng.normal(size=4), np.zeros(4, np.int64)
    factors, solution = matrix.ravel().copy(), right.copy()
    assert factorise(factors, pivots, 4)
    solve_factorised(factors, pivots, 4, solution)
    assert matrix @ solution == pytest.approx(right, abs=1e-13)


@pytest.mark.filterwarnings("ignore")
def test_a_singular_matrix_has_no_factors():
    assert not factorise(np.zeros(9), np.zeros(3, np.int64), 3)
