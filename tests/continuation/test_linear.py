"""Scaled factorisations, dense and sparse, against NumPy's."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.continuation import add_row, equilibrate, factor, linear, scale_matrix
from pddecont.continuation.linear import row_maxima
from pddecont.errors import ConvergenceError

KINDS = pytest.mark.parametrize("make", [np.array, sp.csc_matrix], ids=["dense", "sparse"])


def dense(matrix):
    return matrix.toarray() if sp.issparse(matrix) else matrix


@st.composite
def matrices(draw):
    """Matrices with some entries left out and rows of any size."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    shape = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    values = rng.standard_normal(shape) * (rng.random(shape) < draw(st.floats(0.2, 1.0)))
    return values * 10.0 ** rng.integers(-8, 9, (shape[0], 1))


@settings(max_examples=50, deadline=None, derandomize=True)
@given(matrices(), st.booleans(), st.integers(0, 10**6))
def test_equilibrated_rows_have_a_largest_entry_of_one(matrix, sparse, seed):
    columns = 10.0 ** np.random.default_rng(seed).integers(-6, 7, matrix.shape[1])
    found = equilibrate(sp.csc_matrix(matrix) if sparse else matrix, columns)
    largest = np.max(np.abs(dense(found.matrix)), axis=1)
    assert np.all((np.abs(largest - 1.0) < 1e-12) | ~np.any(matrix, axis=1))
    assert found.rows[:, None] * matrix * columns == pytest.approx(dense(found.matrix), rel=1e-12, abs=1e-300)
    # A row of zeros stays one, and keeps the scale 1.
    assert np.all(found.rows[~np.any(matrix, axis=1)] == 1.0)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(matrices(), st.integers(0, 10**6))
def test_a_row_is_added_below_every_column(matrix, seed):
    row = np.random.default_rng(seed).standard_normal(matrix.shape[1])
    row[::3] = 0.0
    whole = np.vstack([matrix, row])
    assert np.array_equal(add_row(matrix, row), whole)
    added = add_row(sp.csc_matrix(matrix), row)
    assert np.array_equal(added.toarray(), whole)
    # Places are kept in order, and each entry of the row has one, zero or not: the pattern does not depend on it.
    assert added.nnz == sp.csc_matrix(matrix).nnz + matrix.shape[1]
    assert added.has_sorted_indices
    again = add_row(added, row)
    assert np.array_equal(again.toarray(), np.vstack([whole, row]))


@KINDS
def test_factors_solve_for_one_and_for_several_right_sides(make):
    rng = np.random.default_rng(3)
    matrix = rng.standard_normal((7, 7)) * 10.0 ** rng.integers(-9, 10, (7, 1)) * 10.0 ** rng.integers(-9, 10, 7)
    sizes, b = 1.0 / np.max(np.abs(matrix), axis=0), rng.standard_normal((7, 3))
    factors = equilibrate(make(matrix), sizes).factor()
    for right in (b, b[:, 0]):
        x = factors.solve(right)
        assert x.shape == right.shape
        residual = np.abs(matrix @ x - right) / (np.abs(matrix) @ np.abs(x) + np.abs(right))
        assert np.max(residual) < 1e-14
        assert pytest.approx(x, rel=1e-15) == (sizes * factors.solve_scaled(right).T).T


@pytest.mark.parametrize("n_zeros", [0, 40])
def test_large_matrices_are_factored_without_entries_that_are_zero(monkeypatch, n_zeros):
    rng = np.random.default_rng(4)
    whole = sp.random_array((60, 60), density=0.1, rng=rng, format="csc") + sp.eye_array(60, format="csc")
    stored, factored = whole.copy(), []
    stored.data[np.flatnonzero(np.abs(stored.data) < 1.0)[:n_zeros]] = 0.0
    splu, b = scipy.sparse.linalg.splu, rng.standard_normal(60)
    monkeypatch.setattr(scipy.sparse.linalg, "splu", lambda matrix: factored.append(matrix) or splu(matrix))
    monkeypatch.setattr(linear, "MANY", 60)
    x = factor(stored)(b)
    assert stored @ x == pytest.approx(b, abs=1e-12)
    assert factored[0].nnz == stored.nnz - n_zeros and stored.nnz == whole.nnz


@KINDS
def test_a_singular_matrix_is_refused(make):
    with pytest.raises(ConvergenceError, match="the Jacobian is singular"):
        factor(make([[1.0, 2.0], [2.0, 4.0]]))
    with pytest.raises(ConvergenceError, match="the Jacobian is singular"):
        equilibrate(make([[1.0, 2.0], [0.0, 0.0]])).factor()


@KINDS
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_values_that_are_not_finite_are_refused(make, value):
    with pytest.raises(ConvergenceError, match="values that are not finite"):
        factor(make([[1.0, 2.0], [value, 4.0]]))


@KINDS
@pytest.mark.parametrize("k", [0, 1, 2])
def test_the_null_space_and_a_solution_at_right_angles_to_the_border(make, k):
    rng = np.random.default_rng(5)
    matrix = rng.standard_normal((5, 5 + k)) * 10.0 ** rng.integers(-6, 7, (5, 1))
    sizes, border, rhs = 10.0 ** rng.integers(-3, 4, 5 + k), rng.standard_normal((k, 5 + k)), rng.standard_normal(5)
    null, solution = equilibrate(make(matrix), sizes).solve_with_border(border, rhs)
    assert null.shape == (5 + k, k)
    scaled = matrix * sizes
    rows = np.max(np.abs(scaled), axis=1)
    whole = np.vstack([scaled / rows[:, None], border])
    for x, right in ((null, np.vstack([np.zeros((5, k)), np.eye(k)])), (solution, np.append(rhs / rows, np.zeros(k)))):
        # The solutions are as exact as rounding lets them be: each equation holds to rounding of its largest terms.
        residual = np.abs(whole @ x - right) / (np.abs(whole) @ np.abs(x) + np.abs(right) + 1e-300)
        assert np.max(residual, initial=0.0) < 1e-13


@KINDS
def test_rows_and_columns_are_scaled_in_their_places(make):
    matrix = np.array([[1.0, 0.0, 2.0], [0.0, 3.0, 4.0]])
    rows, columns = np.array([10.0, 100.0]), np.array([1.0, 2.0, 3.0])
    assert np.array_equal(dense(scale_matrix(make(matrix), rows, columns)), rows[:, None] * matrix * columns)


@KINDS
def test_the_largest_entry_of_a_row(make):
    assert np.array_equal(row_maxima(make([[1.0, -3.0], [0.0, 0.0], [0.0, 0.5]])), [3.0, 1.0, 0.5])
