"""Floquet multipliers in the complex plane."""

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from pddecont.errors import ResultsError
from pddecont.plot.style import COLOURS
from tests.plot.drawn import legend
from tests.plot.synthetic import gain, point


def test_all_multipliers_are_there_coloured_by_the_free_parameter(every, show):
    figure = show(every, "multipliers", ("in_gain",))
    axes, bar = figure.axes
    dots = axes.collections[0]
    rows = gain()
    z = np.concatenate([r["multipliers"] for r in rows])
    assert np.allclose(dots.get_offsets(), np.column_stack([z.real, z.imag]))
    assert np.allclose(dots.get_array(), np.repeat([r["parameters"][1] for r in rows], 3))
    assert bar.get_ylabel() == "$K$"


def test_the_unit_circle_is_round(every, show):
    axes = show(every, "multipliers", ("in_gain",)).axes[0]
    assert axes.get_aspect() == 1.0
    assert np.hypot(*axes.lines[0].get_xydata().T) == pytest.approx(1.0)
    assert axes.get_xlim()[0] < -1 < 1.6 < axes.get_xlim()[1]


def test_special_points_or_those_asked_for_are_emphasised(every, show):
    axes = show(every, "multipliers", ("in_gain",)).axes[0]
    fold = gain()[8]["multipliers"]
    assert np.allclose(axes.collections[1].get_offsets(), np.column_stack([fold.real, fold.imag]))
    assert list(legend(axes.figure)) == ["LP1  $K$ = 0.3", "GR1  $K$ = 0.5"]
    axes = show(every, "multipliers", ("in_gain",), labels=("GR1",), indices=(0,)).axes[0]
    assert list(legend(axes.figure)) == ["GR1  $K$ = 0.5", "$K$ = 0.1"]
    assert axes.collections[1].get_edgecolor()[0] == pytest.approx(to_rgba(COLOURS[0]))


def test_far_multipliers_do_not_hide_the_circle(made, show):
    rows = [point(float(k), k, 3, 1, multipliers=[-400.0 - k, 0.5]) for k in range(3)]
    axes = show(made(b=(rows, {})), "multipliers").axes[0]
    assert axes.get_xlim()[0] > -2
    assert axes.texts[0].get_text() == "3 outside, up to modulus 402"


def test_the_last_step_that_has_multipliers_is_chosen(every, show):
    # The curves come last but theirs were not computed.
    assert list(legend(show(every, "multipliers"))) == ["PD1  $K$ = 0.2"]
    assert len(show(every, "multipliers", ("orbit",)).axes) == 1


@pytest.mark.parametrize("fixture", ["every", "old"])
def test_what_to_do_where_there_are_none(fixture, show, request):
    results = request.getfixturevalue(fixture)
    with pytest.raises(ResultsError, match="has no multipliers; run it with 'stability: true'"):
        show(results, "multipliers", ("grazing" if fixture == "every" else "in_gain",))


def test_a_point_without_multipliers_among_others(made, show):
    results = made(b=([point(0.0, 0, 3, 1, multipliers=[0.5]), point(1.0, 1, 3, 1, kind="GR")], {}))
    with pytest.raises(ResultsError, match="no multipliers at point GR1"):
        show(results, "multipliers", labels=("GR1",))
    assert len(show(results, "multipliers", indices=(0,)).axes[0].collections) == 2


def test_one_step_at_a_time(every, show):
    with pytest.raises(ResultsError, match="shows one step; choose one of in_gain, doubled"):
        show(every, "multipliers", ("in_gain", "doubled"))
