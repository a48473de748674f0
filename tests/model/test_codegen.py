"""Every derivative of every shipped model against differences of the values."""

import numpy as np
import pytest

from pddecont.model.builder import load_model
from pddecont.model.codegen import NumericModel, source, symbol_names
from tests.conftest import MODELS, all_derivatives, numeric_from

STEP = 1e-30


def functions(numeric):
    model = numeric.model
    yield from ((f"mode {m}", numeric.mode(m)) for m in model.modes)
    yield from ((f"event {e.name}", numeric.event(e.name)) for e in model.events.values() if e.function is not None)
    yield from ((f"reset {r}", numeric.reset(r)) for r in model.resets)


def complex_step(f, args, which, index):
    moved = [np.array(a, dtype=complex) for a in args]
    moved[which][index] += 1j * STEP
    return f.value(*moved).imag / STEP


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_derivatives_agree_with_complex_steps(path):
    numeric = NumericModel(load_model(str(path))[0])
    rng = np.random.default_rng(1)
    n, n_delayed, n_points = numeric.n_states, len(numeric.model.delayed), 5
    p = numeric.parameter_values * rng.uniform(0.9, 1.1, len(numeric.parameter_values))
    args = (rng.normal(size=n_points), rng.uniform(0.5, 1.5, (n, n_points)), rng.uniform(0.5, 1.5, (n_delayed, n_points)), p)
    free = tuple(range(len(p)))
    for name, f in functions(numeric):
        d, dx, dxd, dp, dt = all_derivatives(f, args, free)
        checks = [("dx", dx, 1, n), ("dxd", dxd, 2, n_delayed), ("dp", dp, 3, len(p))]
        for what, values, which, count in checks:
            for k in range(count):
                expected = complex_step(f, args, which, k)
                assert np.allclose(values[:, k], expected, rtol=1e-12, atol=1e-12), (name, what, k)
        expected = complex_step(f, args, 0, slice(None))
        assert np.allclose(dt, expected, rtol=1e-12, atol=1e-12), (name, "dt")
        assert np.allclose(d.value, f.value(*args), rtol=1e-15, atol=1e-15)
        for c in range(n_points):
            out = [0.0] * f.n_out
            f.scalar(args[0][c], args[1][:, c].tolist(), args[2][:, c].tolist(), p.tolist(), out)
            assert np.allclose(out, d.value[:, c], rtol=1e-14, atol=1e-14)


def test_delays_and_period_have_their_derivatives():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {a: 2, b: 3}\nforcing: {period: a**2*b}\n"
                           "modes: {m: {x': x(t - a*b) + sin(2*pi*t/(a**2*b))}}\n")  # fmt: skip
    p = numeric.parameter_values
    assert numeric.delays.value(p) == pytest.approx([6])
    assert numeric.delays.derivatives(p, (0, 1)) == pytest.approx(np.array([[3, 2]]))
    assert numeric.period.derivatives(p, (1, 0)) == pytest.approx(np.array([[4, 12]]))


def test_generated_text_never_holds_the_users_names():
    numeric = numeric_from("name: m\nstates: [exec]\nparameters: {open: 2}\nmodes: {m: {exec': -open*exec}}\n")
    model = numeric.model
    text = source({"value": model.modes["m"]}, symbol_names(model.state_symbols, (), model.parameter_symbols))
    assert "exec" not in text
    assert "open" not in text
    assert numeric.mode("m").value(np.zeros(1), np.array([[3.0]]), np.zeros((0, 1)), np.array([2.0])) == -6.0


def test_shared_parts_are_computed_once():
    numeric = numeric_from("name: m\nstates: [x, y]\nmodes: {m: {x': exp(sin(x) + y), y': 2*exp(sin(x) + y)}}\n")
    model = numeric.model
    text = source({"value": model.modes["m"]}, symbol_names(model.state_symbols, (), ()))
    assert text.count("exp(") == 1
