"""Orbits that are one of a family are told from isolated ones."""

import pytest

from pddecont.errors import ConvergenceError
from tests.runs import run

# An event-triggered controller: y takes the measured x when x is delta away from it, so that it stays on y0 + n delta
# for every y0.
TRIGGERED = {
    "name": "trigger",
    "states": ["x", "y"],
    "parameters": {"a": 1, "k": 1.6, "delta": 0.2, "tau": 0.1},
    "modes": {"loop": {"x'": "a*x - k*y", "y'": 0}},
    "events": {
        "up": "x - y - delta",
        "down": "x - y + delta",
        "arrive_up": {"after": "up", "delay": "tau"},
        "arrive_down": {"after": "down", "delay": "tau"},
    },
    "resets": {"take": {"y": "x(t - tau)"}},
    "segments": {
        "up": {"mode": "loop", "event": "up", "direction": "rising", "to": "loop"},
        "down": {"mode": "loop", "event": "down", "direction": "falling", "to": "loop"},
        "got_up": {"mode": "loop", "event": "arrive_up", "reset": "take", "to": "loop"},
        "got_down": {"mode": "loop", "event": "arrive_down", "reset": "take", "to": "loop"},
    },
    "initial": {"x": 1, "y": 0.9},
    "run": {"steps": [{"name": "t", "simulate": {"t_end": 200}}, {"name": "o", "orbit": {"from": "t"}}]},
}


def test_an_orbit_whose_equations_leave_a_state_free_is_called_one_of_a_family(tmp_path):
    with pytest.raises(ConvergenceError, match=r"is one of a family: at these parameters .* leave .*y.* free"):
        run(TRIGGERED, tmp_path / "a.h5")
