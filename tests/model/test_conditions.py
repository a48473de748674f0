"""Conditions: what they mean, how far they are from changing, and what is wrong with a text that is none."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from pddecont.model import ExpressionError, Scope, combine_differences, list_differences
from pddecont.model.conditions import parse_condition, substitute_in

a, b = sympy.symbols("a b", real=True)
SCOPE = Scope({"a": a, "b": b, "not_a": a + 1}, place="a test")
COMPARISONS = ["a > b", "a >= 1", "b < 0.5", "a + b <= 2", "-1 < a <= 2"]
TEXTS = st.recursive(
    st.sampled_from(COMPARISONS),
    lambda part: st.one_of(
        st.tuples(part, st.sampled_from(["and", "or"]), part).map(lambda p: f"({p[0]}) {p[1]} ({p[2]})"),
        part.map(lambda p: f"not ({p})"),
    ),
    max_leaves=6,
)


@given(TEXTS, st.integers(-40, 40), st.integers(-40, 40))
def test_a_condition_holds_where_python_says_so(text, x, y):
    condition, values = parse_condition(text, SCOPE), {"a": x / 16, "b": y / 16}
    assert bool(condition.subs({a: values["a"], b: values["b"]})) == eval(text, {}, values)


@given(TEXTS, st.integers(-40, 40), st.integers(-40, 40))
def test_how_far_it_is_from_changing_is_positive_where_it_holds(text, x, y):
    """Values are odd multiples of 1/32, where nothing is equal to what it is compared with."""
    values = {a: sympy.Rational(2 * x + 1, 32), b: sympy.Rational(4 * y + 3, 61)}
    condition = parse_condition(text, SCOPE)
    distances = {d: float(d.subs(values)) for d in list_differences(condition)}
    assert (combine_differences(condition, distances) > 0) == bool(condition.subs(values))


def test_and_takes_the_least_and_or_the_largest():
    for text, expected in (("a > 1 and b > 1", 2.0), ("a > 1 or b > 1", 4.0), ("not (a > 1 or b > 1)", -4.0)):
        condition = parse_condition(text, SCOPE)
        values = {d: float(d.subs({a: 5, b: 3})) for d in list_differences(condition)}
        assert combine_differences(condition, values) == expected


def test_a_name_may_begin_like_an_operator():
    assert parse_condition("not_a > 0", SCOPE) == (a + 1 > 0)


def test_other_expressions_take_the_place_of_symbols():
    assert substitute_in(parse_condition("a > 1 and b < a", SCOPE), {a: sympy.Integer(0)}) == sympy.false


@pytest.mark.parametrize(
    ("text", "offset", "message"),
    [
        ("a", 0, "this is no condition"),
        ("a > 0 and b", 10, "this is no condition"),
        ("a == 0", 0, "only > >= < <= compare here"),
        ("a > z", 4, "'z' is not defined"),
        ("a > 0 and", 9, "not an expression"),
        (3.0, 0, "3.0 is a number"),
    ],
)
def test_what_is_none_is_told_with_its_place(text, offset, message):
    with pytest.raises(ExpressionError, match=message) as caught:
        parse_condition(text, SCOPE)
    assert caught.value.offset == offset
