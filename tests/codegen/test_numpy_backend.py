"""Every derivative of every shipped model against differences of the values."""

import numpy as np
import pytest

from pddecont.codegen import ArrayFunction, NumericModel
from pddecont.codegen.numpy_backend import compile_source
from pddecont.model import load_model
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
    n, n_delayed, n_points = numeric.n_states, len(numeric.model.read_symbols), 5
    p = numeric.parameter_values * rng.uniform(0.9, 1.1, len(numeric.parameter_values))
    args = (
        rng.normal(size=n_points),
        rng.uniform(0.5, 1.5, (n, n_points)),
        rng.uniform(0.5, 1.5, (n_delayed, n_points)),
        p,
    )
    free = tuple(range(len(p)))
    for name, whole in functions(numeric):
        # What delays and limits that vary depend on is differentiated elsewhere: here what is read stands still.
        f = ArrayFunction(whole.exprs, whole.states, whole.delayed, whole.parameters)
        d, dx, dxd, dp, dt = all_derivatives(f, args, free)
        checks = [("dx", dx, 1, n), ("dxd", dxd, 2, n_delayed), ("dp", dp, 3, len(p))]
        for what, values, which, count in checks:
            for k in range(count):
                expected = complex_step(f, args, which, k)
                assert np.allclose(values[:, k], expected, rtol=1e-12, atol=1e-12), (name, what, k)
        expected = complex_step(f, args, 0, slice(None))
        assert np.allclose(dt, expected, rtol=1e-12, atol=1e-12), (name, "dt")
        # Common parts are taken out differently: the rounding of a sine's argument, up to 20 here, is seen.
        assert np.allclose(d.value, f.value(*args), rtol=1e-14, atol=1e-14)
        for c in range(n_points):
            out = [0.0] * f.n_out
            f.scalar(args[0][c], args[1][:, c].tolist(), args[2][:, c].tolist(), p.tolist(), out)
            assert np.allclose(out, d.value[:, c], rtol=1e-14, atol=1e-14)


def test_a_structure_names_the_derivatives_that_are_not_zero():
    numeric = numeric_from(
        "name: m\nstates: [x, y]\nparameters: {a: 2, b: 3, p: 1}\nforcing: {period: p}\n"
        "modes: {m: {x': a*y + sin(2*pi*t/p), y': x(t - b)**2 - x}}\n"
    )
    f = numeric.mode("m")
    where = f.structure((0, 1))
    assert [a.tolist() for a in where.dx] == [[0, 1], [1, 0]]
    assert [a.tolist() for a in where.dxd] == [[1], [0]]
    assert [a.tolist() for a in where.dp] == [[0], [0]]
    assert where.dt.tolist() == [0]
    assert where.moved.tolist() == [0, 1]
    assert where.moving.tolist() == [0]
    assert f.uses_delayed
    assert f.structure((0, 1)) is where


def test_which_expressions_are_linear_in_the_states():
    numeric = numeric_from(
        "name: m\nstates: [x, y, z]\nparameters: {a: 2}\nmodes: {m: {x': a**2*x + y, y': x*y, z': x(t - 1)}}\n"
    )
    assert numeric.mode("m").linear == (True, False, False)


def test_a_source_reaches_nothing_but_its_names():
    function = compile_source("def generated(out):\n    out[0] = f(2)", {"f": lambda v: 3 * v})
    out = [0]
    function(out)
    assert out == [6]
    for text in ("open('/etc/passwd')", "__import__('os')", "print()"):
        with pytest.raises(NameError):
            compile_source(f"def generated(out):\n    {text}", {})(out)


def test_what_has_no_value_is_not_finite_and_warns_nobody():
    numeric = numeric_from("name: m\nstates: [x]\nmodes: {m: {x': log(x) + 1/x}}\n")
    values = numeric.mode("m").value(np.zeros(3), np.array([[0.0, -1.0, 1.0]]), np.zeros((0, 3)), np.zeros(0))
    assert np.isfinite(values[0]).tolist() == [False, False, True]


def test_eulers_number_is_a_number():
    numeric = numeric_from("name: m\nstates: [x]\nmodes: {m: {x': exp(1)*x}}\n")
    assert numeric.mode("m").value(np.zeros(1), np.ones((1, 1)), np.zeros((0, 1)), np.zeros(0))[0, 0] == np.e
    out = [0.0]
    numeric.mode("m").scalar(0.0, [1.0], [], [], out)
    assert out == [np.e]
