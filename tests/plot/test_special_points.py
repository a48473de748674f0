"""Special points: their kinds, marks and labels."""

import pytest

from pddecont.bifurcation import list_kinds
from pddecont.plot.special_points import find_special_rows, mark_special_points, read_curve_kind, read_kind
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
    assert (read_curve_kind(step), read_curve_kind(results.step("curve"))) == ("", "ZZ")
    assert read_kind(every.step("folds"), 10) == "R1"


def test_unknown_kinds_have_a_spare_marker_and_their_label(results, axes):
    labels = mark_special_points(axes, results.step("branch"), "K", "top")
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
