"""Branches are drawn part by part, as their orbits are."""

import numpy as np
import pytest

from pddecont.plot.branch_lines import THINNER, draw_parts
from tests.plot.drawn import lines
from tests.plot.synthetic import point


def test_parts_are_drawn_in_their_style_and_the_colour_of_their_family(every, axes):
    step = every.step("in_gain")
    draw_parts(axes, step, ("K", "top"), lambda step, family: "red" if "C" in family.signature.split() else "blue", 2.0)
    drawn = {(line.get_linestyle(), line.get_color(), line.get_linewidth()) for line in axes.lines}
    assert drawn == {("-", "red", 2.0), ("--", "red", 2.0), ("--", "blue", 2.0), (":", "blue", 2.0 - THINNER)}
    places = np.concatenate([xy for style in ("-", "--", ":") for xy in lines(axes, style)])
    assert places[:, 1] == pytest.approx(np.sqrt(places[:, 0]), abs=1e-12)
    assert {line.get_marker() for line in axes.lines} == {"None"}


def test_a_few_points_are_marked(made, axes):
    step = made(b=([point(0.0, 0.2, 3, 1), point(1.0, 0.5, 3, 2)], {})).step("b")
    draw_parts(axes, step, ("K", "top"), lambda step, family: "red", 2.0)
    assert [line.get_marker() for line in axes.lines] == ["."]
