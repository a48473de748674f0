"""Parallel surfaces: digits that exclude each other make no mode, and all that can be are there."""

import random

import numpy as np
import pytest

from pddecont.model import find_start_mode
from tests.conftest import model_from
from tests.model.equations_models import numbers_at
from tests.runs import to_yaml
from tests.simulate.motions import TIGHT, trajectory_of


def model(law, **more):
    given = {"name": "m", "states": ["x", "v"], "equations": {"x'": "v", "v'": law}, "initial": {"x": 9}}
    return model_from({**given, **more})


@pytest.mark.parametrize(
    ("law", "n_modes"),
    [
        ("-x + max(x - 1, 0) - min(x, 0)", 3),
        ("-x + clip(x, -1, 1) + deadzone(x, 0.5) + max(3 - 2*x, 0)", 6),
        ("-x - max(x + v, 0) - max(1 - 2*x - 2*v, 0)", 3),
        # What is not parallel goes with all.
        ("-x + clip(x, -1, 1) + abs(v)", 6),
        ("-x + where(x > 1 and v > 0, v, 0) + abs(x)", 6),
    ],
)
def test_the_modes_are_those_that_states_have(law, n_modes):
    m, draw = model(law), random.Random(3)
    reached = {
        find_start_mode(m.derived, numbers_at(m, x=draw.uniform(-3, 3), v=draw.uniform(-3, 3))) for _ in range(400)
    }
    assert set(m.modes) == reached
    assert len(reached) == n_modes
    assert all(segment.to in reached for segment in m.segments.values())


def test_surfaces_that_hold_a_motion_are_on_a_side_of_the_others():
    m = model("-x - 0.5*sign(v) - 0.3*sign(v - 0.3)")
    assert set(m.modes) == {
        "v_below_v2_below",
        "v_above_v2_below",
        "v_above_v2_above",
        "v_above_v2_on",
        "v_on_v2_below",
    }


@pytest.mark.parametrize(
    ("law", "n_modes"),
    [
        # The sign of a may change; a relay remembers; a delayed value may pass both surfaces at once.
        ("-x - deadzone(x, a)", 4),
        ("-x - hysteresis(x, -1, 1) - max(x - 2, 0)", 4),
        ("-x - max(x(t - 1), 0) - max(x(t - 1) - 1, 0)", 4),
    ],
)
def test_where_that_is_not_sure_all_digits_may_be(law, n_modes):
    assert len(model(law, parameters={"a": 1}).modes) == n_modes


def test_a_jump_over_several_surfaces_leads_where_it_comes_to():
    """From 0 with rate 1 to 1, with 2 to 1.5, back to -2.5, with 3 to -2, with 2 to -1, and again with 1."""
    equations = {"x'": "1 + heaviside(x - 1) + heaviside(-1 - x) + heaviside(-2 - x)"}
    given = {"name": "m", "states": ["x"], "equations": equations, "initial": {"x": 0}}
    jumps = {"back": {"at": "x - 1.5", "direction": "rising", "reset": {"x": -2.5}}}
    t = trajectory_of(to_yaml({**given, "jumps": jumps}), 4.0, TIGHT)
    assert t.events.t == pytest.approx(np.cumsum([1, 0.25, 0.5 / 3, 0.5, 2]), abs=1e-11)
