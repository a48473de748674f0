"""Elimination in the order of time against full matrices, and where it is refused."""

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.continuation import TimeOrder, equilibrate
from pddecont.continuation.time_order import WIDEST, factor_in_time
from pddecont.continuation.trial import LARGEST


def make_order(sizes, n_border=1):
    """Return the order of a matrix whose blocks stand one after the other, with a border behind them."""
    first = np.cumsum([0, *sizes[:-1]])
    return TimeOrder(first, first, np.array(sizes), sum(sizes) + n_border)


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def draw(rng, sizes, n_border, wrapped):
    """Return a random matrix of blocks with a border, and with columns ``wrapped`` that earlier blocks hold too."""
    n = sum(sizes) + n_border
    matrix, first = rng.normal(size=(n, n)), 0
    for size in sizes:
        behind = [c for c in range(first + size, sum(sizes)) if c not in wrapped]
        matrix[np.ix_(range(first, first + size), behind)] = 0.0
        first += size
    return matrix


def check(found, matrix, right):
    """Check a solution against that of the full matrix: as exact as its condition lets it be."""
    expected = np.linalg.solve(matrix, right)
    assert np.max(np.abs(found - expected)) < 1e-14 * np.linalg.cond(matrix) * np.max(np.abs(expected))


@pytest.mark.parametrize("wrapped", [(), (8,), (2, 7, 8)])
@pytest.mark.parametrize("n_border", [0, 1, 3])
def test_solutions_are_those_of_the_full_matrix(rng, wrapped, n_border):
    sizes = (2, 4, 3)
    matrix = draw(rng, sizes, n_border, wrapped)
    # A zero where the first pivot of a block would be.
    matrix[2, 2] = 0.0
    solve = factor_in_time(sp.csc_matrix(matrix), make_order(sizes, n_border))
    for right in (rng.normal(size=len(matrix)), rng.normal(size=(len(matrix), 4))):
        kept = right.copy()
        check(solve(right), matrix, right)
        assert np.array_equal(right, kept)


def test_blocks_may_stand_in_any_order(rng):
    """The first block in time stands in the middle, the border in front."""
    sizes = (2, 4, 3)
    order = TimeOrder(np.array([5, 1, 7]), np.array([8, 4, 1]), np.array(sizes), 10)
    rows, columns = (
        [*(k for s, n in zip(first, sizes, strict=True) for k in range(s, s + n)), 0]
        for first in (order.rows, order.columns)
    )
    matrix = np.zeros((10, 10))
    matrix[np.ix_(rows, columns)] = draw(rng, sizes, 1, (5,))
    right = rng.normal(size=10)
    check(factor_in_time(sp.csc_matrix(matrix), order)(right), matrix, right)


def test_growth_is_seen_and_another_factorisation_taken():
    """A small pivot that a border makes good: the equations regular, solved block by block they lose all digits."""
    matrix = np.array([[1e-17, 0.0, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]])
    right, order = np.array([1.0, 2.0, 3.0]), make_order((1, 1))
    assert np.linalg.cond(matrix) < 10
    assert factor_in_time(sp.csc_matrix(matrix), order) is None
    found = equilibrate(sp.csc_matrix(matrix)).factor(order).solve(right)
    assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-14)
    matrix[0, 0] = 0.5
    assert factor_in_time(sp.csc_matrix(matrix), order)(right) == pytest.approx(
        np.linalg.solve(matrix, right), rel=1e-14
    )


@pytest.mark.parametrize("small", [1e-3, 1e-9])
def test_nearly_singular_equations_are_left_to_another_factorisation(small):
    matrix = np.diag([1.0, 1.0, small])
    assert (factor_in_time(sp.csc_matrix(matrix), make_order((1, 1))) is None) == (small < 1.0 / LARGEST)


@pytest.mark.parametrize("place", [(0, 0), (2, 2)])
def test_singular_equations_are_refused(place):
    matrix = np.eye(3)
    matrix[place] = 0.0
    assert factor_in_time(sp.csc_matrix(matrix), make_order((1, 1))) is None


@pytest.mark.parametrize("wide", [False, True])
def test_a_wide_border_is_left_to_another_factorisation(rng, wide):
    n = WIDEST + wide
    order = make_order((1,), n)
    matrix = sp.csc_matrix(np.eye(n + 1) + 0.01 * rng.normal(size=(n + 1, n + 1)))
    assert (factor_in_time(matrix, order) is None) == wide
    right = rng.normal(size=n + 1)
    assert equilibrate(matrix).factor(order).solve(right) == pytest.approx(
        np.linalg.solve(matrix.toarray(), right), rel=1e-9, abs=1e-11
    )
