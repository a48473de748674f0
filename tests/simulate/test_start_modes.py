"""Modes of many starts at once are those of each alone."""

import numpy as np
import pytest

from pddecont.model import TIME, find_start_mode
from pddecont.simulate.start_modes import read_start_modes
from tests.conftest import numeric_from
from tests.model.equations_models import STICK, TWO
from tests.runs import change

DELAYED = change(
    {**STICK, "parameters": {**STICK["parameters"], "tau": 0.5}},
    "equations.v'",
    "F*cos(om*t) - x - mu*sign(v) - max(0, x(t - tau))",
)
NESTED = change(STICK, "equations.v'", "F*cos(om*t) - x - mu*sign(v) - max(0, abs(x) - 0.4)")
RELAY = change(STICK, "equations.v'", "F*cos(om*t) - x - 0.1*v - hysteresis(x, -0.2, 0.6)")


@pytest.mark.parametrize(
    "model", [STICK, TWO, DELAYED, NESTED, RELAY], ids=["stick", "two", "delayed", "nested", "relay"]
)
@pytest.mark.parametrize("t", [0.0, 2.3])
def test_each_is_what_it_is_alone(model, t):
    """Some lie on surfaces, some beside them by less than rounding of the largest."""
    numeric, draw = numeric_from(model), np.random.default_rng(4)
    n = 60
    states = draw.uniform(-1.5, 1.5, (n, len(numeric.model.states)))
    states[::7, 1] = 0.0
    states[3::7, 1] = 1e-12
    states[5::7, 1] = -1e-12
    delayed = draw.uniform(-1.5, 1.5, (n, len(numeric.model.delayed)))
    found = read_start_modes(numeric, numeric.parameter_values, t, states, delayed)
    symbols = (*numeric.model.state_symbols, *numeric.model.delayed_symbols)
    known = {TIME: t} | dict(zip(numeric.model.parameter_symbols, numeric.parameter_values.tolist(), strict=True))
    expected = [
        find_start_mode(numeric.model.derived, known | dict(zip(symbols, [*x, *xd], strict=True)))
        for x, xd in zip(states.tolist(), delayed.tolist(), strict=True)
    ]
    assert found == expected
    assert len(set(found)) >= 2


def test_a_model_by_hand_starts_in_its_own_mode():
    numeric = numeric_from({"name": "m", "states": ["x"], "modes": {"p": {"x'": 1}}, "initial": {"mode": "p"}})
    assert read_start_modes(numeric, numeric.parameter_values, 0.0, np.zeros((3, 1)), np.zeros((3, 0))) == ["p"] * 3


@pytest.mark.parametrize("n", [1, 5])
def test_one_that_nothing_decides_has_none_and_others_have_theirs(n):
    numeric = numeric_from(
        {"name": "m", "states": ["x"], "equations": {"x'": "sign(x) - 0.1*x"}, "initial": {"x": 0.5}}
    )
    states = np.linspace(0.0, 1.0, n)[:, None]
    found = read_start_modes(numeric, numeric.parameter_values, 0.0, states, np.zeros((n, 0)))
    assert found == [None, *["x_above"] * (n - 1)]
