"""Curves in the plane of two parameters."""

import numpy as np
import pytest
from matplotlib.path import Path as Outline

from pddecont.errors import ResultsError
from pddecont.plot.style import KIND_COLOURS, marker
from pddecont.results.reader import read_results
from pddecont.results.summary import WORDS
from pddecont.results.writer import create
from tests.plot.drawn import coloured, legend, lines, texts
from tests.plot.synthetic import add, point


def test_curves_with_the_same_pair_are_drawn_whatever_its_order(every, show):
    figure = show(every)
    axes = figure.axes[0]
    # The last curve's first free parameter is the horizontal one; all others are turned to fit.
    first = show(every, steps=("folds",)).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (first.get_xlabel(), first.get_ylabel()) == ("$K$", "$\\tau_{d}$")
    grazing = lines(axes, "-")[0]
    assert grazing[:, 1] == pytest.approx(3 + 4 * (grazing[:, 0] - 0.5) ** 2)
    assert coloured(axes, "-") == [KIND_COLOURS["GR"], KIND_COLOURS["LP"]]
    assert coloured(axes, "--") == [KIND_COLOURS["GR"]]
    assert lines(axes, "--")[0][0, 0] == pytest.approx(0.5)


def test_kinds_and_sides_are_named_in_words(every, show):
    names = legend(show(every))
    assert names["grazing"] == KIND_COLOURS["GR"]
    assert names["fold"] == KIND_COLOURS["LP"]
    assert list(names)[2:-2] == ["stable", "unstable", "GG: double grazing", "R1: resonance 1:1", "R2: resonance 1:2"]
    assert list(names)[-2:] == ["shaded side: signature NC C kept (grazing)", "shaded side: orbits exist (fold)"]
    assert "shaded side: orbits exist" in legend(show(every, steps=("folds",)))


def test_points_of_codimension_two_are_labelled(every, show):
    found = texts(show(every).axes[0])
    assert set(found) == {"GG1", "R1_1", "R2_1"}
    assert found["GG1"].xy == pytest.approx((0.5, 3.0))


def test_every_kind_of_point_has_its_own_marker(tmp_path, show):
    kinds = [kind for kind in WORDS if kind != "EP"]
    assert len({marker(kind) for kind in kinds}) == len(kinds)
    create(tmp_path / "a.h5", "m", "r", "r", "{}")
    rows = [point(float(k), 0.1 * k, 3.0 + 0.1 * k, 1.0, kind=kind, multipliers=[0.1 * k]) for k, kind in enumerate(kinds)]
    add(tmp_path / "a.h5", "c", rows, free=("K", "tau_d"), curve="LP", side=True)
    results = read_results(tmp_path / "a.h5")
    for view in ("plane", "manifold"):
        drawn = {str(line.get_marker()): line for line in show(results, view).axes[0].lines if len(line.get_xydata()) == 1}
        for k, kind in enumerate(kinds):
            line = drawn[str(marker(kind))]
            x, y = line.get_data() if view == "plane" else line.get_data_3d()[:2]
            assert (x[0], y[0]) == pytest.approx((0.1 * k, 3.0 + 0.1 * k)), (view, kind)
    axes = show(results, "multipliers", labels=tuple(results.step("c").labels[2 * k] for k in range(4))).axes[0]
    assert len(axes.collections) == 5


def shaded(axes):
    return [Outline(p.get_xy()) for p in axes.patches]


@pytest.mark.parametrize(("x", "y"), [("K", "tau_d"), ("tau_d", "K")])
def test_the_band_lies_on_the_side_that_is_named(every, show, x, y):
    axes = show(every, steps=("grazing",), x=x, y=y).axes[0]
    bands = shaded(axes)
    assert len(bands) == 3
    # The middle of the curve, a double grazing whose side is not known, does not interrupt it.
    for K in np.linspace(0.15, 0.85, 15):
        t = 3 + 4 * (K - 0.5) ** 2
        inside, outside = ((K, t + 0.005), (K, t - 0.005)) if x == "K" else ((t + 0.005, K), (t - 0.005, K))
        assert all(b.contains_point(inside) for b in bands[-1:]), K
        assert not any(b.contains_point(outside) for b in bands), K


