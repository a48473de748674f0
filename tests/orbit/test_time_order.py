"""The order of time in which equations of orbits are solved: against sparse factorisations."""

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.continuation import add_row, equilibrate
from pddecont.continuation.time_order import factor_in_time
from pddecont.orbit import OrbitEvaluation, adapt_mesh, order_in_time, solve_on_mesh
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass, neuron, with_parameter


def remember_two_periods():
    orbit = mackey_glass()
    return with_parameter(orbit, "tau", 1.2 + 2 * orbit.period, MeshRule(6, intervals=12))


ORBITS = {
    "two segments": impact_oscillator,
    "hard wall": hard_wall,
    "no events": mackey_glass,
    "delayed events": neuron,
    "longer delay": remember_two_periods,
}


def solve(make, degree=4):
    return solve_on_mesh(adapt_mesh(make(), MeshRule(degree, intervals=10))).at


def check(matrix, order, sizes):
    """Check that a matrix is solved as SuperLU does, and that its rows and columns are each in one block or beside."""
    equilibrated = equilibrate(matrix, sizes)
    found = factor_in_time(equilibrated.matrix, order)
    right = np.random.default_rng(0).normal(size=(order.n_columns, 5))
    expected = equilibrated.factor().solve_scaled(right / equilibrated.rows[:, None])
    assert np.max(np.abs(found(right) - expected)) < 1e-11 * np.max(np.abs(expected))
    single = found(right[:, 0])
    assert np.max(np.abs(single - expected[:, 0])) < 1e-11 * np.max(np.abs(expected[:, 0]))
    assert np.sum(order.sizes) + len(order.rows_below) == order.n_columns
    assert len(order.rows_below) == len(order.columns_beside)
    assert matrix.shape == (order.n_columns, order.n_columns)


@pytest.mark.parametrize("name", ORBITS)
def test_equations_of_an_orbit(name):
    at = solve(ORBITS[name])
    check(at.jacobian(), order_in_time(at.orbit.problem), at.system.scaling.scale)


def test_equations_of_a_branch():
    """With a free parameter, and a row that picks a point."""
    found = solve(impact_oscillator)
    orbit = found.orbit.with_free(("tau_d",))
    at = OrbitEvaluation(found.system, orbit)
    matrix = add_row(at.jacobian(), np.random.default_rng(1).normal(size=len(orbit.x)))
    check(matrix, at.time_order, np.ones(len(orbit.x)))


def test_large_blocks_stay_sparse():
    assert order_in_time(solve(impact_oscillator, degree=32).orbit.problem) is not None
    assert order_in_time(solve(impact_oscillator, degree=33).orbit.problem) is None
