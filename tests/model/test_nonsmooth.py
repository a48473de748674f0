"""Nonsmooth functions: the law in the mode of a point is the function as Python writes it; and what is refused."""

import math
import random

import pytest

from pddecont.errors import ModelError
from pddecont.model import find_start_mode
from tests.conftest import model_from
from tests.model.equations_models import field_at, numbers_at, one_law

A, B = 0.5, -0.25


def sign(u):
    return math.copysign(1.0, u)


def clip(x, low, high):
    return min(max(x, low), high)


def deadzone(x, low, high):
    return x - high if x > high else x - low if x < low else 0.0


# Text of the law, the same in Python, number of switches.
LAWS = [
    ("sign(x - a)", lambda x, y, z, t: sign(x - A), 1),
    ("3*heaviside(y)*x", lambda x, y, z, t: 3 * x if y > 0 else 0.0, 1),
    ("abs(x*y)", lambda x, y, z, t: abs(x * y), 1),
    ("max(x, y)", lambda x, y, z, t: max(x, y), 1),
    ("min(x, y)", lambda x, y, z, t: min(x, y), 1),
    ("max(x, y, a)", lambda x, y, z, t: max(x, y, A), 2),
    ("min(x, y, a, x*y)", lambda x, y, z, t: min(x, y, A, x * y), 3),
    ("clip(x + y, b, a)", lambda x, y, z, t: clip(x + y, B, A), 2),
    ("deadzone(x, a)", lambda x, y, z, t: deadzone(x, -A, A), 2),
    ("deadzone(y, b, a)", lambda x, y, z, t: deadzone(y, B, A), 2),
    ("where(x > y, x**2, y)", lambda x, y, z, t: x**2 if x > y else y, 1),
    ("where(x < y and y > a, x, 2)", lambda x, y, z, t: x if x < y and y > A else 2.0, 2),
    ("where(x < y or y > a, x, 2)", lambda x, y, z, t: x if x < y or y > A else 2.0, 2),
    ("where(not (x >= y and not y <= a), x, 2)", lambda x, y, z, t: x if not (x >= y and y > A) else 2.0, 2),
    ("where(b < x < a, x, 2)", lambda x, y, z, t: x if B < x < A else 2.0, 2),
    ("coulomb(x - y, 0.4, 0.6)", lambda x, y, z, t: 0.4 * sign(x - y), 1),
    ("hysteresis(x, a, a + 1)", lambda x, y, z, t: 1.0 if x > A + 1 else -1.0, 1),
    ("square(t, 2)", lambda x, y, z, t: 1.0 if t % 2 < 1 else -1.0, 1),
    ("square(t - a, 2)", lambda x, y, z, t: 1.0 if (t - A) % 2 < 1 else -1.0, 1),
    ("max(0, x(t - 1) - a)", lambda x, y, z, t: max(0.0, z - A), 1),
    ("sign(x - x(t - 1))", lambda x, y, z, t: sign(x - z), 1),
    ("abs(cos(pi*t) - x)", lambda x, y, z, t: abs(math.cos(math.pi * t) - x), 1),
    ("abs(abs(x) - 1)", lambda x, y, z, t: abs(abs(x) - 1), 2),
    ("sign(y)*max(0, x - a) + sign(x)", lambda x, y, z, t: sign(y) * max(0.0, x - A) + sign(x), 3),
    ("max(abs(x), abs(y)) - clip(x, -1, 1)", lambda x, y, z, t: max(abs(x), abs(y)) - clip(x, -1, 1), 5),
    ("where(sign(x) + sign(y) > 1, abs(x), y)", lambda x, y, z, t: abs(x) if x > 0 and y > 0 else y, 3),
    ("max(0, sign(x)*y)", lambda x, y, z, t: max(0.0, sign(x) * y), 2),
]


@pytest.mark.parametrize(("text", "plain", "n_switches"), LAWS, ids=[text for text, _, _ in LAWS])
def test_the_law_in_the_mode_of_a_point_is_the_function_itself(text, plain, n_switches):
    model, draw = one_law(f"{text} - 0.5*x"), random.Random(3)
    assert len(model.derived.equations.switches) == n_switches
    for _ in range(40):
        x, y, x_1 = (draw.uniform(-2, 2) for _ in range(3))
        t = draw.uniform(0, 6)
        found = field_at(model, numbers_at(model, t, x=x, y=y, x_1=x_1))
        assert found == pytest.approx([plain(x, y, x_1, t) - 0.5 * x, x_1 - y], abs=1e-13)


