"""Delays commensurate with segment durations."""

import math

import numpy as np
import pytest
from scipy.optimize import root

from tests.hard.linear import Oscillator
from tests.problems import relay
from tests.runs import add_step, labels, parameter, run

BOUNCE = {
    "name": "bounce",
    "states": ["x", "v"],
    "parameters": {"K": 0.15, "tau": 1, "r": 0.8},
    "forcing": {"period": "pi"},
    "modes": {"free": {"x'": "v", "v'": "cos(2*t) - 0.1*v - x + K*x(t - tau)"}},
    "events": {"hit": "x - 0.2"},
    "resets": {"bounce": {"v": "-r*v"}},
    "segments": {"flight": {"mode": "free", "event": "hit", "direction": "rising", "reset": "bounce", "to": "free"}},
    "run": {
        "mesh": {"degree": 9, "tol": 1e-11},
        "monitors": {"v_in": "at(flight, v)"},
        "steps": [
            {"name": "t", "set": {"tau": 0.3, "K": 0}, "simulate": {"t_end": "100*pi"}},
            {"name": "o", "set": {"tau": 0.3, "K": 0}, "orbit": {"from": "t"}},
            {"name": "k", "set": {"tau": 0.3, "K": 0.15}, "orbit": {"from": "o"}},
        ],
    },
}


def bounced(stiffness, v_in):
    """Return the speed at impact of the orbit with period pi of x'' + .1 x' + stiffness x = cos 2t, hard wall at .2."""
    flight = Oscillator(0.1, stiffness, w=2.0)

    def miss(unknowns):
        speed, start = unknowns
        return flight.flow(start, [0.2, -0.8 * speed], math.pi) - [0.2, speed]

    begin = min(np.linspace(0, math.pi, 200), key=lambda s: np.linalg.norm(miss([v_in, s])))
    return root(miss, [v_in, begin], tol=1e-14).x[0]


@pytest.mark.parametrize("turns", [1, 2, 7])
def test_a_jump_that_comes_back_exactly_at_the_next_impact(tmp_path, turns, record):
    """After whole periods x(t - tau) = x(t): feedback is a softer spring, and breaking points all fall on an event."""
    model = add_step(BOUNCE, {"name": "exact", "set": {"tau": f"{turns}*pi"}, "orbit": {"from": "k"}})
    speed = run(model, tmp_path / "a.h5").step("exact").points["monitors"][0, 0]
    record(
        f"hard bounce, delay of {turns} periods",
        "exact pieces, softer spring",
        abs(speed - bounced(0.85, speed)),
        1e-10,
    )


def test_a_branch_through_the_collision(tmp_path, record):
    """From below a whole period to above it: breaking points pass through the event, and the branch does not notice."""
    branch = {
        "from": "k",
        "free": ["tau"],
        "range": {"tau": [3.0, 3.3]},
        "step": {"max": 0.05},
        "events_along": {"whole": "tau - pi"},
    }
    model = add_step(BOUNCE, {"name": "c", "set": {"tau": 3.0}, "continue": branch})
    step = run(model, tmp_path / "a.h5").step("c")
    assert labels(step) == ["UF1"]
    assert parameter(step, "tau")[[0, -1]] == pytest.approx([3.0, 3.3])
    speed = step.points["monitors"][step.row("UF1"), 0]
    record(
        "branch in the delay through a whole period",
        "exact pieces, softer spring",
        abs(speed - bounced(0.85, speed)),
        1e-9,
    )


@pytest.mark.parametrize(("degree", "intervals"), [(3, 4), (7, 9)])
def test_every_breaking_point_on_an_event(tmp_path, degree, intervals, record):
    """The relay without growth: both segments last two delays, and echoes of each event are all of them events or
    midpoints.
    """
    mapping = {
        "model": "relay",
        "set": {"a": 0, "tau": 0.7},
        "mesh": {"degree": degree, "intervals": intervals},
        "monitors": {"amp": "amplitude(x)"},
        "steps": [
            {"name": "t", "simulate": {"t_end": 40}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "c", "continue": {"from": "o", "free": ["a"], "range": {"a": [-0.4, 0.4]}}},
        ],
    }
    results = run(mapping, tmp_path / "a.h5")
    step = results.step("o")
    record(
        f"relay, segments of two delays, degree: {degree}, intervals: {intervals}",
        "period 4 tau, amplitude tau",
        max(abs(step.points["period"][0] - 2.8), abs(step.points["monitors"][0, 0] - 0.7)),
        1e-12,
    )
    branch = results.step("c")
    if degree == 7:
        exact = np.array([relay(a or 1e-300, 0.7) if a else (2.8, 0.7) for a in parameter(branch, "a")])
        found = np.stack([branch.points["period"], branch.points["monitors"][:, 0]], axis=1)[branch.order]
        record(
            "relay, from growth -0.4 to 0.4",
            "closed form",
            np.max(np.abs(found - exact)[np.abs(parameter(branch, "a")) > 1e-3]),
            1e-10,
        )


def test_segments_of_equal_length(tmp_path, record):
    """On-off control with equal segments, T_1 = T_2: the echoes of the one switch and those of the other lie half a
    period apart.
    """
    tau = 0.9
    low, high = math.exp(-tau), 2 - math.exp(-tau)
    period = 2 * (tau + math.log(high))
    mapping = {
        "model": "on_off_control",
        "set": {"U": 2, "L": 0, "theta": 1, "tau": 0.9},
        "mesh": {"degree": 9, "tol": 1e-11},
        "monitors": {"high": "max(x)", "low": "min(x)"},
        "steps": [{"name": "t", "simulate": {"t_end": 60}}, {"name": "o", "orbit": {"from": "t"}}],
    }
    step = run(mapping, tmp_path / "a.h5").step("o")
    found = np.array([step.points["period"][0], *step.points["monitors"][0]])
    record("on-off control with equal segments", "closed form", np.max(np.abs(found - [period, high, low])), 1e-11)
