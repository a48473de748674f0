"""A line collocated on a mesh against exact solutions, its derivatives, and a delay of zero."""

import numpy as np
import pytest

from pddecont.delay import DelayLine, LineOnMesh
from pddecont.delay.delay_line import no_delay
from tests.delay.meshes import LAG, OMEGA, THETA, mesh_of

# tau y' = q - y; and a pair of states that turn while they are drawn to q.
FILTER = DelayLine(np.ones(1), -np.ones((1, 1)), np.ones(1), 0)
PAIR = DelayLine(np.array([1.0, 0.5]), np.array([[-1.0, 2.0], [-2.0, -0.7]]), np.array([0.3, 1.0]), 1)


def on_mesh(line, mesh, *, theta=THETA, n=1, periodic=True):
    return LineOnMesh(line, mesh, theta, LAG, n, mesh.equation_points, periodic=periodic)


@pytest.mark.parametrize("n_stages", [1, 5])
def test_a_periodic_line_gives_its_transfer_function(n_stages):
    mesh = mesh_of(9, [24, 6])
    line = on_mesh(PAIR, mesh, n=n_stages)
    delta = THETA[2] / n_stages
    times = mesh.equation_times @ THETA
    transfer = np.linalg.solve(1j * OMEGA * delta * np.diag(PAIR.mass) - PAIR.A, PAIR.B)[PAIR.out]
    at_nodes = np.sin(OMEGA * times[: mesh.n_collocation])
    assert line.to_points @ at_nodes == pytest.approx(np.imag(transfer * np.exp(1j * OMEGA * times)), abs=1e-11)
    assert np.array_equal(line.to_points[: mesh.n_collocation], line.to_nodes)


def test_a_line_from_given_states_decays_to_its_input():
    """tau y' = c - y from y(0) = a: y = c + (a - c) exp(-t / tau)."""
    mesh = mesh_of(9, [24, 6])
    line = on_mesh(FILTER, mesh, periodic=False)
    times, tau = mesh.equation_times @ THETA, THETA[2]
    rhs = np.zeros((mesh.n_intervals, mesh.degree, 1))
    left = line.output_at_points(line.solve(rhs, np.array([[5.0]])))[:, 0]
    assert left == pytest.approx(5.0 * np.exp(-times / tau), abs=1e-12)
    driven = line.to_points @ np.full(mesh.n_collocation, 2.0)
    assert driven + left == pytest.approx(2.0 + 3.0 * np.exp(-times / tau), abs=1e-12)


def test_a_growing_line_has_a_periodic_solution_too():
    """tau y' = y - q: forward recursion would drown it; the transfer function is 1 / (1 - i omega tau)."""
    growing = DelayLine(np.ones(1), np.ones((1, 1)), -np.ones(1), 0)
    mesh, theta = mesh_of(9, [24, 6]), np.array([9.0, 1.3, 0.2])
    times = mesh.equation_times @ theta
    found = on_mesh(growing, mesh, theta=theta).to_points @ np.sin(OMEGA * times[: mesh.n_collocation])
    exact = np.imag(np.exp(1j * OMEGA * times) / (1 - 1j * OMEGA * theta[2]))
    assert found == pytest.approx(exact, abs=1e-11)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("component", [0, 1, 2])
def test_derivatives_with_inputs_that_stay(component, periodic):
    mesh = mesh_of(4, [6, 3])
    inputs = np.random.default_rng(2).normal(size=(mesh.n_collocation, 3))
    line = on_mesh(PAIR, mesh, periodic=periodic)
    found = line.output_at_points(line.derivative(inputs, component))

    def made(amount):
        theta = THETA + amount * np.eye(3)[component]
        return on_mesh(PAIR, mesh, theta=theta, periodic=periodic).to_points @ inputs

    difference = (8 * (made(1e-3) - made(-1e-3)) - (made(2e-3) - made(-2e-3))) / 12e-3
    assert found == pytest.approx(difference, abs=1e-8 * np.max(np.abs(difference)))


@pytest.mark.parametrize("component", [0, 1, 2])
def test_a_derivative_in_factors_of_small_rank(component):
    mesh = mesh_of(4, [6, 3])
    line = on_mesh(PAIR, mesh)
    inputs = np.random.default_rng(2).normal(size=(mesh.n_collocation, 3))
    U, F = line.derivative_factors(component)
    # A segment's duration moves its own intervals alone, the delay all.
    assert U.shape[1] == {0: 6, 1: 3, 2: 9}[component] * mesh.degree * line.size
    assert U @ (F @ inputs) == pytest.approx(line.output_at_nodes(line.derivative(inputs, component)), abs=1e-10)


def test_weights_on_nodes_as_weights_on_base_points():
    mesh = mesh_of(4, [6, 3])
    rng = np.random.default_rng(3)
    weights, values = rng.normal(size=(5, mesh.n_collocation)), rng.normal(size=(mesh.n_base, 2))
    found = on_mesh(FILTER, mesh).through_nodes(weights) @ values
    assert found == pytest.approx(weights @ mesh.interpolate_at_nodes(values), abs=1e-11)


def test_a_delay_of_zero_reads_the_present():
    mesh, theta = mesh_of(5, [4, 2]), np.array([9.0, 1.3, 0.0])
    operator = no_delay(mesh, theta, LAG, mesh.equation_points)
    at = mesh.equation_times @ theta
    values = np.stack([mesh.base_times(theta) ** 3, mesh.base_times(theta) ** 5 / 100], axis=1)
    exact = np.stack([-3 * at**2, -(at**4) / 20], axis=1)
    assert operator.weights.apply(values) == pytest.approx(np.stack([at**3, at**5 / 100], axis=1), abs=1e-9)
    assert operator.theta_derivative(values, [2], 0)[:, :, 0] == pytest.approx(exact, abs=1e-7)
    assert not operator.theta_derivative(values, [0, 1], 0).any()
    assert not operator.weights.wraps.any()
