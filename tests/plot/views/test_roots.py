"""Characteristic roots in the complex plane."""

import numpy as np
import pytest

from pddecont.errors import ResultsError
from tests.plot.drawn import legend
from tests.plot.equilibria import branch, three


def places(found):
    """Return roots as points of the plane."""
    return np.column_stack([np.real(found), np.imag(found)])


def test_all_roots_are_there_coloured_by_the_free_parameter(resting, show):
    figure = show(resting, "roots", ("resting",))
    axes, bar = figure.axes
    dots = axes.collections[0]
    rows = [arrays["roots"] for _, arrays, _ in branch()]
    assert np.array_equal(dots.get_offsets(), np.concatenate(rows))
    assert np.allclose(dots.get_array(), np.repeat(np.linspace(0.1, 0.9, 33), 4))
    assert (axes.get_xlabel(), bar.get_ylabel()) == ("real part of $\\lambda$", "$K$")


def test_the_imaginary_axis_is_drawn_and_shown(resting, show):
    axes = show(resting, "roots", ("resting",)).axes[0]
    [line] = axes.lines
    assert line.get_xdata() == [0.0, 0.0]
    assert axes.get_xlim()[0] < 0.0 < axes.get_xlim()[1]
    # So also where all roots are far to the left of it.
    axes = show(resting, "roots", ("boundaries",)).axes[0]
    assert axes.get_xlim()[1] > 0.0


def test_far_roots_do_not_hide_those_near_the_axis(resting, show):
    axes = show(resting, "roots", ("resting",)).axes[0]
    assert -4.0 < axes.get_xlim()[0] < -2.9
    assert axes.texts[0].get_text() == "33 farther from zero, up to 1e+03"


def test_special_points_or_those_asked_for_are_emphasised(resting, show):
    axes = show(resting, "roots", ("resting",)).axes[0]
    assert np.array_equal(axes.collections[1].get_offsets(), branch()[8][1]["roots"])
    assert list(legend(axes.figure)) == ["HB1  $K$ = 0.3", "BE1  $K$ = 0.5"]
    axes = show(resting, "roots", ("resting",), labels=("BE1",), indices=(0,)).axes[0]
    assert list(legend(axes.figure)) == ["BE1  $K$ = 0.5", "$K$ = 0.1"]


def test_equilibria_on_no_branch_are_told_apart(resting, show):
    figure = show(resting, "roots", ("all",))
    assert list(legend(figure)) == ["EQ1", "EQ2", "EQ3"]
    offsets = [found.get_offsets() for found in figure.axes[0].collections[1:]]
    assert all(np.array_equal(a, b[1]["roots"]) for a, b in zip(offsets, three(), strict=True))


def test_the_last_branch_is_chosen_before_curves(resting, show):
    assert list(legend(show(resting, "roots"))) == ["HB1  $K$ = 0.3", "BE1  $K$ = 0.5"]


def test_orbits_have_none(resting, show):
    with pytest.raises(ResultsError, match=r"step 'cycles' is a continue step in 1 parameter; .* not as roots"):
        show(resting, "roots", ("cycles",))
