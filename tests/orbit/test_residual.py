"""Residuals are zero on orbits that are known, and what they are where one unknown is off."""

import numpy as np
import pytest

from pddecont.orbit import DelayedEventLink, Orbit, Rows
from pddecont.orbit.residual import compute_residual, find_elapsed_weights, group_by_mode, group_by_reset, phase_weights
from tests.known_orbits import impact_oscillator, mackey_glass, neuron
from tests.orbit.exact import TURN, circle


@pytest.mark.parametrize("orbit", [circle(level=1.5), circle("s", level=0.5)], ids=["no event", "event"])
def test_a_known_orbit_leaves_nothing(orbit):
    assert np.max(np.abs(compute_residual(orbit))) < 1e-11


@pytest.mark.parametrize("make", [impact_oscillator, mackey_glass, neuron], ids=lambda f: f.__name__)
def test_solutions_leave_rounding(make):
    orbit = make()
    residual = compute_residual(orbit)
    assert residual.shape == (Rows(orbit.problem.unknowns).size,)
    assert np.max(np.abs(residual)) < 1e-9


def test_what_each_row_says():
    """Off by one thing at a time: the event by the level, the period by the forcing's, a reset by a jump."""
    orbit = circle("s", level=0.5)
    unknowns, mesh = orbit.problem.unknowns, orbit.mesh
    rows = Rows(unknowns)

    def residual(place, by):
        x = orbit.x.copy()
        x[place] += by
        return compute_residual(Orbit(orbit.problem, x))

    longer = residual(unknowns.duration(0), 0.1)
    assert longer[rows.period] == pytest.approx(0.1)
    last = unknowns.value_index[mesh.last_base[0]]
    off = residual(last, [0.2, 0.3])
    # State after the identity reset less that before; the event's function is y - level.
    assert off[rows.resets : rows.events] == pytest.approx([-0.2, -0.3], abs=1e-10)
    assert off[rows.events] == pytest.approx(0.3, abs=1e-10)
    free = circle(level=1.5)
    later = Orbit(free.problem, free.x + 0.25 * (np.arange(len(free.x)) == free.problem.unknowns.start.start))
    assert compute_residual(later)[Rows(free.problem.unknowns).events] == pytest.approx(0.25)


def test_groups_hold_every_point_once():
    problem = impact_oscillator().problem
    modes = dict(group_by_mode(problem))
    assert list(modes) == ["NC", "C"]
    assert sorted(np.concatenate(list(modes.values()))) == list(range(problem.mesh.n_collocation))
    segment = problem.mesh.segment[modes["C"] // problem.mesh.degree]
    assert set(segment.tolist()) == {1}
    resets = group_by_reset(problem)
    assert [which.tolist() for _, which in resets] == [[0, 1]]


def test_the_phase_condition_is_an_integral():
    """Weights of the integral of z . z_ref' over the orbit, for polynomials: against exact quadrature."""
    orbit = mackey_glass()
    weights = phase_weights(orbit.problem)
    mesh, reference = orbit.mesh, orbit.problem.reference
    values = np.random.default_rng(0).normal(size=reference.shape)
    nodes, w = np.polynomial.legendre.leggauss(2 * mesh.degree)
    sigma = 0.5 + 0.5 * nodes
    at = mesh.basis.lagrange(sigma)
    z = np.einsum("ib,jbn->jin", at, values[mesh.base_index])
    slope = np.einsum("ib,jbn->jin", at @ mesh.basis.differentiate, reference[mesh.base_index])
    assert weights @ values.ravel() == pytest.approx(np.einsum("i,jin,jin->", 0.5 * w, z, slope), abs=1e-11)
    # The reference itself is in phase: the integral of z . z' round a closed orbit is zero.
    assert weights @ reference.ravel() == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize(
    ("segment", "source", "wraps", "weights"),
    [(1, 0, 0, [0, 1]), (0, 1, 1, [1, 0]), (0, 0, 1, [1, 1]), (0, 1, 3, [3, 2]), (1, 1, 2, [2, 2])],
)
def test_the_time_since_a_source(segment, source, wraps, weights):
    problem = circle("s", "s").problem
    assert find_elapsed_weights(problem, DelayedEventLink(segment, source, wraps)).tolist() == weights
    assert problem.n_periods * TURN == pytest.approx(2 * TURN)
