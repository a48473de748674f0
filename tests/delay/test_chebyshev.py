"""The pseudospectral delay line against its own transfer function, against the delay, and its derivatives."""

import numpy as np
import pytest

from pddecont.delay import Chebyshev
from pddecont.delay.chebyshev import profile_line
from tests.delay.meshes import LAG, NOTHING, OMEGA, THETA, check_theta_derivative, delayed, mesh_of


def line_transfer(omega, tau, n):
    """Return what the line does to exp(i omega t): its states obey tau y' = A y + B q."""
    line = profile_line(n)
    return np.linalg.solve(1j * omega * tau * np.eye(n) - line.A, line.B)[line.out]


@pytest.mark.parametrize("n", [1, 2, 5, 9, 14])
def test_a_sine_comes_out_as_in_the_closed_form(n):
    mesh = mesh_of(10, [24, 6])
    u = np.sin(OMEGA * mesh.base_times(THETA))[:, None]
    exact = np.imag(line_transfer(OMEGA, THETA[2], n) * np.exp(1j * OMEGA * mesh.equation_times @ THETA))
    assert np.max(np.abs(delayed(Chebyshev(n), mesh, THETA, u)[:, 0] - exact)) < 1e-11


def test_one_interval_is_a_low_pass_filter():
    """With two points the profile is a straight line: tau y' = q - y."""
    line = profile_line(1)
    assert [*line.mass, *line.A.ravel(), *line.B, line.out] == pytest.approx([1, -1, 1, 0])


def test_the_error_falls_faster_than_any_power():
    """Each point more divides the error by more than the one before it did."""
    errors = np.array([abs(line_transfer(OMEGA, THETA[2], n) - np.exp(-1j * OMEGA * THETA[2])) for n in range(4, 14)])
    ratios = errors[:-1] / errors[1:]
    assert ratios[0] > 9
    assert np.all(np.diff(ratios) > 1)
    assert errors[-1] < 1e-13


@pytest.mark.parametrize("n", [1, 4, 9])
def test_derivatives_in_durations_and_delay(n):
    check_theta_derivative(Chebyshev(n), mesh_of(4, [6, 3]), 1e-7)


def test_zero_delay_is_the_present_value():
    mesh, theta = mesh_of(5, [4, 2]), np.array([9.0, 1.3, 0.0])
    operator = Chebyshev(8).operator(mesh, theta, LAG, mesh.equation_points)
    values = (mesh.base_times(theta) ** 3)[:, None]
    at = mesh.equation_times @ theta
    assert operator.weights.apply(values)[:, 0] == pytest.approx(at**3, abs=1e-10)
    assert operator.theta_derivative(values, [2], 0)[:, 0, 0] == pytest.approx(-3 * at**2, abs=1e-9)


def test_what_a_line_is():
    line = Chebyshev(7)
    assert line.simulated_stages == (0, 0)
    assert line.stages.n == 1
    assert not line.tracks_breaking_points
    assert line.mesh_is_valid(mesh_of(3, [2, 2]), THETA, LAG[None], NOTHING)
