"""Cycles of about a known period in trajectories of a clock."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.errors import SignatureError
from pddecont.simulate import find_nearby_cycle, simulate
from tests.conftest import numeric_from
from tests.runs import to_yaml

CLOCK = {
    "name": "clock",
    "states": ["x"],
    "parameters": {"rate": 1.0},
    "modes": {"m": {"x'": "rate"}},
    "events": {"half": "x - 0.5", "full": "x - 1"},
    "resets": {"back": {"x": "x - 1"}},
    "segments": {
        "h": {"mode": "m", "event": "half", "direction": "rising", "to": "m"},
        "f": {"mode": "m", "event": "full", "direction": "rising", "reset": "back", "to": "m"},
    },
}


def trajectory(t_end):
    numeric = numeric_from(to_yaml(CLOCK))
    return simulate(numeric, numeric.parameter_values, Direct(), t_end)


@pytest.mark.parametrize(("period", "names"), [(1.0, ("h", "f")), (0.9, ("h", "f")), (2.1, ("h", "f", "h", "f"))])
def test_the_cycle_is_the_one_whose_length_is_nearest(period, names):
    """A clock that ticks at each half and each whole: a period of 0.9 is nearly one of its turns."""
    cycle = find_nearby_cycle(trajectory(5.25), period, 1)
    assert cycle.signature == names
    assert np.diff(cycle.times) == pytest.approx([0.5] * len(names))
    assert cycle.times[-1] == pytest.approx(5.0)


def test_a_cycle_without_events_is_the_last_period():
    cycle = find_nearby_cycle(trajectory(0.45), 0.3, 3)
    assert cycle.signature == ()
    assert list(cycle.times) == pytest.approx([0.15, 0.45])
    assert cycle.n_periods == 3


def test_an_event_that_does_not_come_again_in_time():
    with pytest.raises(SignatureError, match="does not come back"):
        find_nearby_cycle(trajectory(5.25), 0.7, 1)
