"""Models given by their equations that several files test, and their laws in modes as numbers."""

from __future__ import annotations

import math

from pddecont.model import TIME, find_start_mode
from pddecont.model.evaluation import evaluate
from tests.conftest import model_from

STICK = {
    "name": "stick",
    "states": ["x", "v"],
    "parameters": {"om": 1.0, "F": 1.5, "mu": 0.8},
    "forcing": {"period": "2*pi/om"},
    "switches": {"slip": "v"},
    "equations": {"x'": "v", "v'": "F*cos(om*t) - x - 0.1*v - mu*sign(v)"},
    "initial": {"x": 1, "v": 0.3},
}
# Two masses on a table, coupled: both may stick.
TWO = {
    "name": "two",
    "states": ["x", "v", "y", "w"],
    "parameters": {"k": 0.6, "m": 0.7, "n": 0.4, "c": 0.3},
    "switches": {"left": "v", "right": "w"},
    "equations": {
        "x'": "v",
        "v'": "-x + k*(y - x) + c*(w - v) - m*sign(v) + 0.2*n*sign(w)",
        "y'": "w",
        "w'": "-y + k*(x - y) + c*(v - w) - n*sign(w) + 0.1*m*sign(v)",
    },
    "initial": {"x": 1, "v": 0.3, "y": -1, "w": 0.2},
}


def one_law(text, **more):
    """Return the model x' = text, of states x and y and a delayed x, forced with period 2."""
    return model_from(
        {
            "name": "law",
            "states": ["x", "y"],
            "parameters": {"a": 0.5, "b": -0.25},
            "forcing": {"period": 2},
            "equations": {"x'": text, "y'": "x(t - 1) - y"},
            "initial": {"x": 0.37, "y": 0.17},
            **more,
        }
    )


def numbers_at(model, t=0.0, **values):
    """Return the symbols of a model with their values; delayed values by their names, as ``x_1``."""
    known = {TIME: t} | dict(zip(model.parameter_symbols, model.parameters.values(), strict=True))
    known |= {s: values[name] for name, s in zip(model.states, model.state_symbols, strict=True)}
    return known | dict.fromkeys(model.delayed_symbols, values.get("x_1", 0.0))


def field_at(model, numbers, mode=None):
    """Return the vector field in the mode of a point, or in a given one."""
    mode = mode or find_start_mode(model.derived, numbers)
    field = [evaluate(f, numbers) for f in model.modes[mode]]
    assert all(map(math.isfinite, field))
    return field
