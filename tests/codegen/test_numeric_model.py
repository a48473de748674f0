"""A model's functions of numbers: made once, kept with the model, made anew where it arrives."""

import gc
import pickle
import weakref

import numpy as np
import pytest

from pddecont.codegen import NumericModel, numpy_backend
from pddecont.model import leave_out_effects
from tests.conftest import model_from, numeric_from, shipped


def test_delays_and_period_have_their_derivatives():
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {a: 2, b: 3}\nforcing: {period: a**2*b}\n"
        "modes: {m: {x': x(t - a*b) + sin(2*pi*t/(a**2*b))}}\n"
    )
    p = numeric.parameter_values
    assert numeric.delays.value(p) == pytest.approx([6])
    assert numeric.delays.derivatives(p, (0, 1)) == pytest.approx(np.array([[3, 2]]))
    assert numeric.period.derivatives(p, (1, 0)) == pytest.approx(np.array([[4, 12]]))


def test_equal_expressions_are_one_function():
    numeric = shipped("impact_oscillator")
    for name, exprs in numeric.model.modes.items():
        assert numeric.mode(name) is numeric.mode(name)
        assert numeric.function(list(exprs)) is numeric.mode(name)
    assert numeric.delays.function is numeric.delays.function


def test_a_source_is_generated_once(monkeypatch):
    written, write = [], numpy_backend.write_array_source
    monkeypatch.setattr(numpy_backend, "write_array_source", lambda *a: written.append(a) or write(*a))
    numeric = shipped("impact_oscillator")
    name, p = next(iter(numeric.model.modes)), numeric.parameter_values
    arguments = np.zeros(3), np.ones((2, 3)), np.ones((len(numeric.model.delayed), 3)), p
    for _ in range(3):
        numeric.mode(name).value(*arguments)
        numeric.mode(name).derivatives(*arguments, (1,))
        numeric.mode(name).derivatives(*arguments, (2,))
    assert len(written) == 3


def test_functions_are_let_go_with_their_model():
    numeric = shipped("impact_oscillator")
    function = weakref.ref(numeric.mode(next(iter(numeric.model.modes))))
    assert function() is not None
    del numeric
    gc.collect()
    assert function() is None


def test_a_model_travels_without_its_functions():
    numeric = shipped("impact_oscillator")
    name = next(iter(numeric.model.modes))
    arguments = np.zeros(3), np.ones((2, 3)), np.ones((len(numeric.model.delayed), 3)), numeric.parameter_values
    expected = numeric.mode(name).value(*arguments)
    assert numeric.compile().history
    arrived = pickle.loads(pickle.dumps(numeric))
    assert arrived.model == numeric.model
    assert np.array_equal(arrived.mode(name).value(*arguments), expected)


def test_machine_code_is_that_of_a_history():
    numeric = shipped("wright")
    x = numeric.model.state_symbols[0]
    assert numeric.compile() is numeric.compile()
    assert numeric.compile(history=(x * 0,)) is not numeric.compile()


def test_parameters_by_name():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {a: 2, b: 3}\nmodes: {m: {x': a*x + b}}\n")
    assert list(numeric.parameter_values) == [2.0, 3.0]
    assert numeric.parameter_index("b") == 1
    assert numeric.n_states == 1


def test_parameters_that_effects_left_out_set_are_put_in():

    numeric = NumericModel(leave_out_effects(shipped("impact_oscillator").model, ["feedback"]))
    p = numeric.parameter_values + 1.0
    fixed = numeric.with_fixed(p)
    assert list(numeric.model.fixed) == ["K"]
    assert fixed[numeric.parameter_index("K")] == 0.0
    others = [i for i in range(len(p)) if i != numeric.parameter_index("K")]
    assert np.array_equal(fixed[others], p[others])
    whole = shipped("impact_oscillator")
    assert whole.with_fixed(p) is p


def test_the_delay_of_an_event_is_a_function():
    text = (
        "name: m\nstates: [x]\nparameters: {a: 2, b: 3}\nmodes: {m: {x': 1}}\n"
        "events: {e: x - 1, l: {after: e, delay: a*b}}\n"
        "segments: {s: {mode: m, event: e, direction: rising, to: m}, r: {mode: m, event: l, to: m}}\n"
    )
    numeric = NumericModel(model_from(text))
    assert numeric.event_delay("l").value(np.array([2.0, 5.0])) == pytest.approx([10.0])
    assert numeric.event_delay("l").derivatives(np.array([2.0, 5.0]), (0, 1)) == pytest.approx(np.array([[5.0, 2.0]]))
    with pytest.raises(AssertionError, match="event e is not a delayed event"):
        numeric.event_delay("e")
    with pytest.raises(AssertionError, match="event l is a delayed event"):
        numeric.event("l")
