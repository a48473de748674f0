"""Distances of orbits as sets of states, on circles."""

import numpy as np
import pytest

from pddecont.orbit import Orbit, measure_distance
from tests.orbit.exact import circle


def test_neither_phase_nor_segments_matter():
    """The circle from two levels, through one segment or none, is one orbit to what its polygon misses."""
    assert measure_distance(circle("s", level=0.3), circle("s", level=0.7)) < 2e-5
    assert measure_distance(circle(), circle("s")) < 2e-5


@pytest.mark.parametrize("factor", [1.001, 1.05, 0.9])
def test_a_larger_circle_is_as_far_away_as_its_radius_is_longer(factor):
    one = circle()
    other = Orbit(one.problem, one.problem.unknowns.join(factor * one.values, one.durations, one.start, one.free))
    assert measure_distance(other, one) == pytest.approx(abs(factor - 1.0), abs=1e-5)


def test_periods_count():
    """Two turns are no nearer to one for having the same states."""
    assert measure_distance(circle("s", "s"), circle("s")) == pytest.approx(1.0)


def test_distance_counts_both_ways():
    """Half a circle lies on the whole one, which does not lie on it."""
    whole = circle()
    t = whole.mesh.base_times(whole.theta)
    half = np.stack([np.cos(t / 2), np.sin(t / 2)], axis=1)
    other = Orbit(whole.problem, whole.problem.unknowns.join(half, whole.durations, whole.start, whole.free))
    assert measure_distance(other, whole) == pytest.approx(measure_distance(whole, other), rel=0.5)
    assert measure_distance(other, whole) > 0.9
