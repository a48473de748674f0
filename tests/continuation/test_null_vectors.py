"""Null vectors of matrices that lack one rank, against singular vectors."""

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.continuation import find_null_vectors
from pddecont.errors import ConvergenceError


def draw(n, k, sigma):
    """Return a matrix (n, n + k) with one singular value sigma and others of 1 to 2."""
    rng = np.random.default_rng(n + k)
    left, right = (np.linalg.qr(rng.standard_normal((size, size)))[0] for size in (n, n + k))
    sizes = np.append(np.linspace(2.0, 1.0, n - 1), sigma)
    return left @ np.hstack([np.diag(sizes), np.zeros((n, k))]) @ right


@pytest.mark.parametrize("make", [np.array, sp.csc_matrix])
@pytest.mark.parametrize("k", [0, 1, 2])
@pytest.mark.parametrize("sigma", [0.0, 1e-9, 1e-4])
def test_they_are_the_least_singular_vectors(make, k, sigma):
    matrix = draw(12, k, sigma)
    left, right = find_null_vectors(make(matrix))
    expected_left, _, expected_right = np.linalg.svd(matrix)
    assert abs(left @ expected_left[:, -1]) == pytest.approx(1.0, abs=1e-12)
    assert right @ right.T == pytest.approx(np.eye(k + 1), abs=1e-12)
    # The same directions: what they leave of one another is nothing.
    spanned = expected_right[-k - 1 :]
    assert right - right @ spanned.T @ spanned == pytest.approx(np.zeros_like(right), abs=1e-10)


@pytest.mark.parametrize("make", [np.array, sp.csc_matrix])
def test_a_matrix_that_is_not_finite_is_refused(make):
    matrix = draw(4, 1, 0.0)
    matrix[1, 2] = np.nan
    with pytest.raises(ConvergenceError, match="not finite"):
        find_null_vectors(make(matrix))
