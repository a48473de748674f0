"""Torus bifurcations, their curves in two parameters and the resonances on them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from pddecont.bifurcation import find_kind, torus
from pddecont.bifurcation.torus import RESONANCES, TORUS, TorusFunction
from pddecont.errors import ConvergenceError
from pddecont.tables import describe_endings
from tests.bifurcation.runs import Known, make_multipliers, plain_multipliers
from tests.runs import labels, multipliers, parameter, run


def test_torus_of_the_pulsed_control(tmp_path):
    text = {
        "model": "pulsed_control",
        "mesh": {"degree": 9, "tol": 1e-10},
        "steps": [
            {"name": "t", "simulate": {"t_end": 200}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["b"], "range": {"b": [-2.2, -0.5]}, "stability": True}},
        ],
    }
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["TR1"]
    assert parameter(step, "b", "TR1") == pytest.approx(-1.71579076378486, abs=1e-10)
    pair = multipliers(step, step.row("TR1"))[:2]
    assert np.abs(pair) == pytest.approx([1.0, 1.0], abs=1e-10)
    assert np.angle(pair[0]) == pytest.approx(1.70121865161311, abs=1e-9)


@pytest.fixture(scope="module")
def pulsed(tmp_path_factory):
    text = {
        "model": "pulsed_control",
        "set": {"c": 0},
        "mesh": {"degree": 9, "tol": 1e-10},
        "steps": [
            {"name": "t", "set": {"c": 1}, "simulate": {"t_end": 200}},
            {"name": "o", "set": {"c": 1}, "orbit": {"from": "t"}},
            {"name": "zero", "set": {"c": 0}, "orbit": {"from": "o"}},
            {"name": "c", "continue": {"from": "zero", "free": ["b"], "range": {"b": [-2.2, -0.5]}, "stability": True}},
            {
                "name": "tr",
                "continue": {
                    "from": {"step": "c", "point": "TR1"},
                    "free": ["b", "q"],
                    "range": {"b": [-2.6, -0.5], "q": [0.25, 3]},
                    "stability": True,
                },
            },
        ],
    }
    return run(text, tmp_path_factory.mktemp("torus") / "a.h5")


def test_the_torus_curve_and_its_resonances(pulsed, tmp_path):
    """mu = exp(i w) = b / W(b/q) gives b = -w / sin(w), q = exp(w cot(w)): resonances at w = 2 pi/3, pi/2 and 0 (q = e,
    b = -1).
    """
    step = pulsed.step("tr")
    b, q = parameter(step, "b"), parameter(step, "q")
    for i, (x, y) in enumerate(zip(b, q, strict=True)):
        if x < -1.001:
            w = brentq(lambda w, x=x: -w / math.sin(w) - x, 1e-9, math.pi - 1e-9, xtol=1e-15)
            assert y == pytest.approx(math.exp(w / math.tan(w)), rel=1e-9), i
    assert set(labels(step)) == {"R3_1", "R4_1", "R1_1"}
    for name, w in (("R3_1", 2 * math.pi / 3), ("R4_1", math.pi / 2)):
        assert parameter(step, "b", name) == pytest.approx(-w / math.sin(w), abs=1e-9)
        assert parameter(step, "q", name) == pytest.approx(math.exp(w / math.tan(w)), abs=1e-9)
    assert (parameter(step, "b", "R1_1"), parameter(step, "q", "R1_1")) == pytest.approx((-1, math.e), abs=1e-6)
    assert any("meets on the real axis" in t for t in describe_endings(step))
    assert not any("WARNING" in t for t in describe_endings(step))
    # Near 1:1 the pair is nearly double, which costs half the digits.
    rows = [i for i in step.order if parameter(step, "b")[list(step.order).index(i)] < -1.05][::4]
    assert len(rows) > 3
    for i in rows:
        plain = plain_multipliers(pulsed, "tr", int(i), "pulsed_control", tmp_path)
        assert np.sort_complex(multipliers(step, i)[:2]) == pytest.approx(np.sort_complex(plain[:2]), abs=1e-8)


AT = SimpleNamespace(orbit=None)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    st.lists(st.tuples(st.floats(0.3, 2.0), st.floats(0.1, 3.0)), min_size=1, max_size=4),
    st.lists(st.floats(-2.0, 2.0), max_size=3),
)
def test_the_test_function_is_the_distance_to_the_circle_and_counts_pairs_outside(polar, real):
    upper = [r * np.exp(1j * angle) for r, angle in polar]
    value = torus.measure_distance(make_multipliers([*real, *upper, *np.conj(upper)]))
    sizes = np.abs(upper)
    assert abs(value) == np.min(np.abs(sizes - 1.0))
    if value:
        assert np.sign(value) == (-1.0) ** np.sum(sizes > 1.0)


def test_without_a_pair_there_is_no_test_function():
    assert math.isnan(torus.measure_distance(make_multipliers([2.0, -0.5])))


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.floats(0.5, 1.5), st.floats(0.05, 3.0))
def test_product_and_sum_of_the_pair(r, angle):
    pair = r * np.exp(1j * angle)
    function = TorusFunction(Known([0.1, pair, np.conj(pair), 0.2]), pair + 0.01)
    assert function.evaluate(AT) == pytest.approx(r**2 - 1.0, abs=1e-12)
    assert function.find_sum(AT) == pytest.approx(2 * r * math.cos(angle), abs=1e-12)
    assert function.update_at(AT).near == pair


def test_the_pair_is_followed_from_where_it_was():
    """Two pairs on the circle: each function goes on with its own."""
    one, other = np.exp(1j), np.exp(2j)
    cache = Known([one, np.conj(one), other, np.conj(other)])
    for pair in (one, other):
        assert set(TorusFunction(cache, pair * 1.02).find_pair(AT)) == {pair, np.conj(pair)}


def test_where_the_pair_has_met_on_the_axis_it_is_two_real_ones():
    """Past a resonance product and sum go on smoothly."""
    function = TorusFunction(Known([1.25, 0.8, 0.1]), 1.0 + 1e-9j)
    assert function.evaluate(AT) == pytest.approx(0.0, abs=1e-15)
    assert function.find_sum(AT) == pytest.approx(2.05, abs=1e-15)
    assert math.isnan(TorusFunction(Known([0.5]), 1j).evaluate(AT))


@pytest.mark.parametrize(
    ("label", "angle"), [("R1", 0.0), ("R2", math.pi), ("R3", 2 * math.pi / 3), ("R4", math.pi / 2)]
)
def test_resonances_are_angles_of_the_pair(label, angle):
    pair = np.exp(1j * angle)
    defining = TorusFunction(Known([pair, np.conj(pair)]), pair)
    at = SimpleNamespace(system=SimpleNamespace(defining=defining), inner=AT)
    (test,) = find_kind(label).curve_tests(at, None)
    assert test.value(SimpleNamespace(at=at)) == pytest.approx(0.0, abs=1e-15)
    assert test.end == ("resonance" if label in ("R1", "R2") else "")
    other = SimpleNamespace(system=SimpleNamespace(defining=None))
    assert find_kind(label).curve_tests(other, None) == []
    assert find_kind(label) in RESONANCES


def test_the_defining_function_takes_the_pair_nearest_to_the_circle():
    near, far = 1.1 * np.exp(1j), 0.5 * np.exp(2j)
    found = TORUS.define(
        AT, SimpleNamespace(find_multipliers=lambda: Known([near, np.conj(near), far, np.conj(far)])), None
    )
    assert found.near == near
    with pytest.raises(ConvergenceError, match="no complex pair of multipliers is left at this point"):
        TORUS.define(AT, SimpleNamespace(find_multipliers=lambda: Known([2.0, 0.5])), None)


@pytest.mark.parametrize("pair", [[np.exp(1j), np.exp(-1j)], [1.25, 0.8]])
def test_its_own_pair_is_taken_out_of_the_multipliers(pair):
    kept = TORUS.remove_critical(make_multipliers([0.9, *pair, -0.4]))
    assert np.array_equal(kept, [0.9, -0.4])
    assert np.array_equal(TORUS.remove_critical(make_multipliers([0.9])), [0.9])
