"""What is written is what is read: random formulas against their values, and printed expressions read again."""

import math

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.codegen.printer import ScalarPrinter
from pddecont.model import TIME, Scope, parse_expression
from pddecont.model.system import make_delayed_symbol, make_symbol

VALUES = {"x": 0.75, "beta": -1.25, "lambda": 1.5, "N": -0.5, "is": 2.25}
T = 0.375
# Arguments of delayed values with their delays, and values for them.
ARGUMENTS = {"t - beta": ("beta", 0.25), "t-2*lambda": ("2*lambda", -1.75), "-N + t - 1": ("N + 1", 1.125)}
# An exponential of 1 is printed as E.
SCOPE = Scope(
    {**{name: make_symbol(name) for name in VALUES}, "E": sympy.E}, states=("x",), delayed=make_delayed_symbol
)
DELAYED = {
    argument: make_delayed_symbol("x", parse_expression(delay, SCOPE)) for argument, (delay, _) in ARGUMENTS.items()
}
NUMBERS = {make_symbol(name): value for name, value in VALUES.items()} | {TIME: T}
NUMBERS |= {DELAYED[argument]: value for argument, (_, value) in ARGUMENTS.items()}
SUM, PRODUCT, SIGN, POWER, ATOM = range(1, 6)
# Functions whose slopes are at most 1; exp is bounded by what is written in it.
FUNCTIONS = {"sin": math.sin, "cos": math.cos, "tanh": math.tanh, "atan": math.atan}


class Formula:
    """A formula as text, how tightly its outermost operator binds, its value, and how large its parts are."""

    def __init__(self, text, binds, value, size):
        self.text, self.binds, self.value, self.size = text, binds, value, max(size, abs(value), 1.0)

    def __repr__(self):
        return self.text

    def within(self, least):
        """Return the text, in parentheses if it binds less tightly than that."""
        return self.text if self.binds >= least else f"({self.text})"


def add(a, b, operator, space):
    sign = 1 if operator == "+" else -1
    text = f"{a.within(SUM)}{space}{operator}{space}{b.within(PRODUCT)}"
    return Formula(text, SUM, a.value + sign * b.value, a.size + b.size)


def multiply(a, b, space):
    return Formula(f"{a.within(PRODUCT)}{space}*{space}{b.within(SIGN)}", PRODUCT, a.value * b.value, a.size * b.size)


def divide(a, b, space):
    """Return a quotient by a number that is at least 2."""
    below = add(raise_to(b, 2), Formula("2", ATOM, 2.0, 2.0), "+", space)
    text = f"{a.within(PRODUCT)}{space}/{space}({below.text})"
    return Formula(text, PRODUCT, a.value / below.value, a.size * below.size)


def negate(a):
    return Formula(f"-{a.within(SIGN)}", SIGN, -a.value, a.size)


def raise_to(a, n):
    return Formula(f"{a.within(ATOM)}**{n}", POWER, a.value**n, a.size**n)


def raise_to_power(a):
    """Return a power of a power, which is read from the right."""
    return Formula(f"{a.within(ATOM)}**2**1", POWER, a.value**2, a.size**2)


def invert(a, space):
    below = add(raise_to(a, 2), Formula("1", ATOM, 1.0, 1.0), "+", space)
    return Formula(f"({below.text})**-1", POWER, 1 / below.value, below.size)


def apply(name, a):
    return Formula(f"{name}({a.text})", ATOM, FUNCTIONS[name](a.value), a.size)


def apply_exp(a):
    return Formula(f"exp(sin({a.text}))", ATOM, math.exp(math.sin(a.value)), 3 * a.size)


def apply_root(a, space):
    inside = add(Formula("1", ATOM, 1.0, 1.0), raise_to(a, 2), "+", space)
    return Formula(f"sqrt({inside.text})", ATOM, math.sqrt(inside.value), inside.size)


def enclose(a, space):
    return Formula(f"({space}{a.text}{space})", ATOM, a.value, a.size)


def make_number(n, text):
    return Formula(text.format(n), ATOM if "/" not in text else PRODUCT, float(eval(text.format(n))), 1.0)


spaces = st.sampled_from(["", " ", "  ", "\n", "\t"])
names = st.one_of(
    st.sampled_from([Formula(name, ATOM, value, 1.0) for name, value in VALUES.items()]),
    st.sampled_from([Formula(f"x({text})", ATOM, value, 1.0) for text, (_, value) in ARGUMENTS.items()]),
    st.just(Formula("t", ATOM, T, 1.0)),
)
whole = st.builds(make_number, st.integers(0, 9), st.sampled_from(["{}", "{}", "{}/3", "{}/8"]))
floats = st.builds(make_number, st.integers(0, 9), st.sampled_from(["{}.5", "{}e-1", ".{}", "0{}.25e1"]))


def make_formulas(atoms):
    """Return formulas of such atoms."""
    return st.recursive(
        atoms,
        lambda parts: st.one_of(
            st.builds(add, parts, parts, st.sampled_from("+-"), spaces),
            st.builds(multiply, parts, parts, spaces),
            st.builds(divide, parts, parts, spaces),
            st.builds(negate, parts),
            st.builds(raise_to, parts, st.integers(2, 3)),
            st.builds(raise_to_power, parts),
            st.builds(invert, parts, spaces),
            st.builds(apply, st.sampled_from(sorted(FUNCTIONS)), parts),
            st.builds(apply_exp, parts),
            st.builds(apply_root, parts, spaces),
            st.builds(enclose, parts, spaces),
        ),
        max_leaves=8,
    )


def evaluate(expr):
    return float(expr.xreplace({symbol: sympy.Float(value, 20) for symbol, value in NUMBERS.items()}).evalf(20))


@settings(max_examples=50, deadline=None, derandomize=True)
@given(make_formulas(st.one_of(names, whole, floats)))
def test_a_formula_has_the_value_that_it_says(formula):
    assert evaluate(parse_expression(formula.text, SCOPE)) == pytest.approx(formula.value, abs=1e-13 * formula.size)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(make_formulas(st.one_of(names, whole)))
def test_a_printed_expression_is_read_as_the_same(formula):
    expr = parse_expression(formula.text, SCOPE)
    again = parse_expression(str(expr), SCOPE)
    assert evaluate(again) == pytest.approx(formula.value, abs=1e-13 * formula.size)
    assert again.free_symbols == expr.free_symbols


@settings(max_examples=50, deadline=None, derandomize=True)
@given(make_formulas(st.one_of(names, whole, floats)))
def test_generated_source_is_read_as_the_same_value(formula):
    expr = parse_expression(formula.text, SCOPE)
    source = ScalarPrinter({symbol: symbol.name for symbol in NUMBERS}).doprint(expr)
    found = parse_expression(source.replace("math.", ""), SCOPE)
    assert evaluate(found) == pytest.approx(formula.value, abs=1e-13 * formula.size)
