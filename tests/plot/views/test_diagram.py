"""What a bifurcation diagram shows."""

import numpy as np
import pytest

from pddecont.errors import ResultsError
from pddecont.plot.smooth_lines import PIECES
from pddecont.plot.style import COLOURS
from tests.plot.drawn import coloured, legend, lines, span, texts


def test_stability_and_admissibility_choose_the_line(every, show):
    axes = show(every, "diagram", ("in_gain",)).axes[0]
    assert [span(xy) for xy in lines(axes, "-")] == [pytest.approx((0.1, 0.3))]
    assert [span(xy) for xy in lines(axes, "--")] == [pytest.approx((0.3, 0.5)), pytest.approx((0.5, 0.775))]
    assert [span(xy) for xy in lines(axes, ":")] == [pytest.approx((0.775, 0.9))]
    for style in ("-", "--", ":"):
        for xy in lines(axes, style):
            assert xy[::PIECES, 1] == pytest.approx(np.sqrt(xy[::PIECES, 0]))
            assert xy[:, 1] == pytest.approx(np.sqrt(xy[:, 0]), rel=1e-3)


def test_each_signature_has_its_colour_and_its_name_in_the_legend(every, show):
    figure = show(every, "diagram", ("in_gain",))
    assert coloured(figure.axes[0], "-") == [COLOURS[0]]
    assert coloured(figure.axes[0], "--") == [COLOURS[0], COLOURS[1]]
    names = legend(figure)
    assert list(names) == ["NC C", "NC", "stable", "unstable", "not admissible"]
    assert names["NC C"] == COLOURS[0]
    assert names["NC"] == COLOURS[1]


def test_branches_in_the_same_parameter_are_drawn_together(every, show):
    figure = show(every, "diagram")
    drawn = lines(figure.axes[0], "-")
    assert [span(xy) for xy in drawn] == [pytest.approx((0.1, 0.3)), pytest.approx((0.2, 0.6))]
    assert figure.axes[0].get_xlabel() == "$K$"
    assert list(legend(figure))[:3] == ["NC C, 1 period", "NC, 1 period", "(NC C)×2, 2 periods"]
    assert [span(xy) for xy in lines(show(every, "diagram", ("in_delay",)).axes[0], "-")] == [(3.0, 4.0)]


def test_steps_that_are_asked_for_are_drawn_and_no_other(every, show):
    figure = show(every, "diagram", ("in_delay", "doubled"), x="K")
    assert len(figure.axes[0].lines) == 3
    assert set(legend(figure)) == {"NC C, 1 period", "(NC C)×2, 2 periods"}


def test_branches_of_one_family_are_told_apart_by_step(every, show):
    figure = show(every, "diagram", ("in_delay", "folds"), x="tau_d", y="top")
    assert legend(figure) == {"in_delay": COLOURS[0], "folds": COLOURS[1]}


def test_one_family_of_one_step_needs_no_legend(every, show):
    assert legend(show(every, "diagram", ("in_delay",))) == {}


def test_old_files_are_drawn_as_before(old, show):
    figure = show(old)
    axes = figure.axes[0]
    assert [span(xy) for xy in lines(axes, "-")] == [pytest.approx((0.1, 0.5))]
    assert not lines(axes, "--")
    assert legend(figure) == {}
    assert set(texts(axes)) == {"LP1", "GR1"}
    assert len(figure.axes) == 3


def test_special_points_are_marked_where_they_are(every, show):
    figure = show(every, "diagram", ("in_gain",))
    axes = figure.axes[0]
    marks = {line.get_marker(): line.get_xydata()[0] for line in axes.lines if len(line.get_xydata()) == 1}
    assert marks == {"s": pytest.approx([0.3, np.sqrt(0.3)]), "o": pytest.approx([0.5, np.sqrt(0.5)])}
    assert texts(axes)["GR1"].xy == pytest.approx((0.5, np.sqrt(0.5)))
    assert [a.get_title() for a in figure.axes[1:]] == ["LP1  $K$ = 0.3", "GR1  $K$ = 0.5"]


