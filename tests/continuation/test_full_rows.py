"""Sparse systems with a few full rows, against the full matrix."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg

from pddecont.continuation import linear
from pddecont.continuation.full_rows import FEW, factor_without_full_rows
from pddecont.continuation.trial import LARGEST

N = 60


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def factor(matrix):
    return scipy.sparse.linalg.splu(matrix).solve


def make_matrix(rng, n_full):
    """Return a matrix with three diagonals and ``n_full`` full rows at its end, largest entries of modulus 1."""
    full = np.diag(np.ones(N)) + 0.3 * np.diag(rng.normal(size=N - 1), 1) + 0.3 * np.diag(rng.normal(size=N - 1), -1)
    for row in range(N - n_full, N):
        full[row] = rng.uniform(-0.5, 0.5, size=N)
        full[row, row] = 1.0
    return full / np.max(np.abs(full), axis=1)[:, None]


@pytest.mark.parametrize("n_full", [1, 2, FEW])
def test_solutions_are_those_of_the_full_matrix(rng, n_full):
    full = make_matrix(rng, n_full)
    solve = factor_without_full_rows(sp.csc_matrix(full), factor)
    for b in (rng.normal(size=N), rng.normal(size=(N, 3))):
        exact = np.linalg.solve(full, b)
        assert solve(b) == pytest.approx(exact, abs=1e-11 * np.max(np.abs(exact)))


def test_what_is_factored_has_no_full_row(rng):
    seen = []

    def look(matrix):
        seen.append(matrix)
        return factor(matrix)

    assert factor_without_full_rows(sp.csc_matrix(make_matrix(rng, 2)), look)
    assert np.max(np.bincount(seen[0].indices)) <= 3


@pytest.mark.parametrize("n_full", [0, FEW + 1])
def test_others_are_left_to_another_factorisation(rng, n_full):
    assert factor_without_full_rows(sp.csc_matrix(make_matrix(rng, n_full)), factor) is None


def test_what_is_singular_without_the_rest_of_a_row_is_left_too(rng):
    """The first unknown stands in the full row alone, whose largest entry is another one's."""
    full = np.diag(np.ones(N - 1), 1)
    full[-1] = rng.uniform(-0.5, 0.5, size=N)
    full[-1, 0], full[-1, 5] = 0.5, 1.0
    assert np.linalg.matrix_rank(full) == N
    assert factor_without_full_rows(sp.csc_matrix(full), factor) is None


def test_rounding_that_has_grown_is_seen(rng):
    def inexact(matrix):
        solve = factor(matrix)
        return lambda b: solve(b) * (1.0 + 1e-5 * np.cos(np.arange(N)).reshape(N, *[1] * (np.ndim(b) - 1)))

    assert factor_without_full_rows(sp.csc_matrix(make_matrix(rng, 2)), inexact) is None


def test_rows_that_are_nearly_parallel_keep_their_difference(rng):
    """As a phase condition and a step along a branch may be: what differs is a part of 1e-4 of them."""
    full = make_matrix(rng, 2)
    full[-2, -1] = 0.999
    full[-1] = full[-2] + 1e-4 * rng.uniform(-1.0, 1.0, size=N)
    full /= np.max(np.abs(full), axis=1)[:, None]
    solve = factor_without_full_rows(sp.csc_matrix(full), factor)
    exact = rng.normal(size=N)
    assert solve(full @ exact) == pytest.approx(exact, abs=4.0 * np.finfo(float).eps * np.linalg.cond(full))


@pytest.mark.parametrize("small", [1e-3, 1e-8])
def test_what_is_nearly_singular_is_left_too(rng, small):
    full = make_matrix(rng, 1)
    full[0] = full[1] + small * rng.normal(size=N) * (full[1] != 0.0)
    found = factor_without_full_rows(sp.csc_matrix(full), factor)
    assert (found is None) == (small < 1.0 / LARGEST)


def test_complex_numbers_are_left_too(rng):
    assert factor_without_full_rows(sp.csc_matrix(make_matrix(rng, 1) * (1.0 + 0.0j)), factor) is None


@pytest.mark.parametrize("many", [N, N + 1])
def test_large_systems_alone_are_factored_so(rng, monkeypatch, many):
    seen, splu = [], scipy.sparse.linalg.splu
    monkeypatch.setattr(linear, "MANY", many)
    monkeypatch.setattr(scipy.sparse.linalg, "splu", lambda m, **options: seen.append(m.nnz) or splu(m, **options))
    full, b = make_matrix(rng, 2), rng.normal(size=N)
    exact = np.linalg.solve(full, b)
    assert linear.factor(sp.csc_matrix(full))(b) == pytest.approx(exact, abs=1e-11 * np.max(np.abs(exact)))
    assert (seen == [np.count_nonzero(full)]) == (many > N)
    assert len(seen) == 1


def test_where_that_does_not_do_the_whole_is_factored(rng, monkeypatch):
    seen, splu = [], scipy.sparse.linalg.splu
    monkeypatch.setattr(linear, "MANY", N)
    monkeypatch.setattr(scipy.sparse.linalg, "splu", lambda m, **options: seen.append(m.nnz) or splu(m, **options))
    full = np.diag(np.ones(N - 1), 1)
    full[-1] = rng.uniform(-0.5, 0.5, size=N)
    full[-1, 0], full[-1, 5] = 0.5, 1.0
    b = rng.normal(size=N)
    assert linear.factor(sp.csc_matrix(full))(b) == pytest.approx(np.linalg.solve(full, b), abs=1e-11)
    assert seen == [N, 2 * N - 1]
