"""Characteristic matrices: their determinants are products over the multipliers."""

import numpy as np
import pytest
import scipy.linalg

from pddecont.errors import ConvergenceError
from pddecont.stability.characteristic import MapCharacteristic, PeriodCharacteristic, factor_at
from pddecont.stability.monodromy import linearise_period
from tests.known_orbits import hard_wall, mackey_glass

ORBITS = {"hard wall": hard_wall, "no events": mackey_glass}
POINTS = (1.3, -0.7, 0.4 + 1.1j)


def random_period(n=6, depth=3):
    rng = np.random.default_rng(2)
    matrices = [np.eye(n) + 0.1 * rng.normal(size=(n, n)), *rng.normal(size=(depth, n, n))]
    powers, rows, columns = np.indices((depth + 1, n, n)).reshape(3, -1)
    return PeriodCharacteristic(n, rows, columns, powers, np.ravel(matrices)), matrices


@pytest.mark.parametrize("z", POINTS)
def test_the_matrix_is_the_sum_of_powers_and_its_derivative_that_of_theirs(z):
    characteristic, matrices = random_period()
    assert characteristic.depth == 3
    assert characteristic.matrix(z).toarray() == pytest.approx(sum(A * z**w for w, A in enumerate(matrices)))
    slopes = sum(w * A * z ** (w - 1) for w, A in enumerate(matrices) if w)
    assert characteristic.derivative(z).toarray() == pytest.approx(slopes)


@pytest.mark.parametrize("z", POINTS)
@pytest.mark.parametrize("kind", ["sparse", "dense"])
def test_factors_solve_and_know_the_determinant_with_its_sign(kind, z):
    rng = np.random.default_rng(1)
    characteristic = random_period()[0] if kind == "sparse" else MapCharacteristic(rng.normal(size=(7, 7)))
    matrix = characteristic.matrix(z)
    matrix = matrix.toarray() if kind == "sparse" else matrix
    factors = factor_at(characteristic, z)
    b = rng.normal(size=len(matrix)) + (1j * rng.normal(size=len(matrix)) if isinstance(z, complex) else 0.0)
    scaled = factors.rows[:, None] * matrix
    assert factors.rows * characteristic.row_sizes(z) == pytest.approx(np.ones(len(matrix)))
    assert np.all(np.max(np.abs(scaled), axis=1) <= 1.0 + 1e-12)
    assert scaled @ factors.solve(b) == pytest.approx(b, abs=1e-11)
    assert scaled.conj().T @ factors.solve_adjoint(b) == pytest.approx(b, abs=1e-11)
    assert np.exp(factors.log_determinant) == pytest.approx(scipy.linalg.det(matrix), rel=1e-11)


@pytest.mark.parametrize("name", ORBITS)
@pytest.mark.parametrize("z", POINTS)
def test_the_determinant_is_that_of_the_map_from_history_to_history(name, z):
    monodromy = linearise_period(ORBITS[name]())
    ratio = factor_at(monodromy.characteristic, z).log_determinant
    ratio -= factor_at(monodromy.characteristic, 0.0).log_determinant
    values = scipy.linalg.eigvals(monodromy.to_matrix())
    assert np.exp(ratio) == pytest.approx(np.prod(1 - z * values), rel=1e-8)


def test_a_matrix_that_is_singular_or_not_finite_is_an_error():
    for dense in (np.eye(3), np.diag([1.0, np.inf, 1.0])):
        with pytest.raises(ConvergenceError):
            factor_at(MapCharacteristic(dense), 1.0)
    zeros = PeriodCharacteristic(2, np.array([0]), np.array([0]), np.array([0]), np.array([1.0]))
    with pytest.raises(ConvergenceError, match="singular"):
        factor_at(zeros, 1.0)
