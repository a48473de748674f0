"""Segments that end where a delay that varies reads a jump: a neuron's echo, later where a slow state is larger.

x' = I - x fires at 1 and starts again from d; read b = tau + c y(b) later the jump is below 1/2, and pushes z. In
closed form: T = ln((I - d)/(I - 1)), z is a sum of exponentials, and so is y' = -y + 1 + z/2, which b hangs on.
"""

from math import exp, log

import numpy as np
import pytest
from scipy.optimize import brentq

from pddecont.model import parse_document
from pddecont.results import read_results
from pddecont.stability import find_multipliers
from tests.orbits import settle_to_orbit
from tests.runs import run, to_yaml

ECHO = {
    "name": "echo",
    "states": ["x", "y", "z"],
    "parameters": {"I": 1.5, "tau": 0.3, "d": 0.3, "c": 0.2},
    "modes": {"go": {"x'": "I - x", "y'": "-y + 1 + z/2", "z'": "-3*z"}},
    "events": {"spike": "x - 1", "echo": "x(t - tau - c*y) - 0.5"},
    "resets": {"fire": {"x": "d"}, "push": {"z": "z + 1"}},
    "segments": {
        "rest": {"mode": "go", "event": "spike", "direction": "rising", "reset": "fire", "to": "go"},
        "hit": {"mode": "go", "event": "echo", "direction": "falling", "reset": "push", "to": "go"},
    },
    "initial": {"mode": "go", "x": 0.7, "y": 0, "z": 0},
}


def at(b, period):
    """Return y and z just after a spike, and y and its slope at the echo, of the orbit with its echo at b."""
    left = period - b
    z = exp(-3 * left) / (1 - exp(-3 * period))
    gain = (exp(-period) - exp(-3 * period)) / 4
    y = (1 - exp(-period) + z * gain + (exp(-left) - exp(-3 * left)) / 4) / (1 - exp(-period))
    there = exp(-b) * y + 1 - exp(-b) + z * (exp(-b) - exp(-3 * b)) / 4
    return y, z, there, -there + 1 + z * exp(-3 * b) / 2


def exact(d=0.3, tau=0.3, c=0.2):
    """Return the period, b, and the multipliers in y and z."""
    period = log((1.5 - d) / 0.5)
    b = brentq(lambda b: b - tau - c * at(b, period)[2], 0.0, period, xtol=1e-15)
    slope = at(b, period)[3]
    left = period - b
    # A neighbour's echo comes db later, by y there.
    db = c / (1 - c * slope) * np.array([exp(-b), (exp(-b) - exp(-3 * b)) / 4])
    free = np.array([[exp(-period), (exp(-period) - exp(-3 * period)) / 4], [0.0, exp(-3 * period)]])
    moved = np.array([(exp(-left) - 3 * exp(-3 * left)) / 4, 3 * exp(-3 * left)])
    return period, b, np.linalg.eigvals(free + np.outer(moved, db))


@pytest.fixture(scope="module")
def orbit():
    return settle_to_orbit(parse_document(to_yaml(ECHO), "m").data)


def test_the_orbit_in_closed_form(orbit):
    period, b, _ = exact()
    (link,) = orbit.problem.links
    assert orbit.signature.names[link.segment] == "hit"
    assert orbit.period == pytest.approx(period, abs=1e-11)
    assert orbit.durations[link.segment] == pytest.approx(b, abs=1e-10)


def test_its_multipliers_in_closed_form(orbit):
    found = np.sort(np.abs(find_multipliers(orbit).values))[::-1][:2]
    assert found == pytest.approx(np.sort(np.abs(exact()[2]))[::-1], abs=1e-8)


def test_the_branch_ends_where_the_jump_falls_short(tmp_path):
    """Read later the jump leads to d, which is no longer below 1/2 beyond d = 1/2."""
    steps = [
        {"name": "motion", "simulate": {"t_end": 60}},
        {"name": "orbit", "orbit": {"from": "motion", "stability": True}},
        {"name": "in_d", "continue": {"from": "orbit", "free": ["d"], "range": {"d": [0.25, 0.6]}}},
    ]
    run({**ECHO, "run": {"steps": steps}}, tmp_path / "a.h5")
    step = read_results(tmp_path / "a.h5").step("in_d")
    d = step.points["parameters"][:, list(step.meta["parameters"]).index("d")]
    assert d[step.row("MC1")] == pytest.approx(0.5, abs=1e-9)
    verified = step.points["verified"][step.order]
    assert np.all(verified[step.points["kind"][step.order] == b""] != 0)
    for row in step.order:
        assert step.points["period"][row] == pytest.approx(log((1.5 - d[row]) / 0.5), abs=1e-9)
