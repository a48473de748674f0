"""Branches and curves in three dimensions."""

import numpy as np
import pytest

from pddecont.errors import ResultsError
from pddecont.plot.style import CURVE_COLOURS
from pddecont.plot.views.manifold import find_within_plane
from tests.plot.drawn import legend
from tests.plot.synthetic import gain, point


def curves(axes):
    """Return (x, y, z), style, width and colour of each line with more than one point."""
    found = [
        (np.array(line.get_data_3d()), line.get_linestyle(), line.get_linewidth(), line.get_color())
        for line in axes.lines
    ]
    return [c for c in found if c[0].shape[1] > 1]


def test_curves_are_thick_and_branches_in_their_plane_thin(every, show):
    axes = show(every, "manifold").axes[0]
    found = curves(axes)
    thick = [c for c in found if c[2] > 2]
    thin = [c for c in found if c[2] < 2]
    assert {c[3] for c in thick} == {CURVE_COLOURS["GR"], CURVE_COLOURS["LP"]}
    x, y, z = thick[0][0]
    assert x == pytest.approx(3 + 4 * (y - 0.5) ** 2)
    assert z == pytest.approx(np.sqrt(y))
    assert [c[1] for c in thick] == ["-", "--", "-"]
    # in_delay, four parts of in_gain, doubled
    assert [c[1] for c in thin] == ["-", "-", "--", "--", ":", "-"]
    assert np.ptp(thin[0][0][1]) == 0
    assert all(np.all(c[0][0] == 3.8) for c in thin[1:])
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()) == ("$\\tau_{d}$", "$K$", r"$\mathit{top}$")
    assert list(legend(axes.figure))[:2] == ["grazing", "fold"]


def test_the_axes_can_be_chosen(every, show):
    axes = show(every, "manifold", x="K", z="period").axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()) == ("$K$", "$\\tau_{d}$", "period")
    assert set(np.concatenate([c[0][2] for c in curves(axes)])) == {7.0, 14.0}


def test_branches_outside_the_plane_are_left_out(made, show):
    elsewhere = [r | {"parameters": [0.7, *r["parameters"][1:]]} for r in gain()]
    curve = [point(float(k), 0.1 * k, 3 + k, 1.0) for k in range(4)]
    results = made(elsewhere=(elsewhere, {}), inside=(gain(), {}), c=(curve, {"free": ("K", "tau_d"), "curve": "GR"}))
    assert len(curves(show(results, "manifold").axes[0])) == 1 + 4
    assert len(curves(show(results, "manifold", ("elsewhere", "c")).axes[0])) == 1 + 4
    assert len(curves(show(results, "manifold", ("c",)).axes[0])) == 1
    assert [s.name for s in find_within_plane(list(results.steps.values())[:2], "K", "tau_d")] == ["inside"]


def test_special_points_are_labelled_where_they_are_seen(every, show):
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    axes = show(every, "manifold").axes[0]
    found = {t.get_text(): t for t in axes.texts}
    assert {"GG1", "LP1", "GR1", "PD1"} <= set(found)
    assert found["GG1"].xy == pytest.approx(proj_transform(3.0, 0.5, np.sqrt(0.5), axes.get_proj())[:2])


def test_without_a_curve_the_plane_must_be_named(old, show):
    with pytest.raises(ResultsError, match="give -x and -y"):
        show(old, "manifold")
    assert len(curves(show(old, "manifold", x="K", y="tau_d").axes[0])) == 1
    with pytest.raises(ResultsError, match="no branch or curve in omega and tau_d"):
        show(old, "manifold", x="omega", y="tau_d")


def test_the_orbits_themselves_along_a_parameter(every, show):
    """The solution manifold of the paper's figure 4.8(b): each orbit in two signals at the height of its parameter."""
    step = every.step("in_gain")
    axes = show(every, "manifold", ("in_gain",), x="x", y="v", z="K").axes[0]
    lines = axes.collections[0]._segments3d
    assert len(lines) == len(step)
    heights = step.points["parameters"][step.order, list(step.meta["parameters"]).index("K")]
    for line, row, height in zip(lines, step.order, heights, strict=True):
        line = np.asarray(line)
        assert np.all(line[:, 2] == height)
        assert line[:-1, :2] == pytest.approx(step.orbit(int(row))["states"][:, :2])
        assert line[-1] == pytest.approx(line[0])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$", "$v$")
