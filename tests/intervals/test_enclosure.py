"""Intervals hold the values and slopes that exact arithmetic gives."""

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from pddecont.intervals import Enclosure
from pddecont.model.evaluation import evaluate as estimate

X, Y, P = sympy.symbols("x y p", real=True)
FUNCTIONS = [
    sympy.sin, sympy.cos, sympy.tan, sympy.asin, sympy.acos, sympy.atan, sympy.sinh, sympy.cosh, sympy.tanh,
    sympy.exp, sympy.log, sympy.sqrt, sympy.Abs, sympy.sign,
]  # fmt: skip
POWERS = [2, 3, 5, -1, -2, sympy.Rational(1, 2), sympy.Rational(5, 3), P]
DIGITS = 40
# A sine of more than this is not asked for: it takes as many digits as the number has.
HUGE = 1e9


def combine(parts):
    """Return expressions made of others; of numbers alone sums and products, since towers of them fill the memory."""
    read = parts.filter(lambda e: bool(e.free_symbols))
    return st.one_of(
        st.builds(lambda a, b: a + b, parts, parts),
        st.builds(lambda a, b: a * b, parts, parts),
        st.builds(lambda f, a: f(a), st.sampled_from(FUNCTIONS), read),
        st.builds(lambda a, n: a**n, read, st.sampled_from(POWERS)),
        st.builds(lambda a, b: (1 + a**2) ** b, read, read),
        st.builds(sympy.atan2, read, read),
    )


def is_real(e):
    return bool(e.free_symbols) and not e.has(sympy.zoo, sympy.nan, sympy.oo, sympy.I, sympy.re, sympy.im, sympy.arg)


LEAVES = st.one_of(
    st.sampled_from([X, Y, P, sympy.pi, sympy.E]), st.fractions(-4, 4, max_denominator=7).map(sympy.Rational)
)
EXPRESSIONS = st.recursive(LEAVES, combine, max_leaves=6).filter(is_real)
NUMBERS = st.one_of(st.sampled_from([-1.0, 0.0, 0.5, 1.0, 3.0]), st.floats(-4, 4, allow_subnormal=False))
WIDTHS = st.sampled_from([0.0, 1e-12, 0.01, 0.5, 3.0])


def evaluate(expr, at):
    """Return what an expression is worth, with many digits; None where it or a function in it has no real value.

    A logarithm of zero has none, though one over it is zero to those who reckon with infinity.
    """
    if not all(abs(estimate(a, at)) < HUGE for f in expr.atoms(sympy.Function) for a in f.args):
        return None
    with mpmath.workdps(DIGITS):
        numbers = {s: mpmath.mpf(v) for s, v in at.items()}
        try:
            parts = [*expr.atoms(sympy.Function), expr]
            values = sympy.lambdify(list(numbers), parts, "mpmath")(*numbers.values())
        except (ValueError, ZeroDivisionError, OverflowError, AttributeError, TypeError):
            return None
        has_value = all(isinstance(value, mpmath.mpf) and mpmath.isfinite(value) for value in values)
        return values[-1] if has_value else None


def has_jump(expr):
    """Whether a derivative is one that is zero beside a jump, and has no value on it."""
    return expr.has(sympy.sign, sympy.atan2, sympy.DiracDelta)


def differentiate(expr, symbol):
    """Return a derivative beside jumps."""
    return expr.diff(symbol).replace(sympy.DiracDelta, lambda *_: sympy.S.Zero)


@settings(max_examples=400, deadline=None)
@given(
    EXPRESSIONS,
    st.tuples(NUMBERS, NUMBERS),
    st.tuples(WIDTHS, WIDTHS),
    st.lists(st.floats(0, 1), min_size=2, max_size=2),
    NUMBERS,
)
@example(X**P, (-1.0, 0.0), (0.0, 0.0), [0.0, 0.0], 3.0)
@example(X**P, (0.0, 0.0), (0.5, 0.0), [0.0, 0.0], 0.5)
@example(X**P, (0.0, 0.0), (0.0, 0.0), [0.0, 0.0], 0.0)
@example(1 / X, (0.0, 0.0), (0.5, 0.0), [1.0, 0.0], 0.5)
@example(sympy.tan(X), (1.5, 0.0), (0.5, 0.0), [1.0, 0.0], 0.5)
def test_values_and_slopes_lie_in_their_intervals(expr, low, widths, parts, p):
    low, high = np.array(low), np.array(low) + widths
    point = np.clip(low + np.array(parts) * widths, low, high)
    values, slopes = Enclosure((expr,), (X, Y), {P: p}).derivatives(low[:, None], high[:, None])
    at = {X: float(point[0]), Y: float(point[1]), P: p}
    value = evaluate(expr, at)
    assume(value is not None)
    assert values.low[0, 0] <= value <= values.high[0, 0]
    for k, symbol in enumerate((X, Y)):
        slope = None if has_jump(expr) and not values.sure[0, 0] else evaluate(differentiate(expr, symbol), at)
        if slope is not None:
            assert slopes.low[0, k, 0] <= slope <= slopes.high[0, k, 0]


