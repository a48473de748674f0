"""Constant motions of small models."""

from pddecont.codegen import NumericModel
from pddecont.delay import Direct
from pddecont.equilibrium import ConstantMotion
from tests.runs import plan

WRIGHT = {
    "name": "logistic",
    "states": ["x"],
    "parameters": {"r": 1.0, "tau": 1.8},
    "modes": {"m": {"x'": "r*x*(1 - x(t - tau))"}},
    "initial": {"x": 0.5},
}
TWO_DELAYS = {
    "name": "two_delays",
    "states": ["x", "y"],
    "parameters": {"a": 1.2, "one": 1.0, "other": 1.5},
    "modes": {"m": {"x'": "-a*(x(t - one) + y(t - other))*(1 + x)", "y'": "3*(x - y) + 0.5*x(t - other)*y"}},
    "initial": {"x": 0.3},
}


def make_motion(model, method=None):
    """Return the constant motion of a model's mode ``m`` and its parameters."""
    steps = [{"name": "t", "simulate": {"t_end": 1}}]
    numeric = NumericModel(plan({**model, "run": {"steps": steps}}).model)
    return ConstantMotion(numeric, "m", method or Direct()), numeric.parameter_values
