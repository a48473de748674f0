"""Code of large models: its numbers against closed forms, and its length, which grows with the states."""

import ast

import numpy as np
import pytest

from models.oscillator_chain import chain
from pddecont.codegen import ModelFunctions, NumericModel, machine_code, numpy_backend
from pddecont.model import parse_document, parse_model
from tests.codegen.test_machine_code import called

N = 100
FREE = ("K", "c", "zeta")


def chain_of(n):
    return NumericModel(parse_model(parse_document(chain(n).split("\nrun:")[0] + "\n", "chain.yaml"))[0])


@pytest.fixture(scope="module")
def large():
    """A chain of 200 states, a point in it, and its parameters by name."""
    numeric = chain_of(N)
    rng = np.random.default_rng(3)
    names = dict(zip(numeric.model.parameters, numeric.parameter_values, strict=True))
    assert [d.state for d in numeric.model.delayed] == list(range(1, 2 * N, 2))
    return numeric, 0.7, rng.normal(size=2 * N), rng.normal(size=N), names


def neighbours(x):
    """Return x_(i-1) - 2 x_i + x_(i+1), with walls at both ends that do not move."""
    padded = np.concatenate([[0.0], x, [0.0]])
    return padded[:-2] - 2.0 * x + padded[2:]


def field_of(t, y, vd, p):
    """Return the field of the chain, state by state."""
    x, v = y[::2], y[1::2]
    force = p["a"] * np.cos(p["omega"] * t)
    rate = force - x - 2 * p["zeta"] * v + p["c"] * neighbours(x) + p["K"] * (vd - v)
    return np.column_stack([v, rate]).ravel()


def jacobians_of(y, vd, p):
    """Return df/dx, df/dxd and the derivatives in K, c and zeta."""
    places, speeds = np.arange(0, 2 * N, 2), np.arange(1, 2 * N, 2)
    dx, dxd, dp = np.zeros((2 * N, 2 * N)), np.zeros((2 * N, N)), np.zeros((2 * N, 3))
    dx[places, speeds] = 1.0
    dx[speeds, places] = -1.0 - 2.0 * p["c"]
    dx[speeds[1:], places[:-1]] = dx[speeds[:-1], places[1:]] = p["c"]
    dx[speeds, speeds] = -2.0 * p["zeta"] - p["K"]
    dxd[speeds, np.arange(N)] = p["K"]
    x, v = y[::2], y[1::2]
    dp[speeds] = np.column_stack([vd - v, neighbours(x), -2.0 * v])
    return dx, dxd, dp


def test_functions_over_arrays_are_the_closed_form(large):
    numeric, t, y, vd, p = large
    arguments = np.array([t]), y[:, None], vd[:, None], numeric.parameter_values
    free = tuple(map(numeric.parameter_index, FREE))
    function = numeric.mode("free")
    expected = field_of(t, y, vd, p)
    d, where = function.derivatives(*arguments, free=free), function.structure(free)
    for values in (function.value(*arguments), d.value):
        assert values[:, 0] == pytest.approx(expected, rel=1e-14, abs=1e-14)
    for name, matrix in zip(("dx", "dxd", "dp"), jacobians_of(y, vd, p), strict=True):
        found = np.zeros_like(matrix)
        found[getattr(where, name)] = getattr(d, name)[:, 0]
        assert found == pytest.approx(matrix, rel=1e-14, abs=1e-14)
        assert len(getattr(d, name)) == np.count_nonzero(matrix)


def test_machine_code_is_the_closed_form(large):
    numeric, t, y, vd, p = large
    functions, arguments = ModelFunctions(numeric.model), (t, y, vd, numeric.parameter_values)
    functions.fields.add(numeric.model.modes.values())
    value, jacobian = (functions.fields.list_addresses(kind)[0] for kind in ("value", "jacobian"))
    assert called(value, 0, *arguments, 2 * N) == pytest.approx(field_of(t, y, vd, p), rel=1e-14, abs=1e-14)
    dx, dxd, _ = jacobians_of(y, vd, p)
    found = called(jacobian, 0, *arguments, dx.size + dxd.size)
    assert found == pytest.approx(np.concatenate([dx.ravel(), dxd.ravel()]), rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("hit", [0, 41, N - 1])
def test_machine_code_of_a_reset_is_exact(large, hit):
    """One velocity is turned round, all else stays as it is: nothing is rounded but the product."""
    numeric, t, y, vd, p = large
    functions, arguments = ModelFunctions(numeric.model), (t, y, vd, numeric.parameter_values)
    functions.resets.add(numeric.model.resets.values())
    _, which = functions.resets.find_place(numeric.model.resets[f"bounce{hit + 1}"])
    value, jacobian = (functions.resets.list_addresses(kind)[0] for kind in ("value", "jacobian"))
    factors = np.ones(2 * N)
    factors[2 * hit + 1] = -p["r"]
    assert np.array_equal(called(value, which, *arguments, 2 * N), factors * y)
    found = called(jacobian, which, *arguments, 2 * N * (3 * N + 1))
    assert np.array_equal(found[: 4 * N**2].reshape(2 * N, 2 * N), np.diag(factors))
    assert not found[4 * N**2 :].any()


def count_operations(text):
    """Return the number of operations, calls and assignments in a generated source."""
    counted = ast.BinOp | ast.UnaryOp | ast.Call | ast.Assign
    return sum(isinstance(node, counted) for node in ast.walk(ast.parse(text)))


def count_in_code_of(n, monkeypatch):
    """Return the operations in the code of a chain's field, events and resets, and of their derivatives."""
    numeric, texts = chain_of(n), {}
    nothing = type("Nothing", (), {"address": 0})
    kinds = [(part, kind) for part in ("fields", "events", "resets") for kind in ("value", "jacobian")]
    functions = ModelFunctions(numeric.model)
    functions.fields.add(numeric.model.modes.values())
    functions.events.add((e.function,) for e in numeric.model.events.values())
    functions.resets.add(numeric.model.resets.values())
    with monkeypatch.context() as patch:
        for part, kind in kinds:
            patch.setattr(
                machine_code, "load_machine_code", lambda text, key=(part, kind): texts.update({key: text}) or nothing
            )
            getattr(functions, part).list_addresses(kind)
        for free in (None, (0, 1)):
            patch.setattr(
                numpy_backend,
                "compile_source",
                lambda text, _, key=free: texts.update({key: text}) or (lambda *_: None),
            )
            numeric.mode("free")._function(free)
    return {key: count_operations(text) for key, text in texts.items()}


def test_the_number_of_operations_grows_as_the_states_do(monkeypatch):
    """Each mass brings as many operations to 100 as to 50, but for signs that the order of names decides."""
    small, middle, large = (count_in_code_of(n, monkeypatch) for n in (25, 50, 100))
    assert len(small) == 8
    for key in small:
        assert large[key] - middle[key] == pytest.approx(2 * (middle[key] - small[key]), rel=0.02), key
