"""How fast orbits cross the events that end their segments, against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pddecont.bifurcation.crossing_rates import find_crossing_rate, find_crossing_rates, find_smallest_crossing_rate
from pddecont.orbit import Orbit, Signature
from tests.problems import WALL


def in_direction(orbit, direction):
    """Return an orbit whose segments are said to meet their events in another direction."""
    segments = tuple(replace(segment, direction=direction) for segment in orbit.problem.segments)
    return Orbit(replace(orbit.problem, signature=Signature(orbit.numeric, segments)), orbit.x)


def test_a_wall_is_met_at_the_speed_before_the_impact(hop_orbit):
    speed = WALL["v_out"] / -0.8
    assert find_crossing_rate(hop_orbit, 0) == pytest.approx(speed, abs=1e-8)
    assert find_crossing_rate(hop_orbit, 0) == pytest.approx(hop_orbit.values[-1, 1], abs=1e-8)
    assert find_smallest_crossing_rate(hop_orbit) == find_crossing_rate(hop_orbit, 0)


def test_a_rate_is_positive_in_the_direction_listed(ball_orbit):
    """The ball falls onto the table at 2 pi / (1 + r), so that it flies for one period of the table."""
    assert find_crossing_rate(ball_orbit, 0) == pytest.approx(2 * math.pi / 1.8, abs=1e-8)
    assert find_crossing_rate(in_direction(ball_orbit, "rising"), 0) == pytest.approx(-2 * math.pi / 1.8, abs=1e-8)


@pytest.mark.parametrize("name", ["hop_orbit", "ball_orbit"])
def test_an_event_of_any_direction_is_met_from_the_side_of_the_segment(name, request):
    """The oscillator lies below its wall, the ball above its table."""
    orbit = request.getfixturevalue(name)
    assert find_crossing_rate(in_direction(orbit, "any"), 0) == pytest.approx(find_crossing_rate(orbit, 0), abs=1e-12)


def test_each_segment_has_its_own_rate(soft_orbit):
    """The contact begins at the speed inward and ends at the speed outward."""
    speeds = soft_orbit.values[soft_orbit.mesh.last_base, 1] * [1.0, -1.0]
    assert find_crossing_rates(soft_orbit) == pytest.approx(speeds, abs=1e-6)
    assert find_smallest_crossing_rate(soft_orbit) == pytest.approx(np.min(speeds), abs=1e-6)
    assert np.all(speeds > 0.1)


def test_an_orbit_that_ends_at_no_event_function_has_no_rate(free_orbit):
    assert np.all(np.isnan(find_crossing_rates(free_orbit)))
    assert math.isnan(find_smallest_crossing_rate(free_orbit))
