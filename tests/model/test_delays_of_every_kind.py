"""Formats of delays that vary, rates, integrals over the past and delays that conditions define."""

from __future__ import annotations

import pytest
import sympy

from pddecont.errors import ModelError
from pddecont.model import Integral, differentiate, leave_out_effects, parse_document, parse_model
from pddecont.model.evaluation import evaluate
from tests.runs import to_yaml

X, T = sympy.Symbol("x", real=True), sympy.Symbol("t", real=True)


def model_of(law, *, states=("x",), parameters=None, more=None):
    """Return the model x' = law."""
    file = {"name": "m", "states": list(states), "parameters": parameters or {"a": 2.0, "c": 0.3, "T": 1.5}}
    file |= {"modes": {"m": {"x'": law}}} | (more or {})
    return parse_model(parse_document(to_yaml(file), "m.yaml"))[0]


def error_of(law, **keys):
    with pytest.raises(ModelError) as told:
        model_of(law, **keys)
    return str(told.value)


def test_constant_delays_come_before_those_that_vary():
    model = model_of("x(t - 1 - c*x) + a*x(t - T)")
    assert [str(d) for d in model.delays] == ["T"]
    assert [str(d) for d in model.varying] == ["c*x + 1"]
    # The rate is read along: derivatives hold it.
    assert [(r.delay, r.derivative) for r in model.delayed] == [(1, 0), (0, 0), (1, 1)]


def test_derivatives_go_through_delays_that_vary():
    model = model_of("a*x(t - 1 - c*x)")
    (f,) = model.modes["m"]
    rate = model.delayed_symbols[1]
    a, c = model.parameter_symbols[:2]
    assert differentiate(f, X, model.chain) == -a * rate * c
    assert differentiate(f, c, model.chain) == -a * rate * X


def test_nested_delays_are_in_the_order_in_which_they_are_read():
    model = model_of("x(t - 1 - c*x(t - T - 0.1*x))")
    inner, outer = model.varying
    assert inner.free_symbols == {X, sympy.Symbol("T", real=True)}
    assert model.delayed_symbols[0] in outer.free_symbols


def test_integrals_know_their_integrand_and_what_their_derivatives_read():
    model = model_of("integral(exp(-c*s)*x(t - s), s, 0, T)")
    c = sympy.Symbol("c", real=True)
    first, slope = model.integrals
    assert first == Integral(sympy.exp(-c * T) * X, sympy.S.Zero, sympy.Symbol("T", real=True))
    assert slope.integrand == -T * sympy.exp(-c * T) * X
    (f,) = model.modes["m"]
    assert differentiate(f, c, model.chain) == model.integral_symbols[1]
    assert (
        sympy.Symbol("x(t - T)", real=True) in differentiate(f, sympy.Symbol("T", real=True), model.chain).free_symbols
    )


def test_infinite_ranges_become_states_that_follow():
    """The gamma kernel r^2 s exp(-r s): two states, each equal to x at rest, that start from the history."""
    model = model_of("-a*integral(c**2*s*exp(-c*s)*x(t - s), s, 0, inf)", more={"initial": {"x": "1 + t*a"}})
    assert model.states == ("x", "memory_1", "memory_2")
    f, first, second = model.modes["m"]
    c, a = (sympy.Symbol(name, real=True) for name in "ca")
    one, two = model.state_symbols[1:]
    assert sympy.simplify(f + a * two) == 0
    assert (sympy.simplify(first - c * (X - one)), sympy.simplify(second - c * (one - two))) == (0, 0)
    # integral of c exp(-c v) (1 - a v) = 1 - a / c, and of c^2 v exp(-c v) (1 - a v) = 1 - 2 a / c.
    numbers = {a: 2.0, c: 0.3}
    assert [evaluate(h, numbers) for h in model.history[1:]] == pytest.approx([1 - 2 / 0.3, 1 - 4 / 0.3], rel=1e-12)


def test_a_shifted_kernel_with_two_rates():
    model = model_of("-integral((exp(-s) - a*exp(-2*s))*x(t - s)**2, s, T, inf)")
    f, *_ = model.modes["m"]
    T_, a = (sympy.Symbol(name, real=True) for name in ("T", "a"))
    one, two = model.state_symbols[1:]
    assert sympy.simplify(f + sympy.exp(-T_) * one - a * sympy.exp(-2 * T_) / 2 * two) == 0


def test_a_delay_that_a_condition_defines():
    """The threshold: tau' = 1 - g(x) / g(x(t - tau)) where the condition holds, and its value at the start."""
    model = model_of(
        "-x(t - tau)",
        parameters={"q": 0.3},
        more={"delays": {"tau": {"where": "integral(1 + q*x(t - s), s, 0, tau) = 1"}}, "initial": {"x": 0.1}},
    )
    assert model.states == ("x", "tau")
    tau, q = model.state_symbols[1], sympy.Symbol("q", real=True)
    held = model.modes["m"][1].xreplace({model.integral_symbols[0]: sympy.S.One})
    late = model.delayed_symbols[0]
    assert sympy.simplify(held - (1 - (1 + q * X) / (1 + q * late))) == 0
    assert evaluate(model.history[1], {q: 0.3}) == pytest.approx(1 / 1.03, rel=1e-14)
    assert evaluate(model.history[1], {q: 2.0}) == pytest.approx(1 / 1.2, rel=1e-14)
    assert tau in model.varying[0].free_symbols


def test_effects_make_delays_constant_and_leave_reads_out():
    effects = {"lag": {"set": {"c": 0}}, "all": {"set": {"T": 0}}}
    model = model_of("x(t - 1 - c*x) + x(t - T)", more={"effects": effects})
    simple = leave_out_effects(model, ["lag"])
    assert (simple.varying, {str(d) for d in simple.delays}) == ((), {"T", "1"})
    assert all(read.derivative == 0 for read in simple.delayed)
    assert [str(d) for d in leave_out_effects(model, ["all"]).delays] == []


@pytest.mark.parametrize(
    ("law", "words"),
    [
        ("x(t - max(x, 1))", "not smooth, and a delay has to be"),
        ("x(t - 1 + 20*x)", "is -1 at the start"),
        ("1.2*x'(t - 1)", "add up to 1.2"),
        ("x'(t - 0)", "at the present time"),
        ("integral(x(t - s), s, 0)", "is written integral("),
        ("integral(x(t - s), s, 0, inf)", "needs a kernel that decays"),
        ("integral(x(t - s), s, 2, 1)", "ends before it begins"),
        ("integral(x*x(t - s), s, 0, 1)", "is a factor outside the integral"),
        ("integral(x(t - 1), s, 0, 1)", "states are read as x(t - s)"),
        ("integral(x(t - x), x, 0, 1)", "choose another name"),
        ("x(t - integral(x(t - s), s, 0, 1))", "a delay cannot hold an integral"),
        ("x(t - 0.1*t)", "no 'forcing'"),
    ],
)
def test_what_is_refused(law, words):
    assert words in error_of(law, more={"initial": {"x": 0.1}})


def test_a_condition_that_a_reset_would_break():
    more = {
        "delays": {"tau": {"where": "tau = 1 + x"}},
        "events": {"e": "x - 1"},
        "resets": {"r": {"x": "0"}},
        "segments": {"s": {"mode": "m", "event": "e", "direction": "rising", "reset": "r", "to": "m"}},
    }
    assert "a reset moves x" in error_of("1 - x(t - tau)", more=more)
    more["delays"] = {"tau": {"where": "tau + 1"}}
    assert "defined by an equation" in error_of("1 - x(t - tau)", more=more)
