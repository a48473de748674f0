"""Panels of figures."""

import pytest

from pddecont.plot.layouts import make_panel_beside_orbits, make_panels, make_stack
from pddecont.plot.segment_colours import match_diagram


@pytest.mark.parametrize(("n", "rows", "columns"), [(1, 1, 1), (2, 1, 2), (3, 1, 3), (4, 2, 2), (5, 2, 3), (6, 2, 3)])
def test_panels_of_equal_size(n, rows, columns):
    figure, panels = make_panels(n)
    assert len(panels) == n
    grid = panels[0].get_gridspec()
    assert (grid.nrows, grid.ncols) == (rows, columns)
    assert [axes.get_visible() for axes in figure.axes] == [True] * n + [False] * (rows * columns - n)


def test_a_stack_has_one_horizontal_axis():
    _, (upper, lower) = make_stack(6.0, 4.0, 2, [2, 1])
    lower.set_xlim(3, 4)
    assert upper.get_xlim() == (3, 4)
    assert upper.get_gridspec().get_height_ratios() == [2, 1]


def test_orbits_stand_beside_the_large_panel(every):
    step = every.step("in_gain")
    rows = [(step, 8), (step, 16)]
    figure, axes = make_panel_beside_orbits([step], rows, match_diagram([step], rows))
    assert figure.axes[0] is axes
    assert [panel.get_title()[:3] for panel in figure.axes[1:]] == ["LP1", "GR1"]
    figure, _ = make_panel_beside_orbits([step], [], [])
    assert len(figure.axes) == 1
