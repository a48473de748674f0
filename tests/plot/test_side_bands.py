"""The soft band along a curve."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path as Outline

from pddecont.plot.side_bands import draw_side_band, fill_signs, find_ranges
from tests.plot.drawn import legend
from tests.plot.synthetic import point

SIGNS = st.lists(st.sampled_from([-1.0, 0.0, 1.0]), min_size=1, max_size=30)


def shaded(axes):
    return [Outline(p.get_xy()) for p in axes.patches]


@settings(max_examples=40, deadline=None)
@given(SIGNS)
def test_ranges_have_one_known_side_and_are_as_long_as_they_can_be(signs):
    signs = np.array(signs)
    ranges = find_ranges(signs)
    for first, last in ranges:
        assert last - first > 1
        assert signs[first] and np.all(signs[first:last] == signs[first])
        assert first == 0 or signs[first - 1] != signs[first]
        assert last == len(signs) or signs[last] != signs[first]
    inside = {k for first, last in ranges for k in range(first, last)}
    for k in set(range(len(signs) - 1)) - inside:
        assert not (signs[k] and signs[k] == signs[k + 1])


@settings(max_examples=40, deadline=None)
@given(SIGNS, st.data())
def test_a_neighbour_tells_the_side_of_a_special_point(signs, data):
    special = data.draw(st.lists(st.booleans(), min_size=len(signs), max_size=len(signs)))
    signs = np.array(signs)
    filled = fill_signs(signs, special)
    for k, (before, after) in enumerate(zip(signs, filled, strict=True)):
        near = {signs[j] for j in (k - 1, k + 1) if 0 <= j < len(signs)}
        assert after == before or (before == 0 and special[k] and after in near)


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


def test_the_band_is_left_out_where_the_side_is_not_known_and_changes_sides(made, show):
    side = {0: (0.0, 1.0), 1: (np.nan, np.nan), 2: (0.0, -1.0)}
    rows = [point(float(k), 0.1 * k, 3.0 + 0.001 * k, 1, side=side[k // 10]) for k in range(30)]
    axes = show(made(c=(rows, {"free": ("K", "tau_d"), "curve": "PD", "side": True}))).axes[0]
    bands = shaded(axes)
    height = 0.02 * np.diff(axes.get_ylim())[0]

    def shade(k, sign):
        return any(b.contains_point((0.1 * k, 3.0 + 0.001 * k + sign * height)) for b in bands)

    assert (shade(5, 1), shade(5, -1)) == (True, False)
    assert (shade(15, 1), shade(15, -1)) == (False, False)
    assert (shade(25, 1), shade(25, -1)) == (False, True)
    assert "shaded side: stable" in legend(axes.figure)


def test_the_band_stays_on_its_side_inside_a_sharp_bend(made, show):
    # A narrow peak, the orbit kept below it: a band of full width would come out on the other flank.
    x = np.linspace(-1, 1, 201)
    rows = [point(float(k), a, 3 + 1 / (1 + 2000 * a * a), 1, side=(0.0, -1.0)) for k, a in enumerate(x)]
    bands = shaded(show(made(c=(rows, {"free": ("K", "tau_d"), "curve": "GR", "side": True}))).axes[0])
    for a in np.concatenate([x[1:97], x[104:-1]]):
        assert not any(b.contains_point((a, 3 + 1 / (1 + 2000 * a * a) + 0.02)) for b in bands), a
        assert bands[0].contains_point((a, 3 + 1 / (1 + 2000 * a * a) - 0.005)), a


@pytest.mark.parametrize("step", ["in_gain", "orbit"])
def test_what_records_no_side_has_no_band(every, axes, step):
    assert not draw_side_band(axes, every.step(step), "K", "tau_d")
    assert not axes.patches
