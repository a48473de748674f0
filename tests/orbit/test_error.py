"""Sizes of states, and the error that a defect leaves inside each interval, against what it really is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import MeshRule
from pddecont.delay import Chain, FullWeights
from pddecont.orbit import estimate_rounding_error, measure_states, solve_on_mesh
from pddecont.orbit.error import estimate_interval_errors
from tests.known_orbits import impact_oscillator
from tests.orbit.exact import circle


def drift(orbit):
    """Return the largest distance of an orbit from the circle in each mesh interval."""
    mesh = orbit.mesh
    points = mesh.grid(np.linspace(0, 1, 21))
    t = orbit.start + mesh.times(points) @ orbit.theta
    apart = mesh.interpolate(orbit.values, points) - np.stack([np.cos(t), np.sin(t)], axis=1)
    return np.max(np.abs(apart).reshape(mesh.n_intervals, -1), axis=1)


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
def test_the_estimate_is_the_error_inside_each_interval(degree):
    """At the intervals' ends the error is of higher order: what there is lies inside."""
    largest = []
    for intervals in (10, 20):
        orbit = solve_on_mesh(circle(level=1.5, tau=0.0, rule=MeshRule(degree, intervals=intervals))).at.orbit
        errors, found = drift(orbit), estimate_interval_errors(orbit)
        largest.append(np.max(found))
        assert np.all(found < 3 * np.max(errors))
        assert np.max(found) == pytest.approx(np.max(errors), rel=0.5)
    assert np.log2(largest[0] / largest[1]) == pytest.approx(degree + 1, abs=0.1)


def test_it_is_worked_out_once():
    orbit = circle()
    assert estimate_interval_errors(orbit) is estimate_interval_errors(orbit)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.floats(1e-3, 1e6), st.floats(-10, 10), st.integers(0, 1000))
def test_a_states_size_is_half_its_swing(swing, middle, seed):
    """Whatever its middle, while that is not a hundred thousand times as large."""
    wave = np.random.default_rng(seed).uniform(-1, 1, (30, 1))
    wave[:2, 0] = -1, 1
    assert measure_states(middle + swing * wave) == pytest.approx([swing])


def test_states_that_hardly_move():
    still = np.array([[100.0, 0.0, 1e-14, 5.0], [100.0 + 1e-4, 0.0, -1e-14, -5.0]])
    assert measure_states(still) == pytest.approx([100.0, 1.0, 1.0, 5.0], rel=1e-5)


def test_rounding_is_what_the_delay_operator_makes_of_it():
    assert estimate_rounding_error(impact_oscillator()) == 0.0
    orbit = circle(method=Chain(3, 30), rule=MeshRule(6, intervals=12))
    weights = orbit.equation_reads.operators[0].weights
    assert isinstance(weights, FullWeights)
    assert weights.amplification > 2
    assert estimate_rounding_error(orbit) == pytest.approx(np.finfo(float).eps * weights.amplification)
