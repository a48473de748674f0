"""Roots of large systems: their number and places in closed form."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.special import lambertw

from pddecont.delay import Direct
from pddecont.equilibrium import CharacteristicMatrix, find_roots

A, B, TAU = 0.5, -2.2, 1.5


def make_ring(n):
    """Return x_k' = -x_k + A x_(k-1)(t - TAU) + B x_(k+1)(t - TAU) on a ring, and all its roots far to the right.

    The wave exp(i theta k) has lambda = -1 + (A exp(-i theta) + B exp(i theta)) exp(-lambda TAU).
    """
    back = sp.csc_matrix(np.roll(np.eye(n), 1, axis=0))
    theta = 2.0 * np.pi * np.arange(n) / n
    through = A * np.exp(-1j * theta) + B * np.exp(1j * theta)
    exact = np.array([-1.0 + lambertw(c * TAU * np.exp(TAU), k) / TAU for c in through for k in range(-6, 6)])
    parts = (-sp.eye(n, format="csc"), A * back + B * back.T)
    return parts, exact


def make_rod(n, feedback=-2.5, delay=1.7):
    """Return the heat equation u_t = u_xx + u/2 + feedback u(t - delay) on (0, pi), and its roots on the slow modes."""
    step = np.pi / (n + 1)
    second = sp.diags([np.ones(n - 1), -2.0 * np.ones(n), np.ones(n - 1)], [-1, 0, 1], format="csc") / step**2
    slow = 0.5 - (2.0 - 2.0 * np.cos(np.arange(1, 9) * step)) / step**2
    exact = [a + lambertw(feedback * delay * np.exp(-a * delay), k) / delay for a in slow for k in range(-6, 6)]
    return (second + 0.5 * sp.eye(n, format="csc"), feedback * sp.eye(n, format="csc")), np.array(exact), delay


def find(parts, delay):
    present, delayed = parts
    if present.shape[0] <= 120:
        present, delayed = present.toarray(), delayed.toarray()
    return find_roots(CharacteristicMatrix(present, (delayed,), np.array([delay]), Direct()))


@pytest.mark.parametrize("n", [30, 100, 200])
def test_all_unstable_roots_of_a_ring_are_found_and_counted(n):
    """Two thirds of them and more are unstable, and their determinant turns hundreds of times along the axis."""
    parts, exact = make_ring(n)
    roots = find(parts, TAU)
    assert roots.counted
    assert roots.n_unstable == np.sum(exact.real > 0.0) > n
    assert max(np.min(np.abs(exact - z)) for z in roots.values) < 1e-13


@pytest.mark.parametrize("n", [20, 200])
def test_fast_modes_that_die_out_do_not_hide_slow_ones(n):
    """The bound of the modulus grows with n^2; what is unstable lies below the feedback alone."""
    parts, exact, delay = make_rod(n)
    roots = find(parts, delay)
    assert roots.counted
    assert roots.n_unstable == 2
    leading = roots.values[np.argsort(-roots.values.real)][:6]
    expected = exact[np.argsort(-exact.real)][:6]
    assert np.allclose(np.sort_complex(leading), np.sort_complex(expected), rtol=0, atol=1e-11 * n)


@pytest.mark.slow
def test_a_thousand_states():
    parts, exact, delay = make_rod(1000)
    roots = find(parts, delay)
    assert roots.counted
    assert roots.n_unstable == 2
    assert max(np.min(np.abs(exact - z)) for z in roots.values) < 1e-10


def neutral(c, b, delay):
    """Return x' = c x'(t - delay) + b x(t - delay) as a characteristic matrix."""
    one = np.ones((1, 1))
    return CharacteristicMatrix(
        0.0 * one, (c * one, b * one), np.array([delay, delay]), Direct(), np.array([1, 0], dtype=np.intp)
    )


@pytest.mark.parametrize(("c", "b", "unstable"), [(0.5, -0.7, 0), (0.5, -2.0, 2), (0.2, -8.0, 4), (-0.6, 0.4, 1)])
def test_roots_of_a_neutral_equation_are_counted(c, b, unstable):
    """lambda (1 - c exp(-lambda)) = b exp(-lambda): pairs cross where cos w = c, b = -w sin w."""
    roots = find_roots(neutral(c, b, 1.0))
    assert roots.counted
    assert roots.n_unstable == unstable
    for z in roots.values:
        assert abs(z * (1.0 - c * np.exp(-z)) - b * np.exp(-z)) < 1e-12 * (
            1.0 + abs(np.exp(-z)) * (abs(b) + abs(c * z))
        )


def test_no_count_is_claimed_where_infinitely_many_roots_may_be_unstable():
    assert find_roots(neutral(1.2, -0.5, 1.0)).n_missing is None
