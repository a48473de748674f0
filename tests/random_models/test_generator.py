"""Random models: the same for a seed, readable, and the same functions in both spellings."""

import math
import re

import numpy as np
import pytest

from tests.conftest import model_from
from tests.random_models.formula import Formula, compile_formula
from tests.random_models.generator import FAMILIES, draw_model

SEEDS = range(4 * len(FAMILIES))


def test_a_seed_gives_the_same_model_again():
    for seed in SEEDS:
        assert draw_model(seed).as_mapping() == draw_model(seed).as_mapping()


@pytest.mark.parametrize("seed", SEEDS)
def test_models_are_read(seed):
    drawn = draw_model(seed)
    model = model_from(drawn.as_mapping())
    assert set(model.modes) == set(drawn.modes)
    assert set(model.segments) == set(drawn.segments)


def test_families_have_one_to_three_delays_resets_delayed_events_and_events_that_read_the_past():
    models = [draw_model(seed) for seed in range(30 * len(FAMILIES))]
    assert {len(m.delays) for m in models} == {1, 2, 3}
    functions = [f for m in models for f in m.events.values()]
    assert any(not isinstance(f, Formula) for f in functions)
    assert any(isinstance(f, Formula) and "past" in f.python for f in functions)
    assert any("past" in f.python for m in models for r in m.resets.values() for f in r.values())
    assert any(m.free in m.delays for m in models)


def evaluate(text, states, past, parameters):
    """Return the value of a model file's formula by substitution of numbers, with Python's arithmetic."""
    for state, value in past.items():
        text = re.sub(rf"\b{state[0]}\(t - {state[1]}\)", f"({value!r})", text)
    return eval(text, {"cos": math.cos, "sin": math.sin, "tanh": math.tanh, "pi": math.pi}, {**parameters, **states})


@pytest.mark.parametrize("seed", SEEDS)
def test_both_spellings_are_one_function(seed):
    model, rng = draw_model(seed), np.random.default_rng(seed)
    z, late = rng.standard_normal(len(model.states)), rng.standard_normal((len(model.delays), len(model.states)))
    states = {"t": 0.7, **dict(zip(model.states, map(float, z), strict=True))}
    past = {(s, d): float(late[i, j]) for i, d in enumerate(model.delays) for j, s in enumerate(model.states)}
    lags = {model.parameters[d]: late[i] for i, d in enumerate(model.delays)}
    formulas = [f for flow in (*model.modes.values(), *model.resets.values()) for f in flow.values()]
    for formula in [*formulas, *(f for f in model.events.values() if isinstance(f, Formula))]:
        value = compile_formula(formula, model.parameters)(0.7, z, lags.__getitem__)
        assert value == pytest.approx(evaluate(formula.yaml, states, past, model.parameters), abs=1e-13)
