import numpy as np
import pytest

from pddecont.orbit.basis import make_basis


@pytest.mark.parametrize("degree", range(1, 15))
def test_polynomials_of_the_degree_are_exact(degree):
    basis = make_basis(degree)
    for k in range(degree + 1):
        values = basis.base**k
        assert basis.values @ values == pytest.approx(basis.nodes**k, abs=1e-13)
        slope = k * basis.nodes ** (k - 1) if k else np.zeros(degree)
        assert basis.slopes @ values == pytest.approx(slope, abs=1e-11)
        assert basis.lagrange(np.array([0.3, 1.0])) @ values == pytest.approx([0.3**k, 1.0], abs=1e-13)


@pytest.mark.parametrize("degree", range(1, 12))
def test_gauss_weights_are_exact_to_twice_the_degree(degree):
    basis = make_basis(degree)
    for k in range(2 * degree):
        assert basis.weights @ basis.nodes**k == pytest.approx(1 / (k + 1), abs=1e-14)
