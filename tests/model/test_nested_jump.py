"""A jump past the corner of a function inside another: both are read anew."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import simulate
from tests.conftest import numeric_from


@pytest.mark.parametrize(
    ("law", "after"),
    [
        # At 0.8 the inner function is at its upper end, and what stands round it says nothing of v; at -0.5 it does.
        ("abs(clip(v, -0.6, 0.6) + 0.1)", lambda v: abs(np.clip(v, -0.6, 0.6) + 0.1)),
        ("sign(max(v, 0.2) - 0.3)", lambda v: np.sign(max(v, 0.2) - 0.3)),
        ("sign(sign(sign(v) - 0.5) + 0.5)", lambda v: np.sign(np.sign(np.sign(v) - 0.5) + 0.5)),
    ],
)
def test_a_function_within_another_is_read_anew_after_a_jump(law, after):
    """v' = law stays what it is at v = -0.5 for the time of the run, or v moves by the integral of it."""
    mapping = {
        "name": "nested",
        "states": ["x", "v", "y"],
        "parameters": {},
        "equations": {"x'": "1", "v'": "0", "y'": law},
        "jumps": {"turn": {"at": "x - 0.25", "direction": "rising", "reset": {"v": "v - 1.3"}}},
        "initial": {"x": 0, "v": 0.8, "y": 0},
    }
    numeric = numeric_from(mapping)
    motion = simulate(numeric, numeric.parameter_values, Direct(), 1.0)
    assert motion([1.0])[0, 2] == pytest.approx(0.25 * after(0.8) + 0.75 * after(-0.5), abs=1e-12)


def test_a_jump_of_one_function_reads_those_anew_that_hang_on_it():
    """As v passes 0 the sign in the middle jumps past 0.5, and with it the outer one."""
    mapping = {
        "name": "nested",
        "states": ["v", "y"],
        "parameters": {},
        "equations": {"v'": "1", "y'": "sign(sign(2*sign(v) + 1) + 0.5*v)"},
        "initial": {"v": -0.5, "y": 0},
    }
    numeric = numeric_from(mapping)
    motion = simulate(numeric, numeric.parameter_values, Direct(), 1.0)
    assert motion([1.0])[0, 1] == pytest.approx(-0.5 + 0.5, abs=1e-12)