def test_a_definition_may_hold_them_and_be_nested():
    model, draw = one_law("2*wall - x", definitions={"wall": "max(0, gap)", "gap": "abs(x) - a"}), random.Random(4)
    for _ in range(20):
        x = draw.uniform(-2, 2)
        found = field_at(model, numbers_at(model, x=x, y=0.1, x_1=0.0))
        assert found[0] == pytest.approx(2 * max(0.0, abs(x) - A) - x, abs=1e-14)


def test_between_its_thresholds_a_relay_starts_below():
    model = one_law("hysteresis(x, -1, 1)")
    for x, expected in ((-1.5, -1), (-0.5, -1), (0.5, -1), (1.5, 1)):
        assert field_at(model, numbers_at(model, x=x, y=0.0, x_1=0.0))[0] == expected


def test_both_modes_of_a_relay_hold_between_its_thresholds():
    model = one_law("hysteresis(x, -1, 1)")
    numbers = numbers_at(model, x=0.3, y=0.0, x_1=0.0)
    assert [field_at(model, numbers, mode)[0] for mode in model.modes] == [-1, 1]
    assert {s.name: (s.event, s.direction) for s in model.segments.values()} == {
        "x_up": ("x_high", "rising"),
        "x_down": ("x_low", "falling"),
    }


@pytest.mark.parametrize(("text", "start"), [("mod(t, 2)", 0.0), ("mod(t - a, 2)", 1.5), ("mod(t + a, 2)", 0.5)])
def test_a_sawtooth_is_a_clock_that_ticks_set_to_zero(text, start):
    model = one_law(f"{text} - x")
    assert model.states == ("x", "y", "clock") and list(model.modes) == ["smooth"]
    assert model.evaluate(model.history[2]) == pytest.approx(start, abs=1e-15)
    (segment,) = model.segments.values()
    assert (segment.direction, str(model.resets[segment.reset][2])) == ("rising", "0")
    tick = model.events[segment.event].function
    for k in range(3):
        assert model.evaluate(tick, time=2.0 * (k + 1) - start) == pytest.approx(0.0, abs=1e-14)


def test_the_same_sawtooth_is_the_same_clock():
    assert one_law("mod(t, 2) + 2*mod(t, 2)*y").states == ("x", "y", "clock")
    assert one_law("mod(t, 2) + mod(t, 1)").states == ("x", "y", "clock", "clock2")


@pytest.mark.parametrize(
    ("text", "n_switches"),
    [
        ("sign(x - a) + abs(2*x - 2*a)", 1),
        ("sign(x - a) + abs(a - x)", 1),
        ("max(x, y) + min(x, y)", 0),
        ("2*max(x, y) + min(x, y)", 1),
        ("max(x, y) + where(3*y > 3*x, 1, 2)", 1),
        ("sign(x) + sign(y)", 2),
        ("sign(x - a) + sign(x + a)", 2),
        ("clip(x, 0, a) + max(0, x)", 2),
        ("square(t, 2) + mod(t, 2)", 1),
        ("hysteresis(x, -1, 1) + 2*hysteresis(x, -1, 1)", 1),
        ("hysteresis(x, -1, 1) + hysteresis(x, -1, 2)", 2),
    ],
)
def test_arguments_that_are_equal_up_to_a_number_share_a_switch(text, n_switches):
    assert len(one_law(text).derived.equations.switches) == n_switches


def test_a_reversed_argument_reads_the_same_digit_the_other_way_round():
    model = one_law("sign(x) + 10*sign(-3*x) + 100*heaviside(-x)", switches={"s": "-2*x"})
    (switch,) = model.derived.equations.switches
    assert (switch.name, str(switch.argument)) == ("s", "-2*x")
    for x in (-0.7, 0.7):
        numbers = numbers_at(model, x=x, y=0.0, x_1=0.0)
        assert find_start_mode(model.derived, numbers) == ("s_above" if x < 0 else "s_below")
        assert field_at(model, numbers)[0] == pytest.approx(sign(x) - 10 * sign(x) + 100 * (x < 0))


