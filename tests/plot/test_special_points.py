"""Special points: their kinds, marks and labels."""

import numpy as np
import pytest

from pddecont.bifurcation import list_kinds
from pddecont.plot.columns import read_column
from pddecont.plot.point_labels import PointLabel
from pddecont.plot.special_points import (
    MOST_NAMED,
    CurveSort,
    find_special_rows,
    mark_special_points,
    name_apart,
    read_curve_sort,
    read_kind,
)
from pddecont.plot.style import OTHER_MARKER, find_marker
from tests.plot.drawn import legend, texts
from tests.plot.synthetic import point

OWN = ("ZZ", "Q9", "SLIDE")


@pytest.fixture
def results(made):
    """Return a branch and a curve with end points and special points of kinds that pictures do not know."""
    rows = [
        point(float(k), 0.1 * k, 3.0 + 0.1 * k, 1.0 + k, kind=kind, multipliers=[0.1 * k])
        for k, kind in enumerate(("EP", "", *OWN, "LP", "EP"))
    ]
    return made(branch=(rows, {}), curve=(rows, {"free": ("K", "tau_d"), "curve": "ZZ", "side": True}))


def test_kinds_are_recorded_not_read_from_labels(results, every):
    step = results.step("branch")
    assert [read_kind(step, i) for i in range(7)] == ["EP", "", *OWN, "LP", "EP"]
    assert find_special_rows(step) == [2, 3, 4, 5]
    assert [read_curve_sort(results.step(name)) for name in ("branch", "curve")] == [CurveSort(""), CurveSort("ZZ")]
    assert read_kind(every.step("folds"), 10) == "R1"


def test_unknown_kinds_have_a_spare_marker_and_their_label(results, axes):
    step = results.step("branch")
    labels = mark_special_points(axes, step, read_column(step, "K"), read_column(step, "top")[None])
    assert [label.text for label in labels] == ["ZZ1", "Q9_1", "SLIDE1", "LP1"]
    assert [line.get_marker() for line in axes.lines] == [OTHER_MARKER] * 3 + [find_marker("LP")]
    assert OTHER_MARKER not in {find_marker(kind.label) for kind in list_kinds()}


@pytest.mark.parametrize("view", ["diagram", "plane", "multipliers"])
def test_unknown_kinds_are_in_every_picture(results, show, view):
    step = "branch" if view == "diagram" else "curve"
    figure = show(results, view, (step,))
    named = {*texts(figure.axes[0]), *(axes.get_title().split()[0] for axes in figure.axes if axes.get_title())}
    assert {"ZZ1", "Q9_1", "SLIDE1"} <= named | {text.split()[0] for text in legend(figure)}
    if view == "plane":
        assert {"ZZ", "SLIDE: SLIDE"} <= set(legend(figure))


def test_marks_are_on_all_lines_and_labels_on_the_first(results, axes):
    heights = np.array([np.arange(7.0), -np.arange(7.0)])
    labels = mark_special_points(axes, results.step("branch"), np.arange(7.0), heights)
    assert [(*line.get_xdata(), *line.get_ydata()) for line in axes.lines] == [(k, k, k, -k) for k in (2, 3, 4, 5)]
    assert [(label.x, label.y) for label in labels] == [(k, k) for k in (2, 3, 4, 5)]


def test_curves_of_equilibria_are_of_another_sort_than_those_of_orbits(every, resting):
    of_orbits, of_equilibria = read_curve_sort(every.step("folds")), read_curve_sort(resting.step("folds"))
    assert (of_orbits, of_equilibria) == (CurveSort("LP"), CurveSort("LP", of_equilibria=True))
    assert of_orbits.colour != of_equilibria.colour


def test_a_text_that_would_stand_for_two_points_says_of_which_step_it_is():
    first = [PointLabel("PD1", 1.0, 2.0), PointLabel("LP1", 0.0, 0.0), PointLabel("GR1", 0.5, 1.0)]
    # The same point of another step, to rounding; another with the same name; one with a name of its own.
    second = [PointLabel("PD1", 1.0 + 1e-9, 2.0), PointLabel("LP1", 0.0, 1.0), PointLabel("LP2", 0.0, 0.0)]
    found = name_apart({"a": first, "b": second})
    assert [label.text for label in found] == ["PD1", "a: LP1", "GR1", "PD1", "b: LP1", "LP2"]
    assert [(label.x, label.y) for label in found] == [(label.x, label.y) for label in (*first, *second)]


def test_of_many_steps_labels_stay_short():
    labels = {f"branch_{k}": [PointLabel("PD1", float(k), 0.0)] for k in range(MOST_NAMED + 1)}
    assert {label.text for label in name_apart(labels)} == {"PD1"}
    del labels["branch_0"]
    assert {label.text for label in name_apart(labels)} == {f"branch_{k}: PD1" for k in range(1, MOST_NAMED + 1)}
    assert name_apart({"a": []}) == []
