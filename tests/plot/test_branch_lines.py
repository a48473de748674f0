"""Branches are drawn part by part, as their orbits are."""

import numpy as np
import pytest

from pddecont.plot.branch_lines import THINNER, draw_parts
from pddecont.plot.columns import read_column
from pddecont.plot.smooth_lines import PIECES
from tests.plot.drawn import lines
from tests.plot.synthetic import point


def test_parts_are_drawn_in_their_style_and_the_colour_of_their_family(every, axes):
    step = every.step("in_gain")
    xs, ys = read_column(step, "K"), read_column(step, "top")[None]
    draw_parts(
        axes, step, np.vstack([xs, ys]), lambda step, family: "red" if "C" in family.signature.split() else "blue", 2.0
    )
    drawn = {(line.get_linestyle(), line.get_color(), line.get_linewidth()) for line in axes.lines}
    assert drawn == {("-", "red", 2.0), ("--", "red", 2.0), ("--", "blue", 2.0), (":", "blue", 2.0 - THINNER)}
    places = np.concatenate([xy for style in ("-", "--", ":") for xy in lines(axes, style)])
    assert places[:, 1] == pytest.approx(np.sqrt(places[:, 0]), rel=1e-3)
    assert {line.get_marker() for line in axes.lines} == {"None"}


def test_a_few_points_are_marked(made, axes):
    step = made(b=([point(0.0, 0.2, 3, 1), point(1.0, 0.5, 3, 2)], {})).step("b")
    draw_parts(axes, step, np.array([[0.2, 0.5], [1.0, 2.0]]), lambda step, family: "red", 2.0)
    assert [line.get_marker() for line in axes.lines] == ["."]


def test_two_lines_are_drawn_for_each_part(made, axes):
    step = made(b=([point(float(k), 0.1 * k, 3, 1, stable=int(k < 2)) for k in range(5)], {})).step("b")
    draw_parts(axes, step, np.array([np.arange(5.0), np.ones(5), -np.ones(5)]), lambda step, family: "red", 2.0)
    drawn = sorted((line.get_linestyle(), *line.get_ydata()[::PIECES]) for line in axes.lines)
    assert drawn == [("-", -1.0, -1.0), ("-", 1.0, 1.0), ("--", *[-1.0] * 4), ("--", *[1.0] * 4)]


def test_points_on_no_branch_are_marks_that_nothing_joins(resting, axes):
    step = resting.step("all")
    xs, ys = read_column(step, "x"), read_column(step, "v")[None]
    draw_parts(axes, step, np.vstack([xs, ys]), lambda step, family: "red", 2.0)
    found = [(line.get_linestyle(), line.get_marker(), line.get_fillstyle(), *line.get_xdata()) for line in axes.lines]
    assert found == [("None", "o", "full", -1.0), ("None", "o", "none", 0.0), ("None", "x", "full", 1.0)]
