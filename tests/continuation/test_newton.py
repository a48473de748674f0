"""What Newton's method says when it does not arrive."""

from itertools import count

import numpy as np
import pytest

from pddecont.continuation.newton import newton
from pddecont.errors import ConvergenceError


def test_steps_that_stay_large_are_told_where_the_equations_hold():
    """Two equations that are one but for 1e-13: rounding of 1e-15 moves the solution by 1e-2."""
    matrix, call = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-13]]), count()

    def residual(x):
        return np.array([1e-15, -1e-15]) * (-1.0) ** next(call)

    with pytest.raises(ConvergenceError) as caught:
        newton(residual, lambda x: matrix, np.zeros(2), np.ones(2))
    assert "did not converge in 12 iterations (the equations hold to 1.0e-15, but the unknowns still move" in str(caught.value)
    assert "the last steps are 2.0e-02, 2.0e-02, 2.0e-02, expected below 1e-08" in str(caught.value)


def test_residuals_that_stay_large_are_told():
    with pytest.raises(ConvergenceError, match=r"did not converge in 12 iterations \(residuals: 1\.0e\+00, "):
        newton(lambda x: np.exp(-x), lambda x: np.diag(-np.exp(-x)), np.zeros(1), np.ones(1))