def test_the_band_is_left_out_where_the_side_is_not_known_and_changes_sides(tmp_path, show):
    create(tmp_path / "a.h5", "m", "r", "r", "{}")
    side = {0: (0.0, 1.0), 1: (np.nan, np.nan), 2: (0.0, -1.0)}
    add(tmp_path / "a.h5", "c", [point(float(k), 0.1 * k, 3.0 + 0.001 * k, 1, side=side[k // 10]) for k in range(30)],
        free=("K", "tau_d"), curve="PD", side=True)  # fmt: skip
    axes = show(read_results(tmp_path / "a.h5")).axes[0]
    bands = shaded(axes)
    height = 0.02 * np.diff(axes.get_ylim())[0]

    def shade(k, sign):
        return any(b.contains_point((0.1 * k, 3.0 + 0.001 * k + sign * height)) for b in bands)

    assert (shade(5, 1), shade(5, -1)) == (True, False)
    assert (shade(15, 1), shade(15, -1)) == (False, False)
    assert (shade(25, 1), shade(25, -1)) == (False, True)
    assert "shaded side: stable" in legend(axes.figure)


def test_a_curve_without_sides_is_drawn_without_a_band(tmp_path, show):
    create(tmp_path / "a.h5", "m", "r", "r", "{}")
    rows = [point(float(k), 0.1 * k, 3.0, 1, note="x_is_1") for k in range(5)]
    add(tmp_path / "a.h5", "u", rows, free=("K", "tau_d"), curve="UF")
    add(tmp_path / "a.h5", "c", rows, free=("K", "tau_d"), new=False)
    figure = show(read_results(tmp_path / "a.h5"))
    assert not shaded(figure.axes[0])
    assert list(legend(figure)) == ["user function x_is_1", "curve"]


def test_orbits_are_shown_beside_when_asked_for(every, show):
    assert len(show(every).axes) == 1
    figure = show(every, labels=("GG1",))
    assert figure.axes[1].get_title() == "GG1  $\\tau_{d}$ = 3  $K$ = 0.5"


def test_a_branch_is_no_curve_and_pairs_are_not_mixed(every, show, tmp_path):
    with pytest.raises(ResultsError, match=r"'in_gain' is a continue step in 1 parameter; it can be drawn as diagram.*not as plane"):
        show(every, "plane", ("in_gain",))
    create(tmp_path / "a.h5", "m", "r", "r", "{}")
    for name, free in (("a", ("K", "tau_d")), ("b", ("K", "omega"))):
        add(tmp_path / "a.h5", name, [point(float(k), k, 3, 1) for k in range(3)], free=free, curve="LP")
    results = read_results(tmp_path / "a.h5")
    with pytest.raises(ResultsError, match=r"different parameters \(a: K, tau_d; b: K, omega\)"):
        show(results, "plane", ("a", "b"))
    assert len(lines(show(results).axes[0], "-")) == 1


def test_the_band_stays_on_its_side_inside_a_sharp_bend(tmp_path, show):
    create(tmp_path / "a.h5", "m", "r", "r", "{}")
    # A narrow peak, the orbit kept below it: a band of full width would come out on the other flank.
    x = np.linspace(-1, 1, 201)
    rows = [point(float(k), a, 3 + 1 / (1 + 2000 * a * a), 1, side=(0.0, -1.0)) for k, a in enumerate(x)]
    add(tmp_path / "a.h5", "c", rows, free=("K", "tau_d"), curve="GR", side=True)
    bands = shaded(show(read_results(tmp_path / "a.h5")).axes[0])
    for a in np.concatenate([x[1:97], x[104:-1]]):
        assert not any(b.contains_point((a, 3 + 1 / (1 + 2000 * a * a) + 0.02)) for b in bands), a
        assert bands[0].contains_point((a, 3 + 1 / (1 + 2000 * a * a) - 0.005)), a
