"""What is zero wherever it is evaluated, or wherever something else is."""

import pytest
import sympy

from pddecont.model.vanishing import measure_terms, vanishes, vanishes_where

x, y, a = sympy.symbols("x y a", real=True)


@pytest.mark.parametrize(
    "expr",
    [
        sympy.S.Zero,
        sympy.sin(x) ** 2 + sympy.cos(x) ** 2 - 1,
        (x + y) ** 3 - x**3 - 3 * x**2 * y - 3 * x * y**2 - y**3,
        sympy.exp(x) * sympy.exp(a) - sympy.exp(x + a),
        sympy.log(x * y) - sympy.log(x) - sympy.log(y),
    ],
)
def test_zero_in_disguise(expr):
    assert vanishes(expr)


@pytest.mark.parametrize(
    "expr",
    [
        sympy.S.One,
        x,
        sympy.sin(x) ** 2 + sympy.cos(x) ** 2 - 1 + sympy.Float(1e-6),
        x * (x - 1),
        sympy.Float(1e-20) * x,
        sympy.exp(x) - 1 - x - x**2 / 2,
    ],
)
def test_what_is_zero_at_some_points_only_is_not(expr):
    assert not vanishes(expr)


@pytest.mark.parametrize(
    ("expr", "surface", "expected"),
    [
        (x - a, x - a, True),
        (y * (x - a), x - a, True),
        ((x - y) * (x + y), x - y, True),
        (x**3 - a**3, x - a, True),
        (x - a, x - 2 * a, False),
        (y, x - a, False),
        (x - a + y, x - a, False),
        pytest.param(*(sympy.sin(x - y**2), x - y**2, True)),
        (x + a, x - a, False),
    ],
)
def test_zero_wherever_a_surface_is(expr, surface, expected):
    assert vanishes_where(sympy.sympify(expr), surface, {x, y}) == expected


def test_a_value_that_is_real_nowhere_is_not_zero():
    assert not vanishes(sympy.sqrt(-1 - x**2))


def test_terms_are_measured_without_their_signs():
    assert measure_terms(3 * x - y, {x: 2.0, y: 5.0}) == 11.0
    assert measure_terms((x - y) ** 2 * a, {x: 2.0, y: 5.0, a: -0.5}) == 24.5
