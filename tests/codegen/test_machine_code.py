"""A model's machine code is its expressions, and what is compiled once is kept."""

import ctypes
import gc
import threading

import numpy as np
import pytest
import sympy

from pddecont.codegen import ModelFunctions, NumericModel, machine_code
from pddecont.codegen.machine_code import load_machine_code, number_outputs, write_machine_source
from pddecont.delay import Direct
from pddecont.model import list_rates, load_model
from pddecont.simulate import Method, Simulator
from tests.conftest import MODELS, all_derivatives, numeric_from

POINTER = ctypes.POINTER(ctypes.c_double)


FUNCTION = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_double, *[POINTER] * 4)


def called(address, which, t, x, xd, p, n_out):
    arrays = [np.array(a, dtype=float) for a in (x, xd, p)] + [np.zeros(max(n_out, 1))]
    FUNCTION(int(address))(int(which), t, *(a.ctypes.data_as(POINTER) for a in arrays))
    return arrays[-1][:n_out]


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_every_models_functions_and_derivatives(path):
    """Against the functions over arrays that continuation uses, whose derivatives are checked against differences."""
    numeric = NumericModel(load_model(str(path))[0])
    # Tangents of models that read rates are not computed; the stiff method asks for the same derivatives.
    tangent = not list_rates(numeric.model)
    simulator = Simulator(numeric, Direct(), Method(stiff=not tangent), tangent=tangent)
    model, tables, system = numeric.model, simulator.tables, simulator.system
    rng = np.random.default_rng(0)
    n, m = numeric.n_states, len(model.read_symbols)
    x, xd, t, p = rng.uniform(0.2, 0.9, n), rng.uniform(0.2, 0.9, m), 0.37, numeric.parameter_values
    arguments = np.array([t]), x[:, None], xd[:, None], p
    events = [None if model.events[e].function is None else numeric.event(e) for e in tables.events]
    cases = [
        ("field", [numeric.mode(name) for name in tables.modes], False),
        ("reset", [numeric.reset(name) for name in tables.resets], True),
        ("event", events, True),
    ]
    for kind, known, with_time in cases:
        values, slopes, numbers = (getattr(system, name) for name in (kind, f"{kind}_jacobian", f"{kind}_case"))
        # What lags that vary are made of comes after the model's own.
        for function, value, jacobian, which in zip(known, values, slopes, numbers, strict=False):
            if function is None:
                continue
            d, dx, dxd, _, dt = all_derivatives(function, arguments)
            k = function.n_out
            assert called(value, which, t, x, xd, p, k) == pytest.approx(d.value[:, 0], rel=1e-14, abs=1e-15)
            if kind != "field" and not tangent:
                # The stiff method asks for derivatives of the field alone.
                continue
            parts = [dx[:, :, 0].ravel(), dxd[:, :, 0].ravel(), *([dt[:, 0]] if with_time else [])]
            expected = np.concatenate(parts)
            assert called(jacobian, which, t, x, xd, p, len(expected)) == pytest.approx(expected, rel=1e-13, abs=1e-14)


def test_the_history_and_its_derivatives():
    numeric = numeric_from(
        "name: m\nstates: [x]\nparameters: {a: 2, tau: 1}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: exp(a*t)}\n"
    )
    functions = ModelFunctions(numeric.model)
    for k in range(4):
        assert called(functions.history, k, -0.3, [0], [0], [2.0, 1.0], 1) == pytest.approx(
            2.0**k * np.exp(-0.6), rel=1e-15
        )


def test_every_function_that_models_may_use_is_compiled():
    t, x = sympy.Symbol("t", real=True), sympy.Symbol("x", real=True)
    names = ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt"]
    exprs = [getattr(sympy, name)(x) for name in names]
    exprs += [
        sympy.atan2(x, t),
        sympy.E * x,
        sympy.pi * x,
        sympy.Rational(1, 3) * x,
        x**-2,
        x ** sympy.Rational(3, 2),
        x**t,
    ]
    code = load_machine_code(write_machine_source([number_outputs(exprs)], {t: "t", x: "x[0]"}))
    expected = [float(e.subs({x: 0.6, t: 1.7})) for e in exprs]
    assert called(code.address, 0, 1.7, [0.6], [0], [0], len(exprs)) == pytest.approx(expected, rel=1e-15)


def test_what_cannot_be_evaluated_is_no_number_and_no_exception():
    x = sympy.Symbol("x", real=True)
    code = load_machine_code(write_machine_source([{0: 1 / x, 1: sympy.log(x), 2: sympy.sqrt(x - 1)}], {x: "x[0]"}))
    assert not np.any(np.isfinite(called(code.address, 0, 0.0, [0.0], [0], [0], 3)))


def test_a_case_of_zeros_writes_nothing():
    x = sympy.Symbol("x", real=True)
    text = write_machine_source([{0: sympy.Integer(0)}, {0: x, 1: sympy.Integer(0)}], {x: "x[0]"})
    assert "    if which == 0:\n        pass\n    elif which == 1:\n        out[0] = x[0]\n    return\n" in text
    code = load_machine_code(text)
    assert list(called(code.address, 0, 0.0, [5.0], [0], [0], 1)) == [0.0]
    assert list(called(code.address, 1, 0.0, [5.0], [0], [0], 2)) == [5.0, 0.0]


def test_code_is_shared_while_it_is_in_use_and_let_go_after():
    x = sympy.Symbol("x", real=True)
    text = write_machine_source([{0: x * sympy.Float(0.1234567)}], {x: "x[0]"})
    code = load_machine_code(text)
    assert load_machine_code(text) is code
    assert text in machine_code._in_use
    del code
    gc.collect()
    assert text not in machine_code._in_use


def test_a_model_lets_its_functions_go_with_it():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {a: 1}\nmodes: {m: {x': -0.987654*a*x}}\n")
    functions = numeric.compile()
    functions.fields.add(numeric.model.modes.values())
    assert functions.fields.list_addresses("value")
    kept = [text for text in machine_code._in_use if "0.987654" in text]
    assert kept
    del functions, numeric
    gc.collect()
    assert not [text for text in machine_code._in_use if "0.987654" in text]


def test_threads_get_one_code():
    x = sympy.Symbol("x", real=True)
    text = write_machine_source([{0: sympy.sin(x) * sympy.Float(0.7654321)}], {x: "x[0]"})
    found, meeting = [], threading.Barrier(4, timeout=20)

    def load():
        meeting.wait()
        found.append(load_machine_code(text))

    threads = [threading.Thread(target=load) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    assert all(code is found[0] for code in found)
