"""Which part of an expression has no finite value, where and why."""

import numpy as np
import pytest

from pddecont.codegen import find_non_finite
from pddecont.model.expression import parse_expression
from tests.conftest import numeric_from

NUMERIC = numeric_from("name: m\nstates: [x, y]\nparameters: {a: 2}\nmodes: {m: {x': -x(t - 1), y': a*y}}\n")


def find(*texts, x=(1.0,), y=(1.0,), xd=None, t=None):
    scope = NUMERIC.model.scope("a test", delayed=NUMERIC.model.delayed_value)
    named = [(f"part {k}", parse_expression(text, scope)) for k, text in enumerate(texts)]
    states = np.array([x, y], dtype=float)
    delayed = np.ones((1, len(x))) if xd is None else np.array([xd], dtype=float)
    times = np.arange(len(x), dtype=float) if t is None else np.array(t)
    return find_non_finite(NUMERIC, named, times, states, delayed, np.array([2.0]))


def test_what_has_values_is_not_named():
    assert find("x/y", "log(x)", "sqrt(x)") == ""


@pytest.mark.parametrize(
    ("text", "x", "reason"),
    [
        ("1 + 1/x", 0.0, "1/x divides by zero in part 0, at t = 0, x = 0"),
        ("sqrt(x - 2)*x", 1.0, "sqrt(x - 2) takes a root of a negative number (-1) in part 0, at t = 0, x = 1"),
        ("log(x)", 0.0, "log(x) takes the logarithm of zero in part 0"),
        ("log(x)", -3.0, "log(x) takes the logarithm of a negative number (-3) in part 0"),
        ("asin(x)", 2.0, "asin(x) is not defined at 2.0 in part 0"),
        ("exp(x**2)", 100.0, "exp(x**2) overflows in part 0"),
        ("x + y", np.inf, "part 0 is asked for where x = inf"),
    ],
)
def test_the_innermost_part_is_named_with_its_reason(text, x, reason):
    assert find(text, x=[x]).startswith(reason)


def test_the_first_in_time_is_named_then_the_first_in_order():
    assert "in part 1, at t = 1" in find("log(x)", "sqrt(y)", x=[1, 1, -1], y=[1, -1, -1])
    assert "in part 0, at t = 0" in find("log(x)", "sqrt(y)", x=[-1], y=[-1])


def test_delayed_values_and_parameters_are_named():
    assert "x(t - 1) = 0" in find("a/x(t - 1)", xd=[0.0])