def test_where_a_function_inside_has_no_value_the_whole_has_none():
    nowhere, zero = Enclosure((1 / sympy.log(X),), (X,), {}), np.zeros((1, 1))
    assert nowhere.values(zero, zero).is_empty[0, 0]
    # Beside it there are values, and zero is not missed as their limit.
    beside = nowhere.values(zero, zero + 0.5)
    assert beside.low[0, 0] <= 1 / np.log(0.5) <= beside.high[0, 0]
    assert beside.holds_zero[0, 0]
    assert not beside.sure[0, 0]


@pytest.mark.parametrize(
    ("expr", "low", "high", "least", "most"),
    [
        (X**2, -1.0, 2.0, 0.0, 4.0),
        (X**3, -1.0, 2.0, -1.0, 8.0),
        (sympy.sin(X), 0.0, 3.0, 0.0, 1.0),
        (sympy.cos(X), 3.0, 4.0, -1.0, np.cos(4.0)),
        (1 / X, 2.0, 4.0, 0.25, 0.5),
        (sympy.exp(X), -1.0, 1.0, np.exp(-1.0), np.e),
        (X ** sympy.Rational(3, 2), 1.0, 4.0, 1.0, 8.0),
        (abs(X), -3.0, 2.0, 0.0, 3.0),
        (sympy.tanh(X), -50.0, 50.0, -1.0, 1.0),
        (1 / X, 0.0, 4.0, 0.25, np.inf),
        (1 / X, -1.0, 4.0, -np.inf, np.inf),
        (sympy.log(X), -1.0, 1.0, -np.inf, 0.0),
    ],
)
def test_one_read_of_a_variable_gives_the_range_itself(expr, low, high, least, most):
    values = Enclosure((expr,), (X,), {}).values(np.array([[low]]), np.array([[high]]))
    assert values.low[0, 0] == pytest.approx(least, rel=1e-14, abs=1e-14)
    assert values.high[0, 0] == pytest.approx(most, rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("expr", [sympy.log(X), sympy.sqrt(X - 2), sympy.asin(X - 5), (X - 3) ** P, 1 / (X + 1 - X)])
def test_nothing_is_known_to_lie_where_a_function_is_defined_nowhere(expr):
    values = Enclosure((expr,), (X,), {P: 0.3}).values(np.array([[-2.0]]), np.array([[-1.0]]))
    defined = expr == 1 / (X + 1 - X)
    assert bool(np.isnan(values.low[0, 0])) != defined
    assert bool(values.sure[0, 0]) == defined


@pytest.mark.parametrize(
    ("expr", "sure"),
    [
        (1 / X, False),
        (sympy.sign(X), False),
        (sympy.sqrt(X), False),
        (sympy.tan(2 * X), False),
        (abs(X), True),
        (X**2, True),
    ],
)
def test_where_a_function_breaks_off_it_is_not_sure(expr, sure):
    values = Enclosure((expr,), (X,), {}).values(np.array([[-1.0]]), np.array([[1.0]]))
    assert bool(values.sure[0, 0]) == sure


def test_a_power_is_that_of_a_whole_number_where_its_exponent_is_one():
    """x**n of negative x has a value for n = 3, as in the model's own functions, and none for n = 3.5."""
    low, high = np.array([[-2.0]]), np.array([[-1.0]])
    assert Enclosure((X**P,), (X,), {P: 3.0}).values(low, high).low[0, 0] == pytest.approx(-8.0, rel=1e-14)
    assert np.isnan(Enclosure((X**P,), (X,), {P: 3.5}).values(low, high).low[0, 0])


def test_many_boxes_are_enclosed_as_each_alone():
    rng = np.random.default_rng(3)
    low = rng.normal(size=(2, 50))
    high = low + rng.random((2, 50))
    enclosure = Enclosure((X * sympy.exp(-Y * P) / (1 + X**2), sympy.sin(X * Y)), (X, Y), {P: 0.7})
    values, slopes = enclosure.derivatives(low, high)
    for b in range(50):
        value, slope = enclosure.derivatives(low[:, b : b + 1], high[:, b : b + 1])
        assert np.array_equal(values.low[:, b], value.low[:, 0])
        assert np.array_equal(slopes.high[..., b], slope.high[..., 0])
