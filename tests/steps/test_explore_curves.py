"""Which special points lie on a curve that is there already."""

import numpy as np
import pytest

from pddecont.exploration import Fingerprint
from pddecont.steps.execution.explore_curves import Curve
from pddecont.tables import list_branches
from tests.bifurcation.test_grazing import TWO_WALLS
from tests.runs import parameter, run

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


def test_where_two_grazings_meet_both_curves_are_followed(tmp_path):
    """The free orbit grazes one wall where A(omega) = a, the other where A = 0.2; curves of others pass by there."""
    explore = {"over": {"omega": [2.2, 2.7], "a": [0.15, 0.25]}, "starts": 4, "check": 0, "depth": 0}
    step = {"name": "all", "set": {"c": 1, "b": 0.2, "a": 0.18}, "explore": explore}
    results = run({**TWO_WALLS, "run": {"steps": [step]}}, tmp_path / "a.h5")
    (found,) = [entry for entry in list_branches(results.step("all")) if entry["from"].endswith("GG1")]
    curve, first = results.step(found["branch"]), results.step(found["from"].split()[0])
    assert (first.meta["curve"], curve.meta["curve"]) == ("GR", "GR")
    omega = np.sqrt(0.5 * (1 + np.sqrt(97)))
    assert parameter(first, "omega", "GG1") == pytest.approx(omega, abs=1e-9)
    assert parameter(curve, "omega") == pytest.approx(omega, abs=1e-9)
    assert (np.min(parameter(curve, "a")), np.max(parameter(curve, "a"))) == pytest.approx((0.2, 0.25), abs=1e-9)
