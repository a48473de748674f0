"""What a simulation knows of the lags of a model."""

import pytest

from pddecont.native.integrator import LEVELS
from pddecont.simulate.past_plan import make_past_plan
from tests.conftest import model_from
from tests.simulate.lagged_models import write_model


@pytest.mark.parametrize(
    "rate, gains",
    [
        ("-x(t - k)", (1,)),
        # d/dt of the integral holds x(t - k): what jumps there jumps two orders higher in x.
        ("-integral(x(t - s), s, 0, k)", (2,)),
        ("-integral(x(t - s), s, 0, k + x/4)", (2,)),
        ("-integral(x(t - s), s, 0, k) - x(t - k)/2", (1,)),
        # The limit itself holds what is read at k.
        ("-integral(x(t - s), s, 0, 2 + x(t - k))", (1, 2)),
    ],
)
def test_by_how_many_orders_jumps_are_smoothed(rate, gains):
    assert make_past_plan(model_from(write_model(["x"], [rate], ["1"]))).gains == gains


@pytest.mark.parametrize("feedback, gain", [("0", LEVELS + 1), ("x(t - 1 - x/4)", 1)])
def test_what_events_alone_read_by_a_lag_that_varies_brings_nothing_back(feedback, gain):
    model = {
        "name": "relay",
        "states": ["x"],
        "parameters": {"k": 1.0},
        "modes": {"up": {"x'": f"k - {feedback}"}, "down": {"x'": "-k"}},
        "events": {"late": "x(t - 1 - x/4)"},
        "segments": {
            "above": {"mode": "up", "event": "late", "direction": "rising", "to": "down"},
            "below": {"mode": "down", "event": "late", "direction": "falling", "to": "up"},
        },
        "initial": {"mode": "up", "x": -0.5},
    }
    assert make_past_plan(model_from(model)).gains == (gain,)
