"""The characteristic matrix."""

import cmath

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.equilibrium import CharacteristicMatrix

PRESENT = np.array([[0.0, 1.0], [-2.0, -0.3]])
DELAYED = np.array([[[0.0, 0.0], [0.7, 0.1]], [[0.2, 0.0], [0.0, -0.4]]])
DELAYS = np.array([1.3, 0.4])


def test_the_matrix_is_that_of_the_exponential_motion():
    """x = q exp(lambda t) solves x' = A_0 x + sum_k A_k x(t - tau_k) exactly where the matrix maps q to zero."""
    root = -0.2 + 1.1j
    expected = root * np.eye(2) - PRESENT
    for through, tau in zip(DELAYED, DELAYS, strict=True):
        expected = expected - cmath.exp(-root * tau) * through
    found, _ = CharacteristicMatrix(PRESENT, tuple(DELAYED), DELAYS, Direct()).at(root)
    assert np.allclose(found, expected, rtol=1e-14)


@pytest.mark.parametrize("method", [Direct(), Chain(2, 5)])
def test_its_derivative_is_that_in_lambda(method):
    matrix, root, h = CharacteristicMatrix(PRESENT, tuple(DELAYED), DELAYS, method), 0.1 + 0.8j, 1e-6
    slope = (matrix.at(root + h)[0] - matrix.at(root - h)[0]) / (2 * h)
    assert np.allclose(matrix.at(root)[1], slope, atol=1e-9)


def test_at_a_root_the_smallest_singular_vector_is_the_eigenvector():
    matrix = CharacteristicMatrix(PRESENT, (), np.zeros(0), Direct())
    values, vectors = np.linalg.eig(PRESENT)
    smallest, vector = matrix.find_smallest(complex(values[0]))
    assert smallest < 1e-15
    assert abs(np.vdot(vector, vectors[:, 0])) == pytest.approx(1.0, abs=1e-14)
    assert matrix.find_smallest(1.0)[0] > 0.1
