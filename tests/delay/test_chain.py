"""The eliminated chain against its closed form on a sine, against explicit chain states, and its derivatives."""

import math

import numpy as np
import pytest

from pddecont.delay.chain import Chain
from pddecont.orbit.mesh import Mesh, equal_cuts, segment_pieces
from tests.problems import chain_transfer

THETA = np.array([9.0, 1.3, 3.8])
OMEGA = 2 * math.pi / (THETA[0] + THETA[1])


def mesh_of(degree, counts):
    return Mesh(degree, 2, segment_pieces(2, 3, equal_cuts(counts)))


@pytest.mark.parametrize(("order", "n"), [(1, 1), (1, 5), (2, 15), (3, 7), (4, 3), (6, 4), (2, 1000)])
def test_a_sine_comes_out_as_in_the_closed_form(order, n):
    mesh = mesh_of(10, [24, 6])
    weights = Chain(order, n).operator(mesh, THETA, 2, mesh.sites).weights
    rounding = 1e-14 * max(100.0, weights.amplification)
    u = np.sin(OMEGA * mesh.base_times(THETA))[:, None]
    exact = np.imag(chain_transfer(OMEGA, THETA[2], order, n) * np.exp(1j * OMEGA * mesh.site_times @ THETA))
    assert np.max(np.abs(weights.apply(u)[:, 0] - exact)) < rounding


@pytest.mark.parametrize(("order", "n"), [(1, 1), (1, 5), (2, 15), (3, 7), (4, 11), (2, 90)])
def test_derivatives_in_durations_and_delay(order, n):
    mesh = mesh_of(4, [6, 3])
    u = np.random.default_rng(0).normal(size=(mesh.n_base, 2))

    def values(theta):
        return Chain(order, n).operator(mesh, theta, 2, mesh.sites).weights.apply(u)

    exact = Chain(order, n).operator(mesh, THETA, 2, mesh.sites).theta_derivative(u, [0, 1, 2])
    for k in range(3):
        h = 1e-3 * np.eye(3)[k]
        # fourth-order differences
        difference = (8 * (values(THETA + h) - values(THETA - h)) - (values(THETA + 2 * h) - values(THETA - 2 * h))) / 12e-3
        assert np.max(np.abs(difference - exact[:, :, k])) < 1e-7 * max(1.0, np.max(np.abs(exact)))


def test_zero_delay_is_the_present_value():
    mesh = mesh_of(5, [4, 2])
    theta = np.array([9.0, 1.3, 0.0])
    times = mesh.base_times(theta)
    operator = Chain(2, 15).operator(mesh, theta, 2, mesh.sites)
    values = (times**3)[:, None]
    at = mesh.site_times @ theta
    assert operator.weights.apply(values)[:, 0] == pytest.approx(at**3, abs=1e-10)
    assert operator.theta_derivative(values, [0, 2])[:, 0, 1] == pytest.approx(-3 * at**2, abs=1e-9)
    assert not operator.theta_derivative(values, [0, 2])[:, 0, 0].any()


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_order_in_the_length_of_a_step_is_that_of_the_taylor_step(order):
    mesh = mesh_of(8, [24, 6])
    times = mesh.site_times @ THETA
    u = np.sin(OMEGA * mesh.base_times(THETA))[:, None]
    # Order 4 doubles rounding errors with every step near its own frequency, so its steps must be few.
    steps = (8, 16) if order == 4 else (40, 80)
    errors = [np.max(np.abs(Chain(order, n).operator(mesh, THETA, 2, mesh.sites).weights.apply(u)[:, 0]
                            - np.sin(OMEGA * (times - THETA[2])))) for n in steps]  # fmt: skip
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)
