"""Zeros to rounding with few values, also where a function bends, is flat or jumps."""

import math

import pytest

from pddecont.continuation.secants import find_zero_between


def find(function, low, high, tol=1e-13):
    """Return the zero that is found, the value there, and how many values it took."""
    places = []

    def value(x):
        places.append(x)
        return function(x)

    found = find_zero_between(value, low, high, function(low), function(high), tol)
    assert all(low < x < high for x in places)
    return *found, len(places)


@pytest.mark.parametrize(
    ("function", "low", "high", "zero", "most"),
    [
        (lambda x: 3.0 * x - 1.0, 0.0, 1.0, 1 / 3, 2),
        (math.cos, 0.0, 2.0, math.pi / 2, 7),
        (lambda x: math.exp(5 * x) - 2.0, 0.0, 1.0, math.log(2.0) / 5, 16),
        (lambda x: x**3 - 1e-9, -1.0, 1.0, 1e-3, 40),
        (lambda x: (x - 0.3) ** 9, 0.0, 1.0, 0.3, 110),
        (lambda x: math.copysign(abs(x - 0.7) ** 0.5, x - 0.7), 0.0, 1.0, 0.7, 60),
    ],
)
def test_a_zero_is_found(function, low, high, zero, most):
    x, value, n = find(function, low, high)
    assert value == function(x)
    assert x == pytest.approx(zero, abs=1e-12 if most < 100 else 1e-3)
    assert n <= most
    back, _, _ = find(lambda x: -function(-x), -high, -low)
    assert back == pytest.approx(-x, abs=1e-12 if most < 100 else 1e-3)


def test_a_jump_through_zero_is_come_near_to():
    x, value, n = find(lambda x: -1.0 if x < 0.3 else 2.0, 0.0, 1.0)
    assert x == pytest.approx(0.3, abs=1e-12)
    assert abs(value) >= 1.0
    assert n < 100


def test_an_end_that_is_zero_is_the_zero():
    assert find_zero_between(math.sin, 0.0, 1.0, 0.0, 1.0, 1e-13) == (0.0, 0.0)
    assert find_zero_between(math.sin, -1.0, 0.0, -1.0, 0.0, 1e-13) == (0.0, 0.0)
