"""A model's compiled functions are its expressions, and what is compiled once is kept."""

import ctypes
import subprocess
import sys

import numpy as np
import pytest
import sympy

from pddecont.model.builder import load_model
from pddecont.model.codegen import NumericModel
from pddecont.simulate.functions import ModelFunctions, compiled, function_text
from tests.conftest import MODELS, ROOT, all_derivatives, numeric_from

POINTER = ctypes.POINTER(ctypes.c_double)
FUNCTION = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_double, *[POINTER] * 4)


def called(address, which, t, x, xd, p, n_out):
    arrays = [np.array(a, dtype=float) for a in (x, xd, p)] + [np.zeros(max(n_out, 1))]
    FUNCTION(address)(which, t, *(a.ctypes.data_as(POINTER) for a in arrays))
    return arrays[-1][:n_out]


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_every_models_functions_and_derivatives(path):
    """Against the functions over arrays that continuation uses, whose derivatives are checked against differences."""
    numeric = NumericModel(load_model(str(path))[0])
    model, functions = numeric.model, ModelFunctions(numeric.model)
    rng = np.random.default_rng(0)
    n, m = numeric.n_states, len(model.delayed)
    x, xd, t, p = rng.uniform(0.2, 0.9, n), rng.uniform(0.2, 0.9, m), 0.37, numeric.parameter_values
    arguments = np.array([t]), x[:, None], xd[:, None], p
    cases = [(functions.field, functions.field_jacobian, [numeric.mode(name) for name in model.modes], False),
             (functions.reset, functions.reset_jacobian, [numeric.reset(name) for name in model.resets], True),
             (functions.event, functions.event_jacobian,
              [None if e.function is None else numeric.event(e.name) for e in model.events.values()], True)]  # fmt: skip
    for value, jacobian, known, with_time in cases if model.events else cases[:2]:
        for which, function in enumerate(known):
            if function is None:
                continue
            d, dx, dxd, _, dt = all_derivatives(function, arguments)
            k = function.n_out
            assert called(value, which, t, x, xd, p, k) == pytest.approx(d.value[:, 0], rel=1e-14, abs=1e-15)
            parts = [dx[:, :, 0].ravel(), dxd[:, :, 0].ravel(), *([dt[:, 0]] if with_time else [])]
            expected = np.concatenate(parts)
            assert called(jacobian, which, t, x, xd, p, len(expected)) == pytest.approx(expected, rel=1e-13, abs=1e-14)


def test_the_history_and_its_derivatives():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {a: 2, tau: 1}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: exp(a*t)}\n")
    address = ModelFunctions(numeric.model).history
    for k in range(4):
        assert called(address, k, -0.3, [0], [0], [2.0, 1.0], 1) == pytest.approx(2.0**k * np.exp(-0.6), rel=1e-15)


def test_every_function_that_models_may_use_is_compiled():
    t, x = sympy.Symbol("t", real=True), sympy.Symbol("x", real=True)
    names = ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt"]
    exprs = [getattr(sympy, name)(x) for name in names]
    exprs += [sympy.atan2(x, t), sympy.E * x, sympy.pi * x, sympy.Rational(1, 3) * x, x**-2, x ** sympy.Rational(3, 2), x**t]
    address = int(compiled(function_text([exprs], {t: "t", x: "x[0]"})).address)
    expected = [float(e.subs({x: 0.6, t: 1.7})) for e in exprs]
    assert called(address, 0, 1.7, [0.6], [0], [0], len(exprs)) == pytest.approx(expected, rel=1e-15)


def test_what_cannot_be_evaluated_is_no_number_and_no_exception():
    x = sympy.Symbol("x", real=True)
    address = int(compiled(function_text([[1 / x, sympy.log(x), sympy.sqrt(x - 1)]], {x: "x[0]"})).address)
    assert not np.any(np.isfinite(called(address, 0, 0.0, [0.0], [0], [0], 3)))


SECOND = """
import numpy as np
from pddecont.delay.direct import Direct
from pddecont.model.codegen import NumericModel
from pddecont.model.builder import load_model
from pddecont.simulate.integrate import simulate
from pddecont.simulate.kernel.advance import run
numeric = NumericModel(load_model("models/impact_oscillator.yaml")[0])
simulate(numeric, numeric.parameter_values, Direct(), 1.0)
print(sum(run.stats.cache_hits.values()), sum(run.stats.cache_misses.values()))
"""


def test_a_second_process_compiles_nothing():
    for expected in (None, ["1", "0"]):
        done = subprocess.run([sys.executable, "-c", SECOND], cwd=ROOT, capture_output=True, text=True, timeout=280, check=True)
        assert expected is None or done.stdout.split() == expected
