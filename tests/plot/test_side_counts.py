"""Numbers of unstable roots on the two sides of a curve."""

import numpy as np
import pytest

from pddecont.plot.columns import read_column
from pddecont.plot.side_counts import name_counts, write_side_counts
from pddecont.plot.special_points import CurveSort


def draw(axes, step):
    """Draw a curve, and return the numbers beside it with their places."""
    axes.plot(read_column(step, "K"), read_column(step, "tau_d"))
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(2.8, 4.2)
    n = write_side_counts(axes, step, "K", "tau_d")
    assert n == len(axes.texts)
    return [(text.get_text(), *text.get_position()) for text in axes.texts]


def test_of_hopf_points_two_more_are_unstable_on_the_other_side(resting, axes):
    """The side is (1, -1): below tau_d = 3 + K. Beyond K = 0.5 another pair is unstable everywhere."""
    found = draw(axes, resting.step("hopf"))
    sides = {(text, y < 3.0 + x, x < 0.5) for text, x, y in found}
    assert sides == {("0", True, True), ("2", False, True), ("2", True, False), ("4", False, False)}
    for _, x, y in found:
        # Close to the curve: 8.5 points of a panel some 250 points high and wide.
        assert 0.01 < abs(y - 3.0 - x) < 0.15


def test_beside_folds_there_are_two_equilibria_on_one_side(resting, axes):
    [(text, x, y)] = draw(axes, resting.step("folds"))
    assert text == "1, 2"
    assert y < 3.9 - x


def test_numbers_avoid_other_curves(resting, axes):
    # A line close below the first half of the curve but for its beginning.
    K = np.linspace(0.2, 0.5, 20)
    axes.plot(K, 2.93 + K)
    found = draw(axes, resting.step("hopf"))
    assert all(x < 0.2 for text, x, y in found if text == "0")


@pytest.mark.parametrize(("x", "y"), [("K", "omega"), ("omega", "tau_d")])
def test_there_are_none_in_another_plane(resting, axes, x, y):
    assert write_side_counts(axes, resting.step("hopf"), x, y) == 0


def test_curves_of_orbits_and_of_boundary_equilibria_have_none(resting, axes):
    assert draw(axes, resting.step("orbit_folds")) == []
    assert draw(axes, resting.step("boundaries")) == []
    assert name_counts(CurveSort("HB", of_equilibria=True), 3) == ("3", "5")


def test_a_curve_that_lies_on_another_adds_no_numbers(resting, axes):
    found = draw(axes, resting.step("hopf"))
    assert write_side_counts(axes, resting.step("hopf"), "K", "tau_d") == 0
    assert len(axes.texts) == len(found)


def test_numbers_without_room_are_left_out(resting, axes):
    for gap in np.linspace(-0.3, 0.3, 25):
        axes.plot([0.0, 1.0], [3.0 + gap, 4.0 + gap])
    assert draw(axes, resting.step("hopf")) == []
