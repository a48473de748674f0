"""The mode in which a motion starts: read from states, delayed values, time and parameters."""

import random

import pytest

from pddecont.errors import ModelError, PddecontError
from pddecont.model import find_start_mode
from tests.conftest import model_from
from tests.model.equations_models import STICK, TWO, numbers_at, one_law
from tests.runs import change


def word(u):
    return "above" if u > 0 else "below"


def test_signs_are_those_of_the_arguments():
    model, draw = one_law("sign(x - a) + abs(y) - max(x(t - 1), 0) + square(t, 2)"), random.Random(12)
    assert [s.name for s in model.derived.equations.switches] == ["x", "y", "x2", "t"]
    for _ in range(40):
        x, y, x_1 = (draw.uniform(-1, 1) for _ in range(3))
        t = draw.uniform(0, 4)
        expected = f"x_{word(x - 0.5)}_y_{word(y)}_x2_{word(x_1)}_t_{'above' if t % 2 < 1 else 'below'}"
        assert find_start_mode(model.derived, numbers_at(model, t, x=x, y=y, x_1=x_1)) == expected


def test_the_signs_of_nested_arguments_are_those_with_the_inner_ones():
    model = one_law("max(abs(x) - a, 0)")
    for x, expected in (
        (-0.8, "below_x2_above"),
        (-0.2, "below_x2_below"),
        (0.2, "above_x2_below"),
        (0.8, "above_x2_above"),
    ):
        assert find_start_mode(model.derived, numbers_at(model, x=x, y=0.0, x_1=0.0)) == f"x_{expected}"


@pytest.mark.parametrize(
    ("x", "expected"),
    [(0.2, "slip_above"), (0.6999, "slip_above"), (0.7001, "slip_on"), (2.2999, "slip_on"), (2.3001, "slip_below")],
)
def test_on_a_surface_the_forces_say_where_it_goes(x, expected):
    """At t = 0 the force is 1.5 - x against friction of 0.8."""
    model = model_from(change(STICK, "initial", {"x": x, "v": 0}))
    assert model.initial_mode == expected
    assert find_start_mode(model.derived, numbers_at(model, x=x, v=0.0)) == expected


def test_parameters_decide_too():
    model = model_from(STICK)
    for mu, expected in ((0.4, "slip_above"), (0.6, "slip_on")):
        numbers = numbers_at(model, x=1.0, v=0.0)
        numbers[model.parameter_symbols[model.parameters and list(model.parameters).index("mu")]] = mu
        assert find_start_mode(model.derived, numbers) == expected


def test_a_value_that_is_zero_but_for_rounding_is_on_the_surface():
    """0.1 + 0.2 - 0.3 is 5.6e-17 in doubles."""
    model = model_from(change(change(STICK, "switches.slip", "v - 0.3"), "equations.v'", "-x - mu*sign(v - 0.3)"))
    assert find_start_mode(model.derived, numbers_at(model, x=0.1, v=0.1 + 0.2)) == "slip_on"
    assert find_start_mode(model.derived, numbers_at(model, x=0.1, v=0.3 + 1e-12)) == "slip_above"


def test_the_delayed_values_of_the_history_are_read():
    """x(-1) of the history cos(t) + t is cos(1) - 1 < 0, though x(0) = 1."""
    model = one_law("-x + sign(x(t - 1))", initial={"x": "cos(t) + t", "y": 1})
    assert model.initial_mode == "x_below"


def test_an_initial_mode_of_ones_own_is_taken():
    assert model_from({**STICK, "initial": {"mode": "slip_below", "v": -1}}).initial_mode == "slip_below"
    with pytest.raises(ModelError, match="mode 'slip' is not defined"):
        model_from({**STICK, "initial": {"mode": "slip"}})


def test_of_two_masses_each_sticks_or_moves_as_its_forces_say():
    """With spring forces far below, or far beyond, what holds them."""
    model = model_from(TWO)
    cases = {(0.0, 0.0): "left_on_right_on", (-3.0, 0.0): "left_above", (3.0, 0.0): "left_below"}
    for (x, y), expected in cases.items():
        assert find_start_mode(model.derived, numbers_at(model, x=x, v=0.0, y=y, w=0.0)).startswith(expected)


def test_where_both_fields_point_away_nothing_decides():
    with pytest.raises(ModelError, match="start beside the surface") as caught:
        one_law("sign(x) - 0.1*y", initial={"x": 0})
    assert "its rate is -1 below and 1 above" in str(caught.value)
    model = one_law("sign(x) - 0.1*y", initial={"x": 0.1})
    assert model.initial_mode == "x_above"
    with pytest.raises(PddecontError, match="both fields point away"):
        find_start_mode(model.derived, numbers_at(model, x=0.0, y=2.0, x_1=0.0))
    # Beyond what the sign can do against it the motion crosses.
    assert find_start_mode(model.derived, numbers_at(model, x=0.0, y=20.0, x_1=0.0)) == "x_below"
