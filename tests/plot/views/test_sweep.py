"""Brute-force diagrams show the numbers in the file."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from pddecont.errors import ResultsError
from pddecont.plot import class_colours
from pddecont.plot.class_colours import OTHER_COLOUR, assign_class_colours, find_middle
from pddecont.plot.region_labels import find_inside
from pddecont.plot.style_sheet import apply_style
from pddecont.plot.views import sweep
from pddecont.plot.views.sweep import choose_state, draw_classes, draw_returns
from tests.plot.drawn import legend

CLASSES = ["period 2, 1 NC, 1 C", "period 2, 2 NC, 2 C"]


def test_every_return_is_a_dot_in_its_classes_colour(simulated, axes):
    step = simulated.steps["diagram"]
    labels, handles = draw_returns(axes, [step], "beta", "x")
    assert not labels
    dots = np.concatenate([line.get_xydata() for line in axes.lines])
    recorded = np.concatenate(
        [
            np.stack([np.full(2, step.points["parameters"][i, 4]), step.orbit(i)["returns"][:, 0]], axis=1)
            for i in range(len(step))
        ]
    )
    assert {tuple(d) for d in dots} == {tuple(d) for d in recorded}
    assert [h.get_label() for h in handles] == list(assign_class_colours([step]).colours) == CLASSES
    assert choose_state([step]) == "x"


@pytest.fixture
def rename(monkeypatch):
    """Return a function that gives each row of a sweep the class that ``name(step, row)`` says."""

    def patch(name):
        for module in (sweep, class_colours):
            monkeypatch.setattr(module, "name_motion", name)

    return patch


def test_many_classes_are_numbered_in_the_order_of_their_periods(simulated, rename, monkeypatch):
    rename(lambda step, i: f"class {i:02}")
    step = simulated.steps["diagram"]
    n = len(step)
    few = assign_class_colours([step])
    assert set(few.colours) == {f"class {i:02}" for i in range(n)}
    assert not few.numbers
    monkeypatch.setattr(class_colours, "MAX_UNNUMBERED", 2)
    many = assign_class_colours([step])
    assert list(many.numbers.values()) == list(range(1, n + 1))
    assert [text for text, _ in many.list_legend()] == [f"{k}: {name}" for k, name in enumerate(many.colours, 1)]
    periods = [step.points["period"][int(name[-2:])] or np.inf for name in many.colours]
    assert periods == sorted(periods)
    assert len(set(many.colours.values())) == n


@pytest.mark.parametrize("name", ["diagram", "plane"])
def test_the_numbers_of_classes_stand_in_the_picture(simulated, show, rename, monkeypatch, name):
    monkeypatch.setattr(class_colours, "MAX_UNNUMBERED", 1)
    rename(lambda step, i: f"class {i % 3}")
    figure = show(simulated, "sweep", (name,))
    written = {text.get_text() for text in figure.axes[0].texts}
    assert {"1", "2", "3"} <= {number for text in written for number in text.split(", ")}
    assert [text for text in legend(figure) if text[0].isdigit()] == ["1: class 0", "2: class 1", "3: class 2"]


def test_a_number_stands_in_the_middle_of_where_its_class_is_found():
    assert find_middle(np.array([5.0, 1.0, 1.1, 1.2, 1.3, 1.4, 5.1])) == 3
    assert find_middle(np.array([2.0, 2.0, 2.0])) == 1
    image = np.zeros((6, 9), dtype=bool)
    image[1:4, 2:7] = True
    assert find_inside(image) == (2, 3)


def test_over_two_parameters_the_class_of_most_starts_is_shown(simulated, axes):
    step = simulated.steps["plane"]
    handles = draw_classes(axes, step, "beta", "a")
    image = np.asarray(axes.collections[0].get_array()).reshape(2, 3)
    assert image.shape == (2, 3)
    assert set(np.unique(image)) <= set(range(len(handles)))
    assert (axes.get_xlabel(), axes.get_ylabel()) == (r"$\beta$", "$a$")


def test_exponents_have_a_panel_of_their_own_below(simulated, show):
    diagram, exponents = show(simulated, "sweep", ("diagram",)).axes
    assert (diagram.get_xlabel(), exponents.get_ylabel()) == ("", "largest Lyapunov exponent")
    recorded = simulated.steps["diagram"].points["lyapunov"]
    drawn = np.concatenate(
        [line.get_ydata() for line in exponents.lines if len(line.get_ydata()) and line.get_marker() == "."]
    )
    assert sorted(drawn) == sorted(recorded)
    assert len(show(simulated, "sweep", ("plane",)).axes) == 1


def test_branches_are_named_beside_the_classes(simulated, show):
    figure = show(simulated, "sweep", ("branch", "diagram"), y="v")
    assert list(legend(figure)) == [*CLASSES, "followed: orbits"]
    assert figure.axes[0].get_ylabel() == "$v$ at returns"


def test_what_is_no_parameter_is_said(simulated, show):
    with pytest.raises(ResultsError, match="no parameter 'bet'; did you mean 'beta'"):
        show(simulated, "sweep", ("diagram",), x="bet")


@pytest.fixture
def many_classes(simulated, rename, monkeypatch):
    """The results of sweeps in which every attractor is of a class of its own, with a long name."""
    rename(lambda step, i: f"period {i + 1}, {i + 1} of one segment, {i} of another")
    monkeypatch.setattr(class_colours, "MAX_CLASSES", 3)
    return simulated


@pytest.mark.parametrize("step", ["diagram", "plane"])
def test_classes_without_a_colour_of_their_own_are_one_line_of_the_legend(many_classes, show, step):
    n = len(many_classes.steps[step])
    figure = show(many_classes, "sweep", (step,))
    names = [name for name in legend(figure) if not name.startswith("followed")]
    assert [name.split(",")[0] for name in names] == ["period 1", "period 2", "period 3", f"{n - 3} other classes"]
    assert to_hex(legend(figure)[names[-1]]) == to_hex(OTHER_COLOUR)


@pytest.mark.parametrize("step", ["diagram", "plane"])
def test_the_diagram_keeps_its_room(simulated, show, step, rename):
    heights = []
    for words in ("", " of a name that goes on and on, with the number of each segment"):
        rename(lambda _, i, words=words: f"{i}{words}")
        with apply_style():
            figure = show(simulated, "sweep", (step,))
            figure.draw_without_rendering()
        heights.append(sum(axes.get_window_extent().height for axes in figure.axes) / figure.dpi)
    assert heights[1] > 0.9 * heights[0]
