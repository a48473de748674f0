"""Elimination in the order of time against a sparse factorisation, and where it is refused."""

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.collocation import MeshRule
from pddecont.continuation import equilibrate
from pddecont.orbit import adapt_mesh, solve_on_mesh
from pddecont.stability.monodromy import linearise_period
from pddecont.stability.time_order import TimeOrder, order_in_time
from tests.known_orbits import (
    chained_impact_oscillator,
    hard_wall,
    impact_oscillator,
    mackey_glass,
    neuron,
    with_parameter,
)


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


def linearise(make, degree=4):
    return linearise_period(solve_on_mesh(adapt_mesh(make(), MeshRule(degree, intervals=10))).at.orbit)


@pytest.mark.parametrize("name", ORBITS)
def test_solutions_are_those_of_a_sparse_factorisation(name):
    monodromy = linearise(ORBITS[name])
    order, present = order_in_time(monodromy.problem), monodromy.present
    right = np.random.default_rng(0).normal(size=(order.n_columns, 5))
    expected = monodromy.factors.solve(right)
    found = order.solve(present, right)
    assert np.max(np.abs(found - expected) / monodromy.sizes[:, None]) < 1e-11 * np.max(
        np.abs(expected) / monodromy.sizes[:, None]
    )
    # Every row and column is in one block, or below and beside all of them.
    assert np.sum(order.sizes) + len(order.rows_below) == order.n_columns
    assert len(order.rows_below) == len(order.columns_beside)


@pytest.mark.parametrize("make", [impact_oscillator, mackey_glass, chained_impact_oscillator])
def test_the_whole_map_is_that_of_its_steps(make):
    monodromy = linearise(make)
    sizes = monodromy.history_sizes
    steps = np.stack([monodromy.step(column[:, None])[1][:, 0] for column in np.diag(sizes)], axis=1) / sizes[:, None]
    assert monodromy.scaled_matrix == pytest.approx(steps, abs=1e-11 * np.max(np.abs(steps)))


def test_large_blocks_stay_sparse():
    assert order_in_time(linearise(impact_oscillator, degree=32).problem) is not None
    assert order_in_time(linearise(impact_oscillator, degree=33).problem) is None


def make_order(n):
    """Return the order of a matrix of ``n`` blocks of one unknown each, and a border of one."""
    places = np.arange(n)
    return TimeOrder(places, places, np.ones(n, dtype=np.intp), n + 1)


def test_growth_is_seen():
    """A small pivot that a border makes good: the equations regular, solved block by block they lose all digits."""
    matrix = np.array([[1e-17, 0.0, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]])
    right = np.array([[1.0], [2.0], [3.0]])
    assert np.linalg.cond(matrix) < 10
    assert make_order(2).solve(equilibrate(sp.csc_matrix(matrix)), right) is None
    matrix[0, 0] = 0.5
    found = make_order(2).solve(equilibrate(sp.csc_matrix(matrix)), right)
    assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-14)


@pytest.mark.parametrize("place", [(0, 0), (2, 2)])
def test_singular_equations_have_no_solutions(place):
    matrix = np.eye(3)
    matrix[place] = 0.0
    assert make_order(2).solve(equilibrate(sp.csc_matrix(matrix)), np.ones((3, 1))) is None
