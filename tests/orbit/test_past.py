"""An orbit as the past of a simulation: the same polynomials, repeated, cut into arcs."""

import numpy as np
import pytest

from pddecont.collocation import MeshRule
from pddecont.orbit import make_past
from pddecont.simulate import make_extension_basis
from tests.orbit.exact import TURN, circle


def evaluate(past, t):
    """Return the states of a past at times, from its steps' extensions."""
    step = np.searchsorted(past.time, t, side="right") - 1
    basis = make_extension_basis((t - past.time[step]) / past.length[step])
    return basis[:, :1] * past.value[step] + np.einsum("ti,tin->tn", basis[:, 1:], past.coefficients[step])


@pytest.mark.parametrize("degree", [1, 3, 6, 7, 8, 10, 12, 20])
def test_polynomials_of_any_degree_are_followed(degree):
    """Up to the degree of a simulation they are the same; beyond, parts follow them to 1e-12."""
    orbit = circle("s", rule=MeshRule(degree, intervals=9))
    past = make_past(orbit, -1.3 * TURN, TURN)
    t = np.random.default_rng(degree).uniform(orbit.start - 1.3 * TURN, orbit.start + TURN, 300)
    points, _ = orbit.mesh.locate(orbit.theta, t - orbit.start)
    assert np.max(np.abs(evaluate(past, t) - orbit.mesh.interpolate(orbit.values, points))) < 1e-12


def test_each_segment_is_an_arc_and_no_event_leaves_one():
    past = make_past(circle("s", "s"), -TURN, 2 * TURN)
    assert np.array_equal(np.unique(past.arc), [1, 2, 3])
    assert np.all(np.diff(past.arc) >= 0)
    assert set(make_past(circle(), -2 * TURN, TURN).arc) == {0}


def test_steps_follow_one_another_up_to_the_end():
    orbit = circle("s")
    past = make_past(orbit, -0.4 * TURN, 0.3 * TURN)
    assert past.time[0] <= orbit.start - 0.4 * TURN
    assert past.end[-1] == orbit.start + 0.3 * TURN
    assert np.max(np.abs(past.time[1:] - past.end[:-1])) < 1e-13


def test_delayed_values_instead_of_states():
    orbit = circle("s", tau=1.0)
    t = np.linspace(0.1, TURN - 0.1, 50) + orbit.start
    found = evaluate(make_past(orbit, 0.0, TURN, delayed=True), t)
    names = [s.name for s in orbit.numeric.model.delayed_symbols]
    exact = np.stack([np.cos(t - 1.0) if "x" in name else np.sin(t - 1.0) for name in names], axis=1)
    assert np.max(np.abs(found - exact)) < 1e-9


def test_a_longer_history_is_the_orbit_again():
    orbit = circle("s")
    past = make_past(orbit, -5.5 * TURN, 0.0)
    t = orbit.start - np.linspace(0.2, 5.4, 40) * TURN
    assert np.max(np.abs(evaluate(past, t) - np.stack([np.cos(t), np.sin(t)], axis=1))) < 1e-9
