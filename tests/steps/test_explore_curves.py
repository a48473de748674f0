"""Which special points lie on a curve that is there already."""

import numpy as np
import pytest

from pddecont.exploration import Fingerprint
from pddecont.steps.execution.explore_curves import Curve

SCALE = np.ones(1)


def motion(height, period=1.0):
    """Return a motion of one state between -1 and a height."""
    return Fingerprint(period, np.array([[-1.0], [height], [0.0], [0.5]]))


def curve(kind, *, period=1.0):
    """Return a curve along the diagonal of the plane; the height of its motions grows along it."""
    along = np.linspace(0.0, 1.0, 21)
    motions = [motion(1.0 + s, period) for s in along]
    return Curve(None, kind, np.arange(21), np.column_stack([along, along]), motions)


def test_a_point_between_two_of_a_curve_with_its_motion_is_on_it():
    assert curve("GR").holds(motion(1.475), np.array([0.475, 0.475]), SCALE)
    assert curve("GR").passes(np.array([0.475, 0.475]))


@pytest.mark.parametrize(
    ("place", "at", "why"),
    [
        ((0.475, 0.52), motion(1.475), "it lies elsewhere"),
        ((0.475, 0.475), motion(1.7), "its motion is another one"),
        ((0.475, 0.475), motion(1.475, 2.0), "its orbit is twice as long"),
    ],
)
def test_other_points_are_not_on_it(place, at, why):
    assert not curve("GR").holds(at, np.array(place), SCALE), why


@pytest.mark.parametrize(("own", "other"), [(1.0, 2.0), (2.0, 1.0)])
def test_a_period_doubling_is_that_of_the_doubled_orbit_too(own, other):
    assert curve("PD", period=own).holds(motion(1.3, other), np.array([0.3, 0.3]), SCALE)


def test_a_curve_of_one_point_holds_that_point():
    single = Curve(None, "GR", np.arange(1), np.array([[0.5, 0.5]]), [motion(1.0)])
    assert single.holds(motion(1.0), np.array([0.5, 0.5]), SCALE)
    assert not single.holds(motion(1.0), np.array([0.5, 0.6]), SCALE)
