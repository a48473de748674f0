"""Characteristic roots against Lambert's function, polynomials, and the solution operator of random systems."""

import math

import numpy as np
import pytest
from scipy.special import lambertw

from pddecont.delay import Chain, Chebyshev
from pddecont.equilibrium import find_roots
from pddecont.equilibrium.counting import count_missing
from tests.equilibrium.linear_systems import draw, find_multipliers, make_matrix


def scalar_roots(a, b, tau, n=40):
    """Return the roots of lambda = a + b exp(-lambda tau) by falling real part."""
    values = np.array([a + lambertw(b * tau * np.exp(-a * tau), k) / tau for k in range(-n, n)])
    return values[np.argsort(-values.real)]


@pytest.mark.parametrize(
    ("a", "b", "tau"), [(0.0, -1.6, 1.0), (-1.0, -2.0, 5.0), (-1.0, -0.5, 1.0), (0.3, -0.2, 1000.0), (-1.0, 0.9, 300.0)]
)
def test_roots_of_one_state_are_those_of_lambert(a, b, tau):
    roots = find_roots(make_matrix([[a]], [[[b]]], [tau]))
    exact = scalar_roots(a, b, tau)
    assert roots.counted and roots.n_unstable == np.sum(exact.real > 0)
    for k, z in enumerate(roots.values[:10]):
        assert np.min(np.abs(exact - z)) < 1e-13 * (1 + abs(z))
        # None is left out: real parts fall as those of the closed form.
        assert z.real == pytest.approx(exact[k].real, abs=1e-11)
    assert np.max(roots.residuals) < 1e-13


def test_at_a_hopf_point_the_pair_lies_on_the_axis():
    roots = find_roots(make_matrix([[0.0]], [[[-math.pi / 2]]], [1.0]))
    assert roots.values[0] == pytest.approx(0.5j * math.pi, abs=1e-14)
    assert roots.n_missing == 0


def test_a_double_root_counts_twice():
    """lambda + a = b exp(-lambda) has a double root where b = -exp(-a - 1), at -a - 1."""
    roots = find_roots(make_matrix([[0.5]], [[[-math.exp(-0.5)]]], [1.0]))
    near = np.abs(roots.values + 0.5 - 0.0) < 1e-5
    assert np.sum(near) == 2


def test_where_all_derivatives_are_zero_all_roots_are():
    """As at the cusp of an equation of one state."""
    roots = find_roots(make_matrix([[0.0]], [[[0.0]]], [0.4]))
    assert roots.values.tolist() == [0.0] and roots.counted and roots.n_unstable == 0


def test_without_delays_they_are_the_eigenvalues():
    rng = np.random.default_rng(3)
    present = rng.normal(size=(7, 7))
    roots = find_roots(make_matrix(present, [], []))
    exact = np.linalg.eigvals(present)
    assert len(roots.values) == 7
    assert all(np.min(np.abs(exact - z)) < 1e-12 for z in roots.values)


def test_a_chain_has_the_roots_of_its_own_ordinary_equations():
    """n steps of the first order: lambda = a + b / (1 + lambda tau / n)^n, a polynomial."""
    a, b, tau, n = -0.3, -1.2, 2.0, 5
    one = np.polynomial.Polynomial([1.0, tau / n]) ** n
    exact = (np.polynomial.Polynomial([-a, 1.0]) * one - b).roots()
    roots = find_roots(make_matrix([[a]], [[[b]]], [tau], Chain(1, n)))
    assert len(roots.values) == n + 1
    assert all(np.min(np.abs(exact - z)) < 1e-11 for z in roots.values)


def test_the_chebyshev_line_comes_to_the_roots_of_the_delay():
    exact = scalar_roots(-1.0, -2.0, 5.0)
    errors = []
    for n in (4, 8, 16):
        roots = find_roots(make_matrix([[-1.0]], [[[-2.0]]], [5.0], Chebyshev(n)))
        errors.append(np.min(np.abs(exact[0] - roots.values)))
    assert errors[0] > errors[1] > errors[2] and errors[2] < 1e-14


@pytest.mark.parametrize("seed", range(12))
def test_no_unstable_root_is_missed(seed):
    check_random(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12, 500))
def test_no_unstable_root_is_missed_in_more_systems(seed):
    check_random(seed)


def check_random(seed):
    """Compare the unstable roots of a random system with the multipliers of its solution operator."""
    matrix = draw(seed)
    roots = find_roots(matrix)
    multipliers = find_multipliers(matrix)
    longest = float(np.max(matrix.delays))
    sizes = np.abs(multipliers)
    assert roots.counted
    assert roots.n_unstable == np.sum(sizes > 1.0)
    for z in roots.values[roots.values.real > -0.2 / longest]:
        expected = np.exp(z * longest)
        assert np.min(np.abs(multipliers - expected)) < 1e-6 * max(1.0, abs(expected))


def test_a_root_left_out_of_the_list_is_counted():
    matrix = make_matrix([[-1.0]], [[[-2.0]]], [5.0])
    values = find_roots(matrix).values
    assert count_missing(matrix, values).number == 0
    pair = values[2:]
    missing = count_missing(matrix, pair)
    assert missing.number == 2
    assert np.min(np.abs(missing.places - values[0])) < 0.2
