"""Interpolation, slopes and quadrature on the reference interval are exact for the polynomials they should be."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import make_basis


@pytest.mark.parametrize("degree", range(1, 15))
def test_polynomials_of_the_degree_are_exact(degree):
    basis = make_basis(degree)
    for k in range(degree + 1):
        values = basis.base**k
        assert basis.values @ values == pytest.approx(basis.nodes**k, abs=1e-13)
        slope = k * basis.nodes ** (k - 1) if k else np.zeros(degree)
        assert basis.slopes @ values == pytest.approx(slope, abs=1e-11)
        slope = k * basis.base ** (k - 1) if k else np.zeros(degree + 1)
        assert basis.differentiate @ values == pytest.approx(slope, abs=1e-11)
        assert basis.lagrange(np.array([0.3, 1.0])) @ values == pytest.approx([0.3**k, 1.0], abs=1e-13)


@pytest.mark.parametrize("degree", range(1, 12))
def test_gauss_weights_are_exact_to_twice_the_degree(degree):
    basis = make_basis(degree)
    for k in range(2 * degree):
        assert basis.weights @ basis.nodes**k == pytest.approx(1 / (k + 1), abs=1e-14)


@pytest.mark.parametrize("degree", range(1, 6))
def test_gauss_weights_are_exact_no_further(degree):
    """The error for sigma^(2m) is (m!)^4 / ((2m + 1) (2m)!^2)."""
    basis = make_basis(degree)
    left = 1 / (2 * degree + 1) - basis.weights @ basis.nodes ** (2 * degree)
    exact = math.factorial(degree) ** 4 / ((2 * degree + 1) * math.factorial(2 * degree) ** 2)
    assert left == pytest.approx(exact, rel=1e-6, abs=1e-15)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(degree=st.integers(1, 12), sigma=st.floats(0.0, 1.0))
def test_the_basis_polynomials_sum_to_one_and_their_moduli_to_little_more(degree, sigma):
    """The Lebesgue constant of m + 1 Chebyshev points is at most 2/pi log(m + 1) + 1.

    Reference: Trefethen, Approximation Theory and Approximation Practice (2013), theorem 15.2.
    """
    weights = make_basis(degree).lagrange(np.array(sigma))
    assert np.sum(weights) == pytest.approx(1.0, abs=1e-12)
    assert np.sum(np.abs(weights)) <= 2 / math.pi * math.log(degree + 1) + 1 + 1e-12


@pytest.mark.parametrize("near", [0.0, 5e-324, 1e-310, 2e-308, 1e-300])
def test_near_a_base_point_the_value_is_its_own(near):
    """One over the smallest distances overflows; the value there is the base point's all the same."""
    basis = make_basis(4)
    assert basis.lagrange(np.array([near])) == pytest.approx(np.eye(5)[:1], abs=1e-290)


def test_base_points_are_the_ends_and_chebyshev_extrema():
    basis = make_basis(4)
    assert basis.base == pytest.approx([0, 0.5 - math.sqrt(0.125), 0.5, 0.5 + math.sqrt(0.125), 1])
    assert np.array_equal(basis.lagrange(basis.base), np.eye(5))
    # A shape of its own goes in front.
    assert basis.lagrange(np.zeros((2, 3))).shape == (2, 3, 5)
    assert make_basis(4) is basis