def test_points_asked_for_are_shown_beside_the_diagram(every, show):
    figure = show(every, "diagram", labels=("GR1",), indices=(3,))
    assert figure.axes[1].get_title().startswith("GR1")
    assert f"{0.2 + 3 * 0.4 / 11:.6g}" in figure.axes[2].get_title()
    with pytest.raises(ResultsError, match="12 points, no index 99"):
        show(every, "diagram", indices=(99,))
    with pytest.raises(ResultsError, match="step 'doubled' has no point 'LP7'"):
        show(every, "diagram", labels=("LP7",))


def test_any_number_of_a_point_can_be_drawn(every, show):
    axes = show(every, "diagram", ("in_gain",), y="n_unstable").axes[0]
    drawn = np.vstack([*lines(axes, "-"), *lines(axes, "--"), *lines(axes, ":")])
    assert {tuple(np.round(xy, 6)) for xy in drawn} >= {(0.1, 0), (0.9, 3)}
    with pytest.raises(ResultsError, match="no column 'tp'; did you mean 'top'"):
        show(every, "diagram", y="tp")


def test_equilibria_and_orbits_are_in_one_picture(resting, show):
    figure = show(resting, "diagram", ("resting", "cycles"))
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$K$", "$x$")
    low, high, _ = list(legend(figure).values())[:3]
    names = list(legend(figure))
    assert names == ["equilibria, low", "equilibria, high", "orbits", "stable", "unstable", "virtual"]
    solid = lines(axes, "-")
    assert [span(xy) for xy in solid] == [pytest.approx(ends) for ends in ((0.1, 0.3), (0.3, 0.7), (0.3, 0.7))]
    assert solid[0][:, 1] == pytest.approx(solid[0][:, 0])
    K = solid[1][:, 0]
    assert solid[1][:, 1] == pytest.approx(K + 0.4 * (K - 0.3), abs=1e-12)
    assert solid[2][:, 1] == pytest.approx(K - 0.09 * (K - 0.3), abs=1e-4)
    assert [span(xy) for xy in lines(axes, "--")] == [pytest.approx((0.3, 0.5)), pytest.approx((0.5, 0.775))]
    assert [span(xy) for xy in lines(axes, ":")] == [pytest.approx((0.775, 0.9))]
    assert coloured(axes, "--") == [low, high]
    assert set(texts(axes)) == {"HB1", "BE1"}
    assert texts(axes)["HB1"].xy == pytest.approx((0.3, 0.3))


def test_equilibria_and_orbits_are_drawn_by_a_monitor_that_both_have(resting, show):
    axes = show(resting, "diagram", ("resting", "cycles"), y="top").axes[0]
    assert axes.get_ylabel() == r"$\mathit{top}$"
    assert len(lines(axes, "-")) == 2


def test_a_state_may_be_asked_for_of_orbits_alone(resting, show):
    axes = show(resting, "diagram", ("cycles",), y="x").axes[0]
    assert [span(xy) for xy in lines(axes, "-")] == [pytest.approx((0.3, 0.7))] * 2


def test_a_file_with_equilibria_shows_all_in_the_parameter_of_the_last_branch(resting, show):
    axes = show(resting, "diagram", ("resting", "cycles")).axes[0]
    assert len(axes.lines) == len(show(resting, "diagram", x="K", y="x", steps=("cycles", "resting")).axes[0].lines)


def test_equilibria_that_lie_on_no_branch_are_marks_in_the_plane_of_two_states(resting, show):
    figure = show(resting, steps=("all",))
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$", "$v$")
    assert {label: note.xy for label, note in texts(axes).items()} == {
        "EQ1": (-1.0, 0.5),
        "EQ2": (0.0, -0.5),
        "EQ3": (1.0, 1.5),
    }
    assert list(legend(figure)) == ["equilibria, low", "equilibria, high", "stable", "unstable", "virtual"]


def test_an_equilibrium_has_no_orbit_to_be_shown_beside(resting, show):
    assert len(show(resting, "diagram", ("resting",)).axes) == 1
    with pytest.raises(ResultsError, match=r"point HB1 of step 'resting' is an equilibrium .*'--view roots'"):
        show(resting, "diagram", ("resting",), labels=("HB1",))
