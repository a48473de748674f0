"""Curves in the plane of two parameters."""

import numpy as np
import pytest

from pddecont.bifurcation import list_kinds
from pddecont.errors import ResultsError
from pddecont.plot.style import CURVE_COLOURS, EQUILIBRIUM_COLOURS, find_marker
from pddecont.reasons import make_reason
from tests.plot.drawn import coloured, legend, lines, texts
from tests.plot.synthetic import point


def test_curves_with_the_same_pair_are_drawn_whatever_its_order(every, show):
    axes = show(every, "plane").axes[0]
    # The last curve's first free parameter is the horizontal one; all others are turned to fit.
    first = show(every, steps=("folds",)).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (first.get_xlabel(), first.get_ylabel()) == ("$K$", "$\\tau_{d}$")
    grazing = lines(axes, "-")[0]
    assert grazing[:, 1] == pytest.approx(3 + 4 * (grazing[:, 0] - 0.5) ** 2, rel=1e-4)
    assert coloured(axes, "-") == [CURVE_COLOURS["GR"], CURVE_COLOURS["LP"]]
    assert coloured(axes, "--") == [CURVE_COLOURS["GR"]]
    assert lines(axes, "--")[0][0, 0] == pytest.approx(0.5)


def test_kinds_and_sides_are_named_in_words(every, show):
    names = legend(show(every, "plane"))
    assert names["grazing"] == CURVE_COLOURS["GR"]
    assert names["fold"] == CURVE_COLOURS["LP"]
    assert list(names)[2:-2] == ["stable", "unstable", "GG: double grazing", "R1: resonance 1:1", "R2: resonance 1:2"]
    assert list(names)[-2:] == ["shaded side: signature NC C kept (grazing)", "shaded side: orbits exist (fold)"]
    assert "shaded side: orbits exist" in legend(show(every, steps=("folds",)))


def test_points_of_codimension_two_are_labelled(every, show):
    found = texts(show(every, "plane").axes[0])
    assert set(found) == {"GG1", "R1_1", "R2_1"}
    assert found["GG1"].xy == pytest.approx((0.5, 3.0))


def test_every_kind_of_point_is_marked(made, show):
    kinds = [kind.label for kind in list_kinds()]
    rows = [
        point(float(k), 0.1 * k, 3.0 + 0.1 * k, 1.0, kind=kind, multipliers=[0.1 * k]) for k, kind in enumerate(kinds)
    ]
    results = made(c=(rows, {"free": ("K", "tau_d"), "curve": "LP", "side": True}))
    for view in ("plane", "manifold"):
        drawn = {
            str(line.get_marker()): line for line in show(results, view).axes[0].lines if len(line.get_xydata()) == 1
        }
        for k, kind in enumerate(kinds):
            line = drawn[str(find_marker(kind))]
            x, y = line.get_data() if view == "plane" else line.get_data_3d()[:2]
            assert (x[0], y[0]) == pytest.approx((0.1 * k, 3.0 + 0.1 * k)), (view, kind)
    axes = show(results, "multipliers", labels=tuple(results.step("c").labels[2 * k] for k in range(4))).axes[0]
    assert len(axes.collections) == 5


def test_a_curve_without_sides_is_drawn_without_a_band(made, show):
    rows = [point(float(k), 0.1 * k, 3.0, 1) for k in range(5)]
    free = {"free": ("K", "tau_d")}
    figure = show(
        made(
            u=(rows, free | {"curve": "UF", "followed": make_reason("user_function", name="x_is_1")}),
            c=(rows, free | {"new": False}),
        )
    )
    assert not figure.axes[0].patches
    assert list(legend(figure)) == ["user function x_is_1", "curve"]


def test_the_branches_stand_beside_their_curves_when_nobody_asks_for_a_view(every, show):
    figure = show(every)
    response, plane = figure.axes
    assert (response.get_xlabel(), response.get_ylabel()) == ("$K$", r"$\mathit{top}$")
    assert (plane.get_xlabel(), plane.get_ylabel()) == ("$K$", "$\\tau_{d}$")
    assert {"LP1", "GR1"} <= set(texts(response))
    assert set(texts(plane)) == {"GG1", "R1_1", "R2_1"}
    names = list(legend(figure))
    assert len(names) == len(set(names))
    assert {"fold", "grazing", "stable"} <= set(names)
    for options in ({"x": "tau_d"}, {"steps": ("grazing",)}):
        assert len(show(every, **options).axes) == 1


