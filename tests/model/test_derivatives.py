"""Derivatives in all symbols at once are those of sympy, term for term, and go through delays that vary."""

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.model import differentiate, find_slopes
from tests.conftest import MODELS, model_from

X, Y, P = SYMBOLS = [sympy.Symbol(name, real=True) for name in ("x", "y", "p")]
FUNCTIONS = [
    *(sympy.sin, sympy.cos, sympy.tan, sympy.asin, sympy.atan, sympy.sinh, sympy.tanh, sympy.exp, sympy.log),
    *(sympy.sqrt, sympy.Abs, lambda e: e**-3, lambda e: e ** sympy.Rational(5, 2), lambda e: 2**e),
]
atoms = st.one_of(
    st.sampled_from(SYMBOLS),
    st.builds(sympy.Rational, st.integers(-9, 9), st.integers(1, 9)),
    st.builds(sympy.Float, st.floats(-3, 3)),
)


def build_angle(y, x):
    """Return atan2(y, x), or y where sympy compares a number with nan and fails."""
    try:
        return sympy.atan2(y, x)
    except TypeError:
        return y


expressions = st.recursive(
    atoms,
    lambda parts: st.one_of(
        st.builds(sympy.Add, parts, parts),
        st.builds(lambda *factors: sympy.Mul(*factors), parts, parts, parts),
        st.builds(lambda e: sympy.Pow(X, e), parts),
        st.builds(build_angle, parts, parts),
        st.builds(lambda f, e: f(e), st.sampled_from(FUNCTIONS), parts),
    ),
    max_leaves=12,
)


def expected_slopes(exprs, symbols):
    slopes = {(i, k): e.diff(s) for i, e in enumerate(exprs) for k, s in enumerate(symbols)}
    return {place: slope for place, slope in slopes.items() if slope != 0}


def is_made_of_numbers(expr):
    """Return whether nothing infinite or undefined stands in an expression, which no model file can hold."""
    return not expr.has(sympy.oo, -sympy.oo, sympy.zoo, sympy.nan)


@settings(max_examples=150, deadline=None)
@given(st.lists(expressions.filter(is_made_of_numbers), min_size=1, max_size=3))
def test_derivatives_are_those_of_sympy(exprs):
    found = find_slopes(exprs, SYMBOLS, {})
    assert found == expected_slopes(exprs, SYMBOLS)
    assert list(found) == sorted(found)


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_derivatives_of_shipped_models_are_those_of_sympy(path):
    model = model_from(path.read_text())
    symbols = [*model.state_symbols[:8], *model.read_symbols[:8], *model.parameter_symbols]
    for exprs in (*model.modes.values(), *model.resets.values()):
        assert find_slopes(exprs[:16], symbols, {}) == expected_slopes(exprs[:16], symbols)


def test_choices_between_numbers_have_the_derivatives_of_their_sides():
    choice = sympy.Piecewise((X**2, X > 0), (P * X, True))
    assert find_slopes([1 + choice], SYMBOLS, {}) == expected_slopes([1 + choice], SYMBOLS)


def test_only_the_symbols_asked_for_are_differentiated_in():
    assert find_slopes([X * Y, P], [Y], {}) == {(0, 0): X}


def test_a_read_moves_with_all_that_its_delay_depends_on():
    """With y = x(t - tau) and tau = p x: d/dx (y^2 + x) = 1 - 2 y y' p, in p it is -2 y y' x."""
    rate = sympy.Symbol("rate", real=True)
    chain = {Y: ((P * X, -rate),)}
    found = find_slopes([Y**2 + X], SYMBOLS, chain)
    assert found == {(0, 0): 1 - 2 * P * Y * rate, (0, 1): 2 * Y, (0, 2): -2 * X * Y * rate}
    assert differentiate(Y**2 + X, P, chain) == -2 * X * Y * rate


def test_a_delay_may_read_what_is_delayed_itself():
    """With y = x(t - p), z = x(t - y): dz/dp = -z' dy/dp = z' y'."""
    z, y_rate, z_rate = (sympy.Symbol(name, real=True) for name in ("z", "y'", "z'"))
    chain = {Y: ((P, -y_rate),), z: ((Y, -z_rate),)}
    assert find_slopes([3 * z], [P, Y], chain) == {(0, 0): 3 * y_rate * z_rate, (0, 1): -3 * z_rate}
