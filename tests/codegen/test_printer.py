"""One printer: what is printed evaluates to what the expression is, and names nothing else."""

import math

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.codegen.numpy_backend import _MATH, _NUMPY, write_array_source
from pddecont.codegen.printer import ArrayPrinter, ScalarPrinter, check_codable, name_symbols, print_assignments
from pddecont.errors import PddecontError
from pddecont.model.expression import TIME
from tests.conftest import numeric_from

X, Y, P = (sympy.Symbol(name, real=True) for name in ("x", "y", "p"))
NAMES = {TIME: "t", X: "x[0]", Y: "x[1]", P: "p[0]"}
FUNCTIONS = [
    sympy.sin,
    sympy.cos,
    sympy.exp,
    sympy.tanh,
    sympy.atan,
    lambda e: sympy.sqrt(e**2 + 1),
    lambda e: 1 / (e**2 + 2),
]
atoms = st.one_of(
    st.sampled_from([X, Y, P, TIME]),
    st.builds(sympy.Rational, st.integers(-9, 9), st.integers(1, 9)),
    st.builds(sympy.Float, st.floats(-3, 3)),
)
expressions = st.recursive(
    atoms,
    lambda parts: st.one_of(
        st.builds(sympy.Add, parts, parts),
        st.builds(sympy.Mul, parts, parts),
        st.builds(lambda f, e: f(e), st.sampled_from(FUNCTIONS), parts),
    ),
    max_leaves=12,
)


def run(lines, functions, x, p, t, n):
    out = [0.0] * n
    exec("\n".join(lines), {"__builtins__": {}, **functions, "x": x, "p": p, "t": t, "out": out})
    return out


@settings(max_examples=60, deadline=None)
@given(st.lists(expressions, min_size=1, max_size=3))
def test_what_is_printed_is_what_is_meant(exprs):
    x, p, t = [0.37, -1.2], [0.8], 0.45
    expected = [float(e.subs({X: x[0], Y: x[1], P: p[0], TIME: t}).evalf()) for e in exprs]
    targets = [(f"out[{i}]", e) for i, e in enumerate(exprs)]
    mathematics = {**{name: getattr(math, name) for name in dir(math) if not name.startswith("_")}}
    for printer, functions in (
        (ArrayPrinter(NAMES), _MATH),
        (ArrayPrinter(NAMES), _NUMPY),
        (ScalarPrinter(NAMES), mathematics),
    ):
        lines = print_assignments(targets, printer)
        assert run(lines, functions, x, p, t, len(exprs)) == pytest.approx(expected, rel=1e-11, abs=1e-11)


@settings(max_examples=60, deadline=None)
@given(st.lists(expressions, min_size=1, max_size=3))
def test_printed_lines_name_arrays_and_common_parts_only(exprs):
    lines = print_assignments([(f"out[{i}]", e) for i, e in enumerate(exprs)], ArrayPrinter(NAMES))
    for line in lines:
        target, _, value = line.partition(" = ")
        assert target.startswith("out[") or (target[0] == "c" and target[1:].isdigit())
        words = {w for w in "".join(ch if ch.isalnum() else " " for ch in value).split() if w[0].isalpha()}
        assert {w for w in words if not ((w[0] in "ce" and w[1:].isdigit()) or w == "e")} <= {"x", "p", "t", *_NUMPY}


def test_zeros_are_not_written_and_common_parts_once():
    part = sympy.exp(sympy.sin(X) + Y)
    lines = print_assignments(
        [("out[0]", part), ("out[1]", sympy.Integer(0)), ("out[2]", 2 * part)], ScalarPrinter(NAMES)
    )
    assert lines == ["c0 = exp(x[1] + sin(x[0]))", "out[0] = c0", "out[2] = 2*c0"]


def test_the_two_dialects():
    expr = sympy.Rational(1, 3) * sympy.asin(X)
    assert print_assignments([("a", expr)], ArrayPrinter(NAMES)) == ["a = (1/3)*arcsin(x[0])"]
    assert print_assignments([("a", expr)], ScalarPrinter(NAMES)) == ["a = ((1.0/3.0))*asin(x[0])"]


def test_symbols_are_places_in_arrays():
    assert name_symbols([X, Y], [sympy.Symbol("d")], [P]) == {
        TIME: "t",
        X: "x[0]",
        Y: "x[1]",
        sympy.Symbol("d"): "xd[0]",
        P: "p[0]",
    }


@pytest.mark.parametrize(
    "expr", [sympy.DiracDelta(X), sympy.zoo, sympy.nan, X + sympy.oo, sympy.Heaviside(X), sympy.Function("f")(X)]
)
def test_what_there_is_no_code_for_is_refused(expr):
    with pytest.raises(PddecontError, match="which is not a smooth function"):
        check_codable([X, expr])
    with pytest.raises(PddecontError):
        print_assignments([("a", expr)], ArrayPrinter(NAMES))


def test_generated_text_never_holds_the_users_names():
    numeric = numeric_from("name: m\nstates: [exec]\nparameters: {open: 2}\nmodes: {m: {exec': -open*exec}}\n")
    model = numeric.model
    names = name_symbols(model.state_symbols, (), model.parameter_symbols)
    text = write_array_source({"value": model.modes["m"]}, names)
    assert "exec" not in text
    assert "open" not in text
    assert numeric.mode("m").value(np.zeros(1), np.array([[3.0]]), np.zeros((0, 1)), np.array([2.0])) == -6.0


def test_shared_parts_are_computed_once():
    numeric = numeric_from("name: m\nstates: [x, y]\nmodes: {m: {x': exp(sin(x) + y), y': 2*exp(sin(x) + y)}}\n")
    model = numeric.model
    text = write_array_source({"value": model.modes["m"]}, name_symbols(model.state_symbols, (), ()))
    assert text.count("exp(") == 1
