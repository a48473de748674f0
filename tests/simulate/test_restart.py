"""Integrations that begin in the middle of a motion whose past is given as polynomials."""

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.simulate import Method, Past, Simulator, follow_motion, make_extension_basis, record_trajectory, simulate
from pddecont.simulate.restart import restart_motion
from tests.conftest import numeric_from
from tests.runs import to_yaml

# x' = -x(t - 1) with an event that reads the delayed value, and a kick some time after each.
MODEL = {
    "name": "delayed",
    "states": ["x"],
    "parameters": {"tau": 1.0, "late": 0.3},
    "modes": {"m": {"x'": "-1.4*x(t - tau)"}},
    "events": {"up": "x(t - tau) - 0.2", "kick": {"after": "up", "delay": "late"}},
    "resets": {"push": {"x": "x + 0.1"}},
    "segments": {
        "a": {"mode": "m", "event": "up", "direction": "rising", "to": "m"},
        "b": {"mode": "m", "event": "kick", "reset": "push", "to": "m"},
    },
    "initial": {"x": 0.7},
}
METHOD = Method(1e-11, 1e-13)


def whole(t_end):
    numeric = numeric_from(to_yaml(MODEL))
    return numeric, simulate(numeric, numeric.parameter_values, Direct(), t_end, METHOD)


def as_past(trajectory, t):
    """Return what a trajectory did up to a time."""
    t0 = trajectory.time
    return Past(t0, trajectory.length, trajectory.end, trajectory.arc, trajectory.value, trajectory.coefficients).until(
        t
    )


@pytest.mark.parametrize("t", [7.3, 12.05, 15.5])
def test_a_motion_begun_anew_goes_on_as_it_did(t):
    """From the past of a trajectory alone, with the kicks under way, the rest of it comes out again."""
    numeric, full = whole(25.0)
    simulator = Simulator(numeric, Direct(), METHOD)
    values = simulator.values(numeric.parameter_values)
    ups = full.events.t[[name == "a" for name in full.events.segment]]
    pending = [(up + 0.3, "kick") for up in ups if up < t < up + 0.3]
    state = restart_motion(simulator, values, as_past(full, t), t, full(t), "m", pending)
    again = record_trajectory(simulator, values.p, state, 25.0)
    times = np.linspace(t + 1e-6, 25.0, 97)
    assert np.max(np.abs(again(times) - full(times))) < 1e-8
    later = full.events.t > t
    assert again.events.segment == tuple(np.array(full.events.segment)[later])
    assert again.events.t == pytest.approx(full.events.t[later], abs=1e-9)


def test_what_a_motion_did_up_to_a_time():
    numeric, full = whole(20.0)
    simulator = Simulator(numeric, Direct(), METHOD)
    values = simulator.values(numeric.parameter_values)
    t = float(full.events.t[2]) + 1e-3
    arguments = simulator, values, as_past(full, t), t, full(t), "m", []
    record = follow_motion(simulator, values, restart_motion(*arguments), t + 0.2, 1000)
    assert record.failure is None
    assert record.states == pytest.approx(full(t + 0.2), abs=1e-8)
    assert follow_motion(simulator, values, restart_motion(*arguments), 20.0, 3) is None


def test_the_basis_of_extensions_is_that_of_trajectories():
    _, full = whole(3.0)
    s = np.array([0.0, 0.2, 0.7, 1.0])
    basis = make_extension_basis(s)
    found = basis[:, :1] * full.value[4] + basis[:, 1:] @ full.coefficients[4]
    ends = np.minimum(full.time[4] + s * full.length[4], full.end[4])
    inside = ends < full.end[4]
    assert found[inside] == pytest.approx(full(ends[inside]), abs=1e-13)
