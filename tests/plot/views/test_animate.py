"""The moving picture: what its panels show, frame for frame."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest
from pddecont.plot.style import COLOURS
from pddecont.plot.views import animate
from pddecont.plot.views.animate import OrbitPanel, can_move, choose_frames, draw_animation, find_limits
from tests.plot.synthetic import point
from tests.plot.test_segment_colours import colours


@pytest.fixture
def panel(every):
    step = every.step("in_gain")
    return OrbitPanel.make(step, ViewRequest(), choose_frames(step))


def test_frames_are_in_order_hold_the_special_points_and_are_few(every, monkeypatch):
    step = every.step("in_gain")
    assert choose_frames(step) == list(step.order)
    monkeypatch.setattr(animate, "MAX_FRAMES", 6)
    shown = choose_frames(step)
    assert len(shown) == 6
    assert {step.row("LP1"), step.row("GR1")} <= set(shown)
    assert shown == sorted(shown, key=list(step.order).index)


def test_the_panel_stays_while_the_orbit_moves(panel, axes):
    panel.draw(axes, 0)
    limits = axes.get_xlim(), axes.get_ylim()
    assert "unstable" not in axes.get_title()
    panel.draw(axes, 12)
    assert (axes.get_xlim(), axes.get_ylim()) == limits
    assert "unstable" in axes.get_title()
    assert limits[0] == pytest.approx((-1.1, 1.1), abs=0.02)


def test_moving_orbits_have_the_colours_of_those_beside_a_diagram(panel, axes):
    for row, expected in ((2, {"NC": COLOURS[2], "C": COLOURS[3]}), (20, {"NC": COLOURS[1]})):
        panel.draw(axes, row)
        assert colours(axes) == expected


def test_of_one_state_time_stands_in_for_the_first(every, axes):
    step = every.step("in_gain")
    panel = OrbitPanel.make(step, ViewRequest(x="v", y="v"), [0, 1])
    panel.draw(axes, 1)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$t$", "$v$")
    assert axes.get_xlim() == (0.0, 7.0)


@pytest.mark.parametrize(
    ("step", "labels"), [("in_gain", ("$K$", r"$\mathit{top}$")), ("grazing", ("$\\tau_{d}$", "$K$"))]
)
def test_a_mark_goes_along_the_diagram_or_the_plane(every, step, labels, monkeypatch, tmp_path):
    from matplotlib.animation import PillowWriter

    monkeypatch.setattr(animate, "MAX_FRAMES", 3)
    moving = draw_animation([every.step(step)], ViewRequest())
    moving.save(tmp_path / "a.gif", PillowWriter(fps=1), dpi=20)
    left, right = moving._fig.axes
    assert (left.get_xlabel(), left.get_ylabel()) == labels
    last = int(every.step(step).order[-1])
    [mark] = [line for line in left.lines if line.get_markersize() == 9]
    K = every.step(step).points["parameters"][last, 1]
    assert mark.get_xydata()[0][labels.index("$K$")] == K
    assert f"$K$ = {K:.6g}" in right.get_title()


def test_one_point_does_not_move(made):
    step = made(b=([point(0.0, 0.1, 3, 1)], {})).step("b")
    assert not can_move(step)
    with pytest.raises(ResultsError, match="has one point; there is nothing to move along"):
        draw_animation([step], ViewRequest())


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=10), st.floats(1e-6, 1e6))
def test_limits_hold_all_values_with_room(values, size):
    low, high = find_limits(np.array([*values, np.nan]), max(size, *map(abs, values)))
    assert low < min(values) <= max(values) < high


def test_limits_of_nothing_but_rounding_lie_far_apart():
    assert find_limits(np.array([1.7e-15, 1.9e-15]), 2.0) == pytest.approx((-0.11, 0.11))
