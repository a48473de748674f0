"""Chattering and Zeno."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pddecont.delay import Direct
from pddecont.errors import ConvergenceError, PddecontError
from pddecont.simulate import Method, simulate
from tests.conftest import numeric_from
from tests.runs import change, run, to_yaml

FLOOR = """
name: floor
states: [y, v]
parameters: {g: 9.81, r: 0.8}
modes: {flight: {y': v, v': -g}, rest: {y': 0, v': 0}}
events: {landing: y}
resets: {bounce: {v: -r*v}}
segments: {hop: {mode: flight, event: landing, direction: falling, reset: bounce, to: flight}}
initial: {y: 1, v: 0}
"""
ACCUMULATION = 4.0637127689
TABLE = {
    "name": "table",
    "states": ["y", "v"],
    "parameters": {"G": 1.3, "r": 0.25},
    "forcing": {"period": "2*pi"},
    "modes": {"flight": {"y'": "v", "v'": "G*sin(t) - 1"}, "rest": {"y'": 0, "v'": 0}},
    "events": {"landing": "y", "lift": "G*sin(t) - 1"},
    "resets": {"bounce": {"v": "-r*v"}, "stop": {"y": 0, "v": 0}},
    "segments": {
        "hop": {"mode": "flight", "event": "landing", "direction": "falling", "reset": "bounce", "to": "flight"},
        "lift": {"mode": "rest", "event": "lift", "direction": "rising", "reset": "stop", "to": "flight"},
    },
    "initial": {"y": 0.01, "v": 0.1},
}


@pytest.mark.parametrize("r", [0.3, 0.8, 0.95, 0.99])
def test_the_time_at_which_impacts_accumulate(r, record):
    numeric = numeric_from(FLOOR.replace("r: 0.8", f"r: {r}"))
    exact = math.sqrt(2 / 9.81) * (1 + r) / (1 - r)
    if r == 0.8:
        assert exact == pytest.approx(ACCUMULATION, abs=1e-10)
    with pytest.raises(ConvergenceError, match=r"accumulate at t = ") as failure:
        simulate(numeric, numeric.parameter_values, Direct(), 2 * exact)
    told = float(str(failure.value).split("t = ")[1].split()[0])
    record(
        f"ball on a floor, restitution {r}: the time that the refusal names",
        "closed form",
        abs(told - exact) / exact,
        1e-9,
    )


def test_what_sticks_stays(record):
    numeric = numeric_from(FLOOR)
    end = simulate(numeric, numeric.parameter_values, Direct(), 6.0, Method(stick={"landing": "rest"}))
    record("ball on a floor that sticks", "rest after 4.0637", np.max(np.abs(end(6.0))), 1e-9)


def test_chatter_to_rest_and_lift_off(record):
    """The ball chatters to rest on the table each turn and leaves it where the table's acceleration is the weight's, G
    sin t = 1.
    """
    numeric = numeric_from(to_yaml(TABLE))
    path = simulate(
        numeric, numeric.parameter_values, Direct(), 20 * math.pi, Method(1e-11, 1e-13, stick={"landing": "rest"})
    )
    lifts = path.events.t[np.array(path.events.segment) == "lift"]
    assert len(lifts) >= 8
    release = math.asin(1 / 1.3)
    record(
        "lift-off after chattering, each turn",
        "G sin t = 1",
        np.max(np.abs((lifts - release + 1) % (2 * math.pi) - 1)),
        1e-10,
    )

    # From there the flight is explicit: y = G (sin t0 - sin t + (t - t0) cos t0) - (t - t0)^2 / 2.
    def height(t):
        s = t - release
        return 1.3 * (math.sin(release) - math.sin(t) + s * math.cos(release)) - s**2 / 2

    landing = brentq(height, release + 0.5, release + 6)
    hops = path.events.t[np.array(path.events.segment) == "hop"]
    first = np.array([hops[hops > t][0] - t for t in lifts[:-1]])
    record("first landing after each lift-off", "explicit flight", np.max(np.abs(first - (landing - release))), 1e-9)


def test_an_orbit_that_chatters_needs_a_mode_of_rest(tmp_path, record):
    """Without one the transient says by name and time where impacts accumulate; with one the orbit rests there."""
    steps = [{"name": "t", "simulate": {"t_end": "20*pi"}}, {"name": "o", "orbit": {"from": "t"}}]
    model = {**TABLE, "run": {"steps": steps}}
    with pytest.raises(
        PddecontError, match=r"events of 'landing' accumulate at t = [\d.]+ \(Zeno\).*stick: \{landing: MODE\}"
    ):
        run(model, tmp_path / "a.h5")
    step = run(change(model, "run.steps.0.simulate.stick", {"landing": "rest"}), tmp_path / "b.h5").step("o")
    names = step.orbit(0)["signature"].tobytes().decode().split()
    assert names.count("hop>rest") == names.count("lift") == 1
    # The first landing after the lift, as above.
    start = names.index("lift") + 1
    longest = step.orbit(0)["unknowns"][start % len(names)]
    release = math.asin(1 / 1.3)

    def height(s):
        return 1.3 * (math.sin(release) - math.sin(release + s) + s * math.cos(release)) - s**2 / 2

    record(
        "orbit that chatters to rest: first flight", "explicit flight", abs(longest - brentq(height, 0.5, 6.0)), 1e-10
    )
