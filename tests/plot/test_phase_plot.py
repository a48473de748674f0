"""Orbits in the plane of two states, jumps and event surfaces."""

import numpy as np
import pytest

from pddecont.plot.phase_plot import draw_orbit, draw_orbits_together
from pddecont.plot.style import COLOURS
from tests.plot.drawn import lines
from tests.plot.synthetic import point

COLOUR = {"NC": COLOURS[0], "C": COLOURS[1]}


def test_an_orbit_is_its_segments_and_the_jumps_between_them(every, axes):
    draw_orbit(axes, every.step("in_gain"), 0, "x", "v", COLOUR, "title")
    assert [line.get_label() for line in axes.lines if line.get_linestyle() == "-" and len(line.get_xydata()) > 2] == [
        "NC",
        "C",
    ]
    # The circle's last point is not its first, and its two halves are one step apart.
    assert len(lines(axes, "--")) == 2
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == ("$x$", "$v$", "title")


def surfaces(axes):
    return [line for line in axes.lines if line.get_color() == "0.35"]


@pytest.fixture
def draw(made, axes):
    """Return a function that draws an orbit with one surface, normal . (x, v) = level."""

    def with_surface(surface):
        step = made(b=([point(0.0, 0.1, 3, 1) | {"surfaces": [surface]}], {})).step("b")
        draw_orbit(axes, step, 0, "x", "v", COLOUR)
        return surfaces(axes)

    return with_surface


def test_a_surface_in_the_plane_is_drawn(draw):
    [line] = draw([2.0, 0.0, 1.8])
    assert list(line.get_xdata()) == [0.9, 0.9]
    *_, line = draw([0.0, 2.0, 1.8])
    assert list(line.get_ydata()) == [0.9, 0.9]
    *_, line = draw([1.0, 2.0, 1.8])
    assert (line.get_xy1(), line.get_slope()) == ((0.0, 0.9), -0.5)


@pytest.mark.parametrize("surface", [[0.0, 0.0, 0.9], [np.nan, 0.0, 0.9]])
def test_a_surface_that_is_none_is_left_out(draw, surface):
    assert not draw(surface)


def test_a_surface_in_other_states_is_left_out(every, axes):
    draw_orbit(axes, every.step("in_gain"), 0, "v", "v", COLOUR)
    assert not surfaces(axes)


def test_orbits_of_several_steps_lie_over_one_another(every, axes):
    draw_orbits_together(axes, [every.step("orbit"), every.step("doubled")], "x", "v", "both")
    first, second = (line for line in axes.lines if not line.get_label().startswith("_"))
    assert (first.get_label(), second.get_label()) == ("orbit", "doubled")
    assert (first.get_color(), second.get_color()) == COLOURS[:2]
    # Where a reset jumps, nothing is drawn.
    assert np.isnan(first.get_xdata()).any()
