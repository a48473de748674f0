"""Branches that come back to where they began."""

import math

import numpy as np
import pytest

from pddecont.continuation import End, Home, StepSettings, TestFunctions, follow_branch
from tests.continuation.systems import Range, circle, line, start_at

WIDE = Range(0, -10.0, 10.0)


def follow_home(system, x, towards, *, error=0.0, images=1, **settings):
    """Return the points of a branch that is followed until it is back at ``x``, and how it ended.

    Of several ``images`` all but the last lie far away.
    """
    state, points = start_at(system, x, towards), []
    here, ahead = (np.asarray(x) + step * state.tangent for step in (0.0, 1e-3))
    away = 100.0 * np.arange(images)[::-1, None]
    home = Home(lambda at: list(here + away), lambda at: list(ahead + away), lambda at: error)
    options = StepSettings(**{"max": 0.3, **settings})
    return points, follow_branch(state, [WIDE], TestFunctions(), options, points.append, 1, home)


@pytest.mark.parametrize("towards", [(0.0, 1.0), (0.0, -1.0)])
@pytest.mark.parametrize("images", [1, 3])
def test_a_circle_is_closed(towards, images):
    points, end = follow_home(circle(), [1.0, 0.0], towards, images=images)
    assert end.end == End.CLOSED
    assert points[-1].kind == "EP"
    assert np.allclose(points[-1].state.x, [1.0, 0.0], atol=1e-9)
    # Chords are shorter than the circle.
    assert 0.95 * 2 * math.pi < points[-1].state.arclength < 2 * math.pi
    angles = np.unwrap([math.atan2(p.state.x[1], p.state.x[0]) for p in points])
    assert abs(angles[-1] - angles[0]) < 2 * math.pi


def test_without_a_home_it_goes_round_and_round():
    state, points = start_at(circle(), [1.0, 0.0], (0.0, 1.0)), []
    end = follow_branch(state, [WIDE], TestFunctions(), StepSettings(max=0.3, max_points=60), points.append, 1)
    assert end.end == End.MAX_POINTS


def test_a_branch_that_passes_beside_its_home_goes_on():
    """On the circle of radius 1, with a home at radius 1.001."""
    state, points = start_at(circle(), [1.0, 0.0], (0.0, 1.0)), []
    here = np.array([1.001, 0.0])
    home = Home(lambda at: [here], lambda at: [np.array([1.001, 1e-3])], lambda at: 1e-6)
    end = follow_branch(state, [WIDE], TestFunctions(), StepSettings(max=0.3, max_points=60), points.append, 1, home)
    assert end.end == End.MAX_POINTS


def test_a_branch_that_comes_the_other_way_is_not_closed():
    state, points = start_at(circle(), [1.0, 0.0], (0.0, 1.0)), []
    here = np.array([1.0, 0.0])
    home = Home(lambda at: [here], lambda at: [np.array([1.0, -1e-3])], lambda at: 0.0)
    end = follow_branch(state, [WIDE], TestFunctions(), StepSettings(max=0.3, max_points=60), points.append, 1, home)
    assert end.end == End.MAX_POINTS


def test_a_line_does_not_come_back():
    points, end = follow_home(line(), [0.0, 0.0], (1.0, 1.0), max=2.0)
    assert end.end == End.RANGE
    assert points[-1].state.x[0] == pytest.approx(10.0, abs=1e-12)


def test_a_solution_that_cannot_be_the_home_has_no_images():
    state, points = start_at(circle(), [1.0, 0.0], (0.0, 1.0)), []
    home = Home(lambda at: [], lambda at: [], lambda at: 0.0)
    end = follow_branch(state, [WIDE], TestFunctions(), StepSettings(max=0.3, max_points=60), points.append, 1, home)
    assert end.end == End.MAX_POINTS