def test_curves_of_several_kinds_have_marks_that_tell_them_apart_without_colours(every, show):
    axes = show(every, "plane").axes[0]
    marks = {line.get_marker() for line in axes.lines if line.get_markevery() is not None}
    assert marks == {find_marker("GR"), find_marker("LP")}
    alone = show(every, steps=("folds",)).axes[0]
    assert all(line.get_markevery() is None for line in alone.lines)


def test_orbits_are_shown_beside_when_asked_for(every, show):
    assert len(show(every, "plane").axes) == 1
    figure = show(every, labels=("GG1",))
    assert figure.axes[1].get_title() == "GG1  $\\tau_{d}$ = 3  $K$ = 0.5"


def test_a_branch_is_no_curve_and_pairs_are_not_mixed(every, show, made):
    with pytest.raises(
        ResultsError, match=r"'in_gain' is a continue step in 1 parameter; it can be drawn as diagram.*not as plane"
    ):
        show(every, "plane", ("in_gain",))
    rows = [point(float(k), k, 3, 1) for k in range(3)]
    results = made(a=(rows, {"free": ("K", "tau_d"), "curve": "LP"}), b=(rows, {"free": ("K", "omega"), "curve": "LP"}))
    with pytest.raises(ResultsError, match=r"different parameters \(a: K, tau_d; b: K, omega\)"):
        show(results, "plane", ("a", "b"))
    assert len(lines(show(results).axes[0], "-")) == 1


def make_doubling_curve(stable):
    """Return a curve of period doublings beside which orbits are stable where ``stable`` says so."""
    return [point(float(k), 0.1 * k, 3.0, 1, side=(0.0, 1.0), stable=s) for k, s in enumerate(stable)]


def test_a_side_is_called_stable_only_where_no_other_multiplier_is_outside(made, show):
    rows = make_doubling_curve([1] * 11 + [0] * 10)
    axes = show(made(c=(rows, {"free": ("K", "tau_d"), "curve": "PD", "side": True}))).axes[0]
    bands = [patch.get_xy() for patch in axes.patches]
    assert len(bands) == 3
    assert max(band[:, 0].max() for band in bands) == pytest.approx(1.0)
    assert "shaded side: stable" in legend(axes.figure)


def test_a_curve_that_is_unstable_on_both_sides_has_no_shaded_side(made, show):
    figure = show(made(c=(make_doubling_curve([0] * 9), {"free": ("K", "tau_d"), "curve": "TR", "side": True})))
    assert not figure.axes[0].patches
    assert not any(name.startswith("shaded") for name in legend(figure))


def test_without_multipliers_no_side_is_called_stable(made, show):
    figure = show(made(c=(make_doubling_curve([-1] * 9), {"free": ("K", "tau_d"), "curve": "PD", "side": True})))
    assert len(figure.axes[0].patches) == 3
    assert "shaded side: fewer unstable multipliers" in legend(figure)


def test_curves_of_equilibria_stand_beside_those_of_orbits(resting, show):
    figure = show(resting, "plane")
    axes = figure.axes[0]
    names = legend(figure)
    kinds = ["fold of orbits", "fold of equilibria", "boundary equilibrium", "Hopf"]
    assert list(names)[:4] == kinds
    assert [names[kind] for kind in kinds] == [
        CURVE_COLOURS["LP"],
        *(EQUILIBRIUM_COLOURS[kind] for kind in ("LP", "BE", "HB")),
    ]
    assert {"HH: Hopf-Hopf", "numbers: unstable roots of the equilibria on that side"} <= set(names)
    assert "HH1" in texts(axes)
    assert [name for name in names if name.startswith("shaded")] == [
        "shaded side: orbits exist (fold of orbits)",
        "shaded side: equilibria exist (fold of equilibria)",
        "shaded side: equilibrium in mode low (boundary equilibrium)",
        "shaded side: stable (Hopf)",
    ]


def test_the_side_of_hopf_points_is_shaded_where_no_other_root_is_unstable(resting, show):
    figure = show(resting, "plane", ("hopf",))
    bands = np.concatenate([patch.get_xy() for patch in figure.axes[0].patches])
    # Below tau_d = 3 + K, up to K = 0.5 where another pair becomes unstable.
    assert np.all(bands[:, 1] <= 3.0 + bands[:, 0] + 1e-9)
    assert np.max(bands[:, 0] - np.maximum(0.0, 3.0 + bands[:, 0] - bands[:, 1])) <= 0.5 + 1e-9
    assert [t.get_text() for t in figure.axes[0].texts if t.get_text() != "HH1"] == ["0", "2", "2", "4"]