def test_what_decides_nothing_is_no_switch():
    assert list(one_law("sign(x)**2 + sign(x) + sign(-x)").modes) == ["smooth"]


def test_products_of_one_sign_are_those_of_its_sides():
    """In the middle, where a motion slides, they are the mean of the sides: sign(x)**3 is sign(x)."""
    model = one_law("-2*sign(x)**3 + 0.5*y")
    assert str(model.modes["x_on"][0]) == "0"
    (off_up, off_down) = (model.events[f"x_off_{way}"].function for way in ("up", "down"))
    assert {str(off_up), str(off_down)} == {"0.5*y - 2", "0.5*y + 2"}


def test_names_of_switches_are_those_of_their_states_unless_given():
    model = one_law("sign(x + y) + sign(y) + sign(y - a) + square(t, 2)", switches={"belt": "y - a"})
    assert [s.name for s in model.derived.equations.switches] == ["belt", "x_y", "y", "t"]


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("x + sign(a)", 5, "the sign of a constant"),
        ("x + max(a, 2*b)", 5, "the sign of a constant"),
        ("abs(x**2 + 1)", 1, "this argument is always positive: it switches nothing"),
        ("y*sign(-exp(x))", 3, "this argument is always negative"),
        ("max(x)", 1, r"max takes 2 or more argument\(s\), found 1"),
        ("sign(x, y)", 1, r"sign takes 1 argument\(s\), found 2"),
        ("1 + clip(x, 1)", 5, r"clip takes 3 argument\(s\), found 2"),
        ("deadzone(x)", 1, r"deadzone takes 2 to 3 argument\(s\), found 1"),
        ("where(x > 0, 1)", 1, r"where\(condition, a, b\) takes 3 arguments, found 2"),
        ("where(x, 1, 2)", 7, "this is no condition"),
        ("where(a > 0, 1, 2)", 1, "the sign of a constant"),
        ("where(2 > 1, 1, 2)", 1, "this condition never changes"),
        ("mod(x, 2)", 1, r"write mod\(t, T\) or square\(t, T\)"),
        ("mod(2*t, 2)", 1, r"write mod\(t, T\) or square\(t, T\)"),
        ("square(t, x)", 1, r"write mod\(t, T\) or square\(t, T\)"),
        ("hysteresis(x, a, a)", 1, "the upper less the lower threshold is 0"),
        ("coulomb(x, 1, 1.3) + coulomb(x, 1, 1.5)", 22, "another coulomb law with another static by kinetic"),
        ("coulomb(x, 1, 1.3) + sign(x)", 22, "the sign of switch 'x' is read by coulomb"),
        ("sign(x) + sign(a*x)", 11, "this argument is a times that of another switch"),
        ("sign(z)", 6, "'z' is not defined"),
        ("sing(x)", 1, "unknown function 'sing'"),
        ("abs + x", 1, r"'abs' is a function: write abs\(...\)"),
    ],
)
def test_what_is_refused_is_told_with_its_place(text, column, message):
    """The text begins in column 7 of line 5, behind its quotation mark."""
    given = f"name: m\nstates: [x, y]\nparameters: {{a: 0.5, b: -0.25}}\nequations:\n  x': \"{text}\"\n  y': -y\n"
    with pytest.raises(ModelError, match=message) as caught:
        model_from(f"{given}forcing: {{period: 2}}\n")
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (5, 7 + column)


@pytest.mark.parametrize("text", ["square(t, 0)", "mod(t, a - 0.5)", "square(t, b)"])
def test_a_period_is_positive(text):
    with pytest.raises(ModelError, match="period"):
        one_law(text)


def test_a_coulomb_law_shares_its_sign_with_nothing_in_either_order():
    with pytest.raises(ModelError, match="is read by coulomb"):
        one_law("-sign(x) - coulomb(x, 1, 1.3)")


@pytest.mark.parametrize("text", ["-coulomb(x, 1, 0.5)", "-coulomb(x, 2*a, a)", "-coulomb(x, 0, 1)"])
def test_static_friction_is_at_least_the_kinetic(text):
    with pytest.raises(ModelError):
        one_law(text)


@pytest.mark.parametrize("text", ["hysteresis(x, 2, 1)", "hysteresis(x, a, b)"])
def test_the_low_threshold_is_the_lower_one(text):
    with pytest.raises(ModelError):
        one_law(text)
