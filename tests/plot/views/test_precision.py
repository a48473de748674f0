"""Work-precision diagrams show the numbers in the file."""

import numpy as np
import pytest

from pddecont.plot.views.precision import draw_work, list_costs
from tests.plot.drawn import legend


def test_errors_are_drawn_against_cost_with_their_slopes(compared, axes):
    handles = draw_work(axes, compared.step("fine"), "n_unknowns")
    assert [h.get_label() for h in handles] == ["direct, slope -4.0", "chain of order 1, slope -4.0"]
    best = handles[0].get_xydata()
    assert best == pytest.approx(np.array([[10 * n, n**-4.0] for n in (4, 8, 16, 32)]))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("unknowns", r"relative error of $\mathit{top}$")
    assert axes.texts[0].get_text() == "error of the reference"
    assert not axes.collections


def test_times_have_their_spread(compared, axes):
    draw_work(axes, compared.step("fine"), "cpu")
    [first, _] = axes.collections
    ends = np.array([segment[:, 0] for segment in first.get_segments()])
    assert ends == pytest.approx(np.array([[0.45 * n, 0.6 * n] for n in (4, 8, 16, 32)]))


def test_a_panel_for_each_cost_and_for_the_distance(compared, show):
    assert list_costs(compared.step("fine")) == ["cpu", "n_unknowns"]
    figure = show(compared)
    assert [axes.get_xlabel() for axes in figure.axes] == ["CPU time (s)", "unknowns", "N"]
    assert [axes.get_ylabel() for axes in figure.axes] == [r"relative error of $\mathit{top}$", "", "Dist(N)"]
    assert len(legend(figure)) == 2
    assert [axes.get_xlabel() for axes in show(compared, "precision", x="memory").axes] == ["memory (bytes)"]
