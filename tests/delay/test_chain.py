"""The eliminated chain against its closed form on a sine, against explicit chain states, and its derivatives."""

import math

import numpy as np
import pytest

from pddecont.delay import Chain, MatrixPowers
from tests.delay.meshes import LAG, OMEGA, THETA, check_theta_derivative, delayed, mesh_of
from tests.problems import chain_transfer


@pytest.mark.parametrize(("order", "n"), [(1, 1), (1, 5), (2, 15), (3, 7), (4, 3), (6, 4), (2, 1000)])
def test_a_sine_comes_out_as_in_the_closed_form(order, n):
    mesh = mesh_of(10, [24, 6])
    weights = Chain(order, n).operator(mesh, THETA, LAG, mesh.equation_points).weights
    rounding = 1e-14 * max(100.0, weights.amplification)
    u = np.sin(OMEGA * mesh.base_times(THETA))[:, None]
    exact = np.imag(chain_transfer(OMEGA, THETA[2], order, n) * np.exp(1j * OMEGA * mesh.equation_times @ THETA))
    assert np.max(np.abs(weights.apply(u)[:, 0] - exact)) < rounding


@pytest.mark.parametrize(("order", "n"), [(2, 15), (3, 7)])
def test_other_points_read_the_same_values(order, n):
    """Reads anywhere on the mesh, against the closed form; those at the equation points are made another way."""
    mesh = mesh_of(10, [24, 6])
    points = mesh.grid(np.array([0.0, 0.3, 1.0]))
    u = np.sin(OMEGA * mesh.base_times(THETA))[:, None]
    found = Chain(order, n).operator(mesh, THETA, LAG, points).weights.apply(u)[:, 0]
    exact = np.imag(chain_transfer(OMEGA, THETA[2], order, n) * np.exp(1j * OMEGA * mesh.times(points) @ THETA))
    assert np.max(np.abs(found - exact)) < 1e-11


@pytest.mark.parametrize(("order", "n"), [(1, 1), (1, 5), (2, 15), (3, 7), (4, 11), (2, 90)])
def test_derivatives_in_durations_and_delay(order, n):
    check_theta_derivative(Chain(order, n), mesh_of(4, [6, 3]), 1e-7)


def test_zero_delay_is_the_present_value():
    mesh = mesh_of(5, [4, 2])
    theta = np.array([9.0, 1.3, 0.0])
    times = mesh.base_times(theta)
    operator = Chain(2, 15).operator(mesh, theta, LAG, mesh.equation_points)
    values = (times**3)[:, None]
    at = mesh.equation_times @ theta
    assert operator.weights.apply(values)[:, 0] == pytest.approx(at**3, abs=1e-10)
    assert operator.theta_derivative(values, [0, 2], 0)[:, 0, 1] == pytest.approx(-3 * at**2, abs=1e-9)
    assert not operator.theta_derivative(values, [0, 2], 0)[:, 0, 0].any()


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_order_in_the_length_of_a_step_is_that_of_the_taylor_step(order):
    mesh = mesh_of(8, [24, 6])
    exact = np.sin(OMEGA * (mesh.equation_times @ THETA - THETA[2]))
    u = np.sin(OMEGA * mesh.base_times(THETA))[:, None]
    # Order 4 doubles rounding errors with every step near its own frequency, so its steps must be few.
    steps = (8, 16) if order == 4 else (40, 80)
    errors = [np.max(np.abs(delayed(Chain(order, n), mesh, THETA, u)[:, 0] - exact)) for n in steps]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 8, 13, 100])
def test_powers_of_a_matrix(n):
    rng = np.random.default_rng(n)
    matrix = rng.normal(size=(5, 5)) / 3
    powers = MatrixPowers(matrix, n)
    exact = np.linalg.matrix_power(matrix, n)
    rows, columns = rng.normal(size=(2, 5)), rng.normal(size=(5, 3))
    assert powers.matrix(n) == pytest.approx(exact, rel=1e-12, abs=1e-14)
    assert powers.from_left(rows, n) == pytest.approx(rows @ exact, rel=1e-12, abs=1e-14)
    assert powers.on(columns, n) == pytest.approx(exact @ columns, rel=1e-12, abs=1e-14)
    assert powers.on(columns, 0) is columns


def test_what_a_chain_is():
    chain = Chain(3, 8)
    assert chain.simulated_stages == (3, 8)
    assert chain.stages.n == 8
    assert not chain.tracks_breaking_points
    # One Taylor step of order 3: w0' = w1/d, w1' = w2/d, w2'/6 = (q - w0 - w1 - w2/2)/d.
    line = chain.stages.line
    assert line.mass == pytest.approx([1, 1, 1 / 6])
    assert np.array_equal(line.A, [[0, 1, 0], [0, 0, 1], [-1, -1, -0.5]])
    assert np.array_equal(line.B, [0, 0, 1])
    assert line.out == 0
