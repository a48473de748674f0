"""Eigenvalues by ARPACK: those of largest modulus, the same to the last bit every time."""

import numpy as np
import pytest

from pddecont.continuation.arnoldi import TAKES_NUMBERS, find_largest

START = np.random.default_rng(0).normal(size=60)


def find(values, k, **options):
    # Similar to a diagonal matrix, but not normal.
    change = np.eye(len(values)) + np.diag(np.full(len(values) - 1, 0.5), k=1)
    matrix = np.linalg.solve(change, np.diag(values) @ change)
    return find_largest(matrix, k, n_vectors=20, start=START, **options)


def test_the_largest_are_found_with_their_vectors():
    expected = 0.8 ** np.arange(60)
    values, vectors, is_complete = find(expected, 4, tol=0.0)
    assert is_complete and vectors.shape == (60, 4)
    assert sorted(np.abs(values), reverse=True) == pytest.approx(expected[:4], rel=1e-10)


def test_where_too_few_are_found_it_says_so():
    values, _, is_complete = find(np.linspace(1.0, 1.01, 60), 8, tol=0.0, max_restarts=1)
    assert not is_complete and len(values) < 8


@pytest.mark.skipif(not TAKES_NUMBERS, reason="this scipy begins again with numbers of its own")
def test_a_map_onto_a_few_directions_has_the_same_eigenvalues_every_time():
    found = [find_largest(np.diag([1.0, 0.5] + [0.0] * 58), 4, n_vectors=12, start=START, tol=0.0) for _ in range(10)]
    assert len({values.tobytes() + vectors.tobytes() for values, vectors, _ in found}) == 1
