"""All zeros in a box, of equations whose zeros are known."""

import itertools

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.intervals import Enclosure, find_zeros

X, Y, Z, R = sympy.symbols("x y z r", real=True)


def search(exprs, symbols, box, constants=None, **options):
    """Return the zeros of equations in a box: the lowest and highest value of each unknown."""
    low, high = np.array(box, dtype=float).T
    return find_zeros(Enclosure(tuple(exprs), tuple(symbols), constants or {}), low, high, high - low, **options)


def check_all(zeros, expected, error=1e-13):
    """Check that exactly these zeros were found, to this error, and that these are known to be all."""
    assert len(zeros.undecided) == 0
    left = [np.array(e, dtype=float) for e in expected]
    assert len(zeros.points) == len(left)
    for point in zeros.points:
        near = [k for k, e in enumerate(left) if np.allclose(point, e, rtol=error, atol=error)]
        assert len(near) == 1
        del left[near[0]]


def test_three_equilibria_of_lorenz():
    exprs = [10 * (Y - X), X * (28 - Z) - Y, X * Y - R * Z]
    root = np.sqrt(27 * 8 / 3)
    check_all(search(exprs, (X, Y, Z), [(-30, 30)] * 3, {R: 8 / 3}), [(0, 0, 0), (root, root, 27), (-root, -root, 27)])


def test_nine_zeros_of_two_cubics():
    check_all(search([X**3 - X, Y**3 - Y], (X, Y), [(-2, 2)] * 2), itertools.product((-1, 0, 1), repeat=2))


def test_zeros_of_a_sine_with_two_on_the_edges():
    check_all(search([sympy.sin(sympy.pi * X)], (X,), [(0, 20)]), [(k,) for k in range(21)])


def test_zeros_at_the_corner_and_on_an_edge_of_the_box():
    """Predators and prey, of which there are none at two of the three."""
    h, m = 0.3, 0.5
    exprs = [X * (1 - X) - X * Y / (h + X), Y * (X / (h + X) - m)]
    star = h * m / (1 - m)
    check_all(search(exprs, (X, Y), [(0, 2)] * 2), [(0, 0), (1, 0), (star, (1 - star) * (h + star))])


def test_a_zero_where_the_equation_ends():
    """x**2.5 has no value below zero."""
    check_all(search([2 * X / (1 + X**2.5) - X], (X,), [(0, 3)]), [(0,), (1,)])


@pytest.mark.parametrize(
    ("exprs", "box"),
    [
        ([X**2 + Y**2 + 1, X - Y], [(-5, 5)] * 2),
        ([X**2 + Y**2 - 1, X + Y - 1.42], [(-5, 5)] * 2),
        ([X**2 + Y**2 - 1, X + Y - 1], [(2, 5)] * 2),
        ([sympy.log(X) + Y, X + 1 + Y**2], [(-5, 5)] * 2),
    ],
)
def test_it_is_sure_that_there_is_none(exprs, box):
    check_all(search(exprs, (X, Y), box), [])


@pytest.mark.parametrize("expr", [(X - 0.3) ** 2, X**2 - 0.6 * X + 0.09, (X - 0.3) ** 3])
def test_a_multiple_zero_is_undecided(expr):
    zeros = search([expr], (X,), [(-1, 1)])
    assert len(zeros.points) == 0
    assert len(zeros.undecided) == 1
    assert zeros.undecided.low[0, 0] <= 0.3 <= zeros.undecided.high[0, 0]
    assert zeros.undecided.widths[0, 0] < 1e-4


def test_a_line_of_zeros_is_undecided_and_others_are_found():
    """Zeros: the line x = y at z = 0, and the point (1, -1, 1)."""
    exprs = [Z * (1 - Z), (X - Y) * (1 - Z) + Z * (X - 1), 2 * (X - Y) * (1 - Z) + Z * (Y + 1)]
    zeros = search(exprs, (X, Y, Z), [(-2, 2)] * 3)
    assert np.allclose(zeros.points, [[1, -1, 1]], atol=1e-13)
    low, high = zeros.undecided.low.min(axis=1), zeros.undecided.high.max(axis=1)
    assert np.allclose(low, [-2, -2, 0], atol=1e-6)
    assert np.allclose(high, [2, 2, 0], atol=1e-6)


def test_what_the_budget_does_not_reach_is_undecided():
    zeros = search([sympy.sin(50 * X) * sympy.cos(37 * Y), sympy.sin(X * Y)], (X, Y), [(1, 9)] * 2, budget=500)
    assert zeros.n_examined < 4000
    assert len(zeros.undecided) >= 1


def test_units_do_not_matter():
    """The same equations in units of 1e-12 and 1e9."""
    exprs = [(X * 1e12) ** 3 - X * 1e12, Y / 1e9 - 1 + X * 1e12 / 2]
    zeros = search(exprs, (X, Y), [(-2e-12, 2e-12), (-2e9, 2e9)])
    assert len(zeros.undecided) == 0
    assert np.allclose(np.sort(zeros.points[:, 0] * 1e12), [-1, 0, 1], atol=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.sets(st.integers(-9, 9), max_size=5), st.integers(1, 3))
def test_written_out_polynomials_lose_no_zero(roots, factor):
    """The product of (x - r/2) and of x^2 + 1, expanded; errors of its terms move a zero by as much over p'."""
    expr = sympy.expand(factor * (X**2 + 1) * sympy.prod(X - sympy.Rational(r, 2) for r in roots))
    polynomial = np.polynomial.Polynomial([float(c) for c in reversed(sympy.Poly(expr, X).all_coeffs())])
    terms = np.polynomial.Polynomial(np.abs(polynomial.coef))
    condition = max((abs(terms(abs(r / 2)) / polynomial.deriv()(r / 2)) for r in roots), default=1.0)
    error = 16 * np.finfo(float).eps * max(condition, 1.0)
    check_all(search([expr], (X,), [(-5, 5)]), [(r / 2,) for r in roots], error)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_newton_from_many_guesses_finds_no_other_zero(seed):
    """Two random equations with waves in them; Newton's method from 300 guesses finds a part of the zeros."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(2, 6))
    exprs = [k[0] + k[1] * X + k[2] * Y + k[3] * sympy.sin(2 * X + k[4]) + k[5] * sympy.cos(X * Y) for k in a.tolist()]
    zeros = search(exprs, (X, Y), [(-2, 2)] * 2)
    f, d = sympy.lambdify((X, Y), exprs), sympy.lambdify((X, Y), sympy.Matrix(exprs).jacobian((X, Y)))
    for guess in rng.uniform(-2, 2, (300, 2)):
        at, step = guess, np.ones(2)
        for _ in range(30):
            step = np.linalg.solve(d(*at) + 1e-300 * np.eye(2), f(*at))
            at = at - step
            if np.max(np.abs(step)) < 1e-13 or np.max(np.abs(at)) > 10:
                break
        if np.max(np.abs(step)) < 1e-10 and np.max(np.abs(at)) < 2 - 1e-9:
            near = np.min(np.max(np.abs(zeros.points - at), axis=1), initial=np.inf)
            inside = np.any(np.all((at >= zeros.undecided.low.T) & (at <= zeros.undecided.high.T), axis=1))
            assert near < 1e-9 or inside
    assert np.allclose([f(*point) for point in zeros.points], 0.0, atol=1e-10)
